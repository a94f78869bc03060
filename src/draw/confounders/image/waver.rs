//! Outlines that waver.
//!
//! Outlines of segmentation networks differ from the true ones smoothly along the body, and drift
//! from frame to frame instead of being drawn anew. So the picture is moved by a sum of long waves,
//! which pass over the figure a whole number of times in a stride, so that cycles stay closed.

use super::fine::Fine;
use super::picture::BitPicture;
use super::warp::warped;
use glam::DVec2;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Root mean square of the movement along each axis at strength 1, metres. Our choice: a pixel of a
/// figure of 57 rows.
const AMPLITUDE_M: f64 = 0.03;
/// The number of waves, the range of their lengths, metres, and the most times that one passes in a
/// stride. Our choice.
const WAVES: usize = 6;
const LENGTHS_M: [f64; 2] = [0.25, 0.60];
const MOST_TURNS: i32 = 3;

/// A wave of movements.
struct OutlineWave {
    /// The phase where the figure's middle is, and its growth a metre to the right and down, radians.
    phase: f64,
    slope: DVec2,
    /// The movement at its crest, in units of the amplitude.
    way: DVec2,
}

/// Moves the outline by 3 cm (root mean square, along each axis) at strength 1, `strides` after the
/// first frame; `rng` is the same for all frames.
pub(crate) fn waver(
    picture: &mut BitPicture,
    fine: &Fine,
    strides: f64,
    strength: f64,
    rng: &mut ChaCha8Rng,
) {
    let waves: [OutlineWave; WAVES] = std::array::from_fn(|_| {
        let [heading, moves, phase, length] = [0; 4].map(|_| rng.random::<f64>());
        let turns = f64::from(rng.random_range(-MOST_TURNS..=MOST_TURNS));
        let [least, most] = LENGTHS_M;
        let unit = |share: f64| DVec2::from_angle(TAU * share);
        OutlineWave {
            phase: TAU * (phase + turns * strides),
            slope: unit(heading) * (TAU / (least + length * (most - least))),
            way: unit(moves),
        }
    });
    let Some(bounds) = picture.bounds() else {
        return;
    };
    let figure = fine.figure();
    let middle = figure.corner + 0.5 * figure.size;
    let scale = fine.samples_per_metre();
    // A sine has a mean square of a half, as has the share of either axis in a direction.
    let most = scale * (AMPLITUDE_M * strength * libm::sqrt(4.0 / WAVES as f64));
    *picture = warped(picture, bounds, |at| {
        let place = (at - middle) / scale;
        let moved = waves
            .iter()
            .map(|wave| wave.way * libm::sin(wave.phase + wave.slope.dot(place)));
        at + most * moved.sum::<DVec2>()
    });
}

#[cfg(test)]
mod tests {
    use super::super::picture::FigureSamples;
    use super::super::tests::side_view;
    use super::*;
    use rand::SeedableRng as _;

    /// Returns how many samples differ between two pictures.
    fn differing(a: &BitPicture, b: &BitPicture) -> u64 {
        let (mut less, mut more) = (a.clone(), b.clone());
        less.remove(b);
        more.remove(a);
        less.area() + more.area()
    }

    #[test]
    fn outlines_waver_by_3_cm_drift_smoothly_and_return_after_a_stride() {
        let (fine, before, FigureSamples { bounds, .. }) = side_view(4);
        let mut moved = 0.0;
        for seed in 0..20 {
            let at = |strides: f64| {
                let mut picture = before.clone();
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                waver(&mut picture, &fine, strides, 1.0, &mut rng);
                picture
            };
            let (first, next, half) = (at(0.0), at(1.0 / 60.0), at(0.5));
            assert_eq!(first, at(1.0));
            assert!(differing(&first, &next) < differing(&first, &half));
            moved += differing(&before, &first) as f64 / 20.0;
        }
        // Half of the outline's points move out or in by less than 2 cm; the outline is more than
        // four heights long.
        let per_metre = fine.samples_per_metre().y;
        let outline = 4.0 * (bounds.bottom - bounds.top) as f64;
        let mean = moved / outline / per_metre;
        assert!((0.01..0.04).contains(&mean), "{mean}");
    }
}

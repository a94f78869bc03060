//! Masks with the faults of video: silhouettes that are rendered to a video and segmented, or that
//! get synthetic segmentation faults.

use crate::segment::{Painted, SegmentSettings, Segmenter, softened};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

/// The source of the silhouettes of real people.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Masks {
    /// The masks of the tree.
    Given,
    /// The masks that [`crate::segment`] finds in a video rendered from them.
    Segmented,
    /// The masks of the tree with wavering outlines, holes and lost parts.
    Degraded,
}

impl Masks {
    /// Returns the name in results.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Segmented => "segmented",
            Self::Degraded => "degraded",
        }
    }

    /// Returns the masks of a take of pictures with this number of columns, in which pixels of 128
    /// and more are the figure. The random generator is seeded from the take's `name` and `seed`.
    pub(crate) fn apply(
        self,
        frames: Vec<Vec<u8>>,
        columns: usize,
        name: &str,
        seed: u64,
    ) -> Vec<Vec<u8>> {
        let key = Sha256::digest(format!("{seed} {name}").as_bytes());
        let mut rng = ChaCha8Rng::from_seed(key.into());
        match self {
            Self::Given => frames,
            Self::Segmented => segmented(&frames, columns, &mut rng),
            Self::Degraded => degraded(&frames, columns, &mut rng),
        }
    }
}

/// Returns the Jaccard index of two masks; 1 if both are empty.
pub(super) fn jaccard(a: &[u8], b: &[u8]) -> f64 {
    let (mut both, mut either) = (0_u32, 0_u32);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (*a >= 128, *b >= 128);
        both += u32::from(a && b);
        either += u32::from(a || b);
    }
    if either == 0 {
        1.0
    } else {
        f64::from(both) / f64::from(either)
    }
}

/// Renders masks to a video, and returns the masks that segmentation finds in it.
fn segmented(frames: &[Vec<u8>], columns: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<u8>> {
    let rows = frames.first().map_or(0, |frame| frame.len() / columns);
    if rows == 0 {
        return Vec::new();
    }
    let mut video = Painted::new((columns, rows), rng);
    let segmenter = Segmenter::new(video.empty(), SegmentSettings::default());
    let one = |frame: &Vec<u8>| segmenter.segment(&video.frame(frame)).mask.grey();
    frames.iter().map(one).collect()
}

/// The number of frames for which a hole or a lost part stays: a third of a second.
const STAYS: usize = 10;
/// The amplitude of the waver, in the threshold at which a softened mask is cut. 0.35 moves the
/// outline by a pixel or two of 200 rows.
const WAVERS: f32 = 0.35;

/// An ellipse in a figure's box: its middle and half axes, in shares of the box.
#[derive(Clone, Copy)]
struct Ellipse {
    middle: (f32, f32),
    half: (f32, f32),
}

impl Ellipse {
    fn has(self, (x, y): (f32, f32)) -> bool {
        let away = |at: f32, middle: f32, half: f32| ((at - middle) / half).powi(2);
        away(x, self.middle.0, self.half.0) + away(y, self.middle.1, self.half.1) < 1.0
    }
}

/// Adds segmentation faults to masks. The model is ours; its strength is chosen so that the masks
/// match the true ones as well as those of `segment` do on ten videos (a Jaccard index of 0.91 to
/// 0.96).
fn degraded(frames: &[Vec<u8>], columns: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<u8>> {
    let shadow = rng.random_bool(0.3).then(|| Ellipse {
        middle: (rng.random_range(0.2..0.8), 0.985),
        half: (rng.random_range(0.3..0.5), 0.02),
    });
    let mut waves = [[0.0_f32; 4]; 6];
    let mut holes: Vec<Ellipse> = Vec::new();
    let mut lost: Option<(f32, f32)> = None;
    let mut found = Vec::new();
    for (number, frame) in frames.iter().enumerate() {
        if number % STAYS == 0 {
            let count = rng.random_range(0..3);
            holes = (0..count)
                .map(|_| Ellipse {
                    middle: (rng.random_range(0.25..0.75), rng.random_range(0.15..0.9)),
                    half: (rng.random_range(0.04..0.12), rng.random_range(0.015..0.04)),
                })
                .collect();
            lost = rng.random_bool(0.12).then(|| {
                let from = rng.random_range(0.0..0.95);
                (from, from + rng.random_range(0.02..0.05))
            });
        }
        for wave in &mut waves {
            *wave = [
                rng.random_range(-0.35..0.35),
                rng.random_range(-0.35..0.35),
                rng.random_range(0.0..std::f32::consts::TAU),
                rng.random_range(-0.4..0.4) * WAVERS,
            ];
        }
        let on: Vec<f32> = frame
            .iter()
            .map(|pixel| f32::from(u8::from(*pixel >= 128)))
            .collect();
        let share = softened(&softened(&softened(&on, columns), columns), columns);
        let figure = || (0..on.len()).filter(|at| on[*at] > 0.0);
        let span = |of: &dyn Fn(usize) -> usize| {
            let least = figure().map(of).min().unwrap_or(0);
            let most = figure().map(of).max().unwrap_or(0);
            (least as f32, (most + 1 - least) as f32)
        };
        let (left, width) = span(&|at| at % columns);
        let (top, height) = span(&|at| at / columns);
        let pixel = |at: usize| {
            let (x, y) = ((at % columns) as f32, (at / columns) as f32);
            let place = ((x - left) / width, (y - top) / height);
            let waver: f32 = waves
                .iter()
                .map(|[across, down, phase, by]| by * (across * x + down * y + phase).sin())
                .sum();
            let is_lost = lost.is_some_and(|(from, to)| (from..to).contains(&place.1));
            let is_cut = is_lost || holes.iter().any(|hole| hole.has(place));
            let is_shadow = shadow.is_some_and(|shadow| shadow.has(place)) && place.1 < 1.0;
            if (share[at] > 0.5 + waver && !is_cut) || is_shadow {
                255
            } else {
                0
            }
        };
        found.push((0..on.len()).map(pixel).collect());
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws a head, a trunk and two swinging legs, 200 rows high.
    fn walker(number: usize) -> Vec<u8> {
        const COLUMNS: usize = 180;
        let swing = 22.0 * (number as f32 * 0.2).sin();
        let is_on = |x: f32, y: f32| {
            let head = ((x - 90.0) / 11.0).powi(2) + ((y - 32.0) / 14.0).powi(2) < 1.0;
            let trunk = (75.0..105.0).contains(&x) && (44.0..125.0).contains(&y);
            let along = (y - 120.0) / 100.0;
            let leg = |by: f32| {
                (120.0..220.0).contains(&y) && (x - 90.0 - by * along).abs() < 9.0 - 3.0 * along
            };
            head || trunk || leg(swing) || leg(-swing)
        };
        (0..240 * COLUMNS)
            .map(|at| {
                let (x, y) = ((at % COLUMNS) as f32, (at / COLUMNS) as f32);
                if is_on(x, y) { 255 } else { 0 }
            })
            .collect()
    }

    #[test]
    fn masks_are_as_like_the_true_ones_as_those_of_videos() {
        let frames: Vec<Vec<u8>> = (0..12).map(|at| walker(at * 3)).collect();
        for (masks, low, high) in [
            (Masks::Segmented, 0.90, 0.995),
            (Masks::Degraded, 0.88, 0.975),
        ] {
            let mut sum = 0.0;
            for name in ["a", "b", "c", "d"] {
                let found = masks.apply(frames.clone(), 180, name, 1);
                let indices = found.iter().zip(&frames).map(|(a, b)| jaccard(a, b));
                sum += indices.sum::<f64>() / frames.len() as f64;
            }
            println!("{}: {}", masks.name(), sum / 4.0);
            assert!(
                (low..high).contains(&(sum / 4.0)),
                "{}: {}",
                masks.name(),
                sum / 4.0
            );
            let again = masks.apply(frames.clone(), 180, "a", 1);
            assert_eq!(again, masks.apply(frames.clone(), 180, "a", 1));
            assert_ne!(again, masks.apply(frames.clone(), 180, "a", 2));
        }
        assert_eq!(Masks::Given.apply(frames.clone(), 180, "a", 1), frames);
    }
}

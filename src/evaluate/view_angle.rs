//! The angle between viewpoints, and Rank-1 against it.

use serde::{Deserialize, Serialize};

use super::intervals::Rank1Intervals;
use super::rank1::Tally;

/// Width of the bins of [`by_angle`], degrees.
pub(crate) const BIN_DEG: f64 = 10.0;
const BINS: usize = 18;
/// The angle below which a viewpoint counts as a training viewpoint, degrees.
const AT_TRAINING_DEG: f64 = 0.5;
/// The tolerance at the end of a bin, degrees. Angles come from sines of single-precision degrees,
/// which put 10 degrees up to 0.00002 above or below. It is the tolerance of
/// [`super::results::RecognizerResult::is_trained_at`].
const END_DEG: f64 = 0.01;

/// Rank-1 of the viewpoints within a range of angles from the training viewpoints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AngleResult {
    /// Beginning of the range, exclusive, degrees.
    pub from_deg: f64,
    /// End of the range, inclusive, degrees; 0 for the training viewpoints themselves.
    pub to_deg: f64,
    /// Number of probes, as [`super::results::ViewpointResult::probes`].
    pub probes: u64,
    /// Share of hits, 0..1.
    pub rank1: f64,
    /// The 95 % intervals of Rank-1.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
}

impl AngleResult {
    /// Returns the middle of the range, degrees.
    #[must_use]
    pub fn middle_deg(&self) -> f64 {
        (self.from_deg + self.to_deg) / 2.0
    }
}

/// Returns the angle between the directions to two cameras, 0..180 degrees. Both are
/// (azimuth, elevation) in degrees. Roll does not count: at elevation 90 all azimuths are one
/// direction.
#[must_use]
pub(crate) fn angle_deg(a: (f64, f64), b: (f64, f64)) -> f64 {
    let (u, v) = (direction(a), direction(b));
    let cross = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    let dot: f64 = u.iter().zip(v).map(|(x, y)| x * y).sum();
    // Exact near 0 and 180, where the cosine is flat.
    cross
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt()
        .atan2(dot)
        .to_degrees()
}

/// Returns Rank-1 by the angle from the nearest training viewpoint, nearest first, without empty
/// bins, from `tallies[viewpoint][person]`. `seed` is the seed for resampling people. The training
/// viewpoints themselves are a bin from 0 to 0. Empty if the training viewpoints are not known.
#[must_use]
pub(crate) fn by_angle(
    trained_at: &[(f64, f64)],
    viewpoints: &[(f64, f64)],
    tallies: &[Vec<Tally>],
    seed: u64,
) -> Vec<AngleResult> {
    let people = tallies.first().map_or(0, Vec::len);
    let mut bins = vec![vec![Tally::default(); people]; BINS + 1];
    for (&here, tallies) in viewpoints.iter().zip(tallies) {
        let angles = trained_at.iter().map(|&there| angle_deg(here, there));
        let Some(angle) = angles.min_by(f64::total_cmp) else {
            return Vec::new();
        };
        let bin = if angle < AT_TRAINING_DEG {
            0
        } else {
            // 10 degrees are in the bin that ends there. A whole number, at least 1.
            (((angle - END_DEG) / BIN_DEG).ceil() as usize).min(BINS)
        };
        for (sum, tally) in bins[bin].iter_mut().zip(tallies) {
            *sum += *tally;
        }
    }
    let results = bins.iter().enumerate().map(|(bin, people)| {
        let all: Tally = people.iter().copied().sum();
        let ends = |bin: usize| bin as f64 * BIN_DEG;
        AngleResult {
            from_deg: if bin == 0 { 0.0 } else { ends(bin - 1) },
            to_deg: ends(bin),
            probes: all.probes,
            rank1: all.rank1().unwrap_or_default(),
            intervals: Rank1Intervals::from_tallies(people, seed),
        }
    });
    results.filter(|result| result.probes > 0).collect()
}

/// Returns the unit vector from the walker to the camera (conventions of the core: +Z is ahead, +X
/// the walker's left, +Y up).
fn direction((azimuth_deg, elevation_deg): (f64, f64)) -> [f64; 3] {
    let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
    let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
    [cos_e * sin_a, sin_e, cos_e * cos_a]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_sphere() {
        for (a, b, angle) in [
            ((0.0, 0.0), (0.0, 0.0), 0.0),
            ((0.0, 0.0), (180.0, 0.0), 180.0),
            ((90.0, 0.0), (90.0, 35.0), 35.0),
            ((0.0, 90.0), (120.0, 90.0), 0.0),
            // cos = cos 60 cos 60 = 1/4.
            ((0.0, 60.0), (60.0, 0.0), 75.522_487_814_070_08),
        ] {
            assert!((angle_deg(a, b) - angle).abs() < 1e-9, "{a:?} {b:?}");
        }
    }

    #[test]
    fn rank_1_is_summed_by_the_angle_from_training() {
        let views = [(90.0, 0.0), (90.0, 5.0), (99.0, 0.0), (0.0, 0.0)];
        let tally = |hits, probes| Tally {
            probes,
            hits,
            non_finite: 0,
        };
        // Of two people, only the first is recognized away from the training viewpoint.
        let tallies = [
            vec![tally(2, 2), tally(2, 2)],
            vec![tally(2, 2), tally(1, 2)],
            vec![tally(1, 2), tally(0, 2)],
            vec![tally(0, 1), tally(0, 1)],
        ];
        assert_eq!(by_angle(&[], &views, &tallies, 1), []);
        let bins = by_angle(&[(90.0, 0.0), (180.0, 90.0)], &views, &tallies, 1);
        let found: Vec<_> = bins
            .iter()
            .map(|bin| (bin.from_deg, bin.to_deg, bin.probes, bin.rank1))
            .collect();
        let expected = [
            (0.0, 0.0, 4, 1.0),
            (0.0, 10.0, 8, 0.5),
            (80.0, 90.0, 2, 0.0),
        ];
        assert_eq!(found, expected);
        assert_eq!(bins[0].intervals.over_people(), Some((1.0, 1.0)));
        assert_eq!(bins[1].intervals.over_people(), Some((0.25, 0.75)));
        assert_eq!(bins[1].middle_deg(), 5.0);
    }

    #[test]
    fn what_is_exactly_at_the_end_of_a_bin_is_in_it() {
        let bin = |at: (f64, f64)| {
            let one = Tally {
                probes: 1,
                hits: 1,
                non_finite: 0,
            };
            let bins = by_angle(&[(90.0, 0.0)], &[at], &[vec![one]], 1);
            (bins[0].from_deg, bins[0].to_deg)
        };
        // On the horizon and straight up from it, the angle is the difference.
        for (at, expected) in [
            ((90.0, 0.4), (0.0, 0.0)),
            ((90.0, 5.0), (0.0, 10.0)),
            ((80.0, 0.0), (0.0, 10.0)),
            ((100.0, 0.0), (0.0, 10.0)),
            ((90.0, 10.0), (0.0, 10.0)),
            ((90.0, 10.02), (10.0, 20.0)),
            ((90.0, 30.0), (20.0, 30.0)),
            ((0.0, 0.0), (80.0, 90.0)),
            ((180.0, 0.0), (80.0, 90.0)),
            ((90.0, 90.0), (80.0, 90.0)),
            // In front of the walker at any height: a right angle to the walker's left.
            ((0.0, 35.0), (80.0, 90.0)),
            ((270.0, 0.0), (170.0, 180.0)),
            // cos 60 cos 60 = 1/4, which is 75.5 degrees.
            ((30.0, 60.0), (70.0, 80.0)),
            // 80.1 and 9.9 in single precision.
            ((f64::from(80.1_f32), 0.0), (0.0, 10.0)),
            ((90.0, f64::from(9.999_999_f32)), (0.0, 10.0)),
            ((90.0, f64::from(10.000_001_f32)), (0.0, 10.0)),
        ] {
            assert_eq!(bin(at), expected, "{at:?}");
        }
    }
}

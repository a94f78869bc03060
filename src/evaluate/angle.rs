//! The angle between viewpoints, and Rank-1 against it.

use super::rank::Tally;
use super::results::{RecognizerResult, ViewpointResult};

/// Width of the bins of [`by_angle`], degrees.
pub const BIN_DEG: f64 = 10.0;

/// The angle between the directions to two cameras, 0..180 degrees. Both are
/// (azimuth, elevation) in degrees. Roll does not count: at elevation 90 all
/// azimuths are one direction.
#[must_use]
pub fn angle_deg(a: (f64, f64), b: (f64, f64)) -> f64 {
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

/// Rank-1 by the angle from the nearest viewpoint that the recognizer was trained
/// at: (middle of the bin in degrees, tally), nearest first, without empty bins.
/// A viewpoint of training itself is a bin of its own at 0. Empty if it is not
/// known where the recognizer was trained.
#[must_use]
pub fn by_angle(result: &RecognizerResult) -> Vec<(f64, Tally)> {
    let mut at_training = Tally::default();
    let mut bins = [Tally::default(); 18];
    for viewpoint in &result.by_viewpoint {
        let Some(angle) = nearest_training_deg(result, viewpoint) else {
            return Vec::new();
        };
        if angle < 0.5 {
            at_training += viewpoint.tally();
        } else {
            // 180 belongs to the last bin. Truncation is the floor: angles are >= 0.
            let bin = ((angle / BIN_DEG) as usize).min(bins.len() - 1);
            bins[bin] += viewpoint.tally();
        }
    }
    let middles = (0..bins.len()).map(|bin| (bin as f64 + 0.5) * BIN_DEG);
    std::iter::once((0.0, at_training))
        .chain(middles.zip(bins))
        .filter(|(_, tally)| tally.probes > 0)
        .collect()
}

/// The angle from a viewpoint to the nearest one of training; none if unknown.
fn nearest_training_deg(result: &RecognizerResult, viewpoint: &ViewpointResult) -> Option<f64> {
    let here = (viewpoint.azimuth_deg, viewpoint.elevation_deg);
    result
        .trained_at
        .iter()
        .map(|&there| angle_deg(here, there))
        .min_by(f64::total_cmp)
}

/// The unit vector from the walker to the camera (conventions of the core: +Z is
/// ahead, +X the walker's left, +Y up).
fn direction((azimuth_deg, elevation_deg): (f64, f64)) -> [f64; 3] {
    let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
    let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
    [cos_e * sin_a, sin_e, cos_e * cos_a]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::result_of;

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
        let mut result = result_of(&[
            (90.0, 0.0, 4, 4),
            (90.0, 5.0, 3, 4),
            (99.0, 0.0, 1, 4),
            (0.0, 0.0, 0, 2),
        ]);
        assert!(
            by_angle(&result).is_empty(),
            "training viewpoints are not known"
        );
        result.trained_at = vec![(90.0, 0.0), (180.0, 90.0)];
        let bins: Vec<_> = by_angle(&result)
            .iter()
            .map(|(angle, t)| (*angle, t.hits, t.probes))
            .collect();
        assert_eq!(bins, [(0.0, 4, 4), (5.0, 4, 8), (95.0, 0, 2)]);
    }
}

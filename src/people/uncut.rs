//! Uncut motions of recorded takes, turned to travel along +Z from the origin unless the file
//! states axes.
//!
//! Files begin anywhere in a laboratory and head anywhere. Viewpoints are relative to the walker's
//! direction, so a take gets one direction for its whole length: from its start to its end, or, if
//! it leads nowhere, where the walker faces first. A file that states which way people face (glTF)
//! is a scene in which cameras have places, so the take keeps its own.

use super::UncutMotion;
use super::retarget::RetargetedMotion;
use edgegait_core::skeleton::Joint;
use glam::{DQuat, DVec3};

/// Speed from start to end, m/s, up to which a take leads nowhere: as for cycles, a walker slower
/// than 0.1 m/s stands or is on a treadmill. Our choice.
const SLOWEST_TRAVEL_M_S: f64 = 0.1;

impl UncutMotion {
    /// Returns the whole take on its walker's own skeleton.
    #[must_use]
    pub fn from_take(take: &RetargetedMotion) -> Self {
        if take.is_placed {
            return Self {
                sample_rate_hz: take.sample_rate_hz,
                roots: take.roots.clone(),
                rotations: take.rotations.clone(),
            };
        }
        let travel = match (take.roots.first(), take.roots.last()) {
            (Some(first), Some(last)) => DVec3::new(last.x - first.x, 0.0, last.z - first.z),
            _ => DVec3::ZERO,
        };
        let seconds = take.len() as f64 / take.sample_rate_hz;
        let ahead = if travel.length() > SLOWEST_TRAVEL_M_S * seconds {
            travel
        } else {
            take.rotations
                .first()
                .map_or(DVec3::Z, |pose| pose[Joint::Pelvis.index()] * DVec3::Z)
        };
        let turn = DQuat::from_rotation_y(-libm::atan2(ahead.x, ahead.z));
        let start = take.roots.first().map_or(DVec3::ZERO, |root| {
            let start = turn * *root;
            DVec3::new(start.x, 0.0, start.z)
        });
        Self {
            sample_rate_hz: take.sample_rate_hz,
            roots: take.roots.iter().map(|root| turn * *root - start).collect(),
            rotations: take
                .rotations
                .iter()
                .map(|pose| {
                    let mut turned = *pose;
                    let pelvis = &mut turned[Joint::Pelvis.index()];
                    *pelvis = (turn * *pelvis).normalize();
                    turned
                })
                .collect(),
        }
    }

    /// Returns the length of the pelvis's path over the floor divided by time, m/s; 0 for one
    /// frame.
    #[must_use]
    pub fn speed_mps(&self) -> f64 {
        let steps = self.roots.windows(2).map(|pair| {
            let step = pair[1] - pair[0];
            libm::hypot(step.x, step.z)
        });
        let path_m: f64 = steps.sum();
        let intervals = self.roots.len().saturating_sub(1).max(1);
        path_m * self.sample_rate_hz / intervals as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::skeleton::JOINTS;

    /// A take at 10 Hz of a walker who faces +X.
    fn take(roots: Vec<DVec3>) -> RetargetedMotion {
        let mut pose = [DQuat::IDENTITY; JOINTS];
        pose[0] = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        RetargetedMotion {
            cut_off_hz: None,
            sample_rate_hz: 10.0,
            start_s: 0.0,
            unit_m: 1.0,
            is_placed: false,
            knows_upright: true,
            offsets: [DVec3::ZERO; JOINTS],
            rotations: vec![pose; roots.len()],
            positions: vec![[DVec3::ZERO; JOINTS]; roots.len()],
            roots,
            residual_mm: 0.0,
            warnings: Vec::new(),
        }
    }

    #[test]
    fn a_take_travels_along_z_from_the_origin() {
        // Backwards along -X, 0.2 m a frame: 2 m/s.
        let span = UncutMotion::from_take(&take(vec![
            DVec3::new(5.0, 0.9, 3.0),
            DVec3::new(4.8, 0.91, 3.0),
            DVec3::new(4.6, 0.9, 3.0),
        ]));
        assert!(span.roots[0].distance(DVec3::new(0.0, 0.9, 0.0)) < 1e-12);
        assert!(span.roots[2].distance(DVec3::new(0.0, 0.9, 0.4)) < 1e-12);
        let ahead = span.rotations[1][0] * DVec3::Z;
        assert!(ahead.distance(-DVec3::Z) < 1e-12, "{ahead}");
        assert!((span.speed_mps() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_take_of_stated_axes_stays_where_it_is() {
        let mut placed = take(vec![DVec3::new(5.0, 0.9, 3.0), DVec3::new(4.8, 0.91, 3.0)]);
        placed.is_placed = true;
        let span = UncutMotion::from_take(&placed);
        assert_eq!(span.roots, placed.roots);
        assert_eq!(span.rotations, placed.rotations);
    }

    #[test]
    fn one_who_stands_looks_along_z() {
        for frames in [1, 50] {
            let span = UncutMotion::from_take(&take(vec![DVec3::new(-1.0, 0.9, 2.0); frames]));
            let ahead = span.rotations[0][0] * DVec3::Z;
            assert!(ahead.distance(DVec3::Z) < 1e-12, "{ahead}");
            assert!(span.roots[0].distance(DVec3::new(0.0, 0.9, 0.0)) < 1e-12);
            assert_eq!(span.speed_mps(), 0.0);
        }
    }
}

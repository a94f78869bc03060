//! A motion on another body: the same joint angles, the root fitted to its legs.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use super::forward_kinematics;
use super::retarget::{ANKLE_HEIGHT, leg_length_m};
use super::{Cycle, Span};

/// Toe tip ahead of the ankle over hip-to-ankle length: three quarters of a foot of
/// 0.152 statures, over 0.491 (Winter 2009, figure 4.1).
const TOE_REACH: f64 = 0.232;

impl Cycle {
    /// This cycle, of a walker with `own` joint offsets, on a body with `target` ones.
    ///
    /// Rotations stay. Root and travel scale with the hip-to-ankle length, and in each
    /// frame the root's height is set so that the lowest point of the soles (toe tips and
    /// below the ankles) has its own clearance of the floor, scaled alike: a foot that
    /// stands still stands.
    #[must_use]
    pub fn onto(&self, own: &[DVec3; JOINTS], target: &[DVec3; JOINTS]) -> Self {
        let (root, ratio) = roots_onto(&self.root, &self.rotations, own, target);
        Self {
            period_s: self.period_s,
            drift_m: self.drift_m * ratio,
            closure_mm: self.closure_mm,
            root,
            rotations: self.rotations.clone(),
        }
    }
}

impl Span {
    /// This motion, of a walker with `own` joint offsets, on a body with `target` ones:
    /// as [`Cycle::onto`], the travel scaled like the legs.
    #[must_use]
    pub fn onto(&self, own: &[DVec3; JOINTS], target: &[DVec3; JOINTS]) -> Self {
        Self {
            sample_rate_hz: self.sample_rate_hz,
            roots: roots_onto(&self.roots, &self.rotations, own, target).0,
            rotations: self.rotations.clone(),
        }
    }
}

/// The roots on the other body, and how much longer its legs are.
fn roots_onto(
    roots: &[DVec3],
    rotations: &[[DQuat; JOINTS]],
    own: &[DVec3; JOINTS],
    target: &[DVec3; JOINTS],
) -> (Vec<DVec3>, f64) {
    let own_leg_m = leg_length_m(own);
    let target_leg_m = leg_length_m(target);
    let ratio = if own_leg_m > 0.0 {
        target_leg_m / own_leg_m
    } else {
        1.0
    };
    let moved = roots
        .iter()
        .zip(rotations)
        .map(|(root, rotations)| {
            let mut scaled = *root * ratio;
            let clearance = lowest_sole(own, own_leg_m, *root, rotations) * ratio;
            scaled.y += clearance - lowest_sole(target, target_leg_m, scaled, rotations);
            scaled
        })
        .collect();
    (moved, ratio)
}

/// Height of the lowest point of both soles.
fn lowest_sole(
    offsets: &[DVec3; JOINTS],
    leg_m: f64,
    root: DVec3,
    rotations: &[DQuat; JOINTS],
) -> f64 {
    let (positions, globals) = forward_kinematics(offsets, root, rotations);
    let sole = -DVec3::Y * ANKLE_HEIGHT * leg_m;
    [Joint::LeftFoot, Joint::RightFoot]
        .into_iter()
        .flat_map(|foot| {
            let (at, turned) = (positions[foot.index()], globals[foot.index()]);
            [sole, sole + DVec3::Z * TOE_REACH * leg_m].map(|point| (at + turned * point).y)
        })
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hips 1 m up on legs of 0.5 + 0.42 m; nothing else.
    fn legs(scale: f64) -> [DVec3; JOINTS] {
        let mut offsets = [DVec3::ZERO; JOINTS];
        for (thigh, shank, foot, x) in [
            (Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot, 0.1),
            (Joint::RightThigh, Joint::RightShank, Joint::RightFoot, -0.1),
        ] {
            offsets[thigh.index()] = DVec3::X * x * scale;
            offsets[shank.index()] = -DVec3::Y * 0.5 * scale;
            offsets[foot.index()] = -DVec3::Y * 0.42 * scale;
        }
        offsets
    }

    fn cycle() -> Cycle {
        let mut bent = [DQuat::IDENTITY; JOINTS];
        bent[Joint::RightThigh.index()] = DQuat::from_rotation_x(-0.5);
        bent[Joint::RightShank.index()] = DQuat::from_rotation_x(1.0);
        Cycle {
            period_s: 1.0,
            drift_m: 1.2,
            closure_mm: 0.0,
            root: vec![DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.01, 1.02, 0.02)],
            rotations: vec![[DQuat::IDENTITY; JOINTS], bent],
        }
    }

    #[test]
    fn a_cycle_on_its_own_body_is_unchanged() {
        let moved = cycle().onto(&legs(1.0), &legs(1.0));
        for (a, b) in moved.root.iter().zip(&cycle().root) {
            assert!(a.distance(*b) < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn a_body_of_half_the_size_takes_half_the_steps() {
        let moved = cycle().onto(&legs(1.0), &legs(0.5));
        assert!((moved.drift_m - 0.6).abs() < 1e-12);
        assert!(moved.root[1].distance(DVec3::new(0.005, 0.51, 0.01)) < 1e-12);
    }

    #[test]
    fn a_span_moves_as_a_cycle_does() {
        let span = Span {
            sample_rate_hz: 100.0,
            roots: cycle().root,
            rotations: cycle().rotations,
        };
        let moved = span.onto(&legs(1.0), &legs(0.5));
        assert!(moved.roots[1].distance(DVec3::new(0.005, 0.51, 0.01)) < 1e-12);
        assert_eq!(moved.sample_rate_hz, 100.0);
    }

    #[test]
    fn longer_shanks_keep_the_standing_foot_on_the_floor() {
        let mut target = legs(1.0);
        target[Joint::LeftFoot.index()].y = -0.52;
        target[Joint::RightFoot.index()].y = -0.52;
        let (own_leg, target_leg) = (0.92, 1.02);
        let moved = cycle().onto(&legs(1.0), &target);
        for (before, after) in cycle()
            .root
            .iter()
            .zip(&moved.root)
            .zip(&cycle().rotations)
            .map(|((before, after), rotations)| {
                (
                    lowest_sole(&legs(1.0), own_leg, *before, rotations),
                    lowest_sole(&target, target_leg, *after, rotations),
                )
            })
        {
            assert!((after - before * target_leg / own_leg).abs() < 1e-12);
        }
    }
}

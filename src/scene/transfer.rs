//! A motion on another body: the same joint angles, the root fitted to its legs.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use super::forward_kinematics;
use super::retarget::{ANKLE_HEIGHT, leg_length_m};
use super::stance::{Steps, soles_of_legs};
use super::{Cycle, Span};

/// Toe tip ahead of the ankle over hip-to-ankle length: three quarters of a foot of
/// 0.152 statures, over 0.491 (Winter 2009, figure 4.1).
const TOE_REACH: f64 = 0.232;

impl Cycle {
    /// This cycle, of a walker with `own` joint offsets, on a body with `target` ones.
    ///
    /// Rotations stay. Root and travel scale with the hip-to-ankle length, and in each
    /// frame the root's height is set so that the lowest point of the soles (toe tips and
    /// below the ankles) has its own clearance of the floor, scaled alike. Where other shares of
    /// thigh, shank and hips would make standing feet slide more than they did, the root gives
    /// way along the floor, and with it the travel.
    #[must_use]
    pub fn onto(&self, own: &[DVec3; JOINTS], target: &[DVec3; JOINTS]) -> Self {
        let (root, ratio) = roots_onto(&self.root, &self.rotations, own, target);
        let mut moved = Self {
            drift_m: self.drift_m * ratio,
            root,
            ..self.clone()
        };
        let ways = plant(
            &Steps::of_cycle(self, own),
            &Steps::of_cycle(&moved, target),
            ratio,
        );
        let frames = moved.root.len() as f64;
        let travel = ways.last().copied().unwrap_or_default();
        for (frame, (root, way)) in moved.root.iter_mut().zip(&ways).enumerate() {
            *root += *way - travel * (frame as f64 / frames);
        }
        let shift =
            (self.root.iter().sum::<DVec3>() * ratio - moved.root.iter().sum::<DVec3>()) / frames;
        for root in &mut moved.root {
            *root += DVec3::new(shift.x, 0.0, shift.z);
        }
        moved.drift_m += travel.z;
        moved
    }
}

impl Span {
    /// This motion, of a walker with `own` joint offsets, on a body with `target` ones:
    /// as [`Cycle::onto`], the travel scaled like the legs.
    #[must_use]
    pub fn onto(&self, own: &[DVec3; JOINTS], target: &[DVec3; JOINTS]) -> Self {
        let (roots, ratio) = roots_onto(&self.roots, &self.rotations, own, target);
        let mut moved = Self {
            roots,
            ..self.clone()
        };
        let ways = plant(
            &Steps::of_span(self, own),
            &Steps::of_span(&moved, target),
            ratio,
        );
        for (root, way) in moved.roots.iter_mut().zip(&ways) {
            *root += *way;
        }
        moved
    }
}

/// How far the root has to give way along the floor by each frame (and after the last of a
/// cycle) for standing feet to slide as they did on the walker's own legs, scaled; the mean of
/// both where both stand.
fn plant(own: &Steps<'_>, moved: &Steps<'_>, ratio: f64) -> Vec<DVec3> {
    let stances = own.stances();
    let slides = |steps: &Steps<'_>| steps.slides(&stances, &soles_of_legs(steps.leg_m()));
    let mut way = DVec3::ZERO;
    let mut ways = vec![way];
    for (before, after) in slides(own).iter().zip(&slides(moved)) {
        let pairs = before.iter().zip(after);
        let more: Vec<DVec3> = pairs
            .filter_map(|(before, after)| Some(before.as_ref()? * ratio - after.as_ref()?))
            .collect();
        way += more.iter().sum::<DVec3>() / more.len().max(1) as f64;
        ways.push(way);
    }
    ways
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

    #[test]
    fn feet_slide_no_more_on_legs_of_other_shares() {
        use super::super::cohort::Person;
        use super::super::{Track, Walk};
        use edgegait_core::pack::{Gait, Sex};
        let person = Person::average(Sex::Male);
        for speed_kmh in [4.0, 6.0, 10.0] {
            let cycle = person.cycle(speed_kmh);
            let mut body = person.body.clone();
            for (joint, factor) in [
                (Joint::LeftShank, 0.85),
                (Joint::RightShank, 0.85),
                (Joint::LeftFoot, 1.2),
                (Joint::RightFoot, 1.2),
            ] {
                body.offsets[joint.index()] *= factor;
            }
            let skate = |cycle: &Cycle, body: &super::super::Body| {
                let walk = Walk {
                    name: String::new(),
                    cycle: 0,
                    gait: Gait::Walk,
                    speed_mps: 0.0,
                    motion: Track::Loop(cycle.clone()),
                };
                walk.skate(body).unwrap().mean_mm
            };
            let own = skate(&cycle, &person.body);
            let (root, ratio) = roots_onto(
                &cycle.root,
                &cycle.rotations,
                &person.body.offsets,
                &body.offsets,
            );
            let unplanted = Cycle {
                root,
                drift_m: cycle.drift_m * ratio,
                ..cycle.clone()
            };
            let planted = cycle.onto(&person.body.offsets, &body.offsets);
            let (unplanted, planted) = (skate(&unplanted, &body), skate(&planted, &body));
            println!(
                "{speed_kmh} km/h: own {own:.1}, unplanted {unplanted:.1}, planted {planted:.1} mm"
            );
            // Where both feet stand, one root cannot hold both.
            assert!(
                planted < 0.5 * (own + unplanted),
                "{own} {unplanted} {planted}"
            );
        }
    }
}

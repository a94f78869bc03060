//! Further cycles of a walk: seeded variations within a person.
//!
//! No two cycles of a person are the same, and takes of different days differ in posture, shoes
//! and speed. A pack stores one cycle of a synthetic walk. Variations put its feet down elsewhere,
//! move the pelvis over them, and add smooth periodic noise above it. Legs are solved for their
//! feet, which neither slide nor cross.

use crate::people::leg::LegLengths;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{DQuat, Mat3, Quat, Vec3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::cohort::normal;

/// Number of harmonics of the noise, beside a constant for the cycle.
const HARMONICS: usize = 3;

/// Cycles of one take: variations 0 to 7 belong to the stored take, 8 to 15 to another, and so on.
pub(crate) const CYCLES_OF_A_TAKE: u32 = 8;

/// The seed of a variation: which cycle of which walk it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CycleSeed {
    /// The user's seed.
    pub seed: u64,
    /// Hash of the subject's name, independent of the rest of the pack.
    pub subject: u64,
    /// Hash of the walk's name and its stored cycle's number.
    pub walk: u64,
    /// Number of the variation; 0 is the stored cycle itself.
    pub variation: u32,
}

/// The difference of one cycle from the stored one.
#[derive(Clone, Debug)]
pub(crate) struct Variation {
    /// `None` leaves the stored cycle as it is.
    noise: Option<Box<Noise>>,
}

/// The parameters of a cycle's difference from the stored one.
#[derive(Clone, Debug)]
struct Noise {
    /// For each joint above the hips: rotation vectors of the constant and of each harmonic's
    /// cosine and sine, radians.
    turns: [[Vec3; 1 + 2 * HARMONICS]; JOINTS],
    /// How much further out each foot is put down, left first, metres.
    aside_m: [f32; 2],
    /// How much further out the toes of each foot point, radians.
    toe_out: [f32; 2],
    /// How much longer steps are, as a share.
    longer: f32,
    /// How much further the pelvis sways to either side, metres.
    sway_m: f32,
    /// How much more it rises and falls, metres from its mean.
    bob_m: f32,
}

/// Standard deviations of a joint's turns between takes and between cycles of one take.
#[derive(Clone, Copy)]
struct TurnSpread {
    /// Spread of the mean over the cycle about the flexion axis, degrees: takes, cycles.
    mean: [f64; 2],
    /// Spread of the mean about each of the other two axes.
    other: [f64; 2],
    /// Spread of the changes over the cycle, equal at every phase.
    swing: [f64; 2],
}

/// Returns the spreads of a joint above the hips; `None` for a leg's joint. Means are from CMU's
/// walkers with several takes or cycles (12 takes of 3 people, 23 cycles of 11 takes;
/// [`super::cohort`]'s fit), swings from the spreads of their amplitudes and delays. Hands and
/// clavicles are ours.
const fn spread(joint: Joint) -> Option<TurnSpread> {
    let (mean, other, swing) = match joint {
        Joint::Pelvis => ([0.6, 0.5], [0.3, 0.4], [0.4, 0.6]),
        Joint::Spine | Joint::Thorax => ([1.0, 0.5], [0.6, 0.4], [0.4, 0.6]),
        Joint::Neck | Joint::Head => ([1.8, 1.2], [1.0, 0.8], [0.4, 0.6]),
        Joint::LeftUpperArm | Joint::RightUpperArm => ([1.6, 0.6], [1.2, 0.7], [2.2, 1.4]),
        Joint::LeftForearm | Joint::RightForearm => ([2.0, 0.9], [0.5, 0.3], [2.0, 1.4]),
        Joint::LeftHand | Joint::RightHand => ([1.5, 1.5], [1.5, 1.5], [0.5, 1.0]),
        Joint::LeftClavicle | Joint::RightClavicle => ([0.2, 0.2], [0.2, 0.2], [0.1, 0.2]),
        Joint::LeftThigh
        | Joint::RightThigh
        | Joint::LeftShank
        | Joint::RightShank
        | Joint::LeftFoot
        | Joint::RightFoot => return None,
    };
    Some(TurnSpread { mean, other, swing })
}

/// Standard deviation of the step width between takes and between cycles, metres: 1.0 and 1.3 cm
/// in CMU's short takes, 2.4 between cycles in publications (Almarwani et al. 2016).
const STEP_WIDTH_M: [f64; 2] = [0.010, 0.014];
/// Standard deviation of the step length between takes and between cycles, as a share: about half
/// of the walk ratio's (0.097, 0.038).
const STEP_LENGTH: [f64; 2] = [0.045, 0.016];
/// Standard deviation of a foot's direction between takes (our choice) and between cycles, degrees.
const TOE_OUT_DEG: [f64; 2] = [1.0, 1.6];
/// Standard deviation of the pelvis's sway from its mean between takes and between cycles, metres,
/// and the sway's correlation with the step width.
const SWAY_M: [f64; 2] = [0.001, 0.0038];
const SWAY_WITH_WIDTH: f64 = 0.69;
/// Standard deviation of the pelvis's rise and fall between takes and between cycles, metres.
const BOB_M: [f64; 2] = [0.0030, 0.0013];

impl Variation {
    /// Returns the variation of one cycle; number 0 is the stored cycle.
    #[must_use]
    pub(crate) fn new(of: CycleSeed) -> Self {
        if of.variation == 0 {
            return Self { noise: None };
        }
        let mut noise = Box::new(Noise::NONE);
        let take = of.variation / CYCLES_OF_A_TAKE;
        if take > 0 {
            // Cycles count up from 0, and takes down from the greatest number.
            noise.add(&mut rng(of, u64::MAX - u64::from(take)), TAKES);
        }
        noise.add(&mut rng(of, u64::from(of.variation)), CYCLES);
        Self { noise: Some(noise) }
    }

    /// Turns a pose of the stored cycle at `phase` into this cycle's pose.
    pub(crate) fn apply(&self, pose: &mut Pose, phase: f32, skeleton: &Skeleton) {
        if let Some(noise) = &self.noise {
            noise.apply(pose, phase, skeleton);
        }
    }
}

/// Indices of the spreads between takes and between cycles.
const TAKES: usize = 0;
const CYCLES: usize = 1;

/// Returns the random number generator of one take or cycle.
fn rng(of: CycleSeed, number: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    let parts = [of.seed, of.subject, of.walk, number];
    for (bytes, part) in key.chunks_exact_mut(8).zip(parts) {
        bytes.copy_from_slice(&part.to_le_bytes());
    }
    ChaCha8Rng::from_seed(key)
}

#[expect(clippy::cast_possible_truncation, reason = "small numbers")]
impl Noise {
    const NONE: Self = Self {
        turns: [[Vec3::ZERO; 1 + 2 * HARMONICS]; JOINTS],
        aside_m: [0.0; 2],
        toe_out: [0.0; 2],
        longer: 0.0,
        sway_m: 0.0,
        bob_m: 0.0,
    };

    /// Adds the differences of one take or cycle.
    fn add(&mut self, rng: &mut ChaCha8Rng, which: usize) {
        let width = normal(rng);
        for (aside_m, toe_out) in self.aside_m.iter_mut().zip(&mut self.toe_out) {
            *aside_m += (0.5 * STEP_WIDTH_M[which] * width) as f32;
            *toe_out += (TOE_OUT_DEG[which] * normal(rng)).to_radians() as f32;
        }
        self.longer += (STEP_LENGTH[which] * normal(rng)) as f32;
        let own = libm::sqrt(1.0 - SWAY_WITH_WIDTH * SWAY_WITH_WIDTH) * normal(rng);
        self.sway_m += (SWAY_M[which] * (SWAY_WITH_WIDTH * width + own)) as f32;
        self.bob_m += (BOB_M[which] * normal(rng)) as f32;
        // Changes fall with the square of the harmonic, so that the noise is smooth.
        let weights: [f64; HARMONICS] = std::array::from_fn(|k| 1.0 / ((k + 1) * (k + 1)) as f64);
        let total: f64 = weights.iter().sum();
        for (joint, terms) in Joint::ALL.into_iter().zip(&mut self.turns) {
            let Some(spread) = spread(joint) else {
                continue;
            };
            for (index, term) in terms.iter_mut().enumerate() {
                let deviation = match index {
                    0 => {
                        let (mean, other) = (spread.mean[which], spread.other[which]);
                        [mean, other, other]
                    }
                    // A harmonic's cosine and sine share its variance: with each at variance v
                    // the sum has variance v at every phase. Other axes swing half as much.
                    _ => {
                        let share = libm::sqrt(weights[(index - 1) / 2] / total);
                        let swing = share * spread.swing[which];
                        [swing, 0.5 * swing, 0.5 * swing]
                    }
                };
                let draw = deviation.map(|sd| (sd * normal(rng)).to_radians() as f32);
                *term += Vec3::from_array(draw);
            }
        }
    }

    fn apply(&self, pose: &mut Pose, phase: f32, skeleton: &Skeleton) {
        let stored = ModelPose::new(skeleton, pose);
        let mut basis = [1.0; 1 + 2 * HARMONICS];
        for harmonic in 1..=HARMONICS {
            #[expect(clippy::cast_precision_loss, reason = "1 to 3")]
            let turns = harmonic as f32 * phase;
            let (sin, cos) = libm::sincosf(core::f32::consts::TAU * (turns - libm::floorf(turns)));
            basis[2 * harmonic - 1] = cos;
            basis[2 * harmonic] = sin;
        }
        // The pelvis sways over the left foot in mid-stance, 0.31 of the cycle after contact: the
        // factors are the sine and the cosine of that phase. It is highest after a quarter of the
        // cycle, and again half a cycle later.
        pose.root.x += self.sway_m * (0.93 * basis[2] - 0.37 * basis[1]);
        pose.root.y -= self.bob_m * basis[3];
        for (rotation, terms) in pose.rotations.iter_mut().zip(&self.turns) {
            let vector: Vec3 = terms.iter().zip(basis).map(|(term, b)| *term * b).sum();
            *rotation = (*rotation * Quat::from_scaled_axis(vector)).normalize();
        }
        for side in 0..2 {
            self.put_down(side, pose, &stored, skeleton);
        }
    }

    /// Solves a leg for its foot's place in this cycle; side 0 is the left one.
    fn put_down(&self, side: usize, pose: &mut Pose, stored: &ModelPose, skeleton: &Skeleton) {
        let [thigh, shank, foot] = LEGS[side].map(Joint::index);
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let pelvis = Mat3::from_quat(pose.rotations[Joint::Pelvis.index()]);
        let hip = pose.root + pelvis * skeleton.offsets[thigh];
        let mut ankle = stored.positions[foot];
        ankle.x += sign * self.aside_m[side];
        ankle.z = stored.positions[Joint::Pelvis.index()].z
            + (1.0 + self.longer) * (ankle.z - stored.positions[Joint::Pelvis.index()].z);
        let leg = LegLengths {
            thigh_m: f64::from(skeleton.offsets[shank].length()),
            shank_m: f64::from(skeleton.offsets[foot].length()),
        };
        let ahead = stored.orientations[thigh] * Vec3::Z;
        let reached = leg.reaching(hip.as_dvec3(), ankle.as_dvec3(), ahead.as_dvec3());
        let pelvis = pose.rotations[Joint::Pelvis.index()].as_dquat();
        let turned = DQuat::from_rotation_y(f64::from(sign * self.toe_out[side]))
            * Quat::from_mat3(&stored.orientations[foot]).as_dquat();
        let mut set =
            |joint: usize, turn: DQuat| pose.rotations[joint] = turn.normalize().as_quat();
        set(thigh, pelvis.inverse() * reached.thigh);
        set(shank, reached.thigh.inverse() * reached.shank);
        set(foot, reached.shank.inverse() * turned);
    }
}

/// The joints of the left and of the right leg.
const LEGS: [[Joint; 3]; 2] = [
    [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
    [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cohort::Person;
    use edgegait_core::pack::Sex;
    use std::sync::OnceLock;

    /// A frame of the average man's walk at 5 km/h, and his skeleton.
    fn stored(frame: usize) -> (Pose, Skeleton) {
        static WALK: OnceLock<(Vec<Pose>, Skeleton)> = OnceLock::new();
        let (poses, skeleton) = WALK.get_or_init(|| {
            let person = Person::average(Sex::Male);
            let cycle = person.cycle(5.0);
            let frames = cycle.root.iter().zip(&cycle.rotations);
            let poses = frames.map(|(root, rotations)| Pose {
                root: root.as_vec3(),
                rotations: rotations.map(DQuat::as_quat),
            });
            let offsets = person.body.offsets.map(glam::DVec3::as_vec3);
            (poses.collect(), Skeleton { offsets })
        });
        (poses[frame].clone(), skeleton.clone())
    }

    fn variation(number: u32) -> Variation {
        Variation::new(CycleSeed {
            seed: 1,
            subject: 2,
            walk: 3,
            variation: number,
        })
    }

    fn varied(cycle: u32, frame: usize, phase: f32) -> (Pose, ModelPose) {
        let (mut pose, skeleton) = stored(frame);
        variation(cycle).apply(&mut pose, phase, &skeleton);
        let model = ModelPose::new(&skeleton, &pose);
        (pose, model)
    }

    #[test]
    fn cycle_zero_is_the_stored_one() {
        assert_eq!(varied(0, 9, 0.3).0, stored(9).0);
    }

    #[test]
    fn cycles_are_reproducible_and_differ() {
        assert_eq!(varied(4, 9, 0.3).0, varied(4, 9, 0.3).0);
        assert_ne!(varied(4, 9, 0.3).0, varied(5, 9, 0.3).0);
    }

    #[test]
    fn a_varied_cycle_still_closes() {
        let ((start, _), (end, _)) = (varied(9, 9, 0.0), varied(9, 9, 1.0));
        for (a, b) in start.rotations.iter().zip(end.rotations) {
            assert!(a.angle_between(b) < 1e-3);
        }
    }

    #[test]
    fn feet_are_put_down_as_far_apart_as_stated_and_stay_there() {
        let foot = |cycle, frame: usize| {
            let phase = frame as f32 / 96.0;
            let (_, model) = varied(cycle, frame, phase);
            let (pose, skeleton) = stored(frame);
            let stored = ModelPose::new(&skeleton, &pose);
            let at = Joint::LeftFoot.index();
            model.positions[at] - stored.positions[at]
        };
        let mut squares = 0.0;
        for cycle in 1..8 {
            // In the first half of the cycle the left foot stands.
            let moved = foot(cycle, 10);
            for frame in [15, 20, 30, 40] {
                let now = foot(cycle, frame);
                // A leg that is too short for a longer step comes up by a millimetre.
                assert!(
                    (now.x - moved.x).abs() < 2e-4,
                    "{cycle} {frame} {now} {moved}"
                );
                assert!(now.y.abs() < 1.5e-3, "{cycle} {frame} {now}");
            }
            squares += f64::from(moved.x * moved.x);
        }
        // Half of 1.4 cm, within a factor of two for seven cycles.
        let deviation = libm::sqrt(squares / 7.0);
        assert!((0.004..0.017).contains(&deviation), "{deviation}");
    }

    #[test]
    fn takes_differ_by_more_than_their_cycles() {
        let arm = |cycle| {
            let (pose, _) = varied(cycle, 0, 0.0);
            pose.rotations[Joint::LeftForearm.index()]
        };
        let mean = |pairs: &[(u32, u32)]| {
            let angles = pairs.iter().map(|&(a, b)| arm(a).angle_between(arm(b)));
            angles.sum::<f32>() / pairs.len() as f32
        };
        let within: Vec<_> = (0..200).map(|i| (8 * i + 8, 8 * i + 9)).collect();
        let between: Vec<_> = (0..200).map(|i| (8 * i + 8, 8 * i + 16)).collect();
        let (within, between) = (mean(&within), mean(&between));
        assert!(between > 1.2 * within, "{between} {within}");
    }
}

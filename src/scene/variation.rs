//! Further cycles of a walk: seeded variations within a person.
//!
//! Nobody walks the same cycle twice. A pack stores one cycle of a made walk; others
//! are that one with smooth periodic noise on every joint.

use edgegait_core::pose::Pose;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{Quat, Vec3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::cohort::normal;

/// Harmonics of the noise: a constant for the cycle, and changes up to three a cycle.
const HARMONICS: usize = 3;

/// Which cycle of which walk: what a variation is drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CycleSeed {
    /// The user's seed.
    pub seed: u64,
    /// Which subject, whatever else is in the pack: a hash of the name.
    pub subject: u64,
    /// Which stored cycle of which walk: a hash of the name, and the cycle.
    pub walk: u64,
    /// Which variation; 0 is the stored cycle itself.
    pub variation: u32,
}

/// Periodic noise on joint rotations.
#[derive(Clone, Debug)]
pub(crate) struct Variation {
    /// For each joint: rotation vectors of the constant and of each harmonic's cosine
    /// and sine, radians. `None` leaves the stored cycle as it is.
    noise: Option<Box<[[Vec3; 1 + 2 * HARMONICS]; JOINTS]>>,
}

/// Standard deviation of a joint's noise, degrees: about its flexion axis, and about
/// each of the other two.
///
/// Within a person joint angles differ from stride to stride by 1.5 to 2 degrees
/// (recalled from the repeatability literature, for example Kadaba et al. 1989, J. Orthop.
/// Res. 7:849-860); arms swing more freely. The split by joints is ours.
const fn deviation_deg(joint: Joint) -> (f32, f32) {
    match joint {
        Joint::Pelvis | Joint::Spine | Joint::Thorax => (0.8, 0.5),
        Joint::Neck | Joint::Head => (1.5, 1.0),
        Joint::LeftThigh | Joint::RightThigh => (1.5, 0.7),
        Joint::LeftShank | Joint::RightShank => (1.8, 0.2),
        Joint::LeftFoot | Joint::RightFoot => (1.8, 0.7),
        Joint::LeftUpperArm | Joint::RightUpperArm => (3.0, 1.5),
        Joint::LeftForearm | Joint::RightForearm => (3.0, 0.5),
        Joint::LeftHand | Joint::RightHand => (2.0, 2.0),
        Joint::LeftClavicle | Joint::RightClavicle => (0.3, 0.3),
    }
}

impl Variation {
    /// The variation of one cycle; the stored cycle for number 0.
    #[must_use]
    pub(crate) fn new(of: CycleSeed) -> Self {
        if of.variation == 0 {
            return Self { noise: None };
        }
        let mut key = [0; 32];
        let parts = [of.seed, of.subject, of.walk, u64::from(of.variation)];
        for (bytes, part) in key.chunks_exact_mut(8).zip(parts) {
            bytes.copy_from_slice(&part.to_le_bytes());
        }
        let mut rng = ChaCha8Rng::from_seed(key);
        // Half of the variance is a constant of the cycle; the rest falls with the
        // square of the harmonic, so that the noise is smooth.
        let weights: [f64; HARMONICS] = std::array::from_fn(|k| 1.0 / ((k + 1) * (k + 1)) as f64);
        let total: f64 = weights.iter().sum();
        let mut noise = Box::new([[Vec3::ZERO; 1 + 2 * HARMONICS]; JOINTS]);
        for (joint, terms) in Joint::ALL.into_iter().zip(noise.iter_mut()) {
            let (flexion, other) = deviation_deg(joint);
            let spread = Vec3::new(flexion, other, other) * core::f32::consts::PI / 180.0;
            for (index, term) in terms.iter_mut().enumerate() {
                // A harmonic's cosine and sine share its variance: with each at variance
                // v the sum has variance v at every phase.
                let variance = match index {
                    0 => 0.5,
                    _ => 0.5 * weights[(index - 1) / 2] / total,
                };
                let size = libm::sqrt(variance);
                #[expect(clippy::cast_possible_truncation, reason = "an angle")]
                let draw =
                    Vec3::from_array(std::array::from_fn(|_| (size * normal(&mut rng)) as f32));
                *term = spread * draw;
            }
        }
        Self { noise: Some(noise) }
    }

    /// Adds this cycle's noise at `phase` to a pose of the stored cycle.
    pub(crate) fn apply(&self, pose: &mut Pose, phase: f32) {
        let Some(noise) = &self.noise else { return };
        let mut basis = [1.0; 1 + 2 * HARMONICS];
        for harmonic in 1..=HARMONICS {
            #[expect(clippy::cast_precision_loss, reason = "1 to 3")]
            let turns = harmonic as f32 * phase;
            let (sin, cos) = libm::sincosf(core::f32::consts::TAU * (turns - libm::floorf(turns)));
            basis[2 * harmonic - 1] = cos;
            basis[2 * harmonic] = sin;
        }
        for (rotation, terms) in pose.rotations.iter_mut().zip(noise.iter()) {
            let vector: Vec3 = terms.iter().zip(basis).map(|(term, b)| *term * b).sum();
            *rotation = (*rotation * Quat::from_scaled_axis(vector)).normalize();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variation(number: u32) -> Variation {
        Variation::new(CycleSeed {
            seed: 1,
            subject: 2,
            walk: 3,
            variation: number,
        })
    }

    fn varied(cycle: u32, phase: f32) -> Pose {
        let mut pose = Pose::REST;
        variation(cycle).apply(&mut pose, phase);
        pose
    }

    #[test]
    fn cycle_zero_is_the_stored_one() {
        assert_eq!(varied(0, 0.3), Pose::REST);
    }

    #[test]
    fn cycles_are_reproducible_and_differ() {
        assert_eq!(varied(4, 0.3), varied(4, 0.3));
        assert_ne!(varied(4, 0.3), varied(5, 0.3));
    }

    #[test]
    fn a_varied_cycle_still_closes() {
        let (start, end) = (varied(9, 0.0), varied(9, 1.0));
        for (a, b) in start.rotations.iter().zip(end.rotations) {
            assert!(a.angle_between(b) < 1e-4);
        }
    }

    #[test]
    fn noise_is_as_large_as_stated() {
        // Root mean square over 500 cycles of the knee's flexion: 1.8 degrees, less the
        // 4 % that drawing again beyond 2.5 deviations takes.
        let squares: f32 = (1..=500)
            .map(|cycle| {
                let turn = varied(cycle, 0.4).rotations[Joint::LeftShank.index()];
                turn.to_scaled_axis().x.to_degrees().powi(2)
            })
            .sum();
        let deviation = (squares / 500.0).sqrt();
        assert!((deviation - 1.73).abs() < 0.15, "{deviation}");
    }
}

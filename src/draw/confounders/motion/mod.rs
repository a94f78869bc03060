//! Confounders of motion: changes to poses, before they are drawn.
//!
//! Each effect changes the pose of one frame, given facts of the whole walk ([`GaitFacts`]) and a
//! strength: 0 changes no byte, 1 is the extreme that the effect's documentation states. No effect
//! puts the feet back on the floor; that requires a body and follows all effects. [`slope`] comes
//! last, since it places feet on a floor where the others leave them in the air.

mod arms;
mod excursion;
mod leg;
mod limp;
mod pace;
mod slope;
mod trunk;

pub(crate) use arms::{
    AROUND_BOX, AT_THE_BAR, ArmPose, UNDER_UMBRELLA, arm_still, around_box, at_the_bar,
    carried_arm, hands_in_pockets, phone_at_ear, raised, under_umbrella,
};
pub(crate) use limp::{limp, limp_phase};
pub(crate) use pace::{age_gait, age_pace, skirt_gait, skirt_pace, speed, speed_pace};
pub(crate) use slope::{floor_normal, slope};
pub(crate) use trunk::load_lean;

use edgegait_core::pose::Pose;
use edgegait_core::skeleton::{JOINTS, Skeleton};
use glam::{DQuat, DVec3};

/// An effect on one frame; takes the pose, facts of its walk, and the strength.
pub(crate) type Effect = fn(&mut Pose, &GaitFacts, f64);

/// Facts of a whole walk that effects on a frame need.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GaitFacts {
    /// The mean rotation of each joint over the cycle, and the mean root, metres.
    pub mean: Pose,
    /// The walker's skeleton.
    pub skeleton: Skeleton,
    /// The distance travelled in a cycle, metres; 0 where the speed is unknown.
    pub stride_m: f64,
    /// The duration of a cycle, seconds.
    pub duration_s: f64,
}

impl GaitFacts {
    /// Computes the facts of a walk from evenly spaced poses of one cycle, at `speed_mps` (0:
    /// unknown). The mean of no poses is the rest pose.
    ///
    /// A mean rotation is the normalized sum of the unit quaternions, each with the sign that
    /// is nearer to the first (Gramkow 2001, J. Math. Imaging Vis. 15:7-16): within 0.1 % of
    /// the least-squares mean for rotations within 40 degrees of each other.
    #[must_use]
    pub(crate) fn from_poses(
        skeleton: Skeleton,
        cycle: impl IntoIterator<Item = Pose>,
        speed_mps: f64,
        duration_s: f64,
    ) -> Self {
        let mut sums = [DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0); JOINTS];
        let (mut root, mut poses) = (DVec3::ZERO, 0u32);
        for pose in cycle {
            root += pose.root.as_dvec3();
            poses += 1;
            for (sum, rotation) in sums.iter_mut().zip(pose.rotations) {
                let rotation = rotation.as_dquat();
                let nearer = if sum.dot(rotation) < 0.0 {
                    -rotation
                } else {
                    rotation
                };
                *sum += nearer;
            }
        }
        let mean = match poses {
            0 => Pose::REST,
            _ => Pose {
                root: (root / f64::from(poses)).as_vec3(),
                rotations: sums.map(|sum| sum.normalize().as_quat()),
            },
        };
        Self {
            mean,
            skeleton,
            stride_m: speed_mps * duration_s,
            duration_s,
        }
    }
}

#[cfg(test)]
mod tests;

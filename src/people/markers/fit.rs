//! Fits constant segment lengths, and joint angles whose forward kinematics follows the joints.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use super::joints::{MarkerJoints, each};
use super::neutral::Neutral;
use super::set::median;
use crate::people::residual::Residual;
use crate::people::retarget::follow::main_child;

/// A motion of constant segment lengths.
pub(super) struct FittedMotion {
    pub(super) offsets: [DVec3; JOINTS],
    pub(super) rotations: Vec<[DQuat; JOINTS]>,
    /// Joint positions: measured where markers determine them, else by forward kinematics.
    pub(super) positions: Vec<[DVec3; JOINTS]>,
    pub(super) residual: Residual,
}

/// Joints that hang straight below their parents in the canonical rest pose.
const HANGING: [Joint; 8] = [
    Joint::LeftForearm,
    Joint::LeftHand,
    Joint::LeftShank,
    Joint::LeftFoot,
    Joint::RightForearm,
    Joint::RightHand,
    Joint::RightShank,
    Joint::RightFoot,
];

/// Returns the walker's offsets: medians over the frames if both ends are measured, else the
/// neutral body's.
fn offsets(joints: &MarkerJoints, neutral: &Neutral) -> [DVec3; JOINTS] {
    std::array::from_fn(|index| {
        let joint = Joint::ALL[index];
        let Some(parent) = joint.parent() else {
            return DVec3::ZERO;
        };
        let (Some(near), Some(far)) = (joints.points(parent), joints.points(joint)) else {
            return neutral.offsets[index];
        };
        if HANGING.contains(&joint) {
            return -DVec3::Y * median(&mut each(near, far, DVec3::distance));
        }
        let Some(turns) = joints.turns(parent) else {
            return neutral.offsets[index];
        };
        let local = each(
            &each(near, far, |near, far| far - near),
            turns,
            |along, turn| turn.inverse() * along,
        );
        DVec3::from_array(std::array::from_fn(|axis| {
            median(&mut local.iter().map(|v| v[axis]).collect::<Vec<_>>())
        }))
    })
}

impl FittedMotion {
    /// Follows the joints from the pelvis outwards. Each segment turns as its markers do, then by
    /// the least rotation that points it from its start to the measured next joint. The residual is
    /// the change of the segments' lengths.
    pub(super) fn new(joints: &MarkerJoints, neutral: &Neutral) -> Self {
        let offsets = offsets(joints, neutral);
        let roots = joints.points(Joint::Pelvis).unwrap_or_default();
        let mut rotations = Vec::with_capacity(roots.len());
        let mut positions = Vec::with_capacity(roots.len());
        let mut residual = Residual::default();
        for (frame, root) in roots.iter().enumerate() {
            let mut reached = [*root; JOINTS];
            let mut globals = [DQuat::IDENTITY; JOINTS];
            for joint in Joint::ALL {
                let i = joint.index();
                let parent = joint.parent().map(Joint::index);
                let carried = parent.map_or(DQuat::IDENTITY, |p| globals[p]);
                if let Some(p) = parent {
                    reached[i] = reached[p] + globals[p] * offsets[i];
                }
                let mut turn = match joints.turns(joint) {
                    Some(turns) => turns[frame],
                    None if joints.points(joint).is_some() && !is_end(joints, joint) => carried,
                    None => neutral.turn(joint, carried, frame),
                };
                if let Some(child) = main_child(joint)
                    && let Some(points) = joints.points(child)
                    && let Some(along) = (points[frame] - reached[i]).try_normalize()
                    && let Some(now) = (turn * offsets[child.index()]).try_normalize()
                {
                    turn = DQuat::from_rotation_arc(now, along) * turn;
                }
                globals[i] = turn.normalize();
            }
            let measured: [Option<DVec3>; JOINTS] =
                std::array::from_fn(|i| joints.points(Joint::ALL[i]).map(|points| points[frame]));
            for (at, to) in reached.iter().zip(measured) {
                if let Some(to) = to {
                    residual.add(at.distance(to));
                }
            }
            positions.push(std::array::from_fn(|i| measured[i].unwrap_or(reached[i])));
            rotations.push(std::array::from_fn(|i| {
                let parent = Joint::ALL[i].parent();
                let parent = parent.map_or(DQuat::IDENTITY, |parent| globals[parent.index()]);
                (parent.inverse() * globals[i]).normalize()
            }));
        }
        Self {
            offsets,
            rotations,
            positions,
            residual,
        }
    }
}

/// Returns whether nothing beyond the joint was measured, so that its orientation follows the norm.
fn is_end(joints: &MarkerJoints, joint: Joint) -> bool {
    main_child(joint).is_some_and(|child| joints.points(child).is_none())
}

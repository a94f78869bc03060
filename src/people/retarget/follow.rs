//! Canonical rotations that follow a calibrated source skeleton, frame by frame.

use crate::people::retarget::rest_pose::{Globals, RestCalibration};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

/// Returns local rotations whose forward kinematics meets the source's joints.
///
/// Each joint turns as its source joint does, then by the least rotation that points it at its
/// child. The latter matters only where several source joints became one (the trunk) or where the
/// file moves joints.
pub(in crate::people) fn local_rotations(
    rest: &RestCalibration,
    world: DQuat,
    frame: &Globals,
    points: &[DVec3; JOINTS],
    offsets: &[DVec3; JOINTS],
) -> [DQuat; JOINTS] {
    /// Shortest segment whose direction is followed, metres.
    const SHORTEST_M: f64 = 0.02;
    let mut globals: [DQuat; JOINTS] = std::array::from_fn(|joint| {
        let part = &rest.parts[joint];
        world * frame.rotations[part.turns_with] * rest.zero[part.turns_with].inverse() * part.axes
    });
    let mut reached = *points;
    for joint in Joint::ALL {
        let i = joint.index();
        if let Some(parent) = joint.parent() {
            let parent = parent.index();
            reached[i] = reached[parent] + globals[parent] * offsets[i];
        }
        let Some(child) = main_child(joint) else {
            continue;
        };
        let c = child.index();
        // Clavicles make up for the trunk's fewer joints, so that the arms hang in their place.
        let is_clavicle = matches!(joint, Joint::LeftClavicle | Joint::RightClavicle);
        let from = if is_clavicle { reached[i] } else { points[i] };
        let along = points[c] - from;
        if along.length() > SHORTEST_M && offsets[c].length() > SHORTEST_M {
            let now = (globals[i] * offsets[c]).normalize();
            globals[i] = DQuat::from_rotation_arc(now, along.normalize()) * globals[i];
        }
    }
    std::array::from_fn(|joint| {
        let parent = Joint::ALL[joint].parent();
        let parent = parent.map_or(DQuat::IDENTITY, |parent| globals[parent.index()]);
        (parent.inverse() * globals[joint]).normalize()
    })
}

/// Returns the joint at the far end of a joint's own segment.
pub(in crate::people) const fn main_child(joint: Joint) -> Option<Joint> {
    Some(match joint {
        Joint::Spine => Joint::Thorax,
        Joint::Thorax => Joint::Neck,
        Joint::Neck => Joint::Head,
        Joint::LeftClavicle => Joint::LeftUpperArm,
        Joint::LeftUpperArm => Joint::LeftForearm,
        Joint::LeftForearm => Joint::LeftHand,
        Joint::RightClavicle => Joint::RightUpperArm,
        Joint::RightUpperArm => Joint::RightForearm,
        Joint::RightForearm => Joint::RightHand,
        Joint::LeftThigh => Joint::LeftShank,
        Joint::LeftShank => Joint::LeftFoot,
        Joint::RightThigh => Joint::RightShank,
        Joint::RightShank => Joint::RightFoot,
        _ => return None,
    })
}

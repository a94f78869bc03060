//! The canonical skeleton: 19 joints, their tree, and the offsets of one body.
//!
//! Every clip is stored for this skeleton and every body is built on it, so that any clip plays on
//! any avatar. The number of joints follows Charalambous & Bharath (BMVC 2016); their choice is
//! ours.

use glam::Vec3;

/// The number of joints of the canonical skeleton.
pub const JOINTS: usize = 19;

/// A joint of the canonical skeleton, in storage order: parents come first.
///
/// In the rest pose every joint's frame is parallel to the world (Y up, Z ahead,
/// X to the walker's left), legs and arms hang straight down along -Y, the trunk
/// and the head point along +Y and the feet along +Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Joint {
    /// Root, midway between the hip joint centres.
    Pelvis,
    /// Lumbar joint, about L4/L5.
    Spine,
    /// Base of the rib cage, about T12/L1.
    Thorax,
    /// Base of the neck, about C7/T1.
    Neck,
    /// Base of the skull.
    Head,
    /// Left sternoclavicular joint.
    LeftClavicle,
    /// Left shoulder.
    LeftUpperArm,
    /// Left elbow.
    LeftForearm,
    /// Left wrist.
    LeftHand,
    /// Right sternoclavicular joint.
    RightClavicle,
    /// Right shoulder.
    RightUpperArm,
    /// Right elbow.
    RightForearm,
    /// Right wrist.
    RightHand,
    /// Left hip.
    LeftThigh,
    /// Left knee.
    LeftShank,
    /// Left ankle.
    LeftFoot,
    /// Right hip.
    RightThigh,
    /// Right knee.
    RightShank,
    /// Right ankle.
    RightFoot,
}

impl Joint {
    /// All joints in storage order, parents first.
    pub const ALL: [Self; JOINTS] = [
        Self::Pelvis,
        Self::Spine,
        Self::Thorax,
        Self::Neck,
        Self::Head,
        Self::LeftClavicle,
        Self::LeftUpperArm,
        Self::LeftForearm,
        Self::LeftHand,
        Self::RightClavicle,
        Self::RightUpperArm,
        Self::RightForearm,
        Self::RightHand,
        Self::LeftThigh,
        Self::LeftShank,
        Self::LeftFoot,
        Self::RightThigh,
        Self::RightShank,
        Self::RightFoot,
    ];

    /// Returns the joint stored at `index`, if there is one.
    #[must_use]
    pub fn from_index(index: usize) -> Option<Self> {
        Self::ALL.get(index).copied()
    }

    /// Returns the position in storage order, below [`JOINTS`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Returns the joint that carries this one; `None` for the pelvis.
    #[must_use]
    pub const fn parent(self) -> Option<Self> {
        Some(match self {
            Self::Pelvis => return None,
            Self::Spine | Self::LeftThigh | Self::RightThigh => Self::Pelvis,
            Self::Thorax => Self::Spine,
            Self::Neck | Self::LeftClavicle | Self::RightClavicle => Self::Thorax,
            Self::Head => Self::Neck,
            Self::LeftUpperArm => Self::LeftClavicle,
            Self::LeftForearm => Self::LeftUpperArm,
            Self::LeftHand => Self::LeftForearm,
            Self::RightUpperArm => Self::RightClavicle,
            Self::RightForearm => Self::RightUpperArm,
            Self::RightHand => Self::RightForearm,
            Self::LeftShank => Self::LeftThigh,
            Self::LeftFoot => Self::LeftShank,
            Self::RightShank => Self::RightThigh,
            Self::RightFoot => Self::RightShank,
        })
    }

    /// Returns whether it is a joint of the left side.
    #[must_use]
    pub fn is_left(self) -> bool {
        // Left joints are stored before right ones.
        self < self.mirrored()
    }

    /// Returns the corresponding joint on the other side; midline joints are their own mirror.
    #[must_use]
    pub const fn mirrored(self) -> Self {
        match self {
            Self::LeftClavicle => Self::RightClavicle,
            Self::LeftUpperArm => Self::RightUpperArm,
            Self::LeftForearm => Self::RightForearm,
            Self::LeftHand => Self::RightHand,
            Self::LeftThigh => Self::RightThigh,
            Self::LeftShank => Self::RightShank,
            Self::LeftFoot => Self::RightFoot,
            Self::RightClavicle => Self::LeftClavicle,
            Self::RightUpperArm => Self::LeftUpperArm,
            Self::RightForearm => Self::LeftForearm,
            Self::RightHand => Self::LeftHand,
            Self::RightThigh => Self::LeftThigh,
            Self::RightShank => Self::LeftShank,
            Self::RightFoot => Self::LeftFoot,
            midline => midline,
        }
    }
}

/// The joint offsets of one body, for forward kinematics.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    /// The offset of each joint from its parent in the rest pose, metres, in the parent's frame;
    /// zero for the pelvis. Indexed by [`Joint::index`].
    pub offsets: [Vec3; JOINTS],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parents_come_before_their_children() {
        for (index, joint) in Joint::ALL.into_iter().enumerate() {
            assert_eq!(joint.index(), index);
            if let Some(parent) = joint.parent() {
                assert!(parent < joint, "{joint:?}");
            }
        }
    }

    #[test]
    fn the_left_joints_are_two_runs_of_the_storage_order() {
        for (index, joint) in Joint::ALL.into_iter().enumerate() {
            let is_left = (5..9).contains(&index) || (13..16).contains(&index);
            assert_eq!(joint.is_left(), is_left, "{joint:?}");
        }
    }

    #[test]
    fn mirroring_twice_changes_nothing_and_keeps_the_tree() {
        for joint in Joint::ALL {
            assert_eq!(joint.mirrored().mirrored(), joint);
            assert_eq!(
                joint.mirrored().parent(),
                joint.parent().map(Joint::mirrored)
            );
        }
    }
}

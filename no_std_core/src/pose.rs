//! Poses: joint rotations, and the joints' positions that follow from them.

use crate::skeleton::{JOINTS, Joint, Skeleton};
use glam::{Mat3, Quat, Vec3};

/// A pose relative to each joint's parent, as a clip decodes to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Pelvis position, metres; y is the height above the floor.
    pub root: Vec3,
    /// Rotation of each joint in its parent's frame; unit quaternions.
    pub rotations: [Quat; JOINTS],
}

impl Pose {
    /// The rest pose with the pelvis at the origin.
    pub const REST: Self = Self {
        root: Vec3::ZERO,
        rotations: [Quat::IDENTITY; JOINTS],
    };
}

/// A pose in the walker's space, which places the hulls.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelPose {
    /// Joint positions, metres.
    pub positions: [Vec3; JOINTS],
    /// Joint orientations; columns are the joint's axes.
    pub orientations: [Mat3; JOINTS],
}

impl ModelPose {
    /// All joints at the origin, not rotated.
    pub const REST: Self = Self {
        positions: [Vec3::ZERO; JOINTS],
        orientations: [Mat3::IDENTITY; JOINTS],
    };

    /// Applies forward kinematics: carries `pose` down the tree of `skeleton`.
    #[must_use]
    pub fn new(skeleton: &Skeleton, pose: &Pose) -> Self {
        let mut model = Self::REST;
        model.update(skeleton, pose);
        model
    }

    /// Applies forward kinematics in place, for the next frame.
    pub fn update(&mut self, skeleton: &Skeleton, pose: &Pose) {
        for joint in Joint::ALL {
            let local = Mat3::from_quat(pose.rotations[joint.index()]);
            let (position, orientation) = match joint.parent() {
                None => (pose.root, local),
                Some(parent) => {
                    let carrier = self.orientations[parent.index()];
                    let offset = skeleton.offsets[joint.index()];
                    (
                        self.positions[parent.index()] + carrier * offset,
                        carrier * local,
                    )
                }
            };
            self.positions[joint.index()] = position;
            self.orientations[joint.index()] = orientation;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::FRAC_PI_2;

    fn stick_figure() -> Skeleton {
        let mut offsets = [Vec3::ZERO; JOINTS];
        offsets[Joint::LeftThigh.index()] = Vec3::new(0.1, 0.0, 0.0);
        offsets[Joint::LeftShank.index()] = Vec3::new(0.0, -0.4, 0.0);
        offsets[Joint::LeftFoot.index()] = Vec3::new(0.0, -0.4, 0.0);
        Skeleton { offsets }
    }

    fn assert_near(found: Vec3, expected: Vec3) {
        assert!((found - expected).length() < 1e-6, "{found} {expected}");
    }

    #[test]
    fn a_thigh_raised_forward_points_along_z() {
        let mut pose = Pose::REST;
        pose.root = Vec3::new(0.0, 0.9, 0.0);
        // Flexion of the hip is a turn about -X: down (-Y) goes to ahead (+Z).
        pose.rotations[Joint::LeftThigh.index()] = Quat::from_rotation_x(-FRAC_PI_2);
        let model = ModelPose::new(&stick_figure(), &pose);
        assert_near(
            model.positions[Joint::LeftShank.index()],
            Vec3::new(0.1, 0.9, 0.4),
        );
        assert_near(
            model.positions[Joint::LeftFoot.index()],
            Vec3::new(0.1, 0.9, 0.8),
        );
    }

    #[test]
    fn a_knee_bends_in_the_frame_of_its_thigh() {
        let mut pose = Pose::REST;
        pose.rotations[Joint::LeftThigh.index()] = Quat::from_rotation_x(-FRAC_PI_2);
        pose.rotations[Joint::LeftShank.index()] = Quat::from_rotation_x(FRAC_PI_2);
        let model = ModelPose::new(&stick_figure(), &pose);
        assert_near(
            model.positions[Joint::LeftFoot.index()],
            Vec3::new(0.1, -0.4, 0.4),
        );
    }

    #[test]
    fn the_pelvis_turns_everything_about_itself() {
        let mut pose = Pose::REST;
        pose.rotations[Joint::Pelvis.index()] = Quat::from_rotation_y(FRAC_PI_2);
        let model = ModelPose::new(&stick_figure(), &pose);
        assert_near(
            model.positions[Joint::LeftThigh.index()],
            Vec3::new(0.0, 0.0, -0.1),
        );
    }
}

//! A walker's figure at one moment.

use edgegait_core::body::Figure;
use edgegait_core::pose::ModelPose;
use glam::Vec3;

/// A figure at one moment.
pub(super) struct PosedWalker<'a> {
    pub figure: Figure<'a>,
    pub model: ModelPose,
    pub pelvis: Vec3,
}

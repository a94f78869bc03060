//! Excursions: rotations of a joint from its mean over the cycle.

use super::GaitFacts;
use edgegait_core::pose::Pose;
use edgegait_core::skeleton::Joint;
use glam::DQuat;

/// Multiplies the angles of the excursions of `joints` by `factor`.
pub(super) fn scale(
    pose: &mut Pose,
    gait: &GaitFacts,
    joints: impl IntoIterator<Item = Joint>,
    factor: f64,
) {
    for joint in joints {
        let mean = gait.mean.rotations[joint.index()].as_dquat();
        turn(pose, joint, |rotation| scaled(rotation, mean, factor));
    }
}

/// Returns `rotation` with `factor` times its angle from `mean`, about the same axis.
pub(super) fn scaled(rotation: DQuat, mean: DQuat, factor: f64) -> DQuat {
    let excursion = mean.inverse() * rotation;
    let shorter = if excursion.w < 0.0 {
        -excursion
    } else {
        excursion
    };
    mean * DQuat::from_scaled_axis(factor * shorter.to_scaled_axis())
}

/// Replaces one joint's rotation.
pub(super) fn turn(pose: &mut Pose, joint: Joint, by: impl FnOnce(DQuat) -> DQuat) {
    let rotation = &mut pose.rotations[joint.index()];
    *rotation = by(rotation.as_dquat()).normalize().as_quat();
}

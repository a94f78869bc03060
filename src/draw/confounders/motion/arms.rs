//! Confounders of the arms: still, in the pockets, or carrying.

use super::GaitFacts;
use super::excursion::{scale, scaled, turn};
use edgegait_core::pose::Pose;
use edgegait_core::skeleton::Joint;
use glam::DQuat;

/// The joints of the left and of the right arm, from the trunk outwards.
const ARMS: [[Joint; 4]; 2] = [
    [
        Joint::LeftClavicle,
        Joint::LeftUpperArm,
        Joint::LeftForearm,
        Joint::LeftHand,
    ],
    [
        Joint::RightClavicle,
        Joint::RightUpperArm,
        Joint::RightForearm,
        Joint::RightHand,
    ],
];

/// The share of its swing that an arm keeps under a heavy load. Our choice.
const LOADED_SWING: f64 = 0.15;

/// Holds the right arm still. Strength 0..=1: the share that clavicle, shoulder, elbow and wrist
/// lose of their excursions about the mean pose.
pub(crate) fn arm_still(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        scale(pose, gait, ARMS[1], 1.0 - strength);
    }
}

/// Puts both hands into the trousers' pockets. Strength 0..=1: the share of the way from the
/// swinging arms to that pose.
///
/// The pose is ours, chosen by looking: upper arms 20 degrees back and 16 out, turned in by 30;
/// elbows bent by 48 degrees, wrists beside the front of the hips.
pub(crate) fn hands_in_pockets(pose: &mut Pose, _gait: &GaitFacts, strength: f64) {
    if strength == 0.0 {
        return;
    }
    for (arm, side) in ARMS.into_iter().zip([1.0, -1.0]) {
        let degrees = |angle: f64| angle.to_radians();
        let pocketed = [
            DQuat::IDENTITY,
            DQuat::from_rotation_x(degrees(20.0))
                * DQuat::from_rotation_z(degrees(side * 16.0))
                * DQuat::from_rotation_y(degrees(-side * 30.0)),
            DQuat::from_rotation_x(degrees(-48.0)),
            DQuat::IDENTITY,
        ];
        for (joint, target) in arm.into_iter().zip(pocketed) {
            turn(pose, joint, |rotation| rotation.slerp(target, strength));
        }
    }
}

/// Lets the right arm hang as if it carried a suitcase: straight down except for 8 degrees
/// outwards and 6 degrees at the elbow, with 15 % of its swing. Strength 0..=1: the share of the
/// way from the swinging arm to that pose. The angles are ours.
pub(crate) fn carried_arm(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let mean = |joint: Joint| gait.mean.rotations[joint.index()].as_dquat();
    let shoulder =
        mean(Joint::Pelvis) * mean(Joint::Spine) * mean(Joint::Thorax) * mean(Joint::RightClavicle);
    let hanging = [
        mean(Joint::RightClavicle),
        shoulder.inverse() * DQuat::from_rotation_z((-8f64).to_radians()),
        DQuat::from_rotation_x((-6f64).to_radians()),
        DQuat::IDENTITY,
    ];
    for (joint, target) in ARMS[1].into_iter().zip(hanging) {
        let mean = mean(joint);
        turn(pose, joint, |rotation| {
            let swing = mean.inverse() * scaled(rotation, mean, LOADED_SWING);
            rotation.slerp(target * swing, strength)
        });
    }
}

//! Confounders of the arms: still, in the pockets, at the ear, or carrying.

use super::GaitFacts;
use super::excursion::{scale, scaled, turn};
use edgegait_core::pose::Pose;
use edgegait_core::skeleton::{Joint, Skeleton};
use glam::{DQuat, DVec3};

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

/// The pose of an arm against the chest, degrees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArmPose {
    /// The upper arm's tilt to the back and outwards, and its inward turn about its length.
    upper_arm_deg: [f64; 3],
    /// The bend of the elbow.
    elbow_deg: f64,
}

/// The poses are ours, chosen by looking: wrists beside the front of the hips, a hand at the ear,
/// before the shoulder, below a box before the belly, and on a bar before the chest.
const POCKETED: ArmPose = ArmPose {
    upper_arm_deg: [20.0, 16.0, 30.0],
    elbow_deg: 48.0,
};
const AT_THE_EAR: ArmPose = ArmPose {
    upper_arm_deg: [-75.0, 20.0, 20.0],
    elbow_deg: 143.0,
};
/// The right arm under an umbrella.
pub(crate) const UNDER_UMBRELLA: ArmPose = ArmPose {
    upper_arm_deg: [-10.0, 10.0, 25.0],
    elbow_deg: 115.0,
};
/// Both arms around a box.
pub(crate) const AROUND_BOX: ArmPose = ArmPose {
    upper_arm_deg: [-5.0, 8.0, 10.0],
    elbow_deg: 75.0,
};
/// Both arms behind a stroller.
pub(crate) const AT_THE_BAR: ArmPose = ArmPose {
    upper_arm_deg: [-15.0, 10.0, 10.0],
    elbow_deg: 60.0,
};

impl ArmPose {
    /// Returns the rotations of clavicle, upper arm, forearm and hand on the left (1) or right (-1).
    fn rotations(self, side: f64) -> [DQuat; 4] {
        let [back, out, turned_in] = self.upper_arm_deg.map(f64::to_radians);
        [
            DQuat::IDENTITY,
            DQuat::from_rotation_x(back)
                * DQuat::from_rotation_z(side * out)
                * DQuat::from_rotation_y(-side * turned_in),
            DQuat::from_rotation_x(-self.elbow_deg.to_radians()),
            DQuat::IDENTITY,
        ]
    }

    /// Returns the way from the left (1) or right (-1) shoulder to the wrist, metres.
    pub(crate) fn reach(self, skeleton: &Skeleton, side: f64) -> DVec3 {
        let [_, forearm, hand] =
            [1, 2, 3].map(|at| skeleton.offsets[ARMS[usize::from(side < 0.0)][at].index()]);
        let [_, upper, lower, _] = self.rotations(side);
        upper * (forearm.as_dvec3() + lower * hand.as_dvec3())
    }

    /// Takes an arm a share of the way to this pose.
    fn hold(self, pose: &mut Pose, side: f64, share: f64) {
        let arm = ARMS[usize::from(side < 0.0)];
        for (joint, target) in arm.into_iter().zip(self.rotations(side)) {
            turn(pose, joint, |rotation| rotation.slerp(target, share));
        }
    }
}

/// Puts both hands into the trousers' pockets. Strength 0..=1: the share of the way from the
/// swinging arms to that pose.
pub(crate) fn hands_in_pockets(pose: &mut Pose, _gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        for side in [1.0, -1.0] {
            POCKETED.hold(pose, side, strength);
        }
    }
}

/// Holds a phone at the right ear. Strength 0..=1: the share of the way from the swinging arm to
/// that pose.
pub(crate) fn phone_at_ear(pose: &mut Pose, _gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        AT_THE_EAR.hold(pose, -1.0, strength);
    }
}

/// Returns how far what is held is raised: wholly from a strength of a quarter on, since nobody
/// half raises an umbrella. Above this, only sizes grow.
pub(crate) const fn raised(strength: f64) -> f64 {
    (4.0 * strength).min(1.0)
}

/// Holds an umbrella with the right hand before the shoulder.
pub(crate) fn under_umbrella(pose: &mut Pose, _gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        UNDER_UMBRELLA.hold(pose, -1.0, raised(strength));
    }
}

/// Holds a box before the belly with both hands.
pub(crate) fn around_box(pose: &mut Pose, _gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        for side in [1.0, -1.0] {
            AROUND_BOX.hold(pose, side, raised(strength));
        }
    }
}

/// Holds the bar of a stroller with both hands.
pub(crate) fn at_the_bar(pose: &mut Pose, _gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        for side in [1.0, -1.0] {
            AT_THE_BAR.hold(pose, side, raised(strength));
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

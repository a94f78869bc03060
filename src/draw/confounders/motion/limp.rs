//! A limp: the right leg moves less and bears weight for a shorter time, and the trunk leans over
//! it.

use super::GaitFacts;
use super::excursion::scale;
use super::trunk::sway;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::skeleton::Joint;
use std::f64::consts::TAU;

/// The share of the excursions at hips, knee and ankle that strength 1 takes away. The right hip
/// keeps the range of severe osteoarthritis (about 24 instead of 40 degrees; Hurwitz et al. 1997,
/// J. Orthop. Res. 15:629-635, as recalled). The rest is ours: the left leg takes shorter steps
/// too, or it would land in the air, and the right toes clear the floor.
const STIFFNESS: [(Joint, f64); 4] = [
    (Joint::RightThigh, 0.4),
    (Joint::RightShank, 0.1),
    (Joint::RightFoot, 0.6),
    (Joint::LeftThigh, 0.25),
];

/// Lean of the trunk over the right leg while it bears weight, degrees: Duchenne's limp, which
/// clinicians call marked at 10 degrees (our choice).
const SWAY_DEG: f64 = 10.0;

/// Difference of the ankles' heights at which most of the weight is on the lower foot, metres.
/// Our choice: half of the rise of a heel before its toes lift.
const BEARING_M: f64 = 0.06;

/// Modulation of time at strength 1. Our choice: the single support of the right leg lasts 0.68 of
/// the left leg's, where each was 38 % of the cycle (healthy walkers: within 0.05 of 1; hemiplegic
/// walkers: 0.5 to 0.9, as recalled).
const HURRY: f64 = 0.25;

/// The middle of the right leg's single support, as the phase of a cycle that begins with the
/// left heel's contact.
const RIGHT_BEARS: f64 = 0.8;

/// Makes the walker limp on the right leg. Strength 0..=1: at 1 the right leg keeps 60 % of its
/// excursions at the hip, 90 % at the knee and 40 % at the ankle, the left hip keeps 75 %, and
/// the trunk tips by 10 degrees to the right while the right foot bears weight. [`limp_phase`]
/// shortens the stance.
pub(crate) fn limp(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let ankles = ModelPose::new(&gait.skeleton, pose).positions;
    let height = |foot: Joint| f64::from(ankles[foot.index()].y);
    let rise = height(Joint::LeftFoot) - height(Joint::RightFoot);
    let borne = 0.5 + 0.5 * libm::tanh(rise / BEARING_M);
    for (joint, share) in STIFFNESS {
        scale(pose, gait, [joint], 1.0 - strength * share);
    }
    sway(pose, strength * SWAY_DEG * borne);
}

/// Returns the phase of the even walk for a phase of the limping walk (cycles; phase 0 is the
/// left heel's contact). The right leg's single support passes faster, by a quarter at strength 1,
/// and the left leg's passes slower.
///
/// A limping cycle begins and ends up to 0.04 cycles later in the even walk.
#[must_use]
pub(crate) fn limp_phase(phase: f64, strength: f64) -> f64 {
    phase + HURRY * strength / TAU * libm::sin(TAU * (phase - RIGHT_BEARS))
}

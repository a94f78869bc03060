//! A limp: one leg that moves less, bears less, and is leaned over.

use super::GaitFacts;
use super::excursion::scale;
use super::trunk::sway;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::skeleton::Joint;
use std::f64::consts::TAU;

/// What share of the excursions at hips, knee and ankle strength 1 takes away: the right hip keeps
/// those of severe osteoarthritis (a range of about 24 instead of 40 degrees; Hurwitz et al. 1997,
/// J. Orthop. Res. 15:629-635, as recalled). The rest is ours: the left leg steps shorter too, since
/// it would land in the air, and the right toes clear the floor.
const STIFFNESS: [(Joint, f64); 4] = [
    (Joint::RightThigh, 0.4),
    (Joint::RightShank, 0.1),
    (Joint::RightFoot, 0.6),
    (Joint::LeftThigh, 0.25),
];

/// Lean of the trunk over the right leg while it bears, degrees: Duchenne's limp, 10 degrees as
/// clinicians call marked (ours).
const SWAY_DEG: f64 = 10.0;

/// Difference of the ankles' heights at which most of the weight is on the lower foot, metres.
/// Ours: half of what a heel rises before its toes lift.
const BEARING_M: f64 = 0.06;

/// Modulation of time at strength 1. Ours: the right leg alone bears for 0.68 of the left's time
/// where each was 38 % of the cycle (healthy walkers: within 0.05 of 1; hemiplegic ones: 0.5 to
/// 0.9, as recalled).
const HURRY: f64 = 0.25;

/// Where a walker's right leg bears alone, in the middle of it: phase of a cycle that begins
/// with the left heel's contact.
const RIGHT_BEARS: f64 = 0.8;

/// Limps on the right leg. Strength 0..=1: at 1 the right leg keeps 60 % of its
/// excursions at the hip, 90 at the knee and 40 at the ankle, the left hip keeps 75 %, and the
/// trunk tips by 10 degrees to the right while the right foot bears. The shorter stance is in [`limp_phase`].
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

/// The phase of the even walk that a limping one is in at `phase` (cycles; phase 0 is the left
/// heel's contact): the time that the right leg alone bears passes faster, by a quarter at
/// strength 1, and the left leg's slower.
///
/// A cycle from phase 0 on begins up to 0.04 cycles later in the even walk, and ends as much
/// later in its next cycle.
#[must_use]
pub(crate) fn limp_phase(phase: f64, strength: f64) -> f64 {
    phase + HURRY * strength / TAU * libm::sin(TAU * (phase - RIGHT_BEARS))
}

//! Walking up and down a slope.

use super::GaitFacts;
use super::leg::PosedLeg;
use super::trunk::{Lean, lean};
use crate::people::forward_kinematics;
use edgegait_core::pose::Pose;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3, Quat, Vec3};

/// The slope at strength 1, degrees. Our choice: a steep footpath; the steepest streets have 19
/// degrees.
pub(crate) const MAX_SLOPE_DEG: f64 = 20.0;

/// The ratio of the lean of pelvis, spine and thorax together to the slope's angle, forwards
/// uphill and backwards downhill; the head stays level. The direction is from Leroux, Fung &
/// Barbeau (2002, Gait & Posture 15:64-74), the amount is ours.
const TRUNK_SHARE: f64 = 0.3;

/// The lean of the trunk by one degree.
const TRUNK: Lean = Lean {
    pelvis_deg: 1.0 / 3.0,
    spine_deg: 1.0 / 3.0,
    thorax_deg: 1.0 / 3.0,
    neck_deg: 0.0,
    head_deg: -1.0,
};

/// The slope below which overstretched knees gradually return, degrees: knees bend forwards on
/// steeper slopes, and poses change continuously at a level floor. Our choice.
const UNBENT_DEG: f64 = 2.0;

const LEGS: [[Joint; 3]; 2] = [
    [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
    [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
];

/// Returns the slope's angle, radians, upwards positive.
fn angle(strength: f64) -> f64 {
    (strength * MAX_SLOPE_DEG).to_radians()
}

/// Returns the upward normal of the floor of [`slope`], a unit vector. The floor passes through
/// the point below the pelvis at height 0.
#[must_use]
pub(crate) fn floor_normal(strength: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(angle(strength));
    DVec3::new(0.0, cos, -sin)
}

/// Puts the walk on a slope. Strength -1..=1: 1 is 20 degrees up, -1 is 20 degrees down.
///
/// Each foot keeps its distance ahead of the pelvis and its height over the floor: an ankle `z`
/// ahead and `h` above the level floor moves to the height `z tan(slope) + h / cos(slope)`, and
/// the foot turns with the floor. Hips and knees follow in closed form. Where a leg is too short,
/// the pelvis sinks.
pub(crate) fn slope(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let angle = angle(strength);
    let (sin, cos) = libm::sincos(angle);
    let (before, _) = placed(pose, gait);
    let root = pose.root.as_dvec3();
    lean(pose, TRUNK, TRUNK_SHARE * strength * MAX_SLOPE_DEG);
    let (positions, turns) = placed(pose, gait);
    let legs = LEGS.map(|[thigh, shank, foot]| PosedLeg {
        hip: positions[thigh.index()],
        knee: positions[shank.index()],
        ankle: positions[foot.index()],
        thigh: turns[thigh.index()],
        shank: turns[shank.index()],
    });
    let targets = LEGS.map(|[.., foot]| {
        let ankle = before[foot.index()];
        let height = ankle.y / cos + (ankle.z - root.z) * sin / cos;
        DVec3::new(ankle.x, height, ankle.z)
    });
    let sinks = legs.iter().zip(targets).map(|(leg, target)| {
        let aside = (target - leg.hip).with_y(0.0).length_squared();
        let reach = leg.reach();
        leg.hip.y - target.y - libm::sqrt((reach * reach - aside).max(0.0))
    });
    let sink = sinks.fold(0.0, f64::max);
    pose.root = (root - sink * DVec3::Y).as_vec3();
    let overstretch = (1.0 - (angle.to_degrees() / UNBENT_DEG).abs()).max(0.0);
    let tip = DQuat::from_rotation_x(-angle);
    let pelvis = turns[Joint::Pelvis.index()];
    for ((leg, target), [thigh, shank, foot]) in legs.iter().zip(targets).zip(LEGS) {
        let bent = leg.reaching(leg.hip - sink * DVec3::Y, target, overstretch);
        for (joint, carrier, own) in [
            (thigh, pelvis, bent.thigh),
            (shank, bent.thigh, bent.shank),
            (foot, bent.shank, tip * turns[foot.index()]),
        ] {
            pose.rotations[joint.index()] = (carrier.inverse() * own).normalize().as_quat();
        }
    }
}

/// Returns joint positions and orientations in the walker's space.
fn placed(pose: &Pose, gait: &GaitFacts) -> ([DVec3; JOINTS], [DQuat; JOINTS]) {
    forward_kinematics(
        &gait.skeleton.offsets.map(Vec3::as_dvec3),
        pose.root.as_dvec3(),
        &pose.rotations.map(Quat::as_dquat),
    )
}

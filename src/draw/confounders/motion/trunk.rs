//! Leans of the trunk, under which legs and arms keep their directions.

use super::GaitFacts;
use super::excursion::turn;
use edgegait_core::pose::Pose;
use edgegait_core::skeleton::Joint;
use glam::DQuat;

/// Lean of the trunk under a heavy backpack, degrees forward of the vertical, in equal parts at
/// pelvis, spine and thorax; the head keeps a sixth of it.
///
/// Children's trunks lean significantly more under loads of 20 % of their mass and more, with
/// stride and cadence unchanged (Hong & Brueggemann 2000, Gait & Posture 11:254-259); adults'
/// trunks lean by about 10 degrees under 20 to 40 % (Kinoshita 1985, Ergonomics 28:1347-1362, as
/// recalled).
const LOADED: Lean = Lean {
    pelvis_deg: 10.0 / 3.0,
    spine_deg: 10.0 / 3.0,
    thorax_deg: 10.0 / 3.0,
    neck_deg: 0.0,
    head_deg: -25.0 / 3.0,
};

/// The angles by which each part of the trunk tips forward from the part below it, degrees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lean {
    pub pelvis_deg: f64,
    pub spine_deg: f64,
    pub thorax_deg: f64,
    pub neck_deg: f64,
    pub head_deg: f64,
}

/// Leans the trunk forward as under a backpack. Strength 0..=1: 1 is 10 degrees, a load of about
/// a third of the walker's mass.
pub(crate) fn load_lean(pose: &mut Pose, _gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        lean(pose, LOADED, strength);
    }
}

/// Tips the trunk by `share` of a lean. Thighs and arms keep their directions.
pub(super) fn lean(pose: &mut Pose, lean: Lean, share: f64) {
    let tip = |degrees: f64| DQuat::from_rotation_x((share * degrees).to_radians());
    let before = pose.clone();
    for (joint, degrees) in [
        (Joint::Pelvis, lean.pelvis_deg),
        (Joint::Spine, lean.spine_deg),
        (Joint::Thorax, lean.thorax_deg),
        (Joint::Neck, lean.neck_deg),
        (Joint::Head, lean.head_deg),
    ] {
        turn(pose, joint, |rotation| rotation * tip(degrees));
    }
    for limb in [
        Joint::LeftThigh,
        Joint::RightThigh,
        Joint::LeftUpperArm,
        Joint::RightUpperArm,
    ] {
        let back = carried(pose, limb).inverse() * carried(&before, limb);
        turn(pose, limb, |rotation| back * rotation);
    }
}

/// Returns the orientation of a joint's parent.
fn carried(pose: &Pose, joint: Joint) -> DQuat {
    std::iter::successors(joint.parent(), |joint| joint.parent())
        .fold(DQuat::IDENTITY, |below, joint| {
            pose.rotations[joint.index()].as_dquat() * below
        })
}

/// Tips spine and thorax sideways by half of `degrees` each, to the walker's right; neck and head
/// undo half of it.
pub(super) fn sway(pose: &mut Pose, degrees: f64) {
    let tip = |share: f64| DQuat::from_rotation_z((share * degrees).to_radians());
    for (joint, share) in [
        (Joint::Spine, 0.5),
        (Joint::Thorax, 0.5),
        (Joint::Neck, -0.25),
        (Joint::Head, -0.25),
    ] {
        turn(pose, joint, |rotation| rotation * tip(share));
    }
}

//! One person's pose at one phase, from the norm's angles and the person's deviations.

use super::angles::AngleNorm;
use super::norms::Angle;
use super::style::{Side, Style};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DQuat;

/// Standing anterior pelvic tilt, degrees: the mean at free walking speed (Schwartz
/// et al. 2008). The canonical rest pose stands like this.
pub(crate) const STANDING_TILT_DEG: f64 = 11.586;

/// Returns one person's angle on one side at a phase of the cycle, degrees.
pub(super) fn angle_of(
    style: &Style,
    norm: &AngleNorm,
    angle: Angle,
    side: Side,
    phase: f64,
) -> f64 {
    let own_phase = match side {
        Side::Left => phase,
        Side::Right => phase + 0.5,
    };
    let own = style.angle(angle, side);
    let (mean, swing) = norm.angle(angle, own_phase - own.phase);
    mean + offset_deg(style, norm, angle, side) + own.amplitude * swing
}

/// Returns how far one person's angle lies from the norm's mean, degrees.
///
/// The hip follows the pelvis and half of the knee, since the feet of a person who tips the
/// pelvis forward or bends the knees stay under the body.
fn offset_deg(style: &Style, norm: &AngleNorm, angle: Angle, side: Side) -> f64 {
    let own = style.angle(angle, side);
    let sd = norm.spread_deg(angle);
    let offset = own.offset_sd * sd + own.offset_deg;
    match angle {
        Angle::HipFlexion => {
            let pelvis = offset_deg(style, norm, Angle::PelvicTilt, Side::Left);
            offset + pelvis + 0.5 * offset_deg(style, norm, Angle::KneeFlexion, side)
        }
        _ => offset,
    }
}

/// Returns local rotations at a phase from the angles alone, wherever the feet then are.
pub(super) fn pose(style: &Style, norm: &AngleNorm, phase: f64) -> [DQuat; JOINTS] {
    let mut rotations = [DQuat::IDENTITY; JOINTS];
    let of = |angle, side| angle_of(style, norm, angle, side, phase).to_radians();
    let left = |angle| of(angle, Side::Left);
    let standing = STANDING_TILT_DEG.to_radians();

    let pelvis = turn_y(-left(Angle::PelvicRotation))
        * turn_z(left(Angle::PelvicObliquity))
        * turn_x(left(Angle::PelvicTilt) - standing);
    let thorax = turn_y(-left(Angle::ThoraxRotation))
        * turn_z(left(Angle::ThoraxObliquity))
        * turn_x(left(Angle::ThoraxTilt));
    // The spine and the thorax share the turn of the trunk. The neck and the head undo it, so
    // that the person looks ahead, at the style's head pitch.
    let trunk = half(pelvis.inverse() * thorax);
    let neck = half(thorax.inverse() * turn_x(style.head_pitch_deg.to_radians()));
    rotations[Joint::Pelvis.index()] = pelvis;
    rotations[Joint::Spine.index()] = trunk;
    rotations[Joint::Thorax.index()] = trunk;
    rotations[Joint::Neck.index()] = neck;
    rotations[Joint::Head.index()] = neck;

    for (side, leg, arm) in [
        (
            Side::Left,
            [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
            [Joint::LeftUpperArm, Joint::LeftForearm],
        ),
        (
            Side::Right,
            [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
            [Joint::RightUpperArm, Joint::RightForearm],
        ),
    ] {
        // Turns about Y and Z have opposite senses on the two sides.
        let sign = match side {
            Side::Left => 1.0,
            Side::Right => -1.0,
        };
        let hip_rotation = of(Angle::HipRotation, side);
        let [thigh, shank, foot] = leg;
        rotations[thigh.index()] = turn_x(standing - of(Angle::HipFlexion, side))
            * turn_z(-sign * of(Angle::HipAdduction, side))
            * turn_y(-sign * hip_rotation);
        rotations[shank.index()] = turn_x(of(Angle::KneeFlexion, side));
        // The foot compensates for the turn of pelvis and hip, and keeps its own direction.
        let turned = of(Angle::PelvicRotation, side) + hip_rotation;
        rotations[foot.index()] = turn_x(-of(Angle::AnkleDorsiflexion, side))
            * turn_y(-sign * (of(Angle::FootProgression, side) - turned));
        let [upper_arm, forearm] = arm;
        rotations[upper_arm.index()] = upper_arm_of(style, norm, side, phase);
        rotations[forearm.index()] = turn_x(-of(Angle::ElbowFlexion, side).max(0.0));
    }
    rotations
}

/// Returns the local rotation of an upper arm at a phase.
pub(super) fn upper_arm_of(style: &Style, norm: &AngleNorm, side: Side, phase: f64) -> DQuat {
    let of = |angle| angle_of(style, norm, angle, side, phase).to_radians();
    let sign = match side {
        Side::Left => 1.0,
        Side::Right => -1.0,
    };
    turn_x(-of(Angle::ShoulderFlexion))
        * turn_z(sign * of(Angle::ShoulderAbduction))
        * turn_y(-sign * style.elbow_plane_deg.to_radians())
}

pub(super) fn turn_x(angle: f64) -> DQuat {
    DQuat::from_rotation_x(angle)
}

pub(super) fn turn_y(angle: f64) -> DQuat {
    DQuat::from_rotation_y(angle)
}

pub(super) fn turn_z(angle: f64) -> DQuat {
    DQuat::from_rotation_z(angle)
}

/// Returns the rotation that gives `whole` when applied twice.
fn half(whole: DQuat) -> DQuat {
    let whole = if whole.w < 0.0 { -whole } else { whole };
    DQuat::from_scaled_axis(0.5 * whole.to_scaled_axis())
}

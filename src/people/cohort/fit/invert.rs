//! The norms' angles of a pose: the inverse of `pose::pose`.

use super::super::pose::STANDING_TILT_DEG;
use crate::people::cohort::norms::Angle;
use crate::people::forward_kinematics;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3, EulerRot};

/// The angles of one side of a pose, degrees.
#[derive(Clone, Copy, Debug)]
pub(super) struct SideAngles {
    /// In the order of [`Angle`].
    pub angles: [f64; 15],
    /// Direction of the foot over the floor, internal. Laboratories call this foot progression;
    /// the foot progression in `angles` is the angle by which [`super::super::pose`] turns the
    /// ankle.
    pub foot_direction: f64,
    /// How far the plane in which the elbow bends is turned inwards about the upper arm.
    pub upper_arm_turn: f64,
}

/// Returns the angles of a pose on the left and the right side.
pub(super) fn sides(pose: &[DQuat; JOINTS]) -> [SideAngles; 2] {
    let (_, globals) = forward_kinematics(&[DVec3::ZERO; JOINTS], DVec3::ZERO, pose);
    [1.0, -1.0].map(|sign| {
        let of = |joint: Joint| if sign > 0.0 { joint } else { joint.mirrored() };
        let local = |joint: Joint| pose[of(joint).index()];
        let trunk = |joint: Joint| {
            let (y, z, x) = globals[joint.index()].to_euler(EulerRot::YZX);
            [x, sign * z, -sign * y].map(f64::to_degrees)
        };
        let limb = |rotation: DQuat| {
            let (x, z, y) = rotation.to_euler(EulerRot::XZY);
            [x, sign * z, -sign * y].map(f64::to_degrees)
        };
        let [pelvic_tilt, pelvic_obliquity, pelvic_rotation] = trunk(Joint::Pelvis);
        let [thorax_tilt, thorax_obliquity, thorax_rotation] = trunk(Joint::Thorax);
        let [hip, abduction, hip_rotation] = limb(local(Joint::LeftThigh));
        let [knee, ..] = limb(local(Joint::LeftShank));
        let [ankle, _, foot] = limb(local(Joint::LeftFoot));
        let upper_arm = local(Joint::LeftClavicle) * local(Joint::LeftUpperArm);
        let [shoulder, shoulder_abduction, arm_turn] = limb(upper_arm);
        let forearm = local(Joint::LeftForearm);
        let along = forearm * -DVec3::Y;
        let elbow = libm::acos((-along.y).clamp(-1.0, 1.0)).to_degrees();
        let bent_to = libm::atan2(along.x, along.z).to_degrees();
        let ahead = globals[of(Joint::LeftFoot).index()] * DVec3::Z;
        SideAngles {
            angles: [
                pelvic_tilt + STANDING_TILT_DEG,
                pelvic_obliquity,
                pelvic_rotation,
                STANDING_TILT_DEG - hip,
                -abduction,
                hip_rotation,
                knee,
                -ankle,
                foot + pelvic_rotation + hip_rotation,
                thorax_tilt,
                thorax_obliquity,
                thorax_rotation,
                -shoulder,
                shoulder_abduction,
                elbow,
            ],
            foot_direction: -sign * libm::atan2(ahead.x, ahead.z).to_degrees(),
            upper_arm_turn: arm_turn - sign * bent_to,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::angles::AngleNorm;
    use super::super::super::pose::{angle_of, pose};
    use super::super::super::style::{Side, Style};
    use super::super::super::{Person, anthropometry::PopulationNorms};
    use super::*;
    use edgegait_core::pack::Sex;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn angles_of_a_pose_are_those_that_it_was_made_of() {
        let dimensions = Person::average(Sex::Female).dimensions;
        assert!(
            (dimensions.stature - PopulationNorms::for_sex(Sex::Female).stature.0).abs() < 1e-12
        );
        for seed in 0..20 {
            let style = Style::random(&mut ChaCha8Rng::seed_from_u64(seed));
            for (speed_kmh, phase) in [(3.0, 0.1), (5.0, 0.63), (7.0, 0.9), (10.0, 0.35)] {
                let norm = AngleNorm::at(&dimensions, speed_kmh);
                let found = sides(&pose(&style, &norm, phase));
                for (side, found) in [Side::Left, Side::Right].into_iter().zip(found) {
                    for (angle, found) in Angle::ALL.into_iter().zip(found.angles) {
                        let mut expected = angle_of(&style, &norm, angle, side, phase);
                        // Pelvis and thorax follow the left side's angles.
                        let trunk = [
                            Angle::PelvicTilt,
                            Angle::PelvicObliquity,
                            Angle::PelvicRotation,
                            Angle::ThoraxTilt,
                            Angle::ThoraxObliquity,
                            Angle::ThoraxRotation,
                        ];
                        if side == Side::Right && trunk.contains(&angle) {
                            expected = angle_of(&style, &norm, angle, Side::Left, phase);
                            if !matches!(angle, Angle::PelvicTilt | Angle::ThoraxTilt) {
                                expected = -expected;
                            }
                        }
                        // The foot compensates for the turn of the pelvis's own right side.
                        if side == Side::Right && angle == Angle::FootProgression {
                            let of =
                                |side| angle_of(&style, &norm, Angle::PelvicRotation, side, phase);
                            expected -= of(Side::Right) + of(Side::Left);
                        }
                        if angle == Angle::ElbowFlexion {
                            expected = expected.max(0.0);
                        }
                        assert!(
                            (expected - found).abs() < 1e-6,
                            "{angle:?} {side:?} at {speed_kmh} km/h: {expected} {found}"
                        );
                    }
                    assert!(
                        (found.upper_arm_turn - style.elbow_plane_deg).abs() < 1e-6
                            || found.angles[14] < 1e-3
                    );
                }
            }
        }
    }
}

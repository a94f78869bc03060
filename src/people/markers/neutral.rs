//! The motion of parts without markers: the norm of adults, on a body of the walker's size.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use super::joints::{MarkerJoints, each};
use super::set::median;
use crate::people::cohort::anthropometry::{DIMENSIONS, Dimensions, PopulationNorms};
use crate::people::cohort::{ELBOW_FLEXION, SHOULDER_ABDUCTION, SHOULDER_FLEXION, WALKING, body};
use crate::people::cutting::contacts::averaged_heading;
use edgegait_core::pack::Sex;

/// The neutral body and its motion.
pub(super) struct Neutral {
    /// Joint offsets of an average person of the walker's stature, metres.
    pub(super) offsets: [DVec3; JOINTS],
    /// Upright, facing with the pelvis, by frame.
    upright: Vec<DQuat>,
    /// The swing of the left and the right thigh ahead of its median, radians, by frame.
    swing: [Vec<f64>; 2],
}

impl Neutral {
    /// Builds the neutral body of a walker whose pelvis and legs are known.
    ///
    /// # Errors
    /// If no person has this stature.
    pub(super) fn new(
        joints: &MarkerJoints,
        sample_rate_hz: f64,
        stature_m: f64,
    ) -> Result<Self, String> {
        let bmi = |sex| PopulationNorms::for_sex(sex).bmi.0;
        let mass_kg = 0.5 * (bmi(Sex::Female) + bmi(Sex::Male)) * stature_m * stature_m;
        let dimensions = Dimensions::expected(stature_m, mass_kg, None, &[0.0; DIMENSIONS])
            .map_err(|error| error.to_string())?;
        let pelvis = joints.turns(Joint::Pelvis).unwrap_or_default();
        let heading = averaged_heading(pelvis, sample_rate_hz);
        let swing = [Joint::LeftThigh, Joint::RightThigh].map(|thigh| {
            let turns = joints.turns(thigh).unwrap_or_default();
            let mut angles = each(turns, &heading, |turn, ahead| {
                let down = turn * -DVec3::Y;
                libm::atan2(down.dot(ahead), -down.y)
            });
            let middle = median(&mut angles.clone());
            for angle in &mut angles {
                *angle -= middle;
            }
            angles
        });
        Ok(Self {
            offsets: body::offsets(&dimensions),
            upright: heading
                .iter()
                .map(|ahead| DQuat::from_rotation_y(libm::atan2(ahead.x, ahead.z)))
                .collect(),
            swing,
        })
    }

    /// Returns the world orientation of a joint without markers in a frame. `parent` is the
    /// orientation of its parent.
    ///
    /// Trunk and head stay upright, as the norm's thorax does within a few degrees. Arms swing with
    /// the opposite leg about the norms' means. Their amplitude is the thigh's swing times the
    /// ratio of the first harmonics of the shoulder's or elbow's norm and the hip's.
    pub(super) fn turn(&self, joint: Joint, parent: DQuat, frame: usize) -> DQuat {
        let amplitude = |harmonics: &[(f64, f64)]| {
            harmonics
                .first()
                .map_or(0.0, |(cosine, sine)| libm::hypot(*cosine, *sine))
        };
        let hip = amplitude(WALKING[2].hip_flexion.harmonics);
        let other = self.swing[usize::from(joint.is_left())]
            .get(frame)
            .copied()
            .unwrap_or_default();
        let sign = if joint.is_left() { 1.0 } else { -1.0 };
        let bend = |curve: &crate::people::cohort::AngleCurve| {
            curve.mean.to_radians() + other * amplitude(curve.harmonics) / hip
        };
        match joint {
            Joint::Spine | Joint::Thorax | Joint::Neck | Joint::Head => {
                self.upright.get(frame).copied().unwrap_or(parent)
            }
            Joint::LeftUpperArm | Joint::RightUpperArm => {
                parent
                    * DQuat::from_rotation_x(-bend(&SHOULDER_FLEXION))
                    * DQuat::from_rotation_z(sign * SHOULDER_ABDUCTION.mean.to_radians())
                    * DQuat::from_rotation_y(-sign * 20f64.to_radians())
            }
            Joint::LeftForearm | Joint::RightForearm => {
                parent * DQuat::from_rotation_x(-bend(&ELBOW_FLEXION).max(0.0))
            }
            _ => parent,
        }
    }
}

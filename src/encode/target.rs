//! Targets for the encoding of cycles, and the measurement of errors.

use super::fourier::FourierBasis;
use super::frames::{VIRTUAL_POINT_M, VIRTUAL_POINTS};
use crate::error::{EncodeError, Result};
use crate::people::cleaning::flips::{MotionEnds, first_flip, largest_step_deg};
use crate::people::{Cycle, forward_kinematics};
use edgegait_core::clip::Loop;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{DMat3, DQuat, DVec3, Vec3};

/// The minimum number of frames of a cycle: enough for three harmonics.
const MIN_FRAMES: usize = 8;

/// A cycle on its walker's skeleton, with the true positions of its joints.
#[derive(Clone, Debug)]
pub(super) struct EncodingTarget<'a> {
    pub(super) cycle: &'a Cycle,
    pub(super) skeleton: Skeleton,
    pub(super) offsets: [DVec3; JOINTS],
    pub(super) series: FourierBasis,
    /// The orientations by frame and joint, in the walker's space.
    pub(super) orientations: Vec<[DQuat; JOINTS]>,
    /// The virtual points by frame and joint, metres.
    pub(super) points: Vec<[[DVec3; VIRTUAL_POINTS]; JOINTS]>,
}

/// Returns a joint's virtual points.
#[inline]
pub(super) fn virtual_points(position: DVec3, orientation: DQuat) -> [DVec3; VIRTUAL_POINTS] {
    around(position, DMat3::from_quat(orientation))
}

/// Returns a joint's virtual points for an orientation as a matrix.
#[inline]
pub(super) fn around(position: DVec3, axes: DMat3) -> [DVec3; VIRTUAL_POINTS] {
    let x = axes.x_axis * VIRTUAL_POINT_M;
    let y = axes.y_axis * VIRTUAL_POINT_M;
    let z = axes.z_axis * VIRTUAL_POINT_M;
    [
        position + x,
        position + y,
        position + z,
        position - x,
        position - y,
        position - z,
    ]
}

impl<'a> EncodingTarget<'a> {
    /// Creates the target of a cycle.
    ///
    /// # Errors
    /// For a cycle with fewer than 8 frames or more than 65,535, with numbers that are not
    /// finite, that does not close, or with a travel or period that the format does not hold.
    pub(super) fn new(cycle: &'a Cycle, skeleton: Skeleton) -> Result<Self> {
        check(cycle)?;
        let mut target = Self {
            cycle,
            offsets: skeleton.offsets.map(Vec3::as_dvec3),
            skeleton,
            series: FourierBasis::new(cycle.root.len()),
            orientations: Vec::with_capacity(cycle.root.len()),
            points: Vec::with_capacity(cycle.root.len()),
        };
        for (root, rotations) in cycle.root.iter().zip(&cycle.rotations) {
            let (positions, orientations) = forward_kinematics(&target.offsets, *root, rotations);
            let joints =
                std::array::from_fn(|joint| virtual_points(positions[joint], orientations[joint]));
            target.points.push(joints);
            target.orientations.push(orientations);
        }
        Ok(target)
    }

    /// Returns the number of frames of the cycle.
    pub(super) const fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns the greatest and mean error of each joint, as the core decodes the cycle.
    pub(super) fn measure(&self, cycle: &Loop<'_>) -> JointErrors {
        #[expect(clippy::cast_precision_loss, reason = "frames of a cycle")]
        let frames = self.len() as f64;
        let mut buffer = vec![0.0; cycle.expanded_len()];
        let expanded = cycle.expand(&mut buffer);
        let expanded = expanded.expect("a buffer of the length that it needs");
        joint_errors(
            self.len(),
            &self.skeleton,
            |frame| self.points[frame],
            |frame| {
                #[expect(
                    clippy::cast_precision_loss,
                    clippy::cast_possible_truncation,
                    reason = "the decoder takes f32"
                )]
                let phase = (frame as f64 / frames) as f32;
                expanded.pose(phase)
            },
        )
    }
}

/// The greatest and mean error of each joint, mm.
pub(super) type JointErrors = [(f64, f64); JOINTS];

/// Returns the greatest and mean distance of each joint's virtual points from the true ones, over
/// all frames, in the poses that the core decodes, mm.
pub(super) fn joint_errors(
    frames: usize,
    skeleton: &Skeleton,
    truth: impl Fn(usize) -> [[DVec3; VIRTUAL_POINTS]; JOINTS],
    pose: impl Fn(usize) -> Pose,
) -> JointErrors {
    let mut errors = [(0.0f64, 0.0f64); JOINTS];
    #[expect(clippy::cast_precision_loss, reason = "frames of a motion")]
    let points = (VIRTUAL_POINTS * frames) as f64;
    for frame in 0..frames {
        let model = ModelPose::new(skeleton, &pose(frame));
        for (joint, (points_there, error)) in truth(frame).iter().zip(&mut errors).enumerate() {
            let position = model.positions[joint].as_dvec3();
            let found = around(position, model.orientations[joint].as_dmat3());
            for (point, found) in points_there.iter().zip(found) {
                let off = point.distance(found) * 1e3;
                error.0 = error.0.max(off);
                error.1 += off / points;
            }
        }
    }
    errors
}

/// The largest distance of a pelvis from the origin: beyond it, the decoder's `f32` has steps of
/// 0.1 mm and more.
const FARTHEST_ROOT_M: f64 = 1e3;

/// Checks that no joint flips over between two frames, since no smooth curve goes through both.
///
/// # Errors
/// If a joint flips; the error names the first such joint and its frames, counted from 0.
pub(super) fn refuse_flips(
    rotations: &[[DQuat; JOINTS]],
    ends: MotionEnds,
    rate_hz: f64,
) -> Result<()> {
    first_flip(rotations, ends, rate_hz).map_or(Ok(()), |flip| {
        Err(EncodeError::Flip {
            joint: flip.joint,
            turned_deg: flip.turned_deg,
            before: flip.before,
            after: flip.after,
            most_deg: largest_step_deg(rate_hz),
            rate_hz,
        }
        .into())
    })
}

/// Checks that no joint turns full circle in a cycle, since its series of vectors does not close.
/// Followed without a jump, its last quaternion is then the opposite of the first.
///
/// # Errors
/// If a joint turns full circle; the error names the first such joint.
fn refuse_circles(rotations: &[[DQuat; JOINTS]]) -> Result<()> {
    for joint in Joint::ALL {
        let index = joint.index();
        let next = rotations.iter().cycle().skip(1);
        let opposite = rotations
            .iter()
            .zip(next)
            .filter(|(a, b)| a[index].dot(b[index]) < 0.0);
        if opposite.count() % 2 == 1 {
            return Err(EncodeError::FullCircle(joint).into());
        }
    }
    Ok(())
}

/// Checks that the format holds a cycle.
pub(super) fn check(cycle: &Cycle) -> Result<()> {
    let frames = cycle.root.len();
    if !(MIN_FRAMES..=usize::from(u16::MAX)).contains(&frames) || cycle.rotations.len() != frames {
        #[expect(clippy::cast_precision_loss, reason = "to be shown")]
        return Err(EncodeError::OutOfRange {
            what: "a gait cycle of",
            found: frames as f64,
            unit: "frames",
            expected: "8 to 65535",
        }
        .into());
    }
    let finite = cycle.root.iter().all(|root| root.is_finite())
        && cycle
            .rotations
            .iter()
            .flatten()
            .all(|rotation| rotation.is_normalized());
    if !finite {
        return Err(EncodeError::NotFinite("a gait cycle".into()).into());
    }
    if !(1e-6..=4_000.0).contains(&cycle.period_s) || !(-2e3..=2e3).contains(&cycle.drift_m) {
        return Err(EncodeError::CycleTooLong {
            period_s: cycle.period_s,
            drift_m: cycle.drift_m,
        }
        .into());
    }
    let farthest_m = cycle.root.iter().map(|root| root.abs().max_element());
    let farthest_m = farthest_m.fold(0.0, f64::max);
    if farthest_m > FARTHEST_ROOT_M {
        return Err(EncodeError::OutOfRange {
            what: "a gait cycle",
            found: farthest_m.round(),
            unit: "m from the origin",
            expected: "at most 1000 (move the walk to the origin)",
        }
        .into());
    }
    #[expect(clippy::cast_precision_loss, reason = "at most 65,535 frames")]
    let rate_hz = frames as f64 / cycle.period_s;
    refuse_flips(&cycle.rotations, MotionEnds::Meet, rate_hz)?;
    refuse_circles(&cycle.rotations)
}

/// Returns the greatest error of any joint, mm.
pub(super) fn worst(errors: &JointErrors) -> f64 {
    errors.iter().map(|joint| joint.0).fold(0.0, f64::max)
}

/// Returns the mean error of all joints, mm.
pub(super) fn mean(errors: &JointErrors) -> f64 {
    errors.iter().map(|joint| joint.1).sum::<f64>() / JOINTS as f64
}

/// Returns an error in units of 0.01 mm, rounded up so that it is never understated.
pub(super) fn hundredths(error_mm: f64) -> u16 {
    rounded_up(error_mm * 100.0)
}

/// Returns an error in units of 0.1 mm, rounded up.
pub(super) fn tenths(error_mm: f64) -> u16 {
    rounded_up(error_mm * 10.0)
}

pub(super) fn rounded_up(value: f64) -> u16 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let whole = value.ceil().clamp(0.0, 65_535.0) as u16;
    whole
}

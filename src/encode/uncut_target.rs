//! Targets for the encoding of uncut motions, and the measurement of errors.

use super::frames::VIRTUAL_POINTS;
use super::target::{around, virtual_points};
use crate::people::{UncutMotion, forward_kinematics};
use edgegait_core::clip::Clip;
use edgegait_core::codebook::Codebook;
use edgegait_core::pose::ModelPose;
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::TAU;

/// The largest heading, radians, up to which the heading stays in the pelvis's rotation, which the
/// codebook's frame suits.
const LARGEST_SWAY: f64 = 1.0;

/// A clip's bytes and encoding errors.
#[derive(Clone, Debug)]
pub struct EncodedClip {
    /// The bytes that [`Clip::parse`] reads.
    pub bytes: Vec<u8>,
    /// The greatest error over virtual points, joints and frames, mm.
    pub max_error_mm: f64,
}

/// The greatest errors by frame and joint, mm.
pub(super) type Errors = Vec<[f64; JOINTS]>;

/// The motion to encode, with the truth against which its errors are measured.
pub(super) struct Encoder<'a> {
    pub(super) span: &'a UncutMotion,
    pub(super) skeleton: &'a Skeleton,
    pub(super) codebook: &'a Codebook<'a>,
    pub(super) duration_us: u64,
    /// The true joint positions by frame.
    pub(super) positions: Vec<[DVec3; JOINTS]>,
    /// The true joint orientations by frame.
    pub(super) orientations: Vec<[DQuat; JOINTS]>,
    /// The heading by frame, radians.
    pub(super) heading: Vec<f64>,
}

impl<'a> Encoder<'a> {
    pub(super) fn new(
        span: &'a UncutMotion,
        skeleton: &'a Skeleton,
        codebook: &'a Codebook<'a>,
    ) -> Self {
        let offsets = skeleton.offsets.map(Vec3::as_dvec3);
        let frames = span.roots.iter().zip(&span.rotations);
        let (positions, orientations): (Vec<_>, Vec<[DQuat; JOINTS]>) = frames
            .map(|(root, rotations)| forward_kinematics(&offsets, *root, rotations))
            .unzip();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most 2^32 frames at 1 Hz or more"
        )]
        let duration_us =
            ((span.roots.len() - 1) as f64 / span.sample_rate_hz * 1e6).round() as u64;
        Self {
            span,
            skeleton,
            codebook,
            duration_us,
            heading: heading(&orientations),
            positions,
            orientations,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns the greatest and mean distance, mm, of the decoded virtual points from the true
    /// ones, and the greatest by frame and joint.
    pub(super) fn measure(&self, bytes: &[u8]) -> Option<(f64, f64, Errors)> {
        let take = Clip::parse(bytes, self.codebook).ok()?.as_uncut()?;
        let (mut max, mut sum) = (0.0f64, 0.0);
        let mut errors = Vec::with_capacity(self.len());
        for (frame, (positions, orientations)) in
            self.positions.iter().zip(&self.orientations).enumerate()
        {
            let pose = take.sample(frame as f64 / self.span.sample_rate_hz);
            let model = ModelPose::new(self.skeleton, &pose);
            errors.push(std::array::from_fn(|joint| {
                let mut most = 0.0f64;
                let truth = virtual_points(positions[joint], orientations[joint]);
                let position = model.positions[joint].as_dvec3();
                let found = around(position, model.orientations[joint].as_dmat3());
                for (point, found) in truth.iter().zip(found) {
                    let error = found.distance(*point) * 1e3;
                    sum += error;
                    most = most.max(error);
                }
                max = max.max(most);
                most
            }));
        }
        Some((
            max,
            sum / (self.len() * JOINTS * VIRTUAL_POINTS) as f64,
            errors,
        ))
    }
}

/// Returns the pelvis's turn about +Y, followed from frame to frame; 0 for a walker who always
/// looks ahead.
pub(super) fn heading(orientations: &[[DQuat; JOINTS]]) -> Vec<f64> {
    let mut last = 0.0;
    let looks: Vec<f64> = orientations
        .iter()
        .map(|frame| {
            // The twist of a swing and a twist (Dobrowolski 2015, arXiv:1506.05481).
            let pelvis = frame[Joint::Pelvis.index()];
            let angle = 2.0 * libm::atan2(pelvis.y, pelvis.w);
            last = angle - TAU * ((angle - last) / TAU).round();
            last
        })
        .collect();
    if looks.iter().all(|angle| angle.abs() < LARGEST_SWAY) {
        return vec![0.0; looks.len()];
    }
    looks
}

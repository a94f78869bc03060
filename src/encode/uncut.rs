//! Encoding of uncut motions as B-spline knots, within a stated error.
//!
//! Joints are fitted parents first, in a closed loop: a child aims at its true orientation in the
//! walker's space given its *decoded* parent. A search over knot intervals and steps finds the
//! fewest bytes whose error, measured with the core's decoder, is within the stated one. Where a
//! fit exceeds it by little, the moments with the largest errors weigh more in the next fit.

use super::target::{JointErrors, joint_errors, refuse_flips, virtual_points};
use super::uncut_fit::Fits;
use super::uncut_target::{EncodedClip, Encoder, heading};
use crate::error::{EncodeError, Result};
use crate::people::cleaning::flips::MotionEnds;
use crate::people::{UncutMotion, forward_kinematics};
use edgegait_core::clip::UncutClip;
use edgegait_core::codebook::Codebook;
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{DQuat, DVec3, Vec3};

/// The number of knot intervals to try, from two frames to [`LONGEST_INTERVAL_S`]. Our choice.
const INTERVALS: u32 = 8;
/// The longest knot interval to try, except the whole motion, seconds.
const LONGEST_INTERVAL_S: f64 = 0.25;
/// The number of frames on which knot interval and scale of longer motions are searched. Our
/// choice.
const SEARCH_FRAMES: usize = 2_400;
/// How much finer the scale of a whole motion usually is than that of its liveliest stretch. Our
/// choice.
const USUAL_LOSS: u8 = 4;
/// The coarsest scale to try: 32 m or radians and more.
const COARSEST: u8 = 200;

/// Encodes an uncut motion such that every virtual point is within `max_error_mm`. Where this
/// error cannot be reached, the finest encoding is returned; its [`EncodedClip::max_error_mm`]
/// states the error.
///
/// Time and memory are proportional to the frames.
///
/// # Errors
/// For a motion without frames, with numbers that are not finite, with rotations that are not
/// unit quaternions, in which a joint flips over, or at less than 1 or more than 10,000
/// frames a second.
pub fn encode_uncut(
    span: &UncutMotion,
    skeleton: &Skeleton,
    codebook: &Codebook<'_>,
    max_error_mm: f64,
) -> Result<EncodedClip> {
    check(span)?;
    let whole = Encoder::new(span, skeleton, codebook);
    let excerpt = whole.liveliest(SEARCH_FRAMES);
    let mut plans = match &excerpt {
        Some(span) => Encoder::new(span, skeleton, codebook).plans(max_error_mm),
        None => whole.plans(max_error_mm),
    };
    let found = if excerpt.is_none() {
        plans.sort_by_key(|plan| plan.found.bytes.len());
        plans.into_iter().next().map(|plan| plan.found)
    } else {
        whole.cheapest(&plans, max_error_mm)
    };
    found
        .or_else(|| whole.finest(max_error_mm))
        .ok_or_else(|| EncodeError::UncutTooFar.into())
}

/// Checks that the format holds an uncut motion.
pub(super) fn check(span: &UncutMotion) -> Result<()> {
    let frames = span.roots.len();
    if frames == 0 || span.rotations.len() != frames || u32::try_from(frames).is_err() {
        return Err(EncodeError::UncutFrames {
            roots: frames,
            poses: span.rotations.len(),
        }
        .into());
    }
    if !(1.0..=10_000.0).contains(&span.sample_rate_hz) {
        return Err(EncodeError::OutOfRange {
            what: "an uncut motion of",
            found: span.sample_rate_hz,
            unit: "frames a second",
            expected: "1 to 10,000",
        }
        .into());
    }
    let sound = |(root, pose): (&DVec3, &[DQuat; JOINTS])| {
        root.is_finite() && pose.iter().all(|rotation| rotation.is_normalized())
    };
    if let Some(frame) = span
        .roots
        .iter()
        .zip(&span.rotations)
        .position(|f| !sound(f))
    {
        return Err(EncodeError::NotFinite(format!("frame {frame} of an uncut motion")).into());
    }
    refuse_flips(&span.rotations, MotionEnds::Open, span.sample_rate_hz)
}

/// A knot interval with the coarsest scale that is good enough.
struct KnotPlan {
    interval_us: u32,
    scale: u8,
    found: EncodedClip,
}

impl Encoder<'_> {
    /// Returns the `frames` consecutive frames with the greatest accelerations, if the motion is
    /// longer.
    fn liveliest(&self, frames: usize) -> Option<UncutMotion> {
        if self.len() <= frames {
            return None;
        }
        let force = |three: &[[DVec3; JOINTS]]| -> f64 {
            let [a, b, c] = three else { return 0.0 };
            let joints = a.iter().zip(b).zip(c);
            joints
                .map(|((a, b), c)| (*a - 2.0 * *b + *c).length_squared())
                .sum()
        };
        let forces: Vec<f64> = self.positions.windows(3).map(force).collect();
        let mut sum: f64 = forces[..frames - 2].iter().sum();
        let (mut most, mut start) = (sum, 0);
        for (next, (out, into)) in forces.iter().zip(&forces[frames - 2..]).enumerate() {
            sum += into - out;
            if sum > most {
                (most, start) = (sum, next + 1);
            }
        }
        let range = start..start + frames;
        Some(UncutMotion {
            sample_rate_hz: self.span.sample_rate_hz,
            roots: self.span.roots[range.clone()].to_vec(),
            rotations: self.span.rotations[range].to_vec(),
        })
    }

    /// Returns the knot intervals to try, from the shortest.
    fn intervals_us(&self) -> Vec<u32> {
        let shortest = 2.0 / self.span.sample_rate_hz;
        let ratio = (LONGEST_INTERVAL_S / shortest).max(1.0);
        let mut list: Vec<u32> = (0..INTERVALS)
            .map(|i| shortest * ratio.powf(f64::from(i) / f64::from(INTERVALS - 1)))
            .map(microseconds)
            .collect();
        list.push(u32::try_from(self.duration_us).unwrap_or(u32::MAX).max(1));
        list.sort_unstable();
        list.dedup();
        list
    }

    /// Returns a plan for each knot interval that can be good enough. Longer intervals need finer
    /// scales.
    fn plans(&self, max_error_mm: f64) -> Vec<KnotPlan> {
        let mut plans: Vec<KnotPlan> = Vec::new();
        for interval_us in self.intervals_us() {
            let start = plans.last().map(|plan| plan.scale);
            match self.coarsest(interval_us, start, max_error_mm) {
                Some(plan) => plans.push(plan),
                None if plans.is_empty() => {}
                None => break,
            }
        }
        plans
    }

    /// Tries the plans of an excerpt on the whole motion: first the cheapest, then shorter knot
    /// intervals, if the whole needs a much finer scale, as long as they help.
    fn cheapest(&self, plans: &[KnotPlan], max_error_mm: f64) -> Option<EncodedClip> {
        let bytes = |&index: &usize| plans[index].found.bytes.len();
        let start = (0..plans.len()).min_by_key(bytes)?;
        let mut best: Option<EncodedClip> = None;
        for plan in plans[..=start].iter().rev() {
            let found = self.coarsest(plan.interval_us, Some(plan.scale), max_error_mm);
            let Some(found) = found else {
                continue;
            };
            let shorter = |best: &EncodedClip| found.found.bytes.len() < best.bytes.len();
            let is_best = best.as_ref().is_none_or(shorter);
            let is_usual = plan.scale.saturating_sub(found.scale) <= USUAL_LOSS;
            if is_best {
                best = Some(found.found);
            }
            if !is_best || is_usual {
                break;
            }
        }
        best
    }

    /// Returns the coarsest scale that is good enough, searched from `start` if there is one.
    fn coarsest(&self, interval_us: u32, start: Option<u8>, max_error_mm: f64) -> Option<KnotPlan> {
        let mut fits = Fits::new(self, interval_us);
        let mut good: Option<(u8, EncodedClip)> = None;
        let mut bad = COARSEST + 1;
        let mut reach = 2;
        let mut scale = start.unwrap_or(COARSEST / 2);
        loop {
            match fits.good(scale, max_error_mm) {
                Some(found) => good = Some((scale, found)),
                None => bad = scale,
            }
            // From the start in growing steps, then by halves.
            scale = match (&good, start) {
                (Some((low, _)), _) if bad - low <= 1 => break,
                (Some((low, _)), Some(_)) if bad > COARSEST => (low + reach).min(COARSEST),
                (Some((low, _)), _) => low + (bad - low) / 2,
                (None, _) if bad == 0 => return None,
                (None, Some(_)) => bad.saturating_sub(reach),
                (None, None) => bad / 2,
            };
            reach = reach.saturating_mul(2);
        }
        let (mut scale, mut found) = good?;
        // Errors rise with the scale, except by chance, which matters less with many frames.
        let lucks = if self.len() > SEARCH_FRAMES { 0 } else { 4 };
        for luck in 2..=lucks {
            if let Some(lucky) = fits.good(scale + luck, max_error_mm) {
                (scale, found) = (scale + luck, lucky);
                break;
            }
        }
        Some(KnotPlan {
            interval_us,
            scale,
            found,
        })
    }

    /// Encodes with one knot a frame: in the coarsest scale that is good enough, else in the finest
    /// that the format holds.
    fn finest(&self, max_error_mm: f64) -> Option<EncodedClip> {
        let interval_us = microseconds(1.0 / self.span.sample_rate_hz);
        if let Some(plan) = self.coarsest(interval_us, None, max_error_mm) {
            return Some(plan.found);
        }
        let fits = Fits::new(self, interval_us);
        (0..=COARSEST).find_map(|scale| Some(fits.encode(scale, &fits.weights)?.0))
    }
}

/// Returns an uncut motion's rotations without the walker's heading, as they are encoded.
pub(super) fn looking_ahead(span: &UncutMotion) -> Vec<[DQuat; JOINTS]> {
    let mut rotations = span.rotations.clone();
    for (pose, angle) in rotations.iter_mut().zip(heading(&span.rotations)) {
        let pelvis = &mut pose[Joint::Pelvis.index()];
        *pelvis = DQuat::from_rotation_y(-angle) * *pelvis;
    }
    rotations
}

/// Returns the greatest and mean error of each joint, as the core decodes the motion.
pub(super) fn measure_joints(
    span: &UncutMotion,
    skeleton: &Skeleton,
    take: &UncutClip<'_>,
) -> JointErrors {
    let offsets = skeleton.offsets.map(Vec3::as_dvec3);
    joint_errors(
        span.roots.len(),
        skeleton,
        |frame| {
            let (positions, orientations) =
                forward_kinematics(&offsets, span.roots[frame], &span.rotations[frame]);
            std::array::from_fn(|joint| virtual_points(positions[joint], orientations[joint]))
        },
        |frame| {
            #[expect(clippy::cast_precision_loss, reason = "at most 2^32 frames")]
            let seconds = frame as f64 / span.sample_rate_hz;
            take.sample(seconds)
        },
    )
}

/// Returns seconds as whole microseconds, at least one.
fn microseconds(seconds: f64) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few seconds; saturates"
    )]
    let microseconds = (seconds * 1e6).round() as u32;
    microseconds.max(1)
}

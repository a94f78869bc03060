//! Finds flips: joints that turn further between two frames than bodies can.
//!
//! No smooth curve goes through both frames, so the encoder rejects them.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DQuat;

/// Fastest rotation of a joint that is not a flip of the capture, degrees a second (30 degrees a
/// frame at 120 Hz), and the largest step at any rate, beyond which the direction of the turn is a
/// guess.
const FASTEST_DEG_S: f64 = 3_600.0;
const LARGEST_STEP_DEG: f64 = 75.0;

/// A joint that turns too far between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flip {
    /// The joint.
    pub joint: Joint,
    /// The frame before the flip.
    pub before: usize,
    /// The frame after the flip; 0 after the last frame of a cycle.
    pub after: usize,
    /// Angle of the turn, degrees.
    pub turned_deg: f64,
}

/// Whether the first frame follows the last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionEnds {
    /// The first frame follows the last: a gait cycle.
    Meet,
    /// The motion does not repeat: an uncut motion.
    Open,
}

/// Returns the largest angle by which a joint may turn between two frames at this rate, degrees.
#[must_use]
pub(crate) fn largest_step_deg(rate_hz: f64) -> f64 {
    (FASTEST_DEG_S / rate_hz).min(LARGEST_STEP_DEG)
}

/// Returns the first flip in frames at this rate, in the order of frames, then joints.
#[must_use]
pub(crate) fn first_flip(
    rotations: &[[DQuat; JOINTS]],
    ends: MotionEnds,
    rate_hz: f64,
) -> Option<Flip> {
    let most = largest_step_deg(rate_hz);
    steps(rotations.len(), ends).find_map(|(before, after)| {
        Joint::ALL.into_iter().find_map(|joint| {
            let turned_deg = step_deg(rotations, joint, before, after);
            (turned_deg > most).then_some(Flip {
                joint,
                before,
                after,
                turned_deg,
            })
        })
    })
}

/// Returns each frame with the one after it.
pub(in crate::people) fn steps(
    count: usize,
    ends: MotionEnds,
) -> impl Iterator<Item = (usize, usize)> {
    let last = match ends {
        MotionEnds::Meet => count,
        MotionEnds::Open => count.saturating_sub(1),
    };
    (0..last).map(move |frame| (frame, (frame + 1) % count))
}

fn step_deg(rotations: &[[DQuat; JOINTS]], joint: Joint, before: usize, after: usize) -> f64 {
    let joint = joint.index();
    rotations[before][joint]
        .angle_between(rotations[after][joint])
        .to_degrees()
}

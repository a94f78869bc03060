//! Flips: joints that turn further between two frames than bodies can.
//!
//! No smooth curve goes through both frames, so the encoder refuses them.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DQuat;

/// Fastest rotation of a joint that is not taken for a flip of the capture, degrees a second:
/// 30 degrees a frame at 120 Hz (DESIGN.md, section 4); and the largest step at any rate,
/// beyond which it is a guess which way a joint turned.
const FASTEST_DEG_S: f64 = 3_600.0;
const LARGEST_STEP_DEG: f64 = 75.0;

/// A joint that turns too far between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flip {
    /// The joint.
    pub joint: Joint,
    /// The frame before it.
    pub before: usize,
    /// The frame behind it; 0 behind the last of a cycle.
    pub after: usize,
    /// How far it turns, degrees.
    pub turned_deg: f64,
}

/// Whether the last frame is followed by the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionEnds {
    /// As of a gait cycle.
    Meet,
    /// As of a take.
    Open,
}

/// The most that a joint may turn between two frames at this rate, degrees.
#[must_use]
pub(crate) fn largest_step_deg(rate_hz: f64) -> f64 {
    (FASTEST_DEG_S / rate_hz).min(LARGEST_STEP_DEG)
}

/// The first flip in frames at this rate, by frame and joint.
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

/// Each frame with the one behind it.
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

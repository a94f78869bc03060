//! The reasons why there are no gait cycles.

use crate::budget::{CYCLE_FRAME_RATES_HZ, CYCLE_STEPS_PER_MINUTE};
use core::fmt;

/// The reason why no gait cycle is found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoCycle {
    /// There are too few frames: a whole cycle is needed, from one widest stance to the next but
    /// one. Two cycles are enough wherever they begin.
    TooShort {
        /// The number of frames.
        frames: u64,
    },
    /// More than half of the frames show nobody.
    Absent,
    /// A person is visible whose legs do not swing.
    Standing {
        /// The share of its mean by which the legs' outline swings, at most.
        swing: f32,
    },
    /// A wave below the range of steps swings at least 1.4 times as much as the strongest within:
    /// slower steps, or whole cycles of a walker who is seen obliquely from in front or behind.
    Slower {
        /// The number of its maxima in a minute.
        waves_per_minute: f32,
    },
    /// The legs' outline changes, but not in steps. The walker may be seen from in front or behind,
    /// where the outline hardly changes, may turn, be partly hidden or badly segmented, or have a
    /// cadence at which nobody walks.
    Irregular {
        /// The share of the change that one steady wave explains, 0..1.
        regular: f32,
    },
}

impl fmt::Display for NoCycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort { frames } => write!(
                f,
                "expected a whole gait cycle, found {frames} frames, which are too few (record two cycles or more)"
            ),
            Self::Absent => f.write_str(
                "expected a person in at least half of the frames, found fewer (check the segmentation)",
            ),
            Self::Standing { swing } => write!(
                f,
                "expected swinging legs, found a person standing still: the outline of the legs changes by {:.1} %",
                100.0 * swing
            ),
            Self::Slower { waves_per_minute } => {
                let (slow, fast) = CYCLE_STEPS_PER_MINUTE;
                write!(
                    f,
                    "expected {slow} to {fast} steps a minute, found a stronger wave of {waves_per_minute:.0} a minute: slower steps, or whole cycles seen from nearly in front or behind (check the frame rate, or move the camera to the side)"
                )
            }
            Self::Irregular { regular } => {
                let (slow, fast) = CYCLE_STEPS_PER_MINUTE;
                write!(
                    f,
                    "expected {slow} to {fast} steady steps a minute, found changes of which a steady wave explains {:.0} % (if the camera sees the walker from in front or behind, move it to the side)",
                    100.0 * regular
                )
            }
        }
    }
}

impl core::error::Error for NoCycle {}

/// The error for a frame rate that is out of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRateError {
    /// The frame rate that was found, frames per second.
    pub found_hz: f32,
}

impl fmt::Display for FrameRateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ((low, high), found) = (CYCLE_FRAME_RATES_HZ, self.found_hz);
        write!(
            f,
            "expected {low} to {high} frames a second, found {found} (leave out frames of a faster recording)"
        )
    }
}

impl core::error::Error for FrameRateError {}

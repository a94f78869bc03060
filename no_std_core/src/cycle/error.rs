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
        /// The amplitude by which the legs swing, as a share of the figure's height.
        swing: f32,
    },
    /// The steps are too slow.
    Slower {
        /// The number of steps in a minute.
        steps_per_minute: f32,
    },
    /// The legs move, but not in steps. The walker may be seen from in front or behind, where the
    /// outline hardly changes, may turn, be partly hidden or badly segmented, or have a
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
                "expected swinging legs, found a person standing still: the legs swing by {:.1} % of the height",
                100.0 * swing
            ),
            Self::Slower { steps_per_minute } => {
                let (slow, fast) = CYCLE_STEPS_PER_MINUTE;
                write!(
                    f,
                    "expected {slow} to {fast} steps a minute, found {steps_per_minute:.0} (check the frame rate)"
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

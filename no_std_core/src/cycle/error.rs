//! Why there are no gait cycles.

use crate::budget::{CYCLE_FRAME_RATES_HZ, CYCLE_STEPS_PER_MINUTE};
use core::fmt;

/// Why no gait cycle is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoCycle {
    /// There are too few frames: a cycle has to be there as a whole, from one step's widest stance to
    /// the widest but one behind it. Two cycles are enough wherever they begin.
    TooShort {
        /// How many frames there are.
        frames: u64,
    },
    /// Nobody is there in more than half of the frames.
    Absent,
    /// Somebody is there whose legs do not swing.
    Standing {
        /// By which share of its mean the legs' outline swings, at most.
        swing: f32,
    },
    /// The legs' outline changes, but not as steps do: seen from in front or behind, where it hardly
    /// changes, or turning, half hidden, badly segmented, or at a cadence that nobody walks at.
    Irregular {
        /// Share of the changes that one steady wave explains, 0..1.
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
                "expected somebody in half of the frames or more, found fewer (see to the segmentation)",
            ),
            Self::Standing { swing } => write!(
                f,
                "expected legs that swing, found somebody who stands: their outline changes by {:.1} %",
                100.0 * swing
            ),
            Self::Irregular { regular } => {
                let (slow, fast) = CYCLE_STEPS_PER_MINUTE;
                write!(
                    f,
                    "expected {slow} to {fast} steady steps a minute, found changes of which a steady wave explains {:.0} % (seen from in front or behind? turn the camera to a side)",
                    100.0 * regular
                )
            }
        }
    }
}

impl core::error::Error for NoCycle {}

/// Cycles are not looked for at such a frame rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRateError {
    /// Frames a second.
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

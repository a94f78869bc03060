//! The error of template builders.

use crate::silhouette::Size;
use core::fmt;

/// The reason why a builder rejects a frame. The builder is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// The frame has another size than the template.
    Size {
        /// The size of the template.
        expected: Size,
        /// The size of the frame.
        found: Size,
    },
    /// The template has all the frames that it can hold, or that were announced.
    Full {
        /// The number of frames.
        frames: u32,
    },
}

impl FrameError {
    /// Checks that a frame of size `found` can follow `frames` others of at most `most`.
    #[inline]
    pub(crate) fn check([expected, found]: [Size; 2], frames: u32, most: u32) -> Result<(), Self> {
        if found != expected {
            return Err(Self::Size { expected, found });
        }
        if frames >= most {
            return Err(Self::Full { frames });
        }
        Ok(())
    }
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { expected, found } => write!(
                f,
                "expected a frame of {expected} pixels, found one of {found} (draw it at that size)"
            ),
            Self::Full { frames } => write!(
                f,
                "expected at most {frames} frames in this template, found one more (begin another)"
            ),
        }
    }
}

impl core::error::Error for FrameError {}

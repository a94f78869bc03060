//! Why a frame is not part of a template.

use crate::silhouette::Size;
use core::fmt;

/// Why a builder refuses a frame; what it had before is as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// The frame has another size than the template.
    Size {
        /// Of the template.
        expected: Size,
        /// Of the frame.
        found: Size,
    },
    /// The template has all the frames that it can have, or that were to come.
    Full {
        /// How many.
        frames: u32,
    },
}

impl FrameError {
    /// That a frame of size `found` comes after `frames` others of at most `most`.
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

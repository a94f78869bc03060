//! A Gait Energy Image that is counted in its own bytes.

use super::FrameError;
use crate::silhouette::{Silhouette, Size};
use core::fmt;

/// A builder of a GEI in a buffer of the caller, for silhouettes of one sample a pixel: it needs
/// only as many bytes as the size has pixels.
#[derive(Debug)]
pub struct GeiInPlace<'a> {
    size: Size,
    frames: u8,
    /// The number of frames in which each pixel is on, row by row from the top.
    counts: &'a mut [u8],
}

/// The error for a buffer that is smaller than the template.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferTooSmall {
    /// Bytes that the template takes.
    pub expected: usize,
    /// Bytes of the buffer.
    pub found: usize,
}

impl fmt::Display for BufferTooSmall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { expected, found } = self;
        write!(
            f,
            "expected a buffer of at least {expected} bytes, found {found}"
        )
    }
}

impl core::error::Error for BufferTooSmall {}

impl<'a> GeiInPlace<'a> {
    /// The maximum number of frames in one GEI: the range of a byte.
    pub const MAX_FRAMES: u8 = u8::MAX;

    /// Makes a builder without frames in the first bytes of `buffer`.
    ///
    /// # Errors
    /// When the buffer has fewer bytes than the size has pixels.
    pub fn new(size: Size, buffer: &'a mut [u8]) -> Result<Self, BufferTooSmall> {
        let (expected, found) = (size.pixels(), buffer.len());
        let counts = buffer.get_mut(..expected);
        let counts = counts.ok_or(BufferTooSmall { expected, found })?;
        counts.fill(0);
        Ok(Self {
            size,
            frames: 0,
            counts,
        })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// If it is of another size, or comes after [`Self::MAX_FRAMES`].
    pub fn add(&mut self, silhouette: &Silhouette) -> Result<(), FrameError> {
        let most = u32::from(Self::MAX_FRAMES);
        FrameError::check([self.size, silhouette.size()], u32::from(self.frames), most)?;
        self.frames += 1;
        let counts = self.counts.chunks_exact_mut(self.size.columns());
        for (row, counts) in silhouette.rows().iter().zip(counts) {
            let mut left = *row;
            while left != 0 {
                if let Some(count) = counts.get_mut(left.trailing_zeros() as usize) {
                    // At most the number of frames.
                    *count = count.saturating_add(1);
                }
                left &= left - 1;
            }
        }
        Ok(())
    }

    /// Returns the number of frames added.
    #[must_use]
    pub const fn frames(&self) -> u8 {
        self.frames
    }

    /// Turns the counts into the mean of the frames, 0..=255, rounded half up, row by row from the
    /// top; black without frames.
    pub fn finish(self) -> &'a [u8] {
        let all = u32::from(self.frames);
        for count in self.counts.iter_mut().filter(|count| **count > 0) {
            let mean = (255 * u32::from(*count) + all / 2) / all;
            *count = u8::try_from(mean).unwrap_or(u8::MAX);
        }
        self.counts
    }
}

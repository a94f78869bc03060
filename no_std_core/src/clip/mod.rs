//! Compressed motions, read in place from a pack's bytes.

mod basis;
mod cycle;
mod expanded;
mod knots;
mod uncut;

pub use cycle::Loop;
pub use expanded::Expanded;
pub use uncut::UncutClip;

use crate::codebook::{CodeTable, Codebook};
use crate::format::{CLIP_LOOP, CLIP_UNCUT, FormatError};
use crate::pose::Pose;

/// A motion in a pack.
#[derive(Clone, Copy, Debug)]
pub enum Clip<'a> {
    /// A closed gait cycle.
    Loop(Loop<'a>),
    /// A motion that does not repeat.
    Uncut(UncutClip<'a>),
}

impl<'a> Clip<'a> {
    /// Checks every length and field of `bytes`; decoding cannot fail afterwards.
    ///
    /// # Errors
    /// If the bytes are not exactly one clip of this version.
    pub fn parse(bytes: &'a [u8], codebook: &Codebook<'a>) -> Result<Self, FormatError> {
        Self::check(bytes, codebook, &CodeTable::from_codebook(codebook))
    }

    /// Checks a clip with codes that were read from the codebook once for many clips.
    pub(crate) fn check(
        bytes: &'a [u8],
        codebook: &Codebook<'a>,
        codes: &CodeTable,
    ) -> Result<Self, FormatError> {
        let clip = Self::over(bytes, codebook)?;
        match &clip {
            Self::Loop(cycle) => cycle.check(codes)?,
            Self::Uncut(take) => take.check()?,
        }
        Ok(clip)
    }

    /// Returns the clip of bytes that [`Self::check`] has checked, reading only where its parts
    /// lie.
    ///
    /// # Errors
    /// None for checked bytes.
    pub(crate) fn over(bytes: &'a [u8], codebook: &Codebook<'a>) -> Result<Self, FormatError> {
        match bytes.first() {
            Some(&CLIP_LOOP) => Loop::over(bytes, codebook).map(Self::Loop),
            Some(&CLIP_UNCUT) => UncutClip::over(bytes, codebook).map(Self::Uncut),
            _ => Err(FormatError::new(0, "clip kind 1 (loop) or 2 (uncut)")),
        }
    }

    /// Returns the closed cycle, if it is one.
    #[must_use]
    pub const fn as_loop(&self) -> Option<Loop<'a>> {
        match self {
            Self::Loop(cycle) => Some(*cycle),
            Self::Uncut(_) => None,
        }
    }

    /// Returns the uncut clip, if it is one.
    #[must_use]
    pub const fn as_uncut(&self) -> Option<UncutClip<'a>> {
        match self {
            Self::Loop(_) => None,
            Self::Uncut(take) => Some(*take),
        }
    }

    /// Returns the pose at a time, seconds. A loop repeats for ever in both directions, and leaves
    /// out its travel ([`Loop::pose`]). An uncut clip travels as recorded, and stands still before
    /// its first and after its last moment. A time that is not finite counts as 0.
    ///
    /// In `f64`, because `f32` resolves only 4 ms in the tenth hour.
    #[must_use]
    pub fn sample(&self, seconds: f64) -> Pose {
        match self {
            Self::Loop(cycle) => cycle.sample(seconds),
            Self::Uncut(take) => take.sample(seconds),
        }
    }

    /// Returns the duration, seconds: of one cycle of a loop, or of a whole uncut clip.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match self {
            Self::Loop(cycle) => cycle.period_s(),
            Self::Uncut(take) => take.duration_s(),
        }
    }

    /// Returns the greatest error that the encoder measured, mm: of virtual points 3 cm off each
    /// joint, in the walker's space, over all frames, against its input.
    #[must_use]
    pub fn max_error_mm(&self) -> f32 {
        match self {
            Self::Loop(cycle) => cycle.max_error_mm(),
            Self::Uncut(take) => take.max_error_mm(),
        }
    }

    /// Returns the mean error that the encoder measured, mm.
    #[must_use]
    pub fn mean_error_mm(&self) -> f32 {
        match self {
            Self::Loop(cycle) => cycle.mean_error_mm(),
            Self::Uncut(take) => take.mean_error_mm(),
        }
    }

    /// Returns the number of frames that the encoder was given.
    #[must_use]
    pub fn frames(&self) -> u32 {
        match self {
            Self::Loop(cycle) => cycle.frames(),
            Self::Uncut(take) => take.frames(),
        }
    }

    /// Returns the size of the clip in its pack, bytes.
    #[must_use]
    pub const fn len_bytes(&self) -> usize {
        match self {
            Self::Loop(cycle) => cycle.len_bytes(),
            Self::Uncut(take) => take.len_bytes(),
        }
    }
}

//! The layout of a C3D file's frames, from its header, its parameters and its length.
//!
//! Header and parameters state most numbers twice, and 16 bits do not hold all counts. Where they
//! disagree, the file's length settles it.

use super::machine::NumberFormat;
use super::parameters::{C3dParameters, unsigned};

/// Size of a block, in which the format counts places, bytes.
pub(super) const BLOCK: usize = 512;

/// Bytes of a number of a file of floats, and of one of integers.
const FLOAT: usize = 4;
const INTEGER: usize = 2;

/// The largest count of 16 bits; larger ones saturate or wrap.
const LARGEST_WORD: f64 = 65_535.0;

/// The words of the header that are used, in the order of the file.
pub(super) struct C3dHeader {
    pub(super) points: u16,
    pub(super) analog_samples: u16,
    pub(super) first_frame: u16,
    pub(super) last_frame: u16,
    pub(super) scale: f64,
    pub(super) data_block: u16,
    pub(super) rate_hz: f64,
}

impl C3dHeader {
    pub(super) fn parse(block: &[u8; BLOCK], machine: NumberFormat) -> Self {
        let word = |at: usize| machine.word([block[at], block[at + 1]]);
        let real =
            |at: usize| machine.real([block[at], block[at + 1], block[at + 2], block[at + 3]]);
        Self {
            points: word(2),
            analog_samples: word(4),
            first_frame: word(6),
            last_frame: word(8),
            scale: real(12),
            data_block: word(16),
            rate_hz: real(20),
        }
    }

    /// Returns the number of frames from the first and last; none if 16 bits may not suffice.
    fn frames(&self) -> Option<f64> {
        let is_sound = self.last_frame >= self.first_frame && self.last_frame < u16::MAX;
        is_sound.then(|| f64::from(self.last_frame) - f64::from(self.first_frame) + 1.0)
    }
}

/// The layout of frames of points in the data section.
pub(super) struct PointsLayout {
    pub(super) machine: NumberFormat,
    /// Byte at which the first frame begins.
    pub(super) start: u64,
    pub(super) frames: usize,
    /// Whether the frames are as many as fit into the file, which ends with a whole block.
    pub(super) is_filled: bool,
    pub(super) points: usize,
    /// Bytes of a frame, analog samples included.
    pub(super) stride: usize,
    /// Source units in one count; `None` for floats.
    pub(super) scale: Option<f64>,
}

/// What a file states about its frames, and its length.
pub(super) struct Statement<'a> {
    pub(super) header: &'a C3dHeader,
    pub(super) parameters: &'a C3dParameters,
    /// Bytes of the file.
    pub(super) length: u64,
}

/// A number of frames.
#[derive(Clone, Copy)]
struct FrameCount {
    frames: usize,
    /// Whether it is as many as fit.
    is_filled: bool,
}

impl Statement<'_> {
    /// Returns the layout of the data from header and parameters, which must agree, or the length
    /// must show which of them is right.
    ///
    /// # Errors
    /// A sentence, if it does not.
    pub(super) fn layout(
        &self,
        machine: NumberFormat,
        warnings: &mut Vec<String>,
    ) -> Result<PointsLayout, String> {
        let (header, parameters) = (self.header, self.parameters);
        let points = header.points;
        if let Some(used) = parameters.count("POINT:USED")
            && used != f64::from(points)
        {
            return Err(format!(
                "the header counts {points} points, POINT:USED {used}: expected the same"
            ));
        }
        if points == 0 {
            return Err("no markers: the file has 0 points".into());
        }
        let start = match header.data_block {
            0 => parameters.count("POINT:DATA_START").unwrap_or_default(),
            block => block.into(),
        };
        if start < 2.0 {
            return Err(format!("expected the data from block 2 on, found {start}"));
        }
        let start = (whole(start) as u64 - 1) * BLOCK as u64;
        let width = self.width(start, warnings)?;
        let stride = self.stride(width);
        let FrameCount { frames, is_filled } = self.frames(start, stride, warnings)?;
        Ok(PointsLayout {
            machine,
            start,
            frames,
            is_filled,
            points: points.into(),
            stride,
            scale: (width == INTEGER).then_some(self.scale().abs()),
        })
    }

    fn scale(&self) -> f64 {
        let stated = self.parameters.number("POINT:SCALE");
        stated.unwrap_or(self.header.scale)
    }

    /// Returns the bytes of a frame of numbers of this width.
    fn stride(&self, width: usize) -> usize {
        width * (4 * usize::from(self.header.points) + usize::from(self.header.analog_samples))
    }

    /// Returns the width of a number: [`FLOAT`] if the scale is negative, [`INTEGER`] if it is
    /// positive.
    fn width(&self, start: u64, warnings: &mut Vec<String>) -> Result<usize, String> {
        let (scale, other) = (self.scale(), self.header.scale);
        let disagreement = format!(
            "the header states a scale of points of {other}, POINT:SCALE {scale}, which is positive for integers and negative for floats"
        );
        if scale.is_nan() || scale == 0.0 {
            return Err(format!("{disagreement}: expected one of both"));
        }
        let width_of = |scale: f64| if scale < 0.0 { FLOAT } else { INTEGER };
        if (scale < 0.0) == (other < 0.0) {
            return Ok(width_of(scale));
        }
        let fits = |width: usize| {
            let stride = self.stride(width);
            let count = self.frames(start, stride, &mut Vec::new());
            count.is_ok_and(|count| self.fills(start, stride, count.frames as f64))
        };
        let (width, kind) = match [fits(FLOAT), fits(INTEGER)] {
            [true, false] => (FLOAT, "floats"),
            [false, true] => (INTEGER, "integers"),
            [true, true] => (width_of(scale), "either, so POINT:SCALE is used"),
            [false, false] => {
                return Err(format!(
                    "{disagreement}: expected the same sign, since the file's length fits neither"
                ));
            }
        };
        warnings.push(format!("{disagreement}: the file's length fits {kind}"));
        Ok(width)
    }

    /// Returns whether this many frames end in the last block of the file.
    fn fills(&self, start: u64, stride: usize, frames: f64) -> bool {
        let end = start as f64 + frames * stride as f64;
        (0.0..BLOCK as f64).contains(&(self.length as f64 - end))
    }

    /// Returns the number of frames: the header's, or one from the parameters if its 16 bits do not
    /// suffice, or as many as fit if theirs do not suffice either.
    fn frames(
        &self,
        start: u64,
        stride: usize,
        warnings: &mut Vec<String>,
    ) -> Result<FrameCount, String> {
        // Two words, the low one first, or one number.
        let field = |name| match *self.parameters.numbers(name) {
            [low, high, ..] => Some(unsigned(low) + 65_536.0 * unsigned(high)),
            [number] => Some(unsigned(number)),
            [] => None,
        };
        let trial = field("TRIAL:ACTUAL_START_FIELD")
            .zip(field("TRIAL:ACTUAL_END_FIELD"))
            .map(|(start, end)| end - start + 1.0);
        let long = self.parameters.number("POINT:LONG_FRAMES");
        let usual = self.parameters.count("POINT:FRAMES");
        let (header, added) = (self.header.frames(), [trial, long, usual]);
        let plausible = |count: &f64| *count >= 1.0 && count.is_finite();
        let mut stated = added.into_iter().flatten();
        let beyond = stated.clone().find(|count| *count > LARGEST_WORD);
        let count = beyond
            .or(header)
            .or(stated.find(plausible))
            .filter(plausible)
            .ok_or_else(|| {
                format!(
                    "expected at least one frame, found frames {} to {}",
                    self.header.first_frame, self.header.last_frame
                )
            })?;
        let room = (self.length.saturating_sub(start) / stride as u64) as f64;
        if beyond.is_none() && room > LARGEST_WORD && !self.fills(start, stride, count) {
            let is_saturated =
                self.header.last_frame == u16::MAX || usual.is_some_and(|it| it >= LARGEST_WORD);
            let mut unwrapped = [header, usual]
                .into_iter()
                .flatten()
                .map(|count| count + 65_536.0 * ((room - count) / 65_536.0).floor().max(0.0));
            let unwrapped = unwrapped.find(|it| self.fills(start, stride, *it));
            if unwrapped.is_some() || is_saturated {
                let frames = unwrapped.unwrap_or(room);
                warnings.push(format!(
                    "16 bits do not hold the number of frames, {count} by the header or POINT:FRAMES: the {frames} that fill the file are used"
                ));
                return Ok(FrameCount {
                    frames: whole(frames),
                    is_filled: unwrapped.is_none(),
                });
            }
            warnings.push(format!(
                "the file has room for {room} frames, but {count} are stated: {count} are used"
            ));
        }
        // One word cannot state larger counts.
        let usual = usual.filter(|it| count < LARGEST_WORD || *it > LARGEST_WORD);
        let others = [trial, long, usual];
        if let Some(other) = others.into_iter().flatten().find(|&other| other != count) {
            warnings.push(format!(
                "the stated numbers of frames differ, {count} and {other}: {count} are used"
            ));
        }
        Ok(FrameCount {
            frames: whole(count),
            is_filled: false,
        })
    }
}

/// Returns a count as an index, clamped to the range of indices.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and the result is compared with the file's length"
)]
fn whole(count: f64) -> usize {
    count as usize
}

//! Uncut clips: motions that do not repeat, such as starts, turns and whole trials.
//!
//! An uncut clip holds 61 channels (those of a loop and the heading), each a uniform cubic B-spline
//! of time. Four knots determine any moment, and knots lie in blocks whose numbers have fixed
//! widths, so that the position of any knot in a block is computed: a pose in the tenth hour costs
//! as much as one in the first second. A channel's knots are as far apart as its motion allows, 1,
//! 2 or 4 intervals, and a channel that never moves has none.
//!
//! The heading is separate from the pelvis's rotation, so that walkers may turn any number of
//! times: the codebook's frame rotates the pelvis first, and the heading last.

use super::knots::{KnotRun, KnotValue, UncutChannel, UncutMoment};
use crate::bits::BitReader;
use crate::codebook::Codebook;
use crate::format::{
    CLIP_UNCUT, END_BYTES, FormatError, UNCUT_CHANNELS, UNCUT_HEADER_BYTES, u16_at, u32_at,
};
use crate::pose::Pose;
use crate::rotation::product;
use crate::skeleton::{JOINTS, Joint};
use glam::{Quat, Vec3};

/// A motion that does not repeat, read in place from a pack's bytes.
#[derive(Clone, Copy, Debug)]
pub struct UncutClip<'a> {
    header: &'a [u8],
    table: &'a [u8],
    ends: &'a [u8],
    blocks: &'a [u8],
    codebook: Codebook<'a>,
}

impl<'a> UncutClip<'a> {
    /// Returns the clip of these bytes, whose blocks the caller has checked or will check.
    ///
    /// # Errors
    /// If its parts do not fit into the bytes.
    pub(super) fn over(bytes: &'a [u8], codebook: &Codebook<'a>) -> Result<Self, FormatError> {
        let (Some(header), Some(rest)) = (
            bytes.get(..UNCUT_HEADER_BYTES),
            bytes.get(UNCUT_HEADER_BYTES..),
        ) else {
            return Err(FormatError::new(
                bytes.len(),
                "an uncut clip's header of 22 bytes",
            ));
        };
        debug_assert_eq!(header.first(), Some(&CLIP_UNCUT), "the caller looked");
        if u32_at(header, 10) == 0 {
            return Err(FormatError::new(10, "a knot interval above 0 microseconds"));
        }
        let take = Self {
            header,
            table: rest,
            ends: &[],
            blocks: &[],
            codebook: *codebook,
        };
        let (table_bytes, blocks) = take
            .check_table()
            .map_err(|error| error.behind(UNCUT_HEADER_BYTES))?;
        let blocks_at = usize::try_from(blocks)
            .ok()
            .and_then(|blocks| blocks.checked_mul(END_BYTES)?.checked_add(table_bytes));
        let parts = blocks_at.and_then(|at| {
            let (table, ends) = (rest.get(..table_bytes)?, rest.get(table_bytes..at)?);
            Some((table, ends, rest.get(at..)?))
        });
        let Some((table, ends, blocks)) = parts else {
            return Err(FormatError::new(
                bytes.len(),
                "as many blocks as the duration needs",
            ));
        };
        Ok(Self {
            table,
            ends,
            blocks,
            ..take
        })
    }

    /// Checks every field of the blocks.
    pub(super) fn check(&self) -> Result<(), FormatError> {
        self.check_blocks()
            .map_err(|error| error.behind(UNCUT_HEADER_BYTES))
    }

    /// Checks all channels, and returns the bytes of the table and the number of blocks.
    fn check_table(&self) -> Result<(usize, u64), FormatError> {
        let mut bits = BitReader::new(self.table);
        let mut blocks = 0;
        for _ in 0..UNCUT_CHANNELS {
            let Some(channel) = UncutChannel::read(&mut bits) else {
                return Err(FormatError::new(
                    bits.position() / 8,
                    "integers of at most 25 bits",
                ));
            };
            blocks = blocks.max(channel.blocks(self.intervals()));
        }
        let bytes = bits.position().div_ceil(8);
        let mut table = BitReader::new(self.table.get(..bytes).unwrap_or(self.table));
        table.skip(bits.position());
        table.check_end()?;
        Ok((bytes, blocks))
    }

    /// Checks the heads of all channels in all blocks.
    fn check_blocks(&self) -> Result<(), FormatError> {
        let (blocks_at, intervals) = (self.table.len() + self.ends.len(), self.intervals());
        let (mut before, mut end_at) = (0, self.table.len());
        for (number, end) in (0..).zip(self.ends.chunks_exact(END_BYTES)) {
            let end = u32_at(end, 0) as usize;
            let Some(block) = self.blocks.get(before..end) else {
                return Err(FormatError::new(
                    end_at,
                    "block ends in rising order within the clip",
                ));
            };
            let (mut channels, mut bits) = (BitReader::new(self.table), BitReader::new(block));
            for _ in 0..UNCUT_CHANNELS {
                let run = UncutChannel::read(&mut channels)
                    .and_then(|channel| KnotRun::read(&mut bits, &channel, intervals, number));
                if run.is_none() {
                    return Err(FormatError::new(
                        blocks_at + before + bits.position() / 8,
                        "differences no wider than the channel's widest",
                    ));
                }
            }
            bits.check_end()
                .map_err(|error| error.behind(blocks_at + before))?;
            before = end;
            end_at += END_BYTES;
        }
        if before != self.blocks.len() {
            return Err(FormatError::new(
                blocks_at + before,
                "the end of the clip after its last block",
            ));
        }
        Ok(())
    }

    /// Returns the duration from the first moment to the last, seconds, exact to a microsecond.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_us() * 1e-6
    }

    fn duration_us(&self) -> f64 {
        const HIGH: f64 = 4_294_967_296.0;
        f64::from(u32_at(self.header, 6)) * HIGH + f64::from(u32_at(self.header, 2))
    }

    /// Returns how many intervals between knots of spacing 0 cover the duration, at least one.
    fn intervals(&self) -> u64 {
        let duration = u64::from(u32_at(self.header, 6)) << 32 | u64::from(u32_at(self.header, 2));
        duration
            .div_ceil(u64::from(self.interval_us()).max(1))
            .max(1)
    }

    /// Returns the time between the knots of a channel of spacing 0, microseconds.
    #[must_use]
    pub fn interval_us(&self) -> u32 {
        u32_at(self.header, 10)
    }

    /// Returns the greatest error that the encoder measured, mm ([`super::Clip::max_error_mm`]).
    #[must_use]
    pub fn max_error_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 14)) * 0.01
    }

    /// Returns the mean error that the encoder measured, mm.
    #[must_use]
    pub fn mean_error_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 16)) * 0.01
    }

    /// Returns the number of frames that the encoder was given.
    #[must_use]
    pub fn frames(&self) -> u32 {
        u32_at(self.header, 18)
    }

    fn scale(&self) -> u8 {
        self.header.get(1).copied().unwrap_or(0)
    }

    /// Returns the size of the clip in its pack, bytes.
    #[must_use]
    pub const fn len_bytes(&self) -> usize {
        self.header.len() + self.table.len() + self.ends.len() + self.blocks.len()
    }

    /// Returns the pose at a time, seconds from the first moment. Before the first and after the
    /// last moment it is the pose of that moment. The walker travels as recorded. A time that is
    /// not finite counts as 0.
    ///
    /// Reads at most two blocks, whatever the duration, and needs no memory except the pose's.
    #[must_use]
    pub fn sample(&self, seconds: f64) -> Pose {
        let (moment, scale) = (self.moment(seconds), self.scale());
        let mut table = BitReader::new(self.table);
        let mut blocks = [0, 1].map(|later| BitReader::new(self.block(moment.block, later)));
        let mut next = || {
            // Cannot be `None`: `check_table` has read all channels.
            let channel = UncutChannel::read(&mut table);
            channel.map_or(KnotValue::ZERO, |channel| {
                channel.value(&mut blocks, &moment)
            })
        };
        let mut vector = |first: usize| {
            [first, first + 1, first + 2]
                .map(|channel| next().times(self.codebook.step(channel, scale)))
        };
        let mut pose = Pose::REST;
        for (joint, first) in Joint::ALL.into_iter().zip((0..).step_by(3)) {
            let turned = self.codebook.frame(joint).turn(vector(first));
            pose.rotations[joint.index()] = Quat::from_array(turned);
        }
        pose.root = Vec3::from_array(vector(3 * JOINTS));
        let heading = next().times_exactly(self.codebook.heading_step(scale));
        let pelvis = &mut pose.rotations[Joint::Pelvis.index()];
        *pelvis = Quat::from_array(product(about_y(heading), pelvis.to_array()));
        pose
    }

    /// Returns where a time lies among the knots.
    fn moment(&self, seconds: f64) -> UncutMoment {
        let seconds = if seconds.is_finite() { seconds } else { 0.0 };
        let microseconds = (seconds * 1e6).clamp(0.0, self.duration_us());
        let position = microseconds / f64::from(self.interval_us());
        UncutMoment::new(position, self.intervals())
    }

    /// Returns the bits of the block `later` blocks after this one; none after the last.
    fn block(&self, number: u64, later: usize) -> &'a [u8] {
        let end_at = |number: usize| {
            let at = number.checked_mul(END_BYTES)?;
            self.ends
                .get(at..)?
                .first_chunk()
                .copied()
                .map(u32::from_le_bytes)
        };
        let bits = usize::try_from(number).ok().and_then(|number| {
            let number = number.checked_add(later)?;
            let start = match number.checked_sub(1) {
                Some(before) => end_at(before)?,
                None => 0,
            };
            self.blocks.get(start as usize..end_at(number)? as usize)
        });
        bits.unwrap_or_default()
    }
}

/// Returns the rotation about +Y by an angle, radians: halved and reduced in `f64`, because walkers
/// may turn any number of times.
fn about_y(angle: f64) -> [f32; 4] {
    let (sin, cos) = libm::sincos(0.5 * angle);
    #[expect(clippy::cast_possible_truncation, reason = "-1 to 1")]
    let (sin, cos) = (sin as f32, cos as f32);
    [0.0, sin, 0.0, cos]
}

#[cfg(test)]
mod tests;

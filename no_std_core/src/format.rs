//! Byte layout of a pack: what the reader here and the host's writer share.
//!
//! `FORMAT.md` beside this crate has the tables. All integers are little-endian.

use core::fmt;

/// The first four bytes of every pack.
pub const MAGIC: [u8; 4] = *b"EGPK";
/// The version that this crate reads and writes.
pub const VERSION: u16 = 1;

/// Bytes before the section table: magic, version, section count, length, CRC-32.
pub const HEADER_BYTES: usize = 16;
/// Where the version stands.
pub const VERSION_AT: usize = 4;
/// Where the number of sections stands.
pub const SECTIONS_AT: usize = 6;
/// Where the length of the whole pack stands.
pub const LENGTH_AT: usize = 8;
/// Where the CRC-32 of everything behind the header stands.
pub const CRC_AT: usize = 12;
/// One entry of the section table: identifier, offset, length.
pub const SECTION_ENTRY_BYTES: usize = 12;

/// Section of UTF-8 names, one after the other without separators.
pub const NAMES: [u8; 4] = *b"NAME";
/// Section of subject records.
pub const SUBJECTS: [u8; 4] = *b"SUBJ";
/// Section of walk records.
pub const WALKS: [u8; 4] = *b"WALK";
/// Section of avatars behind a table of their ends.
pub const AVATARS: [u8; 4] = *b"AVAT";
/// Section of clips behind a table of their ends.
pub const CLIPS: [u8; 4] = *b"CLIP";
/// The sections of version 1, in file order.
pub const SECTION_ORDER: [[u8; 4]; 5] = [NAMES, SUBJECTS, WALKS, AVATARS, CLIPS];

/// Bytes of a subject record: name offset `u32`, name length `u8`, sex `u8`,
/// stature in mm `u16`, mass in 0.1 kg `u16`, avatar `u16`.
pub const SUBJECT_BYTES: usize = 12;
/// Bytes of a walk record: name offset `u32`, name length `u8`, gait `u8`,
/// subject `u16`, cycle `u16`, speed in mm/s `u16`, clip `u16`, reserved `u16` = 0.
pub const WALK_BYTES: usize = 16;
/// Bytes of one entry of a table of ends: `u32`.
pub const END_BYTES: usize = 4;

/// Bytes of an avatar's joint offsets: 3 x `i16` for each joint, in
/// [`OFFSET_STEP_M`].
pub const OFFSETS_BYTES: usize = 3 * 2 * crate::skeleton::JOINTS;
/// Unit of joint offsets and hull origins: 0.1 mm.
pub const OFFSET_STEP_M: f32 = 1e-4;
/// Bytes of a hull's header: joint `u8`, points `u8`, origin 3 x `i16` in
/// [`OFFSET_STEP_M`], step 3 x `u16` in [`HULL_STEP_M`].
pub const HULL_HEADER_BYTES: usize = 14;
/// Unit of a hull's quantisation steps: 1 micrometre.
pub const HULL_STEP_M: f32 = 1e-6;
/// Bytes of a hull point: 3 x `u8`, in steps from the hull's origin.
pub const HULL_POINT_BYTES: usize = 3;

/// Bytes of a clip's header: kind `u8`, reserved `u8` = 0, period in
/// microseconds `u32`, travel per cycle in micrometres `i32`, greatest and mean
/// encoding error in 0.01 mm `u16` each, bytes of the bit stream `u16`.
pub const CLIP_HEADER_BYTES: usize = 16;
/// Kind of a clip that is one closed gait cycle.
pub const CLIP_LOOP: u8 = 1;
/// Bits of one component of a reference rotation (smallest three).
pub const REFERENCE_BITS: u32 = 15;
/// Bits of a channel's number of coefficients.
pub const COUNT_BITS: u32 = 6;
/// Bits of a channel's step index: the step is 2^((index - 64) / 4) radians or metres.
pub const STEP_BITS: u32 = 6;
/// Bits of a band's width.
pub const WIDTH_BITS: u32 = 4;

/// The step of a channel's coefficients, radians or metres: 2^((index - 64) / 4).
#[must_use]
pub fn step_size(index: u32) -> f32 {
    // Exact powers of two times one of four constants: the same on every target.
    const QUARTERS: [f32; 4] = [1.0, 1.189_207_1, core::f32::consts::SQRT_2, 1.681_792_9];
    let quarter = QUARTERS.get((index % 4) as usize).copied().unwrap_or(1.0);
    let octave = (index / 4).min(63) + 127 - 16;
    quarter * f32::from_bits(octave << 23)
}

/// How many coefficients the `band`-th band of a channel holds: 1, 2, 4, 8, 16...
#[must_use]
pub const fn band_length(band: u32) -> usize {
    1 << band
}

/// The CRC-32 (ISO-HDLC, as in PNG and zip) of `bytes`. Bit by bit, without a
/// table: about 10 ns a byte on a host.
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    crc::Crc::<u32, crc::NoTable>::new(&crc::CRC_32_ISO_HDLC).checksum(bytes)
}

/// Why bytes are not a pack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// Offset of the first byte that is wrong, from the start of the pack.
    pub byte: usize,
    /// What was expected there.
    pub expected: &'static str,
}

impl FormatError {
    /// At `byte`, `expected` was not found.
    #[must_use]
    pub const fn new(byte: usize, expected: &'static str) -> Self {
        Self { byte, expected }
    }

    /// The same error counted from `base` bytes further left.
    #[must_use]
    pub const fn behind(self, base: usize) -> Self {
        Self {
            byte: self.byte + base,
            expected: self.expected,
        }
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "byte {}: expected {}", self.byte, self.expected)
    }
}

impl core::error::Error for FormatError {}

/// The `u16` at `at`, or zero past the end.
pub(crate) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    let mut word = [0; 2];
    if let Some(found) = bytes.get(at..at + 2) {
        word.copy_from_slice(found);
    }
    u16::from_le_bytes(word)
}

/// The `i16` at `at`, or zero past the end.
pub(crate) fn i16_at(bytes: &[u8], at: usize) -> i16 {
    u16_at(bytes, at).cast_signed()
}

/// The `u32` at `at`, or zero past the end.
pub(crate) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    let mut word = [0; 4];
    if let Some(found) = bytes.get(at..at + 4) {
        word.copy_from_slice(found);
    }
    u32::from_le_bytes(word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_quarter_octaves_from_two_to_the_minus_sixteen() {
        assert_eq!(step_size(0), 1.0 / 65_536.0);
        assert_eq!(step_size(64), 1.0);
        assert!((step_size(2) / step_size(0) - 2.0_f32.sqrt()).abs() < 1e-6);
        assert!((step_size(7) * step_size(5) / (step_size(6) * step_size(6)) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn crc_has_the_published_check_value() {
        // "check" of CRC-32/ISO-HDLC in Williams' and Cook's catalogue.
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }
}

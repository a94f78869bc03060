//! The byte layout of packs and recognizers, shared by the readers here and the host's writers.
//!
//! `FORMAT.md` beside this crate has the tables. All integers are little-endian.

use crate::budget::MAX_HARMONICS;
use crate::skeleton::JOINTS;
use core::fmt;

/// The first four bytes of every pack.
pub const MAGIC: [u8; 4] = *b"EGPK";
/// The version that this crate reads and writes.
pub const VERSION: u16 = 1;

/// Bytes before the section table: magic, version, section count, length, CRC-32.
pub const HEADER_BYTES: usize = 16;
/// Offset of the version.
pub const VERSION_AT: usize = 4;
/// Offset of the number of sections.
pub const SECTIONS_AT: usize = 6;
/// Offset of the length of the whole pack.
pub const LENGTH_AT: usize = 8;
/// Offset of the CRC-32 of everything after the header.
pub const CRC_AT: usize = 12;
/// Bytes of one entry of the section table: identifier, offset, length.
pub const SECTION_ENTRY_BYTES: usize = 12;

/// Section of UTF-8 names, one after the other without separators.
pub const NAMES: [u8; 4] = *b"NAME";
/// Section of subject records.
pub const SUBJECTS: [u8; 4] = *b"SUBJ";
/// Section of walk records.
pub const WALKS: [u8; 4] = *b"WALK";
/// Section of avatars, after a table of their ends.
pub const AVATARS: [u8; 4] = *b"AVAT";
/// Section of the codebook that all clips share ([`crate::codebook`]).
pub const CODEBOOK: [u8; 4] = *b"CODE";
/// Section of mean walks, after a table of their ends.
pub const MEAN_WALKS: [u8; 4] = *b"TMPL";
/// Section of clips, after a table of their ends.
pub const CLIPS: [u8; 4] = *b"CLIP";
/// The sections of version 1, in file order.
pub const SECTION_ORDER: [[u8; 4]; 7] =
    [NAMES, SUBJECTS, WALKS, AVATARS, CODEBOOK, MEAN_WALKS, CLIPS];

/// Bytes of a subject record: name offset `u32`, name length `u8`, sex `u8`,
/// stature in mm `u16`, mass in 0.1 kg `u16`, avatar `u16`.
pub const SUBJECT_BYTES: usize = 12;
/// Bits of a subject's byte 5 that hold the sex; the others hold the age.
pub const SEX_BITS: u8 = 0b11;
/// The base from which a subject's age is counted, years: 6 bits hold 18 to 80.
pub const UNDER_AGE_YEARS: u8 = 17;
/// Bytes of a walk record: name offset `u32`, name length `u8`, gait `u8`,
/// subject `u16`, cycle `u16`, speed in mm/s `u16`, clip `u16`, avatar + 1 `u16` or 0.
pub const WALK_BYTES: usize = 16;
/// Bytes of one entry of a table of ends: `u32`.
pub const END_BYTES: usize = 4;

/// Bytes of an avatar's header: greatest point error in 0.01 mm `u16`, step in
/// [`HULL_STEP_M`] `u16`, flags `u8`. A bit stream follows.
pub const AVATAR_HEADER_BYTES: usize = 5;
/// Bits of an avatar's flags that count its stored hulls.
pub const HULL_COUNT_MASK: u8 = 0x3f;
/// Flag of an avatar: the skeleton is symmetric, and its right side is not stored.
pub const SYMMETRIC_SKELETON: u8 = 0x40;
/// Flag of an avatar: its hulls were fitted to a mesh, and the header is longer by
/// [`FITTED_BYTES`]: the Jaccard index that they reach, `u16`, in 1/10,000.
pub const FITTED: u8 = 0x80;
/// Bytes of the Jaccard index after an avatar's header.
pub const FITTED_BYTES: usize = 2;
/// Unit of joint offsets: 0.1 mm.
pub const OFFSET_STEP_M: f32 = 1e-4;
/// Unit of an avatar's quantisation step: 1 micrometre.
pub const HULL_STEP_M: f32 = 1e-6;
/// Bits of the width of joint offsets.
pub const OFFSET_WIDTH_BITS: u32 = 5;
/// The maximum number of bits in a joint offset: 3.2 m.
pub const MAX_OFFSET_WIDTH: u32 = 16;
/// Bits of a hull's joint.
pub const JOINT_BITS: u32 = 5;
/// The value in the place of a joint that precedes the first part of a draped hull.
pub const DRAPED: u32 = 31;
/// The value in the place of the first hull's joint that precedes an avatar's clothes.
pub const DRESSED: u32 = 30;
/// Bits of an avatar's clothes.
pub const CLOTHES_BITS: u32 = 8;
/// Bits of a draped hull's number of stored parts less 1.
pub const PARTS_BITS: u32 = 3;
/// Bits of the number of the axis that the points of a row share: 0 none, 1 x, 2 y, 3 z.
pub const SHARED_BITS: u32 = 2;
/// Bits of the width of a hull's coordinates.
pub const WIDTH_BITS: u32 = 4;
/// Bits of a hull's number of rows less 1.
pub const ROWS_BITS: u32 = 5;
/// Bits of a row's number of stored points less 1.
pub const ROW_LENGTH_BITS: u32 = 3;
/// Bits of the number of a row's points on the plane x = 0.
pub const ROW_MIDDLE_BITS: u32 = 2;

/// Bytes of a codebook before its table of Rice parameters: a reference and a basis of 3 x
/// `i16` for each joint, a step offset `u8` for each channel, a greatest and a mean error
/// `u16` for each joint.
pub const CODEBOOK_BYTES: usize = JOINT_ERRORS_AT + 4 * JOINTS;
/// Bytes of one joint's reference and basis.
pub const FRAME_BYTES: usize = 12;
/// Offset of a codebook's step offsets.
pub const STEPS_AT: usize = FRAME_BYTES * JOINTS;
/// Offset of a codebook's errors.
pub const JOINT_ERRORS_AT: usize = STEPS_AT + CHANNELS;
/// Unit of references and bases, which are vectors of [`crate::rotation`]: all rotations by
/// up to half a turn have components of at most 4.
pub const FRAME_STEP: f32 = 4.0 / 32_767.0;

/// Channels of a clip: three for each joint's rotation and three for the root's position.
pub const CHANNELS: usize = 3 * JOINTS + 3;
/// Groups of a channel: its constant, then a cosine and a sine for each harmonic.
pub const MAX_GROUPS: usize = 1 + MAX_HARMONICS;
/// Bits of a number of groups.
pub const GROUPS_BITS: u32 = 6;
/// Bits of the Rice parameter of a channel's number of groups.
pub const GROUPS_RICE_BITS: u32 = 2;
/// Bits of a Rice parameter.
pub const RICE_BITS: u32 = 4;
/// The greatest Rice parameter.
pub const MAX_RICE: u32 = (1 << RICE_BITS) - 1;
/// The number of groups, the constant's and the first harmonic's, whose Rice parameters are not
/// differences from the previous one.
pub const DIRECT_CODES: usize = 2;
/// The number of ones that escape from a Rice code.
pub const RICE_ESCAPE: u32 = 16;
/// Bits of an escaped number.
pub const ESCAPE_BITS: u32 = 24;

/// Bytes of a mean walk before its bit stream: scale `u8`.
pub const TEMPLATE_HEADER_BYTES: usize = 1;

/// Bytes of a loop's header: kind `u8`, mean walk `u8` (0 for none), scale `u8`, period in
/// microseconds `u32`, travel per cycle in micrometres `i32`, greatest and mean encoding
/// error in 0.01 mm `u16` each, closure error in 0.1 mm `u16`, frames encoded `u16`.
pub const LOOP_HEADER_BYTES: usize = 19;
/// Kind of a clip that is one closed gait cycle.
pub const CLIP_LOOP: u8 = 1;

/// Bytes of an uncut clip's header: kind `u8`, scale `u8`, duration in microseconds `u64`, knot
/// interval in microseconds `u32`, greatest and mean encoding error in 0.01 mm `u16` each, frames
/// encoded `u32`.
pub const UNCUT_HEADER_BYTES: usize = 22;
/// Kind of an uncut clip: a motion that does not repeat.
pub const CLIP_UNCUT: u8 = 2;
/// Channels of an uncut clip: those of a loop, and the heading.
pub const UNCUT_CHANNELS: usize = CHANNELS + 1;
/// The heading's number among an uncut clip's channels.
pub const HEADING: usize = CHANNELS;
/// Bits of a channel's spacing: its knots are 2^spacing intervals apart.
pub const SPACING_BITS: u32 = 2;
/// The spacing of a channel without knots, whose value is stored once.
pub const SPACING_CONSTANT: u32 = (1 << SPACING_BITS) - 1;
/// Intervals in a block of an uncut clip: that many knots of a channel of spacing 0.
///
/// Measured with the encoder on nine uncut motions (CMU 02_01, 03_01, 07_01, 08_05, 09_01, 35_01
/// and 131_01, a figure of eight, 25 s of a laboratory): 8 intervals (without spacing 2, whose four
/// taps would lie in three blocks) take 32,358 B at 5 mm and 68,321 B at 1 mm, 16 take 32,128 B and
/// 65,384 B, 32 take 32,335 B and 67,073 B.
pub const BLOCK_INTERVALS: u64 = 16;
/// Bits of the width of an integer of an uncut clip.
pub const INTEGER_WIDTH_BITS: u32 = 5;
/// The maximum number of bits in an integer of an uncut clip: three of them add up within 27 bits.
pub const MAX_INTEGER_WIDTH: u32 = 25;

/// The first four bytes of every recognizer.
pub const RECOGNIZER_MAGIC: [u8; 4] = *b"EGLR";
/// The version of recognizers that this crate reads and writes.
pub const RECOGNIZER_VERSION: u16 = 1;
/// Bytes before a recognizer's classes: magic, CRC-32, version, rows `u8`, columns `u8`,
/// framing `u8`, number of classes `u8`.
pub const RECOGNIZER_HEADER_BYTES: usize = 14;
/// Offset of the CRC-32 of all bytes after it.
pub const RECOGNIZER_CRC_AT: usize = 4;
/// Offset of the version, from which the CRC-32 covers the file.
pub const RECOGNIZER_VERSION_AT: usize = 8;
/// Offset of the number of rows, which the number of columns follows.
pub const RECOGNIZER_SIZE_AT: usize = 10;
/// Offset of the framing.
pub const RECOGNIZER_FRAMING_AT: usize = 12;
/// Framing of figures that fill all rows.
pub const FRAMING_HEIGHT: u8 = 0;
/// Framing of figures that are stretched to their bounding boxes.
pub const FRAMING_BOX: u8 = 1;
/// Offset of the number of classes.
pub const RECOGNIZER_CLASSES_AT: usize = 13;
/// Bytes of a class before the weights of all classes: scale `f32`, bias `f32`.
pub const CLASS_BYTES: usize = 8;

/// Returns the bits of the width of a block's differences if none is wider than `widest`.
#[must_use]
pub const fn width_bits(widest: u32) -> u32 {
    u32::BITS - widest.leading_zeros()
}

/// Returns the step of scale index `index`, radians or metres: 2^(index / 8 - 20).
#[must_use]
pub fn step_size(index: u8) -> f32 {
    // Exact powers of two times one of eight constants: the same on every target.
    const EIGHTHS: [f32; 8] = [
        1.0,
        1.090_507_7,
        1.189_207_1,
        1.296_839_6,
        core::f32::consts::SQRT_2,
        1.542_210_8,
        1.681_792_9,
        1.834_008_1,
    ];
    let eighth = EIGHTHS.get(usize::from(index % 8)).copied().unwrap_or(1.0);
    let octave = u32::from(index / 8) + 127 - 20;
    eighth * f32::from_bits(octave << 23)
}

/// Returns the CRC-32 (ISO-HDLC, as in PNG and zip) of `bytes`. Byte by byte, with a table of 1 kB:
/// about 2 ns a byte on a host.
#[must_use]
pub fn crc32(bytes: &[u8]) -> u32 {
    static CRC: crc::Crc<u32, crc::Table<1>> =
        crc::Crc::<u32, crc::Table<1>>::new(&crc::CRC_32_ISO_HDLC);
    CRC.checksum(bytes)
}

/// The error for bytes that are not a pack, or not a recognizer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// Offset of the first byte that is wrong, from the start of the file.
    pub byte: usize,
    /// The value or field that was expected there.
    pub expected: &'static str,
}

impl FormatError {
    /// Makes the error for bytes without the `expected` value at `byte`.
    #[must_use]
    pub const fn new(byte: usize, expected: &'static str) -> Self {
        Self { byte, expected }
    }

    /// Moves the error's offset by `base` bytes, from a part to the whole that contains it.
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

/// Returns the `u16` at `at`, or zero past the end.
pub(crate) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    let mut word = [0; 2];
    if let Some(found) = bytes.get(at..at + 2) {
        word.copy_from_slice(found);
    }
    u16::from_le_bytes(word)
}

/// Returns the `i16` at `at`, or zero past the end.
pub(crate) fn i16_at(bytes: &[u8], at: usize) -> i16 {
    u16_at(bytes, at).cast_signed()
}

/// Returns the `f32` at `at`, or zero past the end.
pub(crate) fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(u32_at(bytes, at))
}

/// Returns the `u32` at `at`, or zero past the end.
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
    fn steps_are_eighths_of_octaves_from_two_to_the_minus_twenty() {
        assert_eq!(step_size(0), 1.0 / 1_048_576.0);
        assert_eq!(step_size(160), 1.0);
        for index in 0..=255u8 {
            let exact = (f64::from(index) / 8.0 - 20.0).exp2();
            assert!((f64::from(step_size(index)) / exact - 1.0).abs() < 1e-7);
        }
    }

    #[test]
    fn crc_has_the_published_check_value() {
        // "check" of CRC-32/ISO-HDLC in Williams' and Cook's catalogue.
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }
}

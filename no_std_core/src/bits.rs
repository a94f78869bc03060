//! A reader of packed bits.

use crate::format::{DIRECT_CODES, ESCAPE_BITS, FormatError, MAX_RICE, RICE_BITS, RICE_ESCAPE};

/// The minimum number of unread bits in one word: at most 7 of its first byte have been read.
const AHEAD: u32 = u32::BITS - 7;

/// The greatest total length of two Rice codes at which neither can be an escape, whatever their
/// parameter: with an escape, the computed length is at least its 16 ones, a zero, and the other
/// code's zero.
const PLAIN_PAIR: u32 = RICE_ESCAPE + 1;

/// A reader of unsigned and signed integers of 0 to 25 bits, least significant bit first. Past the
/// end it reads zeros: callers check lengths when they parse.
#[derive(Clone, Copy, Debug)]
pub struct BitReader<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> BitReader<'a> {
    /// Starts at the first bit of `bytes`.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    /// Skips `width` bits, any number of them.
    pub const fn skip(&mut self, width: usize) {
        self.position += width;
    }

    /// Returns the number of bits read so far.
    #[must_use]
    pub const fn position(&self) -> usize {
        self.position
    }

    /// Returns whether more bits were read than there are.
    #[must_use]
    pub const fn is_overrun(&self) -> bool {
        self.position > self.bytes.len() * 8
    }

    /// Returns the next bits, at least [`AHEAD`] of them.
    #[inline]
    fn ahead(&self) -> u32 {
        let at = self.position / 8;
        let word = self.bytes.get(at..at + 4).and_then(<[u8]>::first_chunk);
        let word = word.map_or_else(
            || last_word(self.bytes, at),
            |four| u32::from_le_bytes(*four),
        );
        word >> (self.position % 8)
    }

    /// Checks that the stream ends after the bits read so far, padded with zeros to whole bytes.
    /// Streams that decode to the same numbers are thus the same bytes.
    ///
    /// # Errors
    /// If bits are missing, bytes are left over, or the last bits are not 0.
    pub fn check_end(&self) -> Result<(), FormatError> {
        if self.position.div_ceil(8) != self.bytes.len() {
            return Err(FormatError::new(
                self.bytes.len().min(self.position / 8),
                "a bit stream that ends with its last number",
            ));
        }
        if let (Some(last), rest @ 1..) = (self.bytes.last(), self.position % 8)
            && last >> rest != 0
        {
            return Err(FormatError::new(
                self.bytes.len() - 1,
                "zeros after the last number of a bit stream",
            ));
        }
        Ok(())
    }

    /// Reads the next `width` bits as an unsigned integer; `width` is at most 25.
    #[inline]
    pub fn unsigned(&mut self, width: u32) -> u32 {
        debug_assert!(width <= 25);
        let value = self.ahead() & ((1 << width) - 1);
        self.position += width as usize;
        value
    }

    /// Reads the next `width` bits as a two's complement integer; `width` is at most 25.
    pub fn signed(&mut self, width: u32) -> i32 {
        if width == 0 {
            return 0;
        }
        let value = self.unsigned(width).cast_signed();
        (value << (32 - width)) >> (32 - width)
    }

    /// Reads the next integer in a Rice code (Rice and Plaunt 1971) with parameter `k`, at most 15:
    /// the zigzag number (0, 1, -1, 2, -2... as 0, 1, 2, 3, 4...) divided by 2^k as that many ones
    /// and a zero, then the remainder in `k` bits. Sixteen ones are an escape: a two's complement
    /// integer of 24 bits follows.
    #[inline(always)]
    pub fn rice(&mut self, k: u32) -> i32 {
        debug_assert!(k <= MAX_RICE);
        let ahead = self.ahead();
        let ones = ahead.trailing_ones();
        if ones + MAX_RICE >= AHEAD {
            // Passed by value: a borrowed reader is not kept in registers.
            let (number, behind) = long_rice(*self, k);
            self.position = behind;
            return number;
        }
        // This word holds the remainder as well.
        self.position += (ones + 1 + k) as usize;
        from_zigzag(ones << k | (ahead >> ones >> 1) & ((1 << k) - 1))
    }

    /// Reads the next two integers in Rice codes with parameter `k`, from one word if both are
    /// short, as they mostly are.
    #[inline(always)]
    pub(crate) fn rice_pair(&mut self, k: u32) -> [i32; 2] {
        debug_assert!(k <= MAX_RICE);
        let ahead = self.ahead();
        let ones = ahead.trailing_ones();
        let first = ones + 1 + k;
        let behind = ahead.unbounded_shr(first);
        let more = behind.trailing_ones();
        let both = first + more + 1 + k;
        if both > PLAIN_PAIR {
            let (numbers, behind) = rice_apart(*self, k);
            self.position = behind;
            return numbers;
        }
        self.position += both as usize;
        let mask = (1 << k) - 1;
        [
            from_zigzag(ones << k | (ahead >> ones >> 1) & mask),
            from_zigzag(more << k | (behind >> more >> 1) & mask),
        ]
    }

    /// Reads the Rice parameters of a channel's groups: the first [`DIRECT_CODES`] directly, the others
    /// as differences from the previous one in a Rice code with parameter 0. These are mostly 0 or
    /// nearly so, and one word holds many.
    #[inline]
    pub(crate) fn codes(&mut self, codes: &mut [u8]) {
        // A copy is kept in registers.
        let mut here = *self;
        let (mut word, mut unread) = (here.ahead(), AHEAD);
        let (direct, others) = codes.split_at_mut(codes.len().min(DIRECT_CODES));
        let mut last = 0;
        for code in direct {
            last = word & ((1 << RICE_BITS) - 1);
            *code = last.to_le_bytes()[0];
            word >>= RICE_BITS;
            unread -= RICE_BITS;
        }
        for code in others {
            let ones = word.trailing_ones();
            let difference = if ones < unread.min(RICE_ESCAPE) {
                word >>= ones + 1;
                unread -= ones + 1;
                from_zigzag(ones)
            } else {
                here.skip((AHEAD - unread) as usize);
                let difference = here.rice(0);
                (word, unread) = (here.ahead(), AHEAD);
                difference
            };
            last = last.wrapping_sub(difference.cast_unsigned());
            *code = last.to_le_bytes()[0];
        }
        here.skip((AHEAD - unread) as usize);
        *self = here;
    }

    /// Skips an integer in a Rice code with parameter `k`.
    #[inline]
    pub(crate) fn skip_rice(&mut self, k: u32) {
        let ones = self.ahead().trailing_ones();
        if ones >= RICE_ESCAPE {
            self.position += (RICE_ESCAPE + ESCAPE_BITS) as usize;
            return;
        }
        self.position += (ones + 1 + k) as usize;
    }
}

/// Returns the bytes from `at` on, fewer than four, padded with zeros.
#[cold]
#[inline(never)]
fn last_word(bytes: &[u8], at: usize) -> u32 {
    let Some(four) = bytes.last_chunk() else {
        let rest = bytes.get(at..).unwrap_or_default().iter();
        return rest.rfold(0, |word, &byte| word << 8 | u32::from(byte));
    };
    let before = u32::try_from(at + 4 - bytes.len()).unwrap_or(u32::MAX);
    let word = u32::from_le_bytes(*four);
    word.checked_shr(before.saturating_mul(8)).unwrap_or(0)
}

/// Reads an integer that begins with many ones, in a Rice code with parameter `k`, and returns it
/// and the position after it.
#[cold]
#[inline(never)]
fn long_rice(mut bits: BitReader<'_>, k: u32) -> (i32, usize) {
    let ones = bits.ahead().trailing_ones().min(RICE_ESCAPE);
    bits.skip(ones as usize);
    let number = if ones == RICE_ESCAPE {
        bits.signed(ESCAPE_BITS)
    } else {
        bits.skip(1);
        from_zigzag(ones << k | bits.unsigned(k))
    };
    (number, bits.position)
}

/// Reads two integers one by one, in Rice codes with parameter `k`, and returns them and the
/// position after them.
#[inline(never)]
fn rice_apart(mut bits: BitReader<'_>, k: u32) -> ([i32; 2], usize) {
    let numbers = [bits.rice(k), bits.rice(k)];
    (numbers, bits.position)
}

/// Maps 0, 1, 2, 3, 4... to 0, 1, -1, 2, -2...
#[inline]
const fn from_zigzag(zigzag: u32) -> i32 {
    // 0 or -1. The negated complement of the half is the half plus one.
    let odd = -(zigzag & 1).cast_signed();
    -((zigzag >> 1).cast_signed() ^ odd)
}

/// Packs values of the given widths in bits, for tests of readers.
#[cfg(test)]
pub(crate) fn packed(fields: &[(i32, usize)]) -> heapless::Vec<u8, 2048> {
    let bits = fields.iter().map(|&(_, width)| width).sum::<usize>();
    let mut bytes = heapless::Vec::new();
    bytes.resize(bits.div_ceil(8), 0).expect("2048 bytes");
    let mut at = 0;
    for &(value, width) in fields {
        for bit in 0..width {
            bytes[at / 8] |= u8::from(value >> bit.min(31) & 1 == 1) << (at % 8);
            at += 1;
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_read_least_significant_first() {
        let mut bits = BitReader::new(&[0b1010_0110, 0b0000_0001]);
        assert_eq!(bits.unsigned(3), 0b110);
        assert_eq!(bits.unsigned(5), 0b10100);
        assert_eq!(bits.unsigned(2), 1);
        assert_eq!(bits.position(), 10);
        assert!(!bits.is_overrun());
    }

    #[test]
    fn bits_that_are_skipped_are_not_read() {
        let mut bits = BitReader::new(&[0xff, 0b0001_0000, 0x80]);
        bits.skip(12);
        assert_eq!(bits.unsigned(3), 1);
        bits.skip(9);
        assert_eq!(bits.position(), 24);
        assert!(!bits.is_overrun());
        bits.skip(100);
        assert!(bits.is_overrun());
    }

    #[test]
    fn signed_values_extend_their_sign() {
        let mut bits = BitReader::new(&[0b0111_1000, 0xff]);
        assert_eq!(bits.signed(0), 0);
        assert_eq!(bits.signed(3), 0);
        assert_eq!(bits.signed(4), -1);
        assert_eq!(bits.signed(1), 0);
        assert_eq!(bits.signed(8), -1);
    }

    #[test]
    fn reading_past_the_end_gives_zeros_and_is_noticed() {
        let mut bits = BitReader::new(&[0xff]);
        assert_eq!(bits.unsigned(12), 0xff);
        assert!(bits.is_overrun());
        assert_eq!(bits.unsigned(25), 0);
    }

    #[test]
    fn rice_codes_are_read() {
        // k = 1: 3 is zigzag 5 = 2 * 2 + 1: 1 1 0, 1; -1 is zigzag 2 = 1 * 2 + 0: 1 0, 0;
        // k = 0: 0 is 0. From the lowest bit: 1 1 0 1 1 0 0 0.
        let mut bits = BitReader::new(&[0b0001_1011]);
        assert_eq!([bits.rice(1), bits.rice(1), bits.rice(0)], [3, -1, 0]);
        assert_eq!(bits.position(), 8);
    }

    #[test]
    fn sixteen_ones_escape_to_24_bits() {
        let mut bits = BitReader::new(&[0xff, 0xff, 0xfe, 0xff, 0xff, 0x02]);
        assert_eq!(bits.rice(5), -2);
        // Then 0 (zigzag 0) and 1 0 (zigzag 1).
        assert_eq!([bits.rice(0), bits.rice(0)], [0, 1]);
    }
    /// Returns the code of a number as fields of values and widths in bits.
    fn code(value: i32, k: u32) -> [(i32, usize); 2] {
        let zigzag = if value > 0 { 2 * value - 1 } else { -2 * value };
        let ones = zigzag >> k;
        if ones >= RICE_ESCAPE.cast_signed() {
            return [(0xffff, 16), (value, 24)];
        }
        let ones = usize::try_from(ones).expect("not negative");
        [((1 << ones) - 1, ones + 1), (zigzag, k as usize)]
    }

    #[test]
    fn codes_are_two_fields_and_differences() {
        // All series of 0 to 14 codes with one of two differences, so that words end before, in and
        // behind codes; 8 has an escape.
        for differences in [[0, 1], [0, -4], [-7, 7], [3, -8], [0, 8], [8, -8]] {
            for choice in 0..1_u32 << 12 {
                let mut fields = heapless::Vec::<_, 26>::new();
                let mut expected = [9_u8, 6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
                let _ = fields.extend_from_slice(&[(9, 4), (6, 4)]);
                for bit in 0..12 {
                    let difference = differences[(choice >> bit & 1) as usize];
                    let _ = fields.extend_from_slice(&code(difference, 0));
                    let last = i32::from(expected[bit + 1]) - difference;
                    expected[bit + 2] = last.to_le_bytes()[0];
                }
                let bytes = packed(&fields);
                for len in [0, 1, 2 + choice as usize % 13] {
                    let (mut bits, mut read) = (BitReader::new(&bytes), [0; 14]);
                    bits.codes(&mut read[..len]);
                    assert_eq!(read[..len], expected[..len], "{differences:?} {choice:b}");
                    let before = &fields[..if len < 2 { len } else { 2 * len - 2 }];
                    let before = before.iter().map(|field| field.1).sum::<usize>();
                    assert_eq!(bits.position(), before, "{differences:?} {choice:b} {len}");
                }
            }
        }
    }

    #[test]
    fn a_pair_is_two_integers_one_after_the_other() {
        let values = [
            0, 1, -1, 2, -3, 5, 7, -8, 8, 15, -16, 16, 100, -1000, 12_345, -70_000,
        ];
        for k in 0..=MAX_RICE {
            for (first, second) in values.iter().flat_map(|&a| values.map(|b| (a, b))) {
                // Other bits before the pair, and ones after it.
                for (before, behind) in (0..8).flat_map(|before| [(before, 0), (before, 31)]) {
                    let [a, b] = [first, second].map(|value| code(value, k));
                    let fields = [[(0x55, before), (-1, 0)], a, b, [(-1, behind), (0, 0)]];
                    let bytes = packed(fields.as_flattened());
                    let mut bits = BitReader::new(&bytes);
                    bits.skip(before);
                    assert_eq!(bits.rice_pair(k), [first, second], "{k} {before} {behind}");
                    let len = [a, b]
                        .as_flattened()
                        .iter()
                        .map(|field| field.1)
                        .sum::<usize>();
                    assert_eq!(bits.position(), before + len, "{first} {second} {k}");
                }
            }
        }
    }
}

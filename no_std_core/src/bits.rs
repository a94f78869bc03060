//! Reading packed bits from a slice.

/// Reads unsigned and signed integers of 0 to 25 bits, least significant bit
/// first. Past the end it reads zeros: callers check lengths when they parse.
#[derive(Clone, Debug)]
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

    /// Bits read so far.
    #[must_use]
    pub const fn position(&self) -> usize {
        self.position
    }

    /// Whether more bits were read than there are.
    #[must_use]
    pub const fn is_overrun(&self) -> bool {
        self.position > self.bytes.len() * 8
    }

    /// The next `width` bits as an unsigned integer; `width` is at most 25.
    pub fn unsigned(&mut self, width: u32) -> u32 {
        debug_assert!(width <= 25);
        let rest = self.bytes.get(self.position / 8..).unwrap_or_default();
        let word = match rest.first_chunk() {
            Some(whole) => u32::from_le_bytes(*whole),
            None => rest
                .iter()
                .rev()
                .fold(0, |word, &byte| word << 8 | u32::from(byte)),
        };
        let value = (word >> (self.position % 8)) & ((1 << width) - 1);
        self.position += width as usize;
        value
    }

    /// The next `width` bits as a two's complement integer; `width` is at most 25.
    pub fn signed(&mut self, width: u32) -> i32 {
        if width == 0 {
            return 0;
        }
        let value = self.unsigned(width).cast_signed();
        (value << (32 - width)) >> (32 - width)
    }
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
}

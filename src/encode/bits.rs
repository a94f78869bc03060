//! A writer of packed bits, the inverse of `edgegait_core::bits::BitReader`.

use edgegait_core::format::{ESCAPE_BITS, RICE_ESCAPE};

/// A writer that appends integers of 0 to 25 bits, least significant bit first.
#[derive(Clone, Debug, Default)]
pub(super) struct BitWriter {
    bytes: Vec<u8>,
    bits: usize,
}

impl BitWriter {
    /// Appends the `width` low bits of `value`.
    pub(super) fn unsigned(&mut self, value: u32, width: u32) {
        for bit in 0..width {
            if self.bits.is_multiple_of(8) {
                self.bytes.push(0);
            }
            if let Some(last) = self.bytes.last_mut() {
                *last |= u8::from(value >> bit & 1 == 1) << (self.bits % 8);
            }
            self.bits += 1;
        }
    }

    /// Appends `value` as a two's complement integer of `width` bits.
    pub(super) fn signed(&mut self, value: i32, width: u32) {
        self.unsigned(value.cast_unsigned(), width);
    }

    /// Appends `value` in the Rice code with this parameter.
    pub(super) fn rice(&mut self, value: i32, parameter: u32) {
        let zigzag = zigzag(value);
        let ones = zigzag >> parameter;
        if ones >= RICE_ESCAPE {
            self.unsigned((1 << RICE_ESCAPE) - 1, RICE_ESCAPE);
            self.signed(value, ESCAPE_BITS);
        } else {
            self.unsigned((1 << ones) - 1, ones + 1);
            self.unsigned(zigzag, parameter);
        }
    }

    /// Returns the bytes, with zeros in the unused bits of the last one.
    #[must_use]
    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

/// Maps 0, 1, -1, 2, -2... to 0, 1, 2, 3, 4...
fn zigzag(value: i32) -> u32 {
    if value > 0 {
        2 * value.unsigned_abs() - 1
    } else {
        2 * value.unsigned_abs()
    }
}

/// Returns the number of bits that [`BitWriter::rice`] appends.
#[must_use]
pub(super) fn rice_bits(value: i32, parameter: u32) -> u32 {
    let ones = zigzag(value) >> parameter;
    if ones >= RICE_ESCAPE {
        RICE_ESCAPE + ESCAPE_BITS
    } else {
        ones + 1 + parameter
    }
}

/// Returns the number of bits of `value` as a two's complement integer; 0 for 0.
#[must_use]
pub(super) fn signed_width(value: i32) -> u32 {
    if value == 0 {
        return 0;
    }
    let magnitude = if value < 0 { !value } else { value };
    33 - magnitude.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::bits::BitReader;

    #[test]
    fn what_is_written_is_read() {
        let values = [0, 1, -1, 7, -8, 100, -16_384, 16_383, 8_388_607, -8_388_608];
        let mut writer = BitWriter::default();
        let mut bits = 0;
        for parameter in 0..=15 {
            for value in values {
                writer.rice(value, parameter);
                bits += rice_bits(value, parameter) as usize;
            }
        }
        writer.signed(-5, 4);
        let bytes = writer.into_bytes();
        let mut reader = BitReader::new(&bytes);
        for parameter in 0..=15 {
            for value in values {
                assert_eq!(reader.rice(parameter), value, "{parameter}");
            }
        }
        assert_eq!(reader.position(), bits);
        assert_eq!(reader.signed(4), -5);
        assert!(!reader.is_overrun());
    }

    #[test]
    fn widths_are_the_smallest_that_hold_the_value() {
        assert_eq!([1, -1, -2, 127, -128].map(signed_width), [2, 1, 2, 8, 8]);
    }
}

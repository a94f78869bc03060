//! The number formats of the three machines that write C3D files.

/// The number format of a file, named after its machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NumberFormat {
    /// Intel: little endian, IEEE 754.
    Pc,
    /// DEC VAX and PDP-11: little endian words, floats in the F format.
    Vax,
    /// SGI MIPS: big endian, IEEE 754.
    Mips,
}

impl NumberFormat {
    /// Returns the format for the fourth byte of the parameter section.
    pub(super) const fn from_byte(byte: u8) -> Option<Self> {
        match byte {
            84 => Some(Self::Pc),
            85 => Some(Self::Vax),
            86 => Some(Self::Mips),
            _ => None,
        }
    }

    /// Decodes an unsigned word.
    pub(super) const fn word(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Pc | Self::Vax => u16::from_le_bytes(bytes),
            Self::Mips => u16::from_be_bytes(bytes),
        }
    }

    /// Decodes a signed word.
    pub(super) const fn integer(self, bytes: [u8; 2]) -> i16 {
        self.word(bytes).cast_signed()
    }

    /// Decodes a float. VAX's reserved operands (a sign without exponent) become NaN.
    pub(super) fn real(self, bytes: [u8; 4]) -> f64 {
        match self {
            Self::Pc => f32::from_le_bytes(bytes).into(),
            Self::Mips => f32::from_be_bytes(bytes).into(),
            Self::Vax => {
                let [a, b, c, d] = bytes;
                let bits = u32::from_le_bytes([c, d, a, b]);
                let sign = if bits >> 31 == 0 { 1.0 } else { -1.0 };
                let exponent = i32::from((bits << 1).to_be_bytes()[0]);
                match exponent {
                    0 if sign > 0.0 => 0.0,
                    0 => f64::NAN,
                    // 0.1f in base 2, times 2^(exponent - 128); f has 23 bits.
                    _ => {
                        let mantissa = f64::from(bits & 0x7f_ffff | 0x80_0000);
                        sign * libm::ldexp(mantissa, exponent - 128 - 24)
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vax_floats_are_those_of_the_architecture_manual() {
        // VAX Architecture Reference Manual (1987), F_floating: 1.0 is 0x4080 in the first
        // word, -1.0 0xC080, 0.5 0x4000, 3.5 0x4160; pi is 0x4149 0x0FDB.
        let real = |first: u16, second: u16| {
            let [a, b] = first.to_le_bytes();
            let [c, d] = second.to_le_bytes();
            NumberFormat::Vax.real([a, b, c, d])
        };
        assert_eq!(real(0x4080, 0).to_bits(), 1f64.to_bits());
        assert_eq!(real(0xC080, 0).to_bits(), (-1f64).to_bits());
        assert_eq!(real(0x4000, 0).to_bits(), 0.5f64.to_bits());
        assert_eq!(real(0x4160, 0).to_bits(), 3.5f64.to_bits());
        assert!((real(0x4149, 0x0FDB) - std::f64::consts::PI).abs() < 1e-7);
        assert_eq!(real(0, 0x1234).to_bits(), 0f64.to_bits());
        assert!(real(0x8000, 0).is_nan());
        // The smallest number, 2^-128, which is not a normal f32.
        assert_eq!(real(0x0080, 0).to_bits(), libm::ldexp(1.0, -128).to_bits());
    }

    #[test]
    fn words_and_ieee_floats_differ_only_in_the_order_of_bytes() {
        assert_eq!(NumberFormat::Pc.integer([0xFE, 0xFF]), -2);
        assert_eq!(NumberFormat::Vax.word([0x01, 0x02]), 0x0201);
        assert_eq!(NumberFormat::Mips.word([0x01, 0x02]), 0x0102);
        assert_eq!(
            NumberFormat::Pc.real([0, 0, 0x80, 0xBF]).to_bits(),
            (-1f64).to_bits()
        );
        assert_eq!(
            NumberFormat::Mips.real([0xBF, 0x80, 0, 0]).to_bits(),
            (-1f64).to_bits()
        );
        assert_eq!(NumberFormat::from_byte(83), None);
    }
}

//! The numbers in which arrays of masks are stored, and their grey pixels.

use std::borrow::Cow;

/// An array of grey pixels in C order.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct ByteArray<'a> {
    pub shape: Vec<usize>,
    pub bytes: Cow<'a, [u8]>,
}

/// The type of an array's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NumberType {
    Bool,
    Uint8,
    Int32,
    Int64,
    Float16,
    Float32,
    Float64,
}

impl NumberType {
    /// Returns the type of this name in NumPy's notation, if masks are stored in it.
    pub(super) fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "b1" => Self::Bool,
            "u1" => Self::Uint8,
            "i4" => Self::Int32,
            "i8" => Self::Int64,
            "f2" => Self::Float16,
            "f4" => Self::Float32,
            "f8" => Self::Float64,
            _ => return None,
        })
    }

    /// Returns the message about a type that masks are not stored in.
    pub(super) fn expected(found: &str) -> String {
        format!(
            "expected an array of uint8 (u1), bool, int32, int64, float16, float32 or float64, found {found}"
        )
    }

    /// Returns the number of bytes of a number.
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::Bool | Self::Uint8 => 1,
            Self::Float16 => 2,
            Self::Int32 | Self::Float32 => 4,
            Self::Int64 | Self::Float64 => 8,
        }
    }

    /// Converts whole numbers of this type, little-endian, to grey pixels. If none is above 1, they
    /// are a mask's and become 0 to 255; other numbers are rounded.
    ///
    /// # Errors
    /// If a number is below 0, above 255 or not finite.
    pub(super) fn grey(self, bytes: Cow<'_, [u8]>) -> Result<Cow<'_, [u8]>, String> {
        if let Self::Bool | Self::Uint8 = self {
            return Ok(match bytes.iter().max() {
                Some(1) => bytes.iter().map(|byte| 255 * byte).collect(),
                _ => bytes,
            });
        }
        let numbers = || {
            bytes
                .chunks_exact(self.bytes())
                .map(|bytes| self.number(bytes))
        };
        let is_grey = |number: &f64| (0.0..=255.0).contains(number);
        if let Some(other) = numbers().find(|number| !is_grey(number)) {
            return Err(format!(
                "expected numbers from 0 to 1 or from 0 to 255, found {other}"
            ));
        }
        let most = numbers().fold(0.0, f64::max);
        let scale = if most <= 1.0 { 255.0 } else { 1.0 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to 255"
        )]
        let grey = |number: f64| (scale * number).round() as u8;
        Ok(numbers().map(grey).collect())
    }

    /// Converts the bytes of one number.
    fn number(self, bytes: &[u8]) -> f64 {
        let four = || bytes.try_into().unwrap_or_default();
        let eight = || bytes.try_into().unwrap_or_default();
        match self {
            Self::Bool | Self::Uint8 => bytes.first().map_or(0.0, |byte| f64::from(*byte)),
            Self::Int32 => i32::from_le_bytes(four()).into(),
            Self::Float32 => f32::from_le_bytes(four()).into(),
            Self::Float16 => half(u16::from_le_bytes(bytes.try_into().unwrap_or_default())),
            // Rounding matters only far outside of the range.
            Self::Int64 => i64::from_le_bytes(eight()) as f64,
            Self::Float64 => f64::from_le_bytes(eight()),
        }
    }
}

/// Converts a number of half precision (IEEE 754-2019, binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    sign * match bits >> 10 & 0x1f {
        0 => fraction * 2_f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1.0 + fraction) * 2_f64.powi(i32::from(exponent) - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(kind: &str, bytes: Vec<u8>) -> Result<Vec<u8>, String> {
        let kind = NumberType::parse(kind).expect("a type");
        kind.grey(Cow::Owned(bytes)).map(Cow::into_owned)
    }

    fn floats(numbers: &[f32]) -> Vec<u8> {
        numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect()
    }

    fn doubles(numbers: &[f64]) -> Vec<u8> {
        numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect()
    }

    #[test]
    fn masks_of_any_type_become_0_to_255() {
        assert_eq!(grey("b1", vec![0, 1, 1]), Ok(vec![0, 255, 255]));
        assert_eq!(grey("u1", vec![1, 0, 1]), Ok(vec![255, 0, 255]));
        assert_eq!(grey("u1", vec![0, 1, 7, 255]), Ok(vec![0, 1, 7, 255]));
        assert_eq!(grey("u1", vec![0, 0]), Ok(vec![0, 0]));
        let whole = |numbers: [i32; 3]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        assert_eq!(grey("i4", whole([0, 1, 0])), Ok(vec![0, 255, 0]));
        let long = |numbers: [i64; 3]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        assert_eq!(grey("i8", long([255, 128, 0])), Ok(vec![255, 128, 0]));
        // 0.5 x 255 = 127.5, which is rounded up.
        assert_eq!(grey("f4", floats(&[0.0, 0.5, 1.0])), Ok(vec![0, 128, 255]));
        assert_eq!(grey("f8", doubles(&[0.2, 0.998])), Ok(vec![51, 254]));
        assert_eq!(grey("f8", doubles(&[0.4, 254.6])), Ok(vec![0, 255]));
        // numpy.float16([0, 2 ** -24, 0.5, 1]).tobytes()
        let halves = vec![0, 0, 1, 0, 0, 0x38, 0, 0x3c];
        assert_eq!(grey("f2", halves), Ok(vec![0, 0, 128, 255]));
        // numpy.float16([255, 2]).tobytes()
        assert_eq!(grey("f2", vec![0xf8, 0x5b, 0, 0x40]), Ok(vec![255, 2]));
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for (numbers, found) in [
            (&[0.0, -0.5, 1.0][..], "found -0.5"),
            (&[0.0, 256.0], "found 256"),
            (&[f32::NAN, 1.0], "found NaN"),
            (&[f32::INFINITY], "found inf"),
        ] {
            let refused = grey("f4", floats(numbers)).expect_err("refused");
            assert!(refused.ends_with(found), "{refused}");
        }
        assert_eq!(NumberType::parse("f16"), None);
        assert_eq!(NumberType::parse("O8"), None);
    }
}

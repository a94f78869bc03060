//! Numbers in arrays, which the compiler keeps in whatever registers there are.

use super::{Lanes, Wide};

/// Any processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Portable;

/// Makes an array of a value for each lane in a plain loop, which the compiler vectorises where it
/// would not inline closures.
macro_rules! each {
    ($zero:expr; $lane:ident => $value:expr) => {{
        let mut lanes = [$zero; N];
        let mut $lane = 0;
        while $lane < N {
            lanes[$lane] = $value;
            $lane += 1;
        }
        lanes
    }};
}

impl<const N: usize> Lanes<N> for Portable {
    type Floats = [f32; N];
    type Words = [u32; N];
    /// All bits of a lane set, or none, as in SSE2 and NEON.
    type Mask = [u32; N];

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        [value; N]
    }
    #[inline(always)]
    fn load(self, from: &[f32; N]) -> Self::Floats {
        *from
    }
    #[inline(always)]
    fn store(self, floats: Self::Floats, to: &mut [f32; N]) {
        *to = floats;
    }
    #[inline(always)]
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(0.0; k => a[k] + b[k])
    }
    #[inline(always)]
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(0.0; k => a[k] - b[k])
    }
    #[inline(always)]
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(0.0; k => a[k] * b[k])
    }
    #[inline(always)]
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(0.0; k => a[k] / b[k])
    }
    #[inline(always)]
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(0.0; k => if a[k] < b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(0.0; k => if a[k] > b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        each!(0; k => if a[k] < b[k] { u32::MAX } else { 0 })
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        each!(0; k => a[k] & b[k])
    }
    #[inline(always)]
    fn not_less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        each!(0; k => if a[k] >= b[k] { u32::MAX } else { 0 })
    }
    #[inline(always)]
    fn reach(
        self,
        (left, right): (Self::Floats, Self::Floats),
        x: Self::Floats,
        [top, row, bottom]: [Self::Floats; 3],
    ) -> (Self::Floats, Self::Floats) {
        // A NaN has no effect.
        let x = each!(0.0; k => {
            let is_outside = !((top[k] < row[k]) & (row[k] <= bottom[k]));
            f32::from_bits(x[k].to_bits() | if is_outside { u32::MAX } else { 0 })
        });
        (
            Lanes::<N>::min(self, x, left),
            Lanes::<N>::max(self, x, right),
        )
    }
    #[inline(always)]
    fn truncate(self, floats: Self::Floats) -> Self::Words {
        // Adding 2^23 leaves the nearest integer in the lower bits: SSE2 has no faster
        // conversion that Rust's saturating one could become.
        const SHIFT: f32 = 8_388_608.0;
        let nearest = each!(0.0; k => (floats[k] + SHIFT) - SHIFT);
        let excess = each!(0.0; k => if nearest[k] > floats[k] { 1.0 } else { 0.0 });
        each!(0; k => (nearest[k] - excess[k] + SHIFT).to_bits() & 0x7f_ffff)
    }

    #[inline(always)]
    fn round(self, floats: Self::Floats) -> Self::Words {
        // Adding 2^23 leaves the nearest integer in the lower bits.
        each!(0; k => (floats[k] + 8_388_608.0).to_bits() & 0x7f_ffff)
    }

    #[inline(always)]
    fn splat_word(self, value: u32) -> Self::Words {
        [value; N]
    }
    #[inline(always)]
    fn load_words(self, from: &[u32; N]) -> Self::Words {
        *from
    }
    #[inline(always)]
    fn store_words(self, words: Self::Words, to: &mut [u32; N]) {
        *to = words;
    }
    #[inline(always)]
    fn add_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k].wrapping_add(b[k]))
    }
    #[inline(always)]
    fn sub_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k].wrapping_sub(b[k]))
    }
    #[inline(always)]
    fn and_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k] & b[k])
    }
    #[inline(always)]
    fn less_words(self, a: Self::Words, b: Self::Words) -> Self::Mask {
        each!(0; k => if a[k].cast_signed() < b[k].cast_signed() { u32::MAX } else { 0 })
    }
    #[inline(always)]
    fn max_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k].cast_signed().max(b[k].cast_signed()).cast_unsigned())
    }
    #[inline(always)]
    fn choose(self, mask: Self::Mask, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k] & mask[k] | b[k] & !mask[k])
    }
    #[inline(always)]
    fn mul_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k].wrapping_mul(b[k]))
    }
    #[inline(always)]
    fn up<const BY: u32>(self, words: Self::Words) -> Self::Words {
        each!(0; k => words[k] << BY)
    }
    #[inline(always)]
    fn down<const BY: u32>(self, words: Self::Words) -> Self::Words {
        each!(0; k => (words[k].cast_signed() >> BY).cast_unsigned())
    }
    #[inline(always)]
    fn whole(self, floats: Self::Floats) -> Self::Floats {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_precision_loss,
            reason = "what is asked for"
        )]
        let whole = each!(0.0; k => floats[k] as i32 as f32);
        whole
    }
    #[inline(always)]
    fn cut_off(self, floats: Self::Floats) -> Self::Words {
        #[expect(clippy::cast_possible_truncation, reason = "what is asked for")]
        let cut_off = each!(0; k => (floats[k] as i32).cast_unsigned());
        cut_off
    }
    #[inline(always)]
    fn slopes(self, across: Self::Words, down: Self::Words) -> Self::Words {
        // A quotient that is not whole is 2^-14 or more from a whole number.
        #[expect(clippy::cast_possible_truncation, reason = "what is asked for")]
        let slopes = each!(0; k => {
            let across = f64::from((across[k] << 16).cast_signed());
            ((across / f64::from(down[k].cast_signed())) as i32).cast_unsigned()
        });
        slopes
    }
    #[inline(always)]
    fn min_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k].cast_signed().min(b[k].cast_signed()).cast_unsigned())
    }
    #[inline(always)]
    fn widen(
        self,
        (left, right): (Self::Words, Self::Words),
        at: Self::Words,
        row: Self::Words,
        [first, last]: [Self::Words; 2],
    ) -> (Self::Words, Self::Words) {
        // SSE2 compares signed numbers only.
        let is_inside = each!(0; k => {
            let [first, row, last] = [first[k], row[k], last[k]].map(u32::cast_signed);
            if (first <= row) & (row <= last) { u32::MAX } else { 0 }
        });
        let high = each!(0; k => at[k] & is_inside[k]);
        let low = each!(0; k => high[k] | !is_inside[k] >> 1);
        (
            Lanes::<N>::min_words(self, left, low),
            Lanes::<N>::max_words(self, right, high),
        )
    }
    #[inline(always)]
    fn between(self, from: Self::Words, to: Self::Words) -> Self::Words {
        // SSE2 has powers of two, but no shifts by lane.
        let to = Lanes::<N>::max_words(self, from, to);
        let power = |exponent: u32| if exponent < 32 { 1u32 << exponent } else { 0 };
        let (from, to) = (each!(0; k => power(from[k])), each!(0; k => power(to[k])));
        each!(0; k => to[k].wrapping_sub(from[k]))
    }
    #[inline(always)]
    fn count_ones(self, words: Self::Words) -> Self::Words {
        each!(0; k => words[k].count_ones())
    }

    #[inline(always)]
    fn bits_from(self, first: Self::Words) -> Self::Words {
        each!(0; k => if first[k] < 32 { u32::MAX << first[k] } else { 0 })
    }
    #[inline(always)]
    fn bits_but(self, highest: Self::Words) -> Self::Words {
        each!(0; k => if highest[k] < 32 { u32::MAX >> highest[k] } else { 0 })
    }
    #[inline(always)]
    fn without(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k] & !b[k])
    }
    #[inline(always)]
    fn or_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(0; k => a[k] | b[k])
    }
    #[inline(always)]
    fn bits(self, mask: Self::Mask) -> u32 {
        let mut bits = 0;
        let mut lane = 0;
        while lane < N {
            bits |= u32::from(mask[lane] != 0) << lane;
            lane += 1;
        }
        bits
    }
}

impl Wide for Portable {
    type Half = Self;

    super::cuts::edge_by_edge!();

    #[inline(always)]
    fn half(self) -> Self {
        self
    }
}

//! Sixteen numbers in an array, which the compiler puts into what registers there are.

use super::{LANES, Lanes};

/// Any processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Portable;

/// An array of a value for each lane: a plain loop, which the compiler vectorises wherever
/// closures would be called.
macro_rules! each {
    ($lane:ident => $value:expr) => {{
        let mut lanes = [Default::default(); LANES];
        let mut $lane = 0;
        while $lane < LANES {
            lanes[$lane] = $value;
            $lane += 1;
        }
        lanes
    }};
}

/// `a` where the mask is set, otherwise `b`.
#[inline(always)]
fn select(mask: [u32; LANES], a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
    each!(k => f32::from_bits(mask[k] & a[k].to_bits() | !mask[k] & b[k].to_bits()))
}

impl Lanes for Portable {
    type Floats = [f32; LANES];
    type Words = [u32; LANES];
    /// All bits of a lane, or none, as SSE2 and NEON have it.
    type Mask = [u32; LANES];
    type Parity = u64;

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        [value; LANES]
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> Self::Floats {
        *from
    }
    #[inline(always)]
    fn store(self, floats: Self::Floats, to: &mut [f32; LANES]) {
        *to = floats;
    }
    #[inline(always)]
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(k => a[k] + b[k])
    }
    #[inline(always)]
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(k => a[k] - b[k])
    }
    #[inline(always)]
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(k => a[k] * b[k])
    }
    #[inline(always)]
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(k => a[k] / b[k])
    }
    #[inline(always)]
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(k => if a[k] < b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        each!(k => if a[k] > b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        each!(k => if a[k] < b[k] { u32::MAX } else { 0 })
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        each!(k => a[k] & b[k])
    }
    #[inline(always)]
    fn all(self, mask: Self::Mask) -> bool {
        mask.into_iter().fold(u32::MAX, |all, lane| all & lane) != 0
    }
    #[inline(always)]
    fn not_less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        each!(k => if a[k] >= b[k] { u32::MAX } else { 0 })
    }
    #[inline(always)]
    fn within(self, top: Self::Floats, row: Self::Floats, bottom: Self::Floats) -> Self::Mask {
        each!(k => if (top[k] < row[k]) & (row[k] <= bottom[k]) { u32::MAX } else { 0 })
    }
    #[inline(always)]
    fn widen(
        self,
        (left, right): (Self::Floats, Self::Floats),
        x: Self::Floats,
        mask: Self::Mask,
    ) -> (Self::Floats, Self::Floats) {
        (
            select(mask, self.min(x, left), left),
            select(mask, self.max(x, right), right),
        )
    }
    #[inline(always)]
    fn truncate(self, floats: Self::Floats) -> Self::Words {
        // Adding 2^23 leaves the nearest integer in the lower bits: SSE2 has no faster
        // conversion that Rust's saturating one could become.
        const SHIFT: f32 = 8_388_608.0;
        let nearest = each!(k => (floats[k] + SHIFT) - SHIFT);
        let excess = each!(k => if nearest[k] > floats[k] { 1.0 } else { 0.0 });
        each!(k => (nearest[k] - excess[k] + SHIFT).to_bits() & 0x7f_ffff)
    }

    #[inline(always)]
    fn splat_word(self, value: u32) -> Self::Words {
        [value; LANES]
    }
    #[inline(always)]
    fn load_words(self, from: &[u32; LANES]) -> Self::Words {
        *from
    }
    #[inline(always)]
    fn store_words(self, words: Self::Words, to: &mut [u32; LANES]) {
        *to = words;
    }
    #[inline(always)]
    fn merge(self, words: Self::Words, to: &mut [u32; LANES]) {
        for (to, word) in to.iter_mut().zip(words) {
            *to |= word;
        }
    }
    #[inline(always)]
    fn add_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(k => a[k].wrapping_add(b[k]))
    }
    #[inline(always)]
    fn sub_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(k => a[k].wrapping_sub(b[k]))
    }
    #[inline(always)]
    fn and_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(k => a[k] & b[k])
    }
    #[inline(always)]
    fn max_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(k => a[k].cast_signed().max(b[k].cast_signed()).cast_unsigned())
    }
    #[inline(always)]
    fn power_of_two(self, exponents: Self::Words) -> Self::Words {
        each!(k => if exponents[k] < 32 { 1 << exponents[k] } else { 0 })
    }
    #[inline(always)]
    fn count_ones(self, words: Self::Words) -> Self::Words {
        each!(k => words[k].count_ones())
    }

    #[inline(always)]
    fn bits_from(self, first: Self::Words) -> Self::Words {
        each!(k => if first[k] < 32 { u32::MAX << first[k] } else { 0 })
    }
    #[inline(always)]
    fn bits_but(self, highest: Self::Words) -> Self::Words {
        each!(k => if highest[k] < 32 { u32::MAX >> highest[k] } else { 0 })
    }
    #[inline(always)]
    fn without(self, a: Self::Words, b: Self::Words) -> Self::Words {
        each!(k => a[k] & !b[k])
    }

    #[inline(always)]
    fn no_parity(self) -> Self::Parity {
        0
    }
    #[inline(always)]
    fn toggle(
        self,
        parity: Self::Parity,
        mask: Self::Mask,
        numbers: &[u64; LANES],
    ) -> Self::Parity {
        let mut parity = parity;
        let mut lane = 0;
        while lane < LANES {
            // All bits or none, as a signed number.
            parity ^= numbers[lane] & i64::from(mask[lane].cast_signed()).cast_unsigned();
            lane += 1;
        }
        parity
    }
    #[inline(always)]
    fn parity(self, parity: Self::Parity) -> u64 {
        parity
    }
    #[inline(always)]
    fn unite(self, union: u64, mask: Self::Mask, numbers: &[u64; LANES]) -> u64 {
        let mut union = union;
        let mut lane = 0;
        while lane < LANES {
            // All bits or none, as a signed number.
            union |= numbers[lane] & i64::from(mask[lane].cast_signed()).cast_unsigned();
            lane += 1;
        }
        union
    }
    #[inline(always)]
    fn union(self, union: u64) -> u64 {
        union
    }
}

//! Operations on sixteen or eight numbers at a time: portable, and with the wider registers of some
//! processors.
//!
//! All implementations do the same IEEE 754 operations in the same order, without fused ones, so
//! that images do not depend on the choice; `tests/drawing/simd.rs` compares them bit for bit.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod cuts;
mod edges;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod two;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx512::Avx512;
#[cfg(target_arch = "aarch64")]
pub(crate) use neon::Neon;
pub(crate) use portable::Portable;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
pub(crate) use two::TwoHalves;

use edges::ends_one_by_one;
pub(crate) use edges::{Edges, LineEnds, MAX_LINES};

pub(crate) use crate::budget::LANES;
use crate::budget::MAX_HULL_POINTS;
use core::fmt;

/// The instruction set that draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Simd(SimdKind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SimdKind {
    Portable(Portable),
    #[cfg(target_arch = "x86_64")]
    Avx2(TwoHalves<Avx2>),
    #[cfg(target_arch = "x86_64")]
    Avx512Bw(Avx512<false>),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512<true>),
    #[cfg(target_arch = "aarch64")]
    Neon(TwoHalves<Neon>),
}

impl Simd {
    /// The code that the compiler makes for every processor of the target.
    pub const PORTABLE: Self = Self(SimdKind::Portable(Portable));

    /// Returns the widest instruction set of this processor.
    #[must_use]
    pub fn widest() -> Self {
        Self::available().last().unwrap_or(Self::PORTABLE)
    }

    /// Returns all instruction sets of this processor, the narrowest first.
    pub fn available() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let wider = [
            Avx2::detect().map(|half| SimdKind::Avx2(TwoHalves(half))),
            Avx512::detect().map(SimdKind::Avx512Bw),
            Avx512::detect().map(SimdKind::Avx512),
        ];
        #[cfg(target_arch = "aarch64")]
        let wider = [Some(SimdKind::Neon(TwoHalves(Neon)))];
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let wider = [None];
        core::iter::once(Self::PORTABLE).chain(wider.into_iter().flatten().map(Self))
    }

    /// Returns the name that results use for it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            SimdKind::Portable(_) => "portable",
            #[cfg(target_arch = "x86_64")]
            SimdKind::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            SimdKind::Avx512Bw(_) => "avx512bw",
            #[cfg(target_arch = "x86_64")]
            SimdKind::Avx512(_) => "avx512",
            #[cfg(target_arch = "aarch64")]
            SimdKind::Neon(_) => "neon",
        }
    }

    pub(crate) const fn kind(self) -> SimdKind {
        self.0
    }
}

impl fmt::Display for Simd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Compiles a generic function of `lanes` for each instruction set; `dispatch!` chooses one of the
/// results.
macro_rules! compiled {
    (fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?) => {
        /// The function compiled for each instruction set.
        #[cfg(target_arch = "x86_64")]
        mod $name {
            use super::*;

            #[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
            pub fn avx2(
                lanes: crate::simd::TwoHalves<crate::simd::Avx2>,
                $($argument: $type),*
            ) $(-> $result)? {
                super::$name(lanes, $($argument),*)
            }

            #[target_feature(
                enable = "avx2,bmi1,bmi2,popcnt,avx512f,avx512bw,avx512dq,avx512vl"
            )]
            pub fn avx512bw(
                lanes: crate::simd::Avx512<false>,
                $($argument: $type),*
            ) $(-> $result)? {
                super::$name(lanes, $($argument),*)
            }

            #[target_feature(
                enable = "avx2,bmi1,bmi2,popcnt,avx512f,avx512bw,avx512dq,avx512vl,avx512vpopcntdq,avx512vbmi,avx512vbmi2,avx512bitalg,gfni"
            )]
            pub fn avx512(
                lanes: crate::simd::Avx512<true>,
                $($argument: $type),*
            ) $(-> $result)? {
                super::$name(lanes, $($argument),*)
            }
        }
    };
}

macro_rules! dispatch {
    ($simd:expr, $name:ident($($argument:expr),*)) => {
        match $simd.kind() {
            crate::simd::SimdKind::Portable(lanes) => $name(lanes, $($argument),*),
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "such a value exists only after detection")]
            // SAFETY: such a value exists only where the processor has the instructions.
            crate::simd::SimdKind::Avx2(lanes) => unsafe { $name::avx2(lanes, $($argument),*) },
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "such a value exists only after detection")]
            // SAFETY: such a value exists only where the processor has the instructions.
            crate::simd::SimdKind::Avx512Bw(lanes) => unsafe {
                $name::avx512bw(lanes, $($argument),*)
            },
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "such a value exists only after detection")]
            // SAFETY: such a value exists only where the processor has the instructions.
            crate::simd::SimdKind::Avx512(lanes) => unsafe {
                $name::avx512(lanes, $($argument),*)
            },
            #[cfg(target_arch = "aarch64")]
            crate::simd::SimdKind::Neon(lanes) => $name(lanes, $($argument),*),
        }
    };
}

pub(crate) use {compiled, dispatch};

/// Operations on `N` numbers at a time. A value is the proof that the processor has the
/// instructions.
pub(crate) trait Lanes<const N: usize>: Copy {
    /// `N` numbers of type `f32`.
    type Floats: Copy;
    /// `N` numbers of type `u32`.
    type Words: Copy;
    /// `N` truth values.
    type Mask: Copy;

    fn splat(self, value: f32) -> Self::Floats;
    fn load(self, from: &[f32; N]) -> Self::Floats;
    fn store(self, floats: Self::Floats, to: &mut [f32; N]);
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// Returns `a` where it is less than `b`, otherwise `b`.
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// Returns `a` where it is greater than `b`, otherwise `b`.
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// Returns whether `a < b`.
    fn less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask;
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Returns a bit for each truth value, the first one lowest.
    fn bits(self, mask: Self::Mask) -> u32;
    /// Returns whether `a >= b`; false for a NaN.
    fn not_less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask;
    /// Extends the span from the first to the second number to `x` where `top < row <= bottom`.
    fn reach(
        self,
        span: (Self::Floats, Self::Floats),
        x: Self::Floats,
        rows: [Self::Floats; 3],
    ) -> (Self::Floats, Self::Floats);
    /// Returns the integer parts of numbers from 0 to 2^24.
    fn truncate(self, floats: Self::Floats) -> Self::Words;
    /// Returns the nearest integers of numbers from 0 to 2^22.
    fn round(self, floats: Self::Floats) -> Self::Words;

    fn splat_word(self, value: u32) -> Self::Words;
    fn load_words(self, from: &[u32; N]) -> Self::Words;
    fn store_words(self, words: Self::Words, to: &mut [u32; N]);
    /// Adds with wrapping.
    fn add_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Subtracts with wrapping.
    fn sub_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn and_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn or_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Returns `a` without the bits of `b`.
    fn without(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Returns whether `a < b`, for signed numbers.
    fn less_words(self, a: Self::Words, b: Self::Words) -> Self::Mask;
    /// Returns the greater of signed numbers.
    fn max_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Returns `a` where the mask is true, otherwise `b`.
    fn choose(self, mask: Self::Mask, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Returns the lower halves of products.
    fn mul_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Shifts to the left by `BY` bits.
    fn up<const BY: u32>(self, words: Self::Words) -> Self::Words;
    /// Shifts signed numbers to the right by `BY` bits.
    fn down<const BY: u32>(self, words: Self::Words) -> Self::Words;
    /// Returns numbers between -2^31 and 2^31 without their fractions.
    fn whole(self, floats: Self::Floats) -> Self::Floats;
    /// Returns the integer parts of numbers between -2^31 and 2^31, signed.
    fn cut_off(self, floats: Self::Floats) -> Self::Words;
    /// Returns `across * 65,536 / down` without its fraction, for signed numbers: `across` less
    /// than 2^14 on both sides of 0, `down` from 1 to 2^14. A `down` of 0 gives any number.
    fn slopes(self, across: Self::Words, down: Self::Words) -> Self::Words;
    /// Returns the less of signed numbers.
    fn min_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Extends the span from the first number to the second to `at` where the row is one from
    /// the first of `rows` to the last. The span, and `at` in these rows, are from 0 to 2^31 - 1.
    fn widen(
        self,
        span: (Self::Words, Self::Words),
        at: Self::Words,
        row: Self::Words,
        rows: [Self::Words; 2],
    ) -> (Self::Words, Self::Words);
    /// Turns on the bits of rows from each first number on and before the other: none from 64 on.
    #[inline(always)]
    fn fill_rows(self, from: Self::Words, to: Self::Words, rows: &mut [u64; N]) {
        let (mut froms, mut tos) = ([0; N], [0; N]);
        self.store_words(from, &mut froms);
        self.store_words(to, &mut tos);
        for ((row, from), to) in rows.iter_mut().zip(froms).zip(tos) {
            let bits = |first: u32| u64::MAX.checked_shl(first).unwrap_or(0);
            *row |= bits(from) & !bits(to);
        }
    }
    /// Returns the bits from each number on, none from 32 on.
    fn bits_from(self, first: Self::Words) -> Self::Words;
    /// Returns the bits from each first number on and before the other: none from 32 on.
    #[inline(always)]
    fn between(self, from: Self::Words, to: Self::Words) -> Self::Words {
        self.without(self.bits_from(from), self.bits_from(to))
    }
    /// Returns all bits except the `highest` highest ones: none from 32 on.
    fn bits_but(self, highest: Self::Words) -> Self::Words;
    fn count_ones(self, words: Self::Words) -> Self::Words;

    /// Returns the least of the first numbers and the greatest of the others.
    #[inline(always)]
    fn bounds(self, low: Self::Floats, high: Self::Floats) -> (f32, f32) {
        let (mut lows, mut highs) = ([0.0; N], [0.0; N]);
        self.store(low, &mut lows);
        self.store(high, &mut highs);
        let (mut least, mut greatest) = (f32::INFINITY, f32::NEG_INFINITY);
        for (low, high) in lows.into_iter().zip(highs) {
            least = if low < least { low } else { least };
            greatest = if high > greatest { high } else { greatest };
        }
        (least, greatest)
    }

    /// Returns the least of the first and the greatest of the second signed numbers.
    #[inline(always)]
    fn ends_of(self, low: Self::Words, high: Self::Words) -> (i32, i32) {
        let (mut lows, mut highs) = ([0; N], [0; N]);
        self.store_words(low, &mut lows);
        self.store_words(high, &mut highs);
        let (mut least, mut greatest) = (i32::MAX, i32::MIN);
        for (low, high) in lows.into_iter().zip(highs) {
            least = least.min(low.cast_signed());
            greatest = greatest.max(high.cast_signed());
        }
        (least, greatest)
    }

    /// Returns the wrapping sum.
    #[inline(always)]
    fn sum(self, words: Self::Words) -> u32 {
        let mut lanes = [0; N];
        self.store_words(words, &mut lanes);
        lanes.into_iter().fold(0, u32::wrapping_add)
    }
}

/// Operations on sixteen numbers at a time, or on eight of them, and on the facets and edges of
/// hulls.
pub(crate) trait Wide: Lanes<16> {
    type Half: Lanes<8>;
    /// The edges that columns cut.
    type Cuts: Copy;

    /// Whether sixteen numbers are one register.
    const IS_ONE: bool = false;

    fn half(self) -> Self::Half;

    /// Returns, for each of 64 numbers below 64, the bit with that number.
    #[inline(always)]
    fn look_up(self, bits: u64, numbers: &[u8; 64]) -> u64 {
        let mut found = 0;
        for (at, &number) in numbers.iter().enumerate() {
            found |= (bits >> (number % 64) & 1) << at;
        }
        found
    }

    /// Returns, for two pairs of sets of at most 64 facets, the edges that have on their sides a
    /// facet of each set of the pair.
    #[inline(always)]
    fn beside(self, pairs: [[u64; 2]; 2], edges: &[Edges]) -> [[u64; 2]; 2] {
        let mut beside = [[0; 2]; 2];
        for (half, edges) in edges.iter().enumerate().take(2) {
            let [left, right] = &edges.sides;
            for (beside, [first, second]) in beside.iter_mut().zip(pairs) {
                let first = self.look_up(first, left) | self.look_up(first, right);
                let second = self.look_up(second, left) | self.look_up(second, right);
                beside[half] = first & second;
            }
        }
        beside
    }

    /// Writes the ends of the edges that have exactly one facet of the set `bits` on their sides
    /// from line number `at` on, and returns the number of such edges. Lines after them may change,
    /// too.
    #[inline(always)]
    fn ends(
        self,
        bits: u64,
        edges: &[Edges],
        points: [&[f32; MAX_HULL_POINTS]; 2],
        (ends, at): (&mut LineEnds, usize),
    ) -> usize {
        ends_one_by_one(self, bits, edges, points, (ends, at))
    }

    /// Returns the lowest eight bits, a byte each, the lowest one first.
    #[inline(always)]
    fn spread(self, bits: u64) -> u64 {
        const ONES: u64 = 0x0101_0101_0101_0101;
        /// Bit k of byte k.
        const DIAGONAL: u64 = 0x8040_2010_0804_0201;
        // A byte each, 0 or a power of two, and then 0 or 1.
        let spread = ((bits & 0xff) * ONES) & DIAGONAL;
        ((spread + 0x7f * ONES) >> 7) & ONES
    }

    /// Transposes a square of bits: bit `c` of word `r` becomes bit `r` of word `c` (Warren 2013,
    /// "Hacker's Delight", section 7-3).
    #[inline(always)]
    fn turn(self, columns: &[u32; 32]) -> [u32; 32] {
        let mut words = *columns;
        let (mut apart, mut low) = (16, 0x0000_ffff);
        while apart > 0 {
            for both in words.chunks_exact_mut(2 * apart) {
                let (first, second) = both.split_at_mut(apart);
                for (a, b) in first.iter_mut().zip(second) {
                    let turn = (*a >> apart ^ *b) & low;
                    (*a, *b) = (*a ^ turn << apart, *b ^ turn);
                }
            }
            apart /= 2;
            low ^= low << apart;
        }
        words
    }

    /// Assembles 64 numbers from up to eight binary digits, the lowest one first; a digit has a bit
    /// for each number.
    #[inline(always)]
    fn numbers(self, digits: &[u64]) -> [u8; 64] {
        let mut numbers = [0; 64];
        for (at, eight) in numbers.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            let mut sum = 0;
            for (worth, digit) in digits.iter().enumerate() {
                sum |= self.spread(digit >> (8 * at)) << worth;
            }
            *eight = u64::to_le_bytes(sum);
        }
        numbers
    }

    /// Replaces numbers below 128 by their entries in a table.
    #[inline(always)]
    fn find(self, table: &[u8; 128], numbers: &mut [u8; 64]) {
        for number in numbers {
            *number = table[usize::from(*number) % 128];
        }
    }

    /// Returns lane `lane`, below 8, in the first half of the lanes, and lane 8 + `lane` in the
    /// other.
    #[inline(always)]
    fn pair(self, floats: Self::Floats, lane: usize) -> Self::Floats {
        let mut lanes = [0.0; LANES];
        self.store(floats, &mut lanes);
        let [low, high] = [lane, LANES / 2 + lane].map(|lane| lanes[lane % LANES]);
        for (at, place) in lanes.iter_mut().enumerate() {
            *place = if at < LANES / 2 { low } else { high };
        }
        self.load(&lanes)
    }

    /// Returns, in each half of the lanes, its lane `lane`, below 7, four times, and the next one
    /// four times.
    #[inline(always)]
    fn quads(self, floats: Self::Floats, lane: usize) -> Self::Floats {
        let mut lanes = [0.0; LANES];
        self.store(floats, &mut lanes);
        let of = lanes;
        for (at, place) in lanes.iter_mut().enumerate() {
            *place = of[(at / 8 * 8 + lane + at / 4 % 2) % LANES];
        }
        self.load(&lanes)
    }

    /// Swaps the first and the second four lanes of each half.
    #[inline(always)]
    fn swapped(self, floats: Self::Floats) -> Self::Floats {
        let mut lanes = [0.0; LANES];
        self.store(floats, &mut lanes);
        for eight in lanes.chunks_exact_mut(8) {
            eight.rotate_left(4);
        }
        self.load(&lanes)
    }

    /// Returns the edges that each of two pairs of masks selects, prepared for cuts. `hull` holds
    /// the edges and, for each point, those that begin or end at it; `passed` holds how many column
    /// centres lie left of each point.
    fn cuts(
        self,
        hull: (&[Edges], &[[u64; 2]]),
        masks: [[u64; 2]; 2],
        passed: &[u32; MAX_HULL_POINTS],
    ) -> Self::Cuts;

    /// Returns the edges that a column's plane crosses. Columns must be passed one after another,
    /// from the first one that crosses the hull.
    fn crossed(self, cuts: &mut Self::Cuts, column: usize) -> [[u64; 2]; 2];

    /// Returns where a plane cuts edges that it crosses, and the greater of the two numbers of
    /// cuts. `points` are those of the hull: to the right, upwards and towards the camera; `plane`
    /// is at a distance to the right. Cuts are given upwards and towards the camera, in eight lanes
    /// for each pair of masks; unused lanes are NaN. Removes these edges from the masks.
    fn corners(
        self,
        cuts: (&Self::Cuts, &[Edges]),
        masks: &mut [[u64; 2]; 2],
        points: [&[f32; MAX_HULL_POINTS]; 3],
        plane: f32,
    ) -> ([Self::Floats; 2], usize);
}

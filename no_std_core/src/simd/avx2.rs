//! Eight numbers in a register of AVX2, for processors since Haswell and Zen.
#![expect(
    unsafe_code,
    reason = "intrinsics; a value of the type exists only after the processor was checked"
)]

use super::{Edges, Lanes, LineEnds, TwoHalves, Wide};
use crate::budget::MAX_HULL_POINTS;
use core::arch::x86_64::*;

cpufeatures::new!(found, "avx2", "bmi1", "bmi2", "popcnt");

/// A processor with AVX2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Avx2(());

impl Avx2 {
    pub fn detect() -> Option<Self> {
        found::get().then_some(Self(()))
    }
}

macro_rules! with {
    ($($call:tt)*) => {
        // SAFETY: `self` exists, so the processor has the instructions; addresses are those of
        // arrays of the length that is read or written.
        unsafe { $($call)* }
    };
}

impl Lanes<8> for Avx2 {
    type Floats = __m256;
    type Words = __m256i;
    type Mask = __m256;

    #[inline(always)]
    fn splat(self, value: f32) -> __m256 {
        with!(_mm256_set1_ps(value))
    }
    #[inline(always)]
    fn load(self, from: &[f32; 8]) -> __m256 {
        with!(_mm256_loadu_ps(from.as_ptr()))
    }
    #[inline(always)]
    fn store(self, floats: __m256, to: &mut [f32; 8]) {
        with!(_mm256_storeu_ps(to.as_mut_ptr(), floats));
    }
    #[inline(always)]
    fn add(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_add_ps(a, b))
    }
    #[inline(always)]
    fn sub(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_sub_ps(a, b))
    }
    #[inline(always)]
    fn mul(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_mul_ps(a, b))
    }
    #[inline(always)]
    fn div(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_div_ps(a, b))
    }
    #[inline(always)]
    fn min(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_min_ps(a, b))
    }
    #[inline(always)]
    fn max(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_max_ps(a, b))
    }
    #[inline(always)]
    fn less(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b))
    }
    #[inline(always)]
    fn not_less(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_cmp_ps::<_CMP_GE_OQ>(a, b))
    }
    #[inline(always)]
    fn and(self, a: __m256, b: __m256) -> __m256 {
        with!(_mm256_and_ps(a, b))
    }
    #[inline(always)]
    fn bits(self, mask: __m256) -> u32 {
        with!(_mm256_movemask_ps(mask)).cast_unsigned()
    }
    #[inline(always)]
    fn reach(
        self,
        (left, right): (__m256, __m256),
        x: __m256,
        [top, row, bottom]: [__m256; 3],
    ) -> (__m256, __m256) {
        with! {
            let is_above = _mm256_cmp_ps::<_CMP_NLT_UQ>(top, row);
            let is_below = _mm256_cmp_ps::<_CMP_NLE_UQ>(row, bottom);
            // With all bits set, x is a NaN, which has no effect.
            let x = _mm256_or_ps(x, _mm256_or_ps(is_above, is_below));
            (_mm256_min_ps(x, left), _mm256_max_ps(x, right))
        }
    }
    #[inline(always)]
    fn truncate(self, floats: __m256) -> __m256i {
        with!(_mm256_cvttps_epi32(floats))
    }

    #[inline(always)]
    fn round(self, floats: __m256) -> __m256i {
        with!(_mm256_cvtps_epi32(floats))
    }

    #[inline(always)]
    fn splat_word(self, value: u32) -> __m256i {
        with!(_mm256_set1_epi32(value.cast_signed()))
    }
    #[inline(always)]
    fn load_words(self, from: &[u32; 8]) -> __m256i {
        with!(_mm256_loadu_si256(from.as_ptr().cast()))
    }
    #[inline(always)]
    fn store_words(self, words: __m256i, to: &mut [u32; 8]) {
        with!(_mm256_storeu_si256(to.as_mut_ptr().cast(), words));
    }
    #[inline(always)]
    fn add_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_add_epi32(a, b))
    }
    #[inline(always)]
    fn sub_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_sub_epi32(a, b))
    }
    #[inline(always)]
    fn and_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_and_si256(a, b))
    }
    #[inline(always)]
    fn or_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_or_si256(a, b))
    }
    #[inline(always)]
    fn without(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_andnot_si256(b, a))
    }
    #[inline(always)]
    fn less_words(self, a: __m256i, b: __m256i) -> __m256 {
        with!(_mm256_castsi256_ps(_mm256_cmpgt_epi32(b, a)))
    }
    #[inline(always)]
    fn max_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_max_epi32(a, b))
    }
    #[inline(always)]
    fn choose(self, mask: __m256, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_blendv_epi8(b, a, _mm256_castps_si256(mask)))
    }
    #[inline(always)]
    fn mul_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_mullo_epi32(a, b))
    }
    #[inline(always)]
    fn up<const BY: u32>(self, words: __m256i) -> __m256i {
        with!(_mm256_sllv_epi32(
            words,
            _mm256_set1_epi32(BY.cast_signed())
        ))
    }
    #[inline(always)]
    fn down<const BY: u32>(self, words: __m256i) -> __m256i {
        with!(_mm256_srav_epi32(
            words,
            _mm256_set1_epi32(BY.cast_signed())
        ))
    }
    #[inline(always)]
    fn whole(self, floats: __m256) -> __m256 {
        with!(_mm256_round_ps::<{ _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC }>(floats))
    }
    #[inline(always)]
    fn cut_off(self, floats: __m256) -> __m256i {
        with!(_mm256_cvttps_epi32(floats))
    }
    #[inline(always)]
    fn slopes(self, across: __m256i, down: __m256i) -> __m256i {
        with! {
            // A quotient that is not whole is 2^-14 or more from a whole number.
            let across = _mm256_slli_epi32::<16>(across);
            let slopes = |across, down| {
                _mm256_cvttpd_epi32(_mm256_div_pd(_mm256_cvtepi32_pd(across), _mm256_cvtepi32_pd(down)))
            };
            let low = slopes(_mm256_castsi256_si128(across), _mm256_castsi256_si128(down));
            let high = slopes(
                _mm256_extracti128_si256::<1>(across),
                _mm256_extracti128_si256::<1>(down),
            );
            _mm256_set_m128i(high, low)
        }
    }
    #[inline(always)]
    fn min_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_min_epi32(a, b))
    }
    #[inline(always)]
    fn widen(
        self,
        (left, right): (__m256i, __m256i),
        at: __m256i,
        row: __m256i,
        [first, last]: [__m256i; 2],
    ) -> (__m256i, __m256i) {
        with! {
            let is_above = _mm256_cmpgt_epi32(first, row);
            let is_below = _mm256_cmpgt_epi32(row, last);
            // With all bits set, it is the greatest unsigned number, and below 0 as a signed one.
            let at = _mm256_or_si256(at, _mm256_or_si256(is_above, is_below));
            (_mm256_min_epu32(left, at), _mm256_max_epi32(right, at))
        }
    }
    #[inline(always)]
    fn fill_rows(self, from: __m256i, to: __m256i, rows: &mut [u64; 8]) {
        with! {
            let ones = _mm256_set1_epi64x(-1);
            let none = _mm256_setzero_si256();
            let bits = |first| _mm256_sllv_epi64(ones, first);
            // Rows 0, 1, 4 and 5, and the others.
            let low = _mm256_andnot_si256(
                bits(_mm256_unpacklo_epi32(to, none)),
                bits(_mm256_unpacklo_epi32(from, none)),
            );
            let high = _mm256_andnot_si256(
                bits(_mm256_unpackhi_epi32(to, none)),
                bits(_mm256_unpackhi_epi32(from, none)),
            );
            let mut fill = |at: usize, filled| {
                let rows = rows.as_mut_ptr().add(at).cast();
                _mm256_storeu_si256(rows, _mm256_or_si256(_mm256_loadu_si256(rows), filled));
            };
            fill(0, _mm256_permute2x128_si256::<0x20>(low, high));
            fill(4, _mm256_permute2x128_si256::<0x31>(low, high));
        }
    }
    /// Computes both together: the greatest is the negated least of the negated numbers.
    #[inline(always)]
    fn ends_of(self, low: __m256i, high: __m256i) -> (i32, i32) {
        with! {
            let high = _mm256_sub_epi32(_mm256_setzero_si256(), high);
            let four = _mm256_min_epi32(
                _mm256_permute2x128_si256::<0x20>(low, high),
                _mm256_permute2x128_si256::<0x31>(low, high),
            );
            let two = _mm256_min_epi32(four, _mm256_shuffle_epi32::<0b01_00_11_10>(four));
            let one = _mm256_min_epi32(two, _mm256_shuffle_epi32::<0b10_11_00_01>(two));
            (
                _mm256_cvtsi256_si32(one),
                -_mm_cvtsi128_si32(_mm256_extracti128_si256::<1>(one)),
            )
        }
    }
    /// Computes both together, as [`Self::ends_of`].
    #[inline(always)]
    fn bounds(self, low: __m256, high: __m256) -> (f32, f32) {
        with! {
            let high = _mm256_sub_ps(_mm256_set1_ps(-0.0), high);
            let four = _mm256_min_ps(
                _mm256_permute2f128_ps::<0x20>(low, high),
                _mm256_permute2f128_ps::<0x31>(low, high),
            );
            let two = _mm256_min_ps(four, _mm256_permute_ps::<0b01_00_11_10>(four));
            let one = _mm256_min_ps(two, _mm256_permute_ps::<0b10_11_00_01>(two));
            let greatest = -_mm_cvtss_f32(_mm256_extractf128_ps::<1>(one));
            (_mm256_cvtss_f32(one), greatest)
        }
    }
    #[inline(always)]
    fn bits_from(self, first: __m256i) -> __m256i {
        with!(_mm256_sllv_epi32(_mm256_set1_epi32(-1), first))
    }
    #[inline(always)]
    fn bits_but(self, highest: __m256i) -> __m256i {
        with!(_mm256_srlv_epi32(_mm256_set1_epi32(-1), highest))
    }
    /// Counts by table, four bits at a time (Mula 2011).
    #[inline(always)]
    fn count_ones(self, words: __m256i) -> __m256i {
        with! {
            let low = _mm256_set1_epi8(15);
            let table = _mm256_setr_epi8(
                0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,
                0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,
            );
            let first = _mm256_shuffle_epi8(table, _mm256_and_si256(words, low));
            let rest = _mm256_srli_epi16::<4>(words);
            let rest = _mm256_shuffle_epi8(table, _mm256_and_si256(rest, low));
            let bytes = _mm256_add_epi8(first, rest);
            let pairs = _mm256_maddubs_epi16(bytes, _mm256_set1_epi8(1));
            _mm256_madd_epi16(pairs, _mm256_set1_epi16(1))
        }
    }
}

impl TwoHalves<Avx2> {
    /// Returns the points with these numbers, below 32.
    #[inline(always)]
    fn pick(self, numbers: __m256i, points: &[f32; MAX_HULL_POINTS]) -> __m256 {
        with! {
            let eight = |at: usize| {
                _mm256_permutevar8x32_ps(_mm256_loadu_ps(points.as_ptr().add(at)), numbers)
            };
            // The sign chooses.
            let is_odd = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(numbers));
            let is_high = _mm256_castsi256_ps(_mm256_slli_epi32::<27>(numbers));
            let low = _mm256_blendv_ps(eight(0), eight(8), is_odd);
            if _mm256_movemask_ps(is_high) == 0 {
                return low;
            }
            let high = _mm256_blendv_ps(eight(16), eight(24), is_odd);
            _mm256_blendv_ps(low, high, is_high)
        }
    }
}

/// For each set of eight, its members in order.
const TOGETHER: [[u8; 8]; 256] = {
    let mut together = [[0; 8]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut member, mut count) = (0, 0);
        while member < 8 {
            if set >> member & 1 == 1 {
                together[set][count] = member;
                count += 1;
            }
            member += 1;
        }
        set += 1;
    }
    together
};

impl Wide for TwoHalves<Avx2> {
    type Half = Avx2;

    super::cuts::edge_by_edge!();

    #[inline(always)]
    fn numbers(self, digits: &[u64]) -> [u8; 64] {
        let mut numbers = [0; 64];
        for (half, numbers) in numbers.as_chunks_mut::<32>().0.iter_mut().enumerate() {
            with! {
                let byte = _mm256_setr_epi64x(
                    0,
                    0x0101_0101_0101_0101,
                    0x0202_0202_0202_0202,
                    0x0303_0303_0303_0303,
                );
                let bit = _mm256_set1_epi64x(0x8040_2010_0804_0201u64.cast_signed());
                let (mut sum, mut worth) = (_mm256_setzero_si256(), _mm256_set1_epi8(1));
                for &digit in digits {
                    #[expect(clippy::cast_possible_truncation, reason = "half by half")]
                    let digit = _mm256_set1_epi32((digit >> (32 * half)) as i32);
                    let bits = _mm256_and_si256(_mm256_shuffle_epi8(digit, byte), bit);
                    let is_set = _mm256_cmpeq_epi8(bits, bit);
                    sum = _mm256_or_si256(sum, _mm256_and_si256(is_set, worth));
                    worth = _mm256_add_epi8(worth, worth);
                }
                _mm256_storeu_si256(numbers.as_mut_ptr().cast(), sum);
            }
        }
        numbers
    }

    #[inline(always)]
    fn half(self) -> Avx2 {
        self.0
    }

    /// Looks up the byte of each bit, and the bit in it, by tables: 32 at a time.
    #[inline(always)]
    fn look_up(self, bits: u64, numbers: &[u8; 64]) -> u64 {
        let mut found = 0;
        with! {
            let bytes = _mm256_set1_epi64x(bits.cast_signed());
            let powers = _mm256_set1_epi64x(0x8040_2010_0804_0201u64.cast_signed());
            for half in [0, 32] {
                let numbers = _mm256_loadu_si256(numbers.as_ptr().add(half).cast());
                let byte = _mm256_and_si256(_mm256_srli_epi16::<3>(numbers), _mm256_set1_epi8(7));
                let byte = _mm256_shuffle_epi8(bytes, byte);
                let bit = _mm256_and_si256(numbers, _mm256_set1_epi8(7));
                let bit = _mm256_shuffle_epi8(powers, bit);
                let is_set = _mm256_cmpeq_epi8(_mm256_and_si256(byte, bit), bit);
                let is_set = _mm256_movemask_epi8(is_set).cast_unsigned();
                found |= u64::from(is_set) << half;
            }
        }
        found
    }

    #[inline(always)]
    fn ends(
        self,
        bits: u64,
        edges: &[Edges],
        points: [&[f32; MAX_HULL_POINTS]; 2],
        (ends, at): (&mut LineEnds, usize),
    ) -> usize {
        // The numbers of points at which outline edges begin and end.
        let mut outline = [[0u8; 2 * 64]; 2];
        let mut count = 0;
        for edges in edges.iter().take(2) {
            let [left, right] = &edges.sides;
            let is_outline = self.look_up(bits, left) ^ self.look_up(bits, right);
            for first in (0..edges.len.min(64)).step_by(8) {
                let chosen = (is_outline >> first) as usize % 256;
                with! {
                    let order = _mm_loadl_epi64(TOGETHER[chosen].as_ptr().cast());
                    for (numbers, outline) in [&edges.from, &edges.to].into_iter().zip(&mut outline) {
                        let numbers = _mm_loadl_epi64(numbers.as_ptr().add(first).cast());
                        let numbers = _mm_shuffle_epi8(numbers, order);
                        _mm_storel_epi64(outline.as_mut_ptr().add(count).cast(), numbers);
                    }
                }
                count += chosen.count_ones() as usize;
            }
        }
        for first in (0..count).step_by(8) {
            for (outline, ends) in outline.iter().zip([&mut ends.from, &mut ends.to]) {
                let numbers = with! {
                    let numbers = _mm_loadl_epi64(outline.as_ptr().add(first).cast());
                    _mm256_cvtepu8_epi32(numbers)
                };
                for (ends, points) in ends.iter_mut().zip(points) {
                    let ends = ends.get_mut(at + first..);
                    if let Some(ends) = ends.and_then(<[f32]>::first_chunk_mut) {
                        self.0.store(self.pick(numbers, points), ends);
                    }
                }
            }
        }
        count
    }

    #[inline(always)]
    fn spread(self, bits: u64) -> u64 {
        with!(_pdep_u64(bits, 0x0101_0101_0101_0101))
    }
    #[inline(always)]
    fn pair(self, floats: Self::Floats, lane: usize) -> Self::Floats {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_possible_wrap,
            reason = "below 8"
        )]
        let index = with!(_mm256_set1_epi32(lane as i32));
        with!([
            _mm256_permutevar8x32_ps(floats[0], index),
            _mm256_permutevar8x32_ps(floats[1], index),
        ])
    }
}

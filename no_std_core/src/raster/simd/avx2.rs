//! Sixteen numbers in two registers of AVX2, of processors since Haswell and Zen.
#![expect(
    unsafe_code,
    reason = "intrinsics; each value of the type was made after the processor was asked"
)]

use super::{LANES, Lanes};
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

/// An intrinsic of both halves.
macro_rules! both {
    ($intrinsic:expr, $a:expr, $b:expr) => {
        with!([$intrinsic($a[0], $b[0]), $intrinsic($a[1], $b[1])])
    };
}

/// `a` where the mask is set, otherwise `b`.
#[inline(always)]
fn select(mask: [__m256; 2], a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
    with!([
        _mm256_blendv_ps(b[0], a[0], mask[0]),
        _mm256_blendv_ps(b[1], a[1], mask[1]),
    ])
}

/// Those numbers that the mask names, and zeros.
#[inline(always)]
fn named(mask: [__m256; 2], numbers: &[u64; LANES]) -> [__m256i; 4] {
    with! {
        let numbers = numbers.as_ptr().cast::<__m256i>();
        let (first, rest) = (_mm256_castps_si256(mask[0]), _mm256_castps_si256(mask[1]));
        [
            _mm256_and_si256(_mm256_cvtepi32_epi64(_mm256_castsi256_si128(first)), _mm256_loadu_si256(numbers)),
            _mm256_and_si256(
                _mm256_cvtepi32_epi64(_mm256_extracti128_si256::<1>(first)),
                _mm256_loadu_si256(numbers.add(1)),
            ),
            _mm256_and_si256(
                _mm256_cvtepi32_epi64(_mm256_castsi256_si128(rest)),
                _mm256_loadu_si256(numbers.add(2)),
            ),
            _mm256_and_si256(
                _mm256_cvtepi32_epi64(_mm256_extracti128_si256::<1>(rest)),
                _mm256_loadu_si256(numbers.add(3)),
            ),
        ]
    }
}

impl Lanes for Avx2 {
    type Floats = [__m256; 2];
    type Words = [__m256i; 2];
    type Mask = [__m256; 2];
    type Parity = __m256i;

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        [with!(_mm256_set1_ps(value)); 2]
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> Self::Floats {
        with!([
            _mm256_loadu_ps(from.as_ptr()),
            _mm256_loadu_ps(from.as_ptr().add(8))
        ])
    }
    #[inline(always)]
    fn store(self, floats: Self::Floats, to: &mut [f32; LANES]) {
        with! {
            _mm256_storeu_ps(to.as_mut_ptr(), floats[0]);
            _mm256_storeu_ps(to.as_mut_ptr().add(8), floats[1]);
        }
    }
    #[inline(always)]
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(_mm256_add_ps, a, b)
    }
    #[inline(always)]
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(_mm256_sub_ps, a, b)
    }
    #[inline(always)]
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(_mm256_mul_ps, a, b)
    }
    #[inline(always)]
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(_mm256_div_ps, a, b)
    }
    #[inline(always)]
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(_mm256_min_ps, a, b)
    }
    #[inline(always)]
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(_mm256_max_ps, a, b)
    }
    #[inline(always)]
    fn less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        both!(_mm256_cmp_ps::<_CMP_LT_OQ>, a, b)
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        both!(_mm256_and_ps, a, b)
    }
    #[inline(always)]
    fn all(self, mask: Self::Mask) -> bool {
        with!(_mm256_movemask_ps(_mm256_and_ps(mask[0], mask[1]))) == 0xff
    }
    #[inline(always)]
    fn not_less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        both!(_mm256_cmp_ps::<_CMP_GE_OQ>, a, b)
    }
    #[inline(always)]
    fn within(self, top: Self::Floats, row: Self::Floats, bottom: Self::Floats) -> Self::Mask {
        let below = self.less(top, row);
        let above = both!(_mm256_cmp_ps::<_CMP_LE_OQ>, row, bottom);
        self.and(below, above)
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
        with!([
            _mm256_cvttps_epi32(floats[0]),
            _mm256_cvttps_epi32(floats[1])
        ])
    }

    #[inline(always)]
    fn splat_word(self, value: u32) -> Self::Words {
        [with!(_mm256_set1_epi32(value.cast_signed())); 2]
    }
    #[inline(always)]
    fn load_words(self, from: &[u32; LANES]) -> Self::Words {
        with! {
            let start = from.as_ptr().cast::<__m256i>();
            [_mm256_loadu_si256(start), _mm256_loadu_si256(start.add(1))]
        }
    }
    #[inline(always)]
    fn store_words(self, words: Self::Words, to: &mut [u32; LANES]) {
        with! {
            let start = to.as_mut_ptr().cast::<__m256i>();
            _mm256_storeu_si256(start, words[0]);
            _mm256_storeu_si256(start.add(1), words[1]);
        }
    }
    #[inline(always)]
    fn merge(self, words: Self::Words, to: &mut [u32; LANES]) {
        self.store_words(both!(_mm256_or_si256, self.load_words(to), words), to);
    }
    #[inline(always)]
    fn add_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(_mm256_add_epi32, a, b)
    }
    #[inline(always)]
    fn sub_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(_mm256_sub_epi32, a, b)
    }
    #[inline(always)]
    fn and_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(_mm256_and_si256, a, b)
    }
    #[inline(always)]
    fn max_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(_mm256_max_epi32, a, b)
    }
    #[inline(always)]
    fn power_of_two(self, exponents: Self::Words) -> Self::Words {
        both!(_mm256_sllv_epi32, self.splat_word(1), exponents)
    }
    /// Counts by table, four bits at a time (Mula 2011).
    #[inline(always)]
    fn count_ones(self, words: Self::Words) -> Self::Words {
        let mut counts = words;
        for half in &mut counts {
            with! {
                let low = _mm256_set1_epi8(15);
                let table = _mm256_setr_epi8(
                    0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,
                    0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,
                );
                let first = _mm256_shuffle_epi8(table, _mm256_and_si256(*half, low));
                let rest = _mm256_srli_epi16::<4>(*half);
                let rest = _mm256_shuffle_epi8(table, _mm256_and_si256(rest, low));
                let bytes = _mm256_add_epi8(first, rest);
                let pairs = _mm256_maddubs_epi16(bytes, _mm256_set1_epi8(1));
                *half = _mm256_madd_epi16(pairs, _mm256_set1_epi16(1));
            }
        }
        counts
    }

    #[inline(always)]
    fn bits_from(self, first: Self::Words) -> Self::Words {
        both!(_mm256_sllv_epi32, self.splat_word(u32::MAX), first)
    }
    #[inline(always)]
    fn bits_but(self, highest: Self::Words) -> Self::Words {
        both!(_mm256_srlv_epi32, self.splat_word(u32::MAX), highest)
    }
    #[inline(always)]
    fn without(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(_mm256_andnot_si256, b, a)
    }

    #[inline(always)]
    fn no_parity(self) -> __m256i {
        with!(_mm256_setzero_si256())
    }
    #[inline(always)]
    fn toggle(self, parity: __m256i, mask: Self::Mask, numbers: &[u64; LANES]) -> __m256i {
        let [a, b, c, d] = named(mask, numbers);
        with! {
            let all = _mm256_xor_si256(_mm256_xor_si256(a, b), _mm256_xor_si256(c, d));
            _mm256_xor_si256(parity, all)
        }
    }
    #[inline(always)]
    fn parity(self, parity: __m256i) -> u64 {
        let mut lanes = [0u64; 4];
        with!(_mm256_storeu_si256(lanes.as_mut_ptr().cast(), parity));
        lanes.into_iter().fold(0, |all, lane| all ^ lane)
    }
    #[inline(always)]
    fn unite(self, union: __m256i, mask: Self::Mask, numbers: &[u64; LANES]) -> __m256i {
        let [a, b, c, d] = named(mask, numbers);
        with! {
            let all = _mm256_or_si256(_mm256_or_si256(a, b), _mm256_or_si256(c, d));
            _mm256_or_si256(union, all)
        }
    }
    #[inline(always)]
    fn union(self, union: __m256i) -> u64 {
        let mut lanes = [0u64; 4];
        with!(_mm256_storeu_si256(lanes.as_mut_ptr().cast(), union));
        lanes.into_iter().fold(0, |all, lane| all | lane)
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

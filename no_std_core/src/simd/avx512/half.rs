//! Operations on eight of the sixteen lanes.

use super::{Avx512, Avx512Half, Lanes};
use core::arch::x86_64::*;

impl<const BYTES: bool> Lanes<8> for Avx512Half<BYTES> {
    type Floats = __m256;
    type Words = __m256i;
    type Mask = __mmask8;

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
    fn less(self, a: __m256, b: __m256) -> __mmask8 {
        with!(_mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b))
    }
    #[inline(always)]
    fn and(self, a: __mmask8, b: __mmask8) -> __mmask8 {
        a & b
    }
    #[inline(always)]
    fn not_less(self, a: __m256, b: __m256) -> __mmask8 {
        with!(_mm256_cmp_ps_mask::<_CMP_GE_OQ>(a, b))
    }
    #[inline(always)]
    fn reach(
        self,
        (left, right): (__m256, __m256),
        x: __m256,
        [top, row, bottom]: [__m256; 3],
    ) -> (__m256, __m256) {
        with! {
            let is_below = _mm256_cmp_ps_mask::<_CMP_LT_OQ>(top, row);
            let is_inside = _mm256_mask_cmp_ps_mask::<_CMP_LE_OQ>(is_below, row, bottom);
            (
                _mm256_mask_min_ps(left, is_inside, x, left),
                _mm256_mask_max_ps(right, is_inside, x, right),
            )
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
    fn less_words(self, a: __m256i, b: __m256i) -> __mmask8 {
        with!(_mm256_cmplt_epi32_mask(a, b))
    }
    #[inline(always)]
    fn max_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_max_epi32(a, b))
    }
    #[inline(always)]
    fn count_ones(self, words: __m256i) -> __m256i {
        with! {
            if BYTES {
                return _mm256_popcnt_epi32(words);
            }
            let both = Avx512::<false>(()).count_ones(_mm512_castsi256_si512(words));
            _mm512_castsi512_si256(both)
        }
    }

    #[inline(always)]
    fn choose(self, mask: __mmask8, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_mask_mov_epi32(b, mask, a))
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
            let is_below = _mm256_cmple_epi32_mask(first, row);
            let crosses = _mm256_mask_cmple_epi32_mask(is_below, row, last);
            (
                _mm256_mask_min_epu32(left, crosses, left, at),
                _mm256_mask_max_epi32(right, crosses, right, at),
            )
        }
    }
    #[inline(always)]
    fn fill_rows(self, from: __m256i, to: __m256i, rows: &mut [u64; 8]) {
        with! {
            let ones = _mm256_set1_epi64x(-1);
            let mut fill = |at: usize, from, to| {
                let bits = |first| _mm256_sllv_epi64(ones, _mm256_cvtepu32_epi64(first));
                let rows = rows.as_mut_ptr().add(at).cast();
                let filled = _mm256_andnot_si256(bits(to), bits(from));
                _mm256_storeu_si256(rows, _mm256_or_si256(_mm256_loadu_si256(rows), filled));
            };
            fill(0, _mm256_castsi256_si128(from), _mm256_castsi256_si128(to));
            fill(4, _mm256_extracti128_si256::<1>(from), _mm256_extracti128_si256::<1>(to));
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
    #[inline(always)]
    fn without(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_andnot_si256(b, a))
    }
    #[inline(always)]
    fn or_words(self, a: __m256i, b: __m256i) -> __m256i {
        with!(_mm256_or_si256(a, b))
    }
    #[inline(always)]
    fn bits(self, mask: __mmask8) -> u32 {
        u32::from(mask)
    }
}

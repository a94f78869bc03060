//! Operations on eight of the sixteen lanes.

use super::{Avx512Half, Lanes};
use core::arch::x86_64::*;

impl Lanes<8> for Avx512Half {
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
        with!(_mm256_popcnt_epi32(words))
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

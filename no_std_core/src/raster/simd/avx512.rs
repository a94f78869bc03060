//! Sixteen numbers in one register of AVX-512, of processors since Ice Lake and Zen 4.
#![expect(
    unsafe_code,
    reason = "intrinsics; each value of the type was made after the processor was asked"
)]

use super::{Edges, LANES, Lanes, Lines, Solid};
use core::arch::x86_64::*;

cpufeatures::new!(
    found,
    "avx2",
    "bmi1",
    "bmi2",
    "popcnt",
    "avx512f",
    "avx512bw",
    "avx512dq",
    "avx512vl",
    "avx512vpopcntdq",
    "avx512vbmi2"
);

/// A processor with AVX-512.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Avx512(());

impl Avx512 {
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

impl Lanes for Avx512 {
    type Floats = __m512;
    type Words = __m512i;
    type Mask = __mmask16;
    type Parity = __m512i;

    #[inline(always)]
    fn splat(self, value: f32) -> __m512 {
        with!(_mm512_set1_ps(value))
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> __m512 {
        with!(_mm512_loadu_ps(from.as_ptr()))
    }
    #[inline(always)]
    fn store(self, floats: __m512, to: &mut [f32; LANES]) {
        with!(_mm512_storeu_ps(to.as_mut_ptr(), floats));
    }
    #[inline(always)]
    fn add(self, a: __m512, b: __m512) -> __m512 {
        with!(_mm512_add_ps(a, b))
    }
    #[inline(always)]
    fn sub(self, a: __m512, b: __m512) -> __m512 {
        with!(_mm512_sub_ps(a, b))
    }
    #[inline(always)]
    fn mul(self, a: __m512, b: __m512) -> __m512 {
        with!(_mm512_mul_ps(a, b))
    }
    #[inline(always)]
    fn div(self, a: __m512, b: __m512) -> __m512 {
        with!(_mm512_div_ps(a, b))
    }
    #[inline(always)]
    fn min(self, a: __m512, b: __m512) -> __m512 {
        with!(_mm512_min_ps(a, b))
    }
    #[inline(always)]
    fn max(self, a: __m512, b: __m512) -> __m512 {
        with!(_mm512_max_ps(a, b))
    }
    #[inline(always)]
    fn less(self, a: __m512, b: __m512) -> __mmask16 {
        with!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b))
    }
    #[inline(always)]
    fn and(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a & b
    }
    #[inline(always)]
    fn all(self, mask: __mmask16) -> bool {
        mask == __mmask16::MAX
    }
    #[inline(always)]
    fn not_less(self, a: __m512, b: __m512) -> __mmask16 {
        with!(_mm512_cmp_ps_mask::<_CMP_GE_OQ>(a, b))
    }
    #[inline(always)]
    fn within(self, top: __m512, row: __m512, bottom: __m512) -> __mmask16 {
        with! {
            let below = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(top, row);
            _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(below, row, bottom)
        }
    }
    #[inline(always)]
    fn widen(
        self,
        (left, right): (__m512, __m512),
        x: __m512,
        mask: __mmask16,
    ) -> (__m512, __m512) {
        with!((
            _mm512_mask_min_ps(left, mask, x, left),
            _mm512_mask_max_ps(right, mask, x, right),
        ))
    }
    #[inline(always)]
    fn truncate(self, floats: __m512) -> __m512i {
        with!(_mm512_cvttps_epi32(floats))
    }

    #[inline(always)]
    fn splat_word(self, value: u32) -> __m512i {
        with!(_mm512_set1_epi32(value.cast_signed()))
    }
    #[inline(always)]
    fn load_words(self, from: &[u32; LANES]) -> __m512i {
        with!(_mm512_loadu_si512(from.as_ptr().cast()))
    }
    #[inline(always)]
    fn store_words(self, words: __m512i, to: &mut [u32; LANES]) {
        with!(_mm512_storeu_si512(to.as_mut_ptr().cast(), words));
    }
    #[inline(always)]
    fn merge(self, words: __m512i, to: &mut [u32; LANES]) {
        with! {
            let start = to.as_mut_ptr().cast::<__m256i>();
            let low = _mm512_castsi512_si256(words);
            let high = _mm512_extracti64x4_epi64::<1>(words);
            _mm256_storeu_si256(start, _mm256_or_si256(_mm256_loadu_si256(start), low));
            let start = start.add(1);
            _mm256_storeu_si256(start, _mm256_or_si256(_mm256_loadu_si256(start), high));
        }
    }
    #[inline(always)]
    fn add_words(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_add_epi32(a, b))
    }
    #[inline(always)]
    fn sub_words(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_sub_epi32(a, b))
    }
    #[inline(always)]
    fn and_words(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_and_si512(a, b))
    }
    #[inline(always)]
    fn max_words(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_max_epi32(a, b))
    }
    #[inline(always)]
    fn power_of_two(self, exponents: __m512i) -> __m512i {
        with!(_mm512_sllv_epi32(_mm512_set1_epi32(1), exponents))
    }
    #[inline(always)]
    fn count_ones(self, words: __m512i) -> __m512i {
        with!(_mm512_popcnt_epi32(words))
    }

    #[inline(always)]
    fn bits_from(self, first: __m512i) -> __m512i {
        with!(_mm512_sllv_epi32(_mm512_set1_epi32(-1), first))
    }
    #[inline(always)]
    fn bits_but(self, highest: __m512i) -> __m512i {
        with!(_mm512_srlv_epi32(_mm512_set1_epi32(-1), highest))
    }
    #[inline(always)]
    fn without(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_andnot_si512(b, a))
    }

    #[inline(always)]
    fn no_parity(self) -> __m512i {
        self.splat_word(0)
    }
    #[inline(always)]
    fn toggle(self, parity: __m512i, mask: __mmask16, numbers: &[u64; LANES]) -> __m512i {
        let [low, high] = mask.to_le_bytes();
        let (first, rest) = numbers.split_at(LANES / 2);
        with! {
            let first = _mm512_maskz_loadu_epi64(low, first.as_ptr().cast());
            let rest = _mm512_maskz_loadu_epi64(high, rest.as_ptr().cast());
            _mm512_ternarylogic_epi64::<0x96>(parity, first, rest)
        }
    }
    #[inline(always)]
    fn parity(self, parity: __m512i) -> u64 {
        let mut lanes = [0u64; LANES / 2];
        with!(_mm512_storeu_si512(lanes.as_mut_ptr().cast(), parity));
        lanes.into_iter().fold(0, |all, lane| all ^ lane)
    }

    #[inline(always)]
    fn unite(self, union: __m512i, mask: __mmask16, numbers: &[u64; LANES]) -> __m512i {
        let [low, high] = mask.to_le_bytes();
        let (first, rest) = numbers.split_at(LANES / 2);
        with! {
            let first = _mm512_maskz_loadu_epi64(low, first.as_ptr().cast());
            let rest = _mm512_maskz_loadu_epi64(high, rest.as_ptr().cast());
            _mm512_ternarylogic_epi64::<0xfe>(union, first, rest)
        }
    }
    #[inline(always)]
    fn union(self, union: __m512i) -> u64 {
        with!(_mm512_reduce_or_epi64(union)).cast_unsigned()
    }

    #[inline(always)]
    fn spread(self, bits: u64) -> u64 {
        with!(_pdep_u64(bits, 0x0101_0101_0101_0101))
    }
    #[inline(always)]
    fn pair(self, floats: __m512, lane: usize) -> __m512 {
        const FIRST: [u32; LANES] = [0, 0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8, 8];
        #[expect(clippy::cast_possible_truncation, reason = "below 8")]
        let index = self.add_words(self.load_words(&FIRST), self.splat_word(lane as u32));
        with!(_mm512_permutexvar_ps(index, floats))
    }

    /// All edges of a mask are moved together.
    #[inline(always)]
    fn corners(self, solid: Solid<'_>, [upper, lower]: [u64; 2], plane: f32) -> [__m512; 2] {
        let here = u64::MAX >> (64 - solid.from.len().clamp(1, 64));
        let (upper, lower) = (upper & here, lower & here);
        let mut a = [self.splat(0.0); 3];
        let mut b = a;
        with! {
            let from = _mm512_maskz_loadu_epi8(here, solid.from.as_ptr().cast());
            let to = _mm512_maskz_loadu_epi8(here, solid.to.as_ptr().cast());
            let from = _mm_unpacklo_epi64(
                _mm512_castsi512_si128(_mm512_maskz_compress_epi8(upper, from)),
                _mm512_castsi512_si128(_mm512_maskz_compress_epi8(lower, from)),
            );
            let to = _mm_unpacklo_epi64(
                _mm512_castsi512_si128(_mm512_maskz_compress_epi8(upper, to)),
                _mm512_castsi512_si128(_mm512_maskz_compress_epi8(lower, to)),
            );
            let (from, to) = (_mm512_cvtepu8_epi32(from), _mm512_cvtepu8_epi32(to));
            for axis in 0..3 {
                let low = _mm512_loadu_ps(solid.points[axis].as_ptr());
                let high = _mm512_loadu_ps(solid.points[axis].as_ptr().add(16));
                a[axis] = _mm512_permutex2var_ps(low, from, high);
                b[axis] = _mm512_permutex2var_ps(low, to, high);
            }
        }
        super::cut(self, a, b, plane)
    }

    /// Up to 16 lines at once: the ends of an outline's edges are moved together.
    #[inline(always)]
    fn lines(self, edges: Edges<'_>, lines: &mut Lines) -> (usize, f32, f32) {
        let mut count = 0;
        let (mut tops, mut bottoms) = (self.splat(f32::INFINITY), self.splat(f32::NEG_INFINITY));
        with! {
            let (x0, x1) = (_mm512_loadu_ps(edges.x.as_ptr()), _mm512_loadu_ps(edges.x.as_ptr().add(16)));
            let (y0, y1) = (_mm512_loadu_ps(edges.y.as_ptr()), _mm512_loadu_ps(edges.y.as_ptr().add(16)));
            let halves = edges.from.chunks(64).zip(edges.to.chunks(64));
            for ((from, to), outline) in halves.zip(edges.outline) {
                let here = u64::MAX >> (64 - from.len().clamp(1, 64));
                let ends = |ends: &[u8]| {
                    let ends = _mm512_maskz_loadu_epi8(here, ends.as_ptr().cast());
                    _mm512_maskz_compress_epi8(outline & here, ends)
                };
                let (mut from, mut to) = (ends(from), ends(to));
                let end = count + (outline & here).count_ones() as usize;
                while count < end {
                    let a = _mm512_cvtepu8_epi32(_mm512_castsi512_si128(from));
                    let b = _mm512_cvtepu8_epi32(_mm512_castsi512_si128(to));
                    let (ax, ay) = (_mm512_permutex2var_ps(x0, a, x1), _mm512_permutex2var_ps(y0, a, y1));
                    let (bx, by) = (_mm512_permutex2var_ps(x0, b, x1), _mm512_permutex2var_ps(y0, b, y1));
                    let (top, bottom) = (self.min(ay, by), self.max(ay, by));
                    let written = u16::MAX >> (LANES - (end - count).min(LANES));
                    tops = _mm512_mask_min_ps(tops, written, tops, top);
                    bottoms = _mm512_mask_max_ps(bottoms, written, bottoms, bottom);
                    let slope = self.div(self.sub(bx, ax), self.sub(by, ay));
                    let parts = [
                        (&mut lines.x, ax),
                        (&mut lines.y, ay),
                        (&mut lines.slope, slope),
                        (&mut lines.top, top),
                        (&mut lines.bottom, bottom),
                    ];
                    for (part, floats) in parts {
                        if let Some(place) = part.get_mut(count..).and_then(<[f32]>::first_chunk_mut) {
                            self.store(floats, place);
                        }
                    }
                    count = end.min(count + LANES);
                    from = _mm512_alignr_epi64::<2>(from, from);
                    to = _mm512_alignr_epi64::<2>(to, to);
                }
            }
        }
        let (top, bottom) = self.bounds(tops, bottoms);
        (count, top, bottom)
    }

    /// Both together: the greatest is the least of what is turned about 0.
    #[inline(always)]
    fn bounds(self, low: __m512, high: __m512) -> (f32, f32) {
        with! {
            let high = _mm512_sub_ps(_mm512_set1_ps(-0.0), high);
            let (low_half, high_half) = (
                _mm512_shuffle_f32x4::<0b01_00_01_00>(low, high),
                _mm512_shuffle_f32x4::<0b11_10_11_10>(low, high),
            );
            // Eight of each, then four, two and one.
            let eight = _mm512_min_ps(low_half, high_half);
            let four = _mm512_min_ps(eight, _mm512_shuffle_f32x4::<0b10_11_00_01>(eight, eight));
            let two = _mm512_min_ps(four, _mm512_permute_ps::<0b01_00_11_10>(four));
            let one = _mm512_min_ps(two, _mm512_permute_ps::<0b10_11_00_01>(two));
            let least = _mm512_cvtss_f32(one);
            let greatest = -_mm_cvtss_f32(_mm512_extractf32x4_ps::<2>(one));
            (least, greatest)
        }
    }
    #[inline(always)]
    fn sum(self, words: __m512i) -> u32 {
        with!(_mm512_reduce_add_epi32(words)).cast_unsigned()
    }
}

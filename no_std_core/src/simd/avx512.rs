//! Sixteen numbers in one register of AVX-512.
#![expect(
    unsafe_code,
    reason = "intrinsics; a value of the type exists only after the processor was checked"
)]

use super::{Edges, LANES, Lanes, LineEnds, Wide};
use crate::budget::MAX_HULL_POINTS;
use core::arch::x86_64::*;

cpufeatures::new!(
    found, "avx2", "bmi1", "bmi2", "popcnt", "avx512f", "avx512bw", "avx512dq", "avx512vl"
);
cpufeatures::new!(
    found_bytes,
    "avx512vpopcntdq",
    "avx512vbmi",
    "avx512vbmi2",
    "avx512bitalg",
    "gfni"
);

/// A processor with AVX-512: with what sorts bytes and counts bits, since Ice Lake and Zen 4, or
/// without, since Skylake's servers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Avx512<const BYTES: bool>(());

/// A processor with AVX-512 that works on eight numbers at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Avx512Half<const BYTES: bool>(());

impl<const BYTES: bool> Avx512<BYTES> {
    pub fn detect() -> Option<Self> {
        (found::get() && (!BYTES || found_bytes::get())).then_some(Self(()))
    }
}

macro_rules! with {
    ($($call:tt)*) => {
        // SAFETY: `self` exists, so the processor has the instructions; addresses are those of
        // arrays of the length that is read or written.
        unsafe { $($call)* }
    };
}

/// Implements the part of [`Wide`] that needs only what all processors with AVX-512 have.
macro_rules! for_all {
    ($bytes:literal) => {
        type Half = Avx512Half<$bytes>;

        const IS_ONE: bool = true;

        #[inline(always)]
        fn half(self) -> Self::Half {
            Avx512Half(())
        }

        #[inline(always)]
        fn spread(self, bits: u64) -> u64 {
            with!(_pdep_u64(bits, 0x0101_0101_0101_0101))
        }
        #[inline(always)]
        fn pair(self, floats: __m512, lane: usize) -> __m512 {
            self.moved(
                floats,
                &[0, 0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8, 8],
                lane,
            )
        }
        #[inline(always)]
        fn quads(self, floats: __m512, lane: usize) -> __m512 {
            self.moved(
                floats,
                &[0, 0, 0, 0, 1, 1, 1, 1, 8, 8, 8, 8, 9, 9, 9, 9],
                lane,
            )
        }
        #[inline(always)]
        fn swapped(self, floats: __m512) -> __m512 {
            with!(_mm512_shuffle_f32x4::<0b10_11_00_01>(floats, floats))
        }
        #[inline(always)]
        fn numbers(self, digits: &[u64]) -> [u8; 64] {
            planes::numbers(self, digits)
        }
    };
}

mod bytes;
mod cuts;
mod half;
mod planes;

impl<const BYTES: bool> Lanes<LANES> for Avx512<BYTES> {
    type Floats = __m512;
    type Words = __m512i;
    type Mask = __mmask16;

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
    fn not_less(self, a: __m512, b: __m512) -> __mmask16 {
        with!(_mm512_cmp_ps_mask::<_CMP_GE_OQ>(a, b))
    }
    #[inline(always)]
    fn reach(
        self,
        (left, right): (__m512, __m512),
        x: __m512,
        [top, row, bottom]: [__m512; 3],
    ) -> (__m512, __m512) {
        with! {
            let is_below = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(top, row);
            let is_inside = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(is_below, row, bottom);
            (
                _mm512_mask_min_ps(left, is_inside, x, left),
                _mm512_mask_max_ps(right, is_inside, x, right),
            )
        }
    }
    #[inline(always)]
    fn truncate(self, floats: __m512) -> __m512i {
        with!(_mm512_cvttps_epi32(floats))
    }

    #[inline(always)]
    fn round(self, floats: __m512) -> __m512i {
        with!(_mm512_cvtps_epi32(floats))
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
    fn less_words(self, a: __m512i, b: __m512i) -> __mmask16 {
        with!(_mm512_cmplt_epi32_mask(a, b))
    }
    #[inline(always)]
    fn max_words(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_max_epi32(a, b))
    }
    #[inline(always)]
    fn count_ones(self, words: __m512i) -> __m512i {
        with! {
            if BYTES {
                return _mm512_popcnt_epi32(words);
            }
            // By table, four bits at a time (Mula 2011).
            let low = _mm512_set1_epi8(15);
            let table = _mm512_broadcast_i32x4(_mm_setr_epi8(
                0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,
            ));
            let first = _mm512_shuffle_epi8(table, _mm512_and_si512(words, low));
            let rest = _mm512_and_si512(_mm512_srli_epi16::<4>(words), low);
            let bytes = _mm512_add_epi8(first, _mm512_shuffle_epi8(table, rest));
            let pairs = _mm512_maddubs_epi16(bytes, _mm512_set1_epi8(1));
            _mm512_madd_epi16(pairs, _mm512_set1_epi16(1))
        }
    }

    #[inline(always)]
    fn choose(self, mask: __mmask16, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_mask_mov_epi32(b, mask, a))
    }
    #[inline(always)]
    fn mul_words(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_mullo_epi32(a, b))
    }
    #[inline(always)]
    fn up<const BY: u32>(self, words: __m512i) -> __m512i {
        with!(_mm512_slli_epi32::<BY>(words))
    }
    #[inline(always)]
    fn down<const BY: u32>(self, words: __m512i) -> __m512i {
        with!(_mm512_srai_epi32::<BY>(words))
    }
    #[inline(always)]
    fn whole(self, floats: __m512) -> __m512 {
        with!(_mm512_roundscale_ps::<
            { _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC },
        >(floats))
    }
    #[inline(always)]
    fn cut_off(self, floats: __m512) -> __m512i {
        with!(_mm512_cvttps_epi32(floats))
    }
    #[inline(always)]
    fn slopes(self, across: __m512i, down: __m512i) -> __m512i {
        with! {
            // A quotient that is not whole is 2^-14 or more from a whole number.
            let across = _mm512_slli_epi32::<16>(across);
            let slopes = |across, down| {
                _mm512_cvttpd_epi32(_mm512_div_pd(_mm512_cvtepi32_pd(across), _mm512_cvtepi32_pd(down)))
            };
            let low = slopes(_mm512_castsi512_si256(across), _mm512_castsi512_si256(down));
            let high = slopes(
                _mm512_extracti64x4_epi64::<1>(across),
                _mm512_extracti64x4_epi64::<1>(down),
            );
            _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high)
        }
    }
    #[inline(always)]
    fn min_words(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_min_epi32(a, b))
    }
    #[inline(always)]
    fn widen(
        self,
        (left, right): (__m512i, __m512i),
        at: __m512i,
        row: __m512i,
        [first, last]: [__m512i; 2],
    ) -> (__m512i, __m512i) {
        with! {
            let is_below = _mm512_cmple_epi32_mask(first, row);
            let crosses = _mm512_mask_cmple_epi32_mask(is_below, row, last);
            (
                _mm512_mask_min_epu32(left, crosses, left, at),
                _mm512_mask_max_epi32(right, crosses, right, at),
            )
        }
    }
    #[inline(always)]
    fn ends_of(self, low: __m512i, high: __m512i) -> (i32, i32) {
        with! {
            // Both together: the greatest is the negated least of the negated numbers.
            let high = _mm512_sub_epi32(_mm512_setzero_si512(), high);
            let eight = _mm512_min_epi32(
                _mm512_shuffle_i32x4::<0b01_00_01_00>(low, high),
                _mm512_shuffle_i32x4::<0b11_10_11_10>(low, high),
            );
            let four = _mm512_min_epi32(eight, _mm512_shuffle_i32x4::<0b10_11_00_01>(eight, eight));
            let two = _mm512_min_epi32(four, _mm512_shuffle_epi32::<0b01_00_11_10>(four));
            let one = _mm512_min_epi32(two, _mm512_shuffle_epi32::<0b10_11_00_01>(two));
            (
                _mm512_cvtsi512_si32(one),
                -_mm_cvtsi128_si32(_mm512_extracti32x4_epi32::<2>(one)),
            )
        }
    }
    #[inline(always)]
    fn fill_rows(self, from: __m512i, to: __m512i, rows: &mut [u64; LANES]) {
        with! {
            let ones = _mm512_set1_epi64(-1);
            let mut fill = |at: usize, from, to| {
                let bits = |first| _mm512_sllv_epi64(ones, _mm512_cvtepu32_epi64(first));
                let rows = rows.as_mut_ptr().add(at).cast();
                let filled = _mm512_andnot_si512(bits(to), bits(from));
                _mm512_storeu_si512(rows, _mm512_or_si512(_mm512_loadu_si512(rows), filled));
            };
            fill(0, _mm512_castsi512_si256(from), _mm512_castsi512_si256(to));
            fill(
                LANES / 2,
                _mm512_extracti64x4_epi64::<1>(from),
                _mm512_extracti64x4_epi64::<1>(to),
            );
        }
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
    fn or_words(self, a: __m512i, b: __m512i) -> __m512i {
        with!(_mm512_or_si512(a, b))
    }
    #[inline(always)]
    fn bits(self, mask: __mmask16) -> u32 {
        u32::from(mask)
    }

    /// Computes both together: the greatest is the negated least of the negated numbers.
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

impl<const BYTES: bool> Avx512<BYTES> {
    /// Returns the lanes with these numbers, each `further` up.
    #[inline(always)]
    fn moved(self, floats: __m512, lanes: &[u32; LANES], further: usize) -> __m512 {
        #[expect(clippy::cast_possible_truncation, reason = "below 8")]
        let further = self.splat_word(further as u32);
        let lanes = self.add_words(self.load_words(lanes), further);
        with!(_mm512_permutexvar_ps(lanes, floats))
    }

    /// Returns coordinates of the points with these numbers, a byte each.
    #[inline(always)]
    fn pick(self, numbers: __m128i, points: &[f32; MAX_HULL_POINTS]) -> __m512 {
        with! {
            let low = _mm512_loadu_ps(points.as_ptr());
            let high = _mm512_loadu_ps(points.as_ptr().add(LANES));
            _mm512_permutex2var_ps(low, _mm512_cvtepu8_epi32(numbers), high)
        }
    }
}

impl Wide for Avx512<false> {
    for_all!(false);
    super::cuts::edge_by_edge!();

    /// Looks up the byte of each bit, and the bit in it, by tables.
    #[inline(always)]
    fn look_up(self, bits: u64, numbers: &[u8; 64]) -> u64 {
        with! {
            let seven = _mm512_set1_epi8(7);
            let numbers = _mm512_loadu_si512(numbers.as_ptr().cast());
            let byte = _mm512_and_si512(_mm512_srli_epi16::<3>(numbers), seven);
            let byte = _mm512_shuffle_epi8(_mm512_set1_epi64(bits.cast_signed()), byte);
            let powers = _mm512_set1_epi64(0x8040_2010_0804_0201u64.cast_signed());
            let bit = _mm512_shuffle_epi8(powers, _mm512_and_si512(numbers, seven));
            _mm512_test_epi8_mask(byte, bit)
        }
    }

    /// Finds the ends of sixteen edges, and moves those of the outline together.
    #[inline(always)]
    fn ends(
        self,
        bits: u64,
        edges: &[Edges],
        points: [&[f32; MAX_HULL_POINTS]; 2],
        (ends, at): (&mut LineEnds, usize),
    ) -> usize {
        let mut count = 0;
        for edges in edges {
            let [left, right] = &edges.sides;
            let outline = self.look_up(bits, left) ^ self.look_up(bits, right);
            for quarter in 0..edges.len.div_ceil(LANES) {
                let first = LANES * quarter % 64;
                #[expect(clippy::cast_possible_truncation, reason = "sixteen of them")]
                let chosen = (outline >> first) as u16;
                for (numbers, ends) in [(&edges.from, &mut ends.from), (&edges.to, &mut ends.to)] {
                    let numbers = with!(_mm_loadu_si128(numbers.as_ptr().add(first).cast()));
                    for (ends, points) in ends.iter_mut().zip(points) {
                        let ends = ends.get_mut(at + count..);
                        if let Some(ends) = ends.and_then(<[f32]>::first_chunk_mut) {
                            let all = self.pick(numbers, points);
                            self.store(with!(_mm512_maskz_compress_ps(chosen, all)), ends);
                        }
                    }
                }
                count += chosen.count_ones() as usize;
            }
        }
        count
    }
}

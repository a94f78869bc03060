//! Operations on hulls of processors that move bytes and count bits (VBMI, VBMI2, BITALG).

use super::cuts::{self, WideCuts};
use super::{Avx512, Avx512Half, Edges, LANES, Lanes, LineEnds, Wide, planes};
use crate::budget::MAX_HULL_POINTS;
use core::arch::x86_64::*;

/// Operations on numbers of points, a byte each.
impl Avx512<true> {
    /// Returns the numbers that the mask selects, without gaps.
    #[inline(always)]
    pub(super) fn together(self, mask: u64, numbers: &[u8; 64]) -> __m512i {
        with! {
            let numbers = _mm512_loadu_si512(numbers.as_ptr().cast());
            _mm512_maskz_compress_epi8(mask, numbers)
        }
    }

    /// Returns the first `count` numbers of `first`, followed by `others`, 64 in all.
    #[inline(always)]
    pub(super) fn append(self, first: __m512i, count: u32, others: __m512i) -> __m512i {
        let behind = u64::MAX.checked_shl(count).unwrap_or(0);
        with!(_mm512_mask_expand_epi8(first, behind, others))
    }

    /// Returns all numbers except the first sixteen.
    #[inline(always)]
    pub(super) fn without_sixteen(self, numbers: __m512i) -> __m512i {
        with!(_mm512_alignr_epi64::<2>(numbers, numbers))
    }

    /// Returns the first eight numbers that each mask selects.
    #[inline(always)]
    pub(super) fn eights(self, numbers: [__m512i; 2], masks: [u64; 2]) -> __m512i {
        with!(_mm512_castsi128_si512(_mm_unpacklo_epi64(
            _mm512_castsi512_si128(_mm512_maskz_compress_epi8(masks[0], numbers[0])),
            _mm512_castsi512_si128(_mm512_maskz_compress_epi8(masks[1], numbers[1])),
        )))
    }
}

impl Wide for Avx512<true> {
    for_all!(true);

    type Cuts = WideCuts;

    #[inline(always)]
    fn look_up(self, bits: u64, numbers: &[u8; 64]) -> u64 {
        with!(_mm512_bitshuffle_epi64_mask(
            _mm512_set1_epi64(bits.cast_signed()),
            _mm512_loadu_si512(numbers.as_ptr().cast()),
        ))
    }

    #[inline(always)]
    fn beside(self, pairs: [[u64; 2]; 2], edges: &[Edges]) -> [[u64; 2]; 2] {
        cuts::beside(self, pairs, edges)
    }

    /// Moves the numbers of the points at the ends together, and writes their coordinates.
    #[inline(always)]
    fn ends(
        self,
        bits: u64,
        edges: &[Edges],
        points: [&[f32; MAX_HULL_POINTS]; 2],
        (ends, at): (&mut LineEnds, usize),
    ) -> usize {
        let mut from = self.splat_word(0);
        let (mut to, mut count) = (from, 0);
        for edges in edges {
            let [left, right] = &edges.sides;
            let outline = self.look_up(bits, left) ^ self.look_up(bits, right);
            from = self.append(from, count, self.together(outline, &edges.from));
            to = self.append(to, count, self.together(outline, &edges.to));
            count += outline.count_ones();
        }
        // A convex outline has at most 32 edges; only rounding could give more than 64.
        if count > 64 {
            return crate::simd::ends_one_by_one(self, bits, edges, points, (ends, at));
        }
        let count = count as usize;
        for first in (at..at + count).step_by(LANES) {
            for (numbers, ends) in [(from, &mut ends.from), (to, &mut ends.to)] {
                for (ends, points) in ends.iter_mut().zip(points) {
                    if let Some(ends) = ends.get_mut(first..).and_then(<[f32]>::first_chunk_mut) {
                        let numbers = with!(_mm512_castsi512_si128(numbers));
                        self.store(self.pick(numbers, points), ends);
                    }
                }
            }
            (from, to) = (self.without_sixteen(from), self.without_sixteen(to));
        }
        count
    }

    #[inline(always)]
    fn cuts(
        self,
        (edges, _): (&[Edges], &[[u64; 2]]),
        masks: [[u64; 2]; 2],
        passed: &[u32; MAX_HULL_POINTS],
    ) -> WideCuts {
        cuts::cuts(self, edges, masks, passed)
    }
    #[inline(always)]
    fn crossed(self, cuts: &mut WideCuts, column: usize) -> [[u64; 2]; 2] {
        cuts::crossed(self, cuts, column)
    }
    #[inline(always)]
    fn corners(
        self,
        (cuts, _): (&WideCuts, &[Edges]),
        masks: &mut [[u64; 2]; 2],
        points: [&[f32; MAX_HULL_POINTS]; 3],
        plane: f32,
    ) -> ([__m512; 2], usize) {
        cuts::corners(self, cuts, masks, points, plane)
    }

    #[inline(always)]
    fn turn(self, columns: &[u32; 32]) -> [u32; 32] {
        planes::turn(self, columns)
    }
    #[inline(always)]
    fn find(self, table: &[u8; 128], numbers: &mut [u8; 64]) {
        planes::find(self, table, numbers);
    }
}

//! Edges that columns cut, 64 at a time.

use super::{Avx512, Edges, LANES, Lanes};
use crate::budget::MAX_HULL_POINTS;
use core::arch::x86_64::*;

/// Sets a bit for each facet that is not in a set: if it is set for both sides of an edge, neither
/// is.
#[inline(always)]
pub fn beside(l: Avx512<true>, pairs: [[u64; 2]; 2], edges: &[Edges]) -> [[u64; 2]; 2] {
    let [[a, b], [c, d]] = pairs;
    let mut beside = [[0; 2]; 2];
    with! {
        let missing = _mm512_maskz_mov_epi8(!a, l.splat_byte(1));
        let missing = _mm512_mask_add_epi8(missing, !b, missing, l.splat_byte(2));
        let missing = _mm512_mask_add_epi8(missing, !c, missing, l.splat_byte(4));
        let missing = _mm512_mask_add_epi8(missing, !d, missing, l.splat_byte(8));
        for (half, edges) in edges.iter().enumerate().take(2) {
            let left = _mm512_loadu_si512(edges.sides[0].as_ptr().cast());
            let right = _mm512_loadu_si512(edges.sides[1].as_ptr().cast());
            let both = _mm512_and_si512(
                _mm512_permutexvar_epi8(left, missing),
                _mm512_permutexvar_epi8(right, missing),
            );
            beside[0][half] = _mm512_testn_epi8_mask(both, l.splat_byte(1 | 2));
            beside[1][half] = _mm512_testn_epi8_mask(both, l.splat_byte(4 | 8));
        }
    }
    beside
}

#[inline(always)]
pub fn cuts(
    l: Avx512<true>,
    edges: &[Edges],
    [upper, lower]: [[u64; 2]; 2],
    passed: &[u32; MAX_HULL_POINTS],
) -> WideCuts {
    let none = l.splat_byte(0);
    let mut all = [CutSide {
        from: none,
        to: none,
        first: none,
        end: none,
    }; 2];
    let mut is_cut = [0; 2];
    with! {
        let low = _mm512_cvtepi32_epi8(_mm512_loadu_si512(passed.as_ptr().cast()));
        let high = _mm512_cvtepi32_epi8(_mm512_loadu_si512(passed.as_ptr().add(LANES).cast()));
        let passed = _mm512_castsi256_si512(_mm256_set_m128i(high, low));
        for (half, edges) in edges.iter().enumerate().take(2) {
            let from = _mm512_loadu_si512(edges.from.as_ptr().cast());
            let to = _mm512_loadu_si512(edges.to.as_ptr().cast());
            let a = _mm512_permutexvar_epi8(from, passed);
            let b = _mm512_permutexvar_epi8(to, passed);
            let (first, end) = (_mm512_min_epu8(a, b), _mm512_max_epu8(a, b));
            is_cut[half] = _mm512_cmplt_epu8_mask(first, end);
            all[half] = CutSide { from, to, first, end };
        }
    }
    let upper = [upper[0] & is_cut[0], upper[1] & is_cut[1]];
    let lower = [lower[0] & is_cut[0], lower[1] & is_cut[1]];
    let most = |masks: [u64; 2]| masks[0].count_ones() + masks[1].count_ones();
    if most(upper).max(most(lower)) <= 64 {
        return WideCuts {
            sides: [l.those(&all, upper), l.those(&all, lower)],
            rest: None,
        };
    }
    WideCuts {
        sides: [l.those(&all, [upper[0], 0]), l.those(&all, [lower[0], 0])],
        rest: Some([l.those(&all, [0, upper[1]]), l.those(&all, [0, lower[1]])]),
    }
}
#[inline(always)]
pub fn crossed(l: Avx512<true>, cuts: &WideCuts, column: usize) -> [[u64; 2]; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "below 64")]
    let column = l.splat_byte(column as u8);
    let [upper, lower] = &cuts.sides;
    let mut masks = [
        [l.crossing(upper, column), 0],
        [l.crossing(lower, column), 0],
    ];
    if let Some([upper, lower]) = &cuts.rest {
        masks[0][1] = l.crossing(upper, column);
        masks[1][1] = l.crossing(lower, column);
    }
    masks
}

/// Moves all edges of a mask together. The other masks are used when these are empty.
#[inline(always)]
pub fn corners(
    l: Avx512<true>,
    cuts: &WideCuts,
    masks: &mut [[u64; 2]; 2],
    points: [&[f32; MAX_HULL_POINTS]; 3],
    plane: f32,
) -> ([__m512; 2], usize) {
    let (mut half, mut sides) = (0, &cuts.sides);
    if let Some(rest) = &cuts.rest
        && masks[0][0] | masks[1][0] == 0
    {
        (half, sides) = (1, rest);
    }
    let [upper, lower] = [masks[0][half], masks[1][half]];
    let count = upper.count_ones().max(lower.count_ones()) as usize;
    (masks[0][half], masks[1][half]) = (0, 0);
    if count > LANES / 2 {
        (masks[0][half], masks[1][half]) = (without_eight(upper), without_eight(lower));
    }
    let mut a = [l.splat(0.0); 3];
    let mut b = a;
    let from = l.eights([sides[0].from, sides[1].from], [upper, lower]);
    let to = l.eights([sides[0].to, sides[1].to], [upper, lower]);
    let [from, to] = [from, to].map(|numbers| with!(_mm512_castsi512_si128(numbers)));
    for axis in 0..3 {
        a[axis] = l.pick(from, points[axis]);
        b[axis] = l.pick(to, points[axis]);
    }
    (crate::simd::cuts::cut(l, a, b, plane), count.min(LANES / 2))
}

/// Up to 64 edges that columns cut: the numbers of their ends, the first column that cuts each, and
/// the column after the last. No column cuts unused entries.
#[derive(Clone, Copy, Debug)]
struct CutSide {
    from: __m512i,
    to: __m512i,
    first: __m512i,
    end: __m512i,
}

/// Edges that columns cut, and the rest if there is no room for all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideCuts {
    sides: [CutSide; 2],
    rest: Option<[CutSide; 2]>,
}

impl Avx512<true> {
    #[inline(always)]
    fn splat_byte(self, value: u8) -> __m512i {
        with!(_mm512_set1_epi8(value.cast_signed()))
    }

    /// Returns the edges that the masks select, at most 64.
    #[inline(always)]
    fn those(self, [low, high]: &[CutSide; 2], masks: [u64; 2]) -> CutSide {
        let first = masks[0].count_ones();
        let numbers = self.append(
            self.together(masks[0], &NUMBERS[0]),
            first,
            self.together(masks[1], &NUMBERS[1]),
        );
        let count = first + masks[1].count_ones();
        let those = !u64::MAX.checked_shl(count).unwrap_or(0);
        with! {
            CutSide {
                from: _mm512_maskz_permutex2var_epi8(those, low.from, numbers, high.from),
                to: _mm512_maskz_permutex2var_epi8(those, low.to, numbers, high.to),
                first: _mm512_maskz_permutex2var_epi8(those, low.first, numbers, high.first),
                end: _mm512_maskz_permutex2var_epi8(those, low.end, numbers, high.end),
            }
        }
    }

    /// Returns the edges that the plane of a column crosses.
    #[inline(always)]
    fn crossing(self, side: &CutSide, column: __m512i) -> u64 {
        with! {
            let is_right = _mm512_cmple_epu8_mask(side.first, column);
            _mm512_mask_cmplt_epu8_mask(is_right, column, side.end)
        }
    }
}

/// Clears the lowest eight bits that are set.
fn without_eight(mask: u64) -> u64 {
    (0..8).fold(mask, |mask, _| mask & mask.wrapping_sub(1))
}

/// The numbers 0 to 63, and 64 to 127.
const NUMBERS: [[u8; 64]; 2] = {
    let mut numbers = [[0; 64]; 2];
    let mut at = 0;
    while at < 64 {
        numbers[0][at as usize] = at;
        numbers[1][at as usize] = 64 + at;
        at += 1;
    }
    numbers
};

//! Lines along the outline of a hull, and the rows that they cross.

use super::super::image_points::{part, placed, store};
use super::super::placement::{Placement, as_pixels};
use super::{BLOCK, Sampling};
use crate::silhouette::Size;
use crate::simd::{LANES, Lanes, LineEnds, Wide};

/// A margin that is larger than the rounding error of a row's number, and far smaller than a row.
const SLACK: f32 = 2e-5;

/// Up to sixteen lines of one hull's outline: `x + slope * (row - y)` for rows in
/// `top..=bottom`, the top left out.
#[derive(Clone, Debug)]
pub struct Strip {
    pub x: [f32; LANES],
    pub y: [f32; LANES],
    pub slope: [f32; LANES],
    pub top: [f32; LANES],
    pub bottom: [f32; LANES],
    /// The lines that cross each block of rows, a byte a block: the first eight and the others.
    /// Because of [`SLACK`], a line may be included that crosses no sample.
    pub crossing: [u64; 2],
    /// The number of lines.
    pub len: usize,
    /// Whether the next strip is another hull's.
    pub is_last: bool,
}

impl Strip {
    pub const EMPTY: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        slope: [0.0; LANES],
        top: [0.0; LANES],
        bottom: [0.0; LANES],
        crossing: [0; 2],
        len: 0,
        is_last: true,
    };

    /// Returns the lines that cross a block, a bit each.
    #[inline(always)]
    pub const fn lines(&self, block: u32) -> u64 {
        let [first, last] = self.crossing;
        (first >> (8 * block) & 0xff) | (last >> (8 * block) & 0xff) << 8
    }
}

/// Computes the lines of a strip: sixteen at a time if that is one register, otherwise eight.
#[inline(always)]
pub fn lay_all<L: Wide>(
    l: L,
    strip: &mut Strip,
    ends: &LineEnds,
    placement: &Placement,
    sampling: Sampling,
    size: Size,
) {
    strip.crossing = [0; 2];
    if L::IS_ONE {
        lay(l, strip, ends, 0, placement, sampling, size);
    } else {
        for first in (0..strip.len).step_by(BLOCK) {
            lay(l.half(), strip, ends, first, placement, sampling, size);
        }
    }
}

/// Places the ends of `N` lines in the image, and finds which rows the lines between them cross.
#[inline(always)]
fn lay<const N: usize, L: Lanes<N>>(
    l: L,
    strip: &mut Strip,
    ends: &LineEnds,
    first: usize,
    placement: &Placement,
    sampling: Sampling,
    size: Size,
) {
    let place =
        |[x, y]: &[[f32; LANES]; 2]| placed(l, [part(l, x, first), part(l, y, first)], placement);
    let ([ax, ay], [bx, by]) = (place(&ends.from), place(&ends.to));
    let (top, bottom) = (l.min(ay, by), l.max(ay, by));
    store(l, ax, &mut strip.x, first);
    store(l, ay, &mut strip.y, first);
    store(
        l,
        l.div(l.sub(bx, ax), l.sub(by, ay)),
        &mut strip.slope,
        first,
    );
    store(l, top, &mut strip.top, first);
    store(l, bottom, &mut strip.bottom, first);

    // Rows that have a sample below the top, and rows that have one not below the bottom: half a
    // row less, because rounding is to the nearest.
    let places = sampling.places();
    let (Some(&upmost), Some(&lowest)) = (places.first(), places.last()) else {
        return;
    };
    let (zero, rows) = (l.splat(0.0), l.splat(as_pixels(size.rows())));
    let from = l.add(top, l.splat(0.5 - lowest - SLACK));
    let from = l.min(l.max(from, zero), rows);
    let to = l.add(bottom, l.splat(0.5 - upmost + SLACK));
    let to = l.min(l.max(to, zero), rows);
    let crosses = l.bits(l.less_words(l.round(from), l.round(to)));
    // The same for blocks: (from + 1/2) / 8 and (to + 1/2 + 7) / 8, half a block less.
    let (share, margin) = (l.splat(0.125), l.splat(0.4375));
    let from = l.max(l.sub(l.mul(from, share), margin), zero);
    let to = l.add(l.mul(to, share), margin);
    let crossing = l.ranges(l.round(from), l.round(to));
    // Lanes after the last line hold old values.
    let lines = crosses & !(u32::MAX << (strip.len - first).min(LANES));
    for (half, (blocks, crossing)) in strip
        .crossing
        .iter_mut()
        .skip(first / BLOCK)
        .zip(crossing)
        .enumerate()
    {
        *blocks = crossing & (u64::from(lines >> (BLOCK * half) & 0xff) * 0x0101_0101_0101_0101);
    }
}

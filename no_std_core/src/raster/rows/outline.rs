//! Lines along the outline of a hull, and the rows that they cross.

use super::super::image_points::{first_numbers, part, placed, store};
use super::super::placement::{Placement, as_pixels};
use super::Sampling;
use crate::silhouette::Size;
use crate::simd::{LANES, Lanes, LineEnds};

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
    /// The first row of pixels that any line crosses, and the first one below. Because of
    /// [`SLACK`], a row may be included of which no sample is crossed.
    pub first: i32,
    pub end: i32,
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
        first: 0,
        end: 0,
        len: 0,
        is_last: true,
    };
}

/// Places the ends of the lines of a strip in the image, and finds which rows they cross.
#[inline(always)]
pub fn lay<const N: usize, L: Lanes<N>>(
    l: L,
    strip: &mut Strip,
    (ends, start): (&LineEnds, usize),
    placement: &Placement,
    sampling: Sampling,
    size: Size,
) {
    // Rows that have a sample below the top, and rows that have one not below the bottom: half a
    // row less, because rounding is to the nearest.
    let places = sampling.places();
    let (Some(&upmost), Some(&lowest)) = (places.first(), places.last()) else {
        return;
    };
    let above = l.splat(0.5 - lowest - SLACK);
    let below = l.splat(0.5 - upmost + SLACK);
    let (zero, rows) = (l.splat(0.0), l.splat(as_pixels(size.rows())));
    let none = l.splat_word(0);
    let (mut least, mut most) = (l.splat_word(i32::MAX.cast_unsigned()), none);
    for first in (0..strip.len).step_by(N) {
        let at = start + first;
        // Not a closure, which would not have the processor's instructions.
        let [x, y] = &ends.from;
        let [ax, ay] = placed(l, [part(l, x, at), part(l, y, at)], placement);
        let [x, y] = &ends.to;
        let [bx, by] = placed(l, [part(l, x, at), part(l, y, at)], placement);
        let (top, bottom) = (l.min(ay, by), l.max(ay, by));
        let slope = l.div(l.sub(bx, ax), l.sub(by, ay));
        store(l, ax, &mut strip.x, first);
        store(l, ay, &mut strip.y, first);
        store(l, slope, &mut strip.slope, first);
        store(l, top, &mut strip.top, first);
        store(l, bottom, &mut strip.bottom, first);
        let from = l.round(l.min(l.max(l.add(top, above), zero), rows));
        let to = l.round(l.min(l.max(l.add(bottom, below), zero), rows));
        // Lanes after the last line hold old values.
        #[expect(clippy::cast_possible_truncation, reason = "at most 16")]
        let is_line = l.less_words(first_numbers(l), l.splat_word((strip.len - first) as u32));
        let crosses = l.and(is_line, l.less_words(from, to));
        least = l.choose(crosses, l.min_words(least, from), least);
        most = l.choose(crosses, l.max_words(most, to), most);
    }
    (strip.first, strip.end) = l.ends_of(least, most);
}

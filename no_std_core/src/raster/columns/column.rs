//! Filling of columns: the part of a plane inside hulls, at all elevations together, one a lane.

use super::Azimuth;
use crate::budget::LANES;
use crate::raster::placement::as_pixels;
use crate::simd::Wide;

const HALF: usize = LANES / 2;

/// One column of the images at all elevations: 24 times 64 rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(64))]
pub(crate) struct ImageColumn {
    /// Rows at the first sixteen elevations. Bit `r` is row `r`.
    pub low: [u32; LANES],
    /// Rows at the first sixteen elevations. Bit `r` is row 32 + `r`.
    pub high: [u32; LANES],
    /// Rows at the other elevations: `low`, and after it `high`.
    pub rest: [u32; LANES],
}

impl ImageColumn {
    pub const EMPTY: Self = Self {
        low: [0; LANES],
        high: [0; LANES],
        rest: [0; LANES],
    };

    /// Returns the rows at one elevation; bit `r` is row `r`.
    pub fn rows(&self, elevation: usize) -> u64 {
        let [low, high] = self.halves(elevation);
        u64::from(low) | u64::from(high) << 32
    }

    /// Returns the rows at one elevation; bit `r` of the first word is row `r`, of the other 32 +
    /// `r`.
    pub fn halves(&self, elevation: usize) -> [u32; 2] {
        if elevation < LANES {
            [self.low[elevation], self.high[elevation]]
        } else {
            [elevation, HALF + elevation].map(|lane| self.rest[lane % LANES])
        }
    }
}

/// The part of one plane inside a hull: the greatest and the least height that corners of a
/// cross-section reach, pixels upwards from the image's centre.
#[derive(Clone, Copy)]
pub struct PlaneSpan<L: Wide> {
    top: L::Floats,
    bottom: L::Floats,
    /// The top and the negated bottom at the other elevations.
    rest: L::Floats,
}

/// A height below any row.
const LOWEST: f32 = -64.0;

impl<L: Wide> PlaneSpan<L> {
    /// Returns an empty span: the top is below the last row, and the bottom above the first.
    #[inline(always)]
    pub fn empty(l: L) -> Self {
        Self {
            top: l.splat(LOWEST),
            bottom: l.splat(-LOWEST),
            rest: l.splat(LOWEST),
        }
    }

    /// Extends the span to corners: `y` and `w` hold those that can be uppermost in the first eight
    /// lanes, and those that can be lowest in the others, `count` of each. A NaN has no effect.
    #[inline(always)]
    pub fn reach(&mut self, l: L, azimuth: &Azimuth, [y, w]: [&[f32; LANES]; 2], count: usize) {
        // Four without checking the count: a branch on it is hard to predict.
        for at in 0..4 {
            self.reach_pair(l, azimuth, [y, w], at);
        }
        for at in 4..count.min(HALF) {
            self.reach_pair(l, azimuth, [y, w], at);
        }
        let [y, w] = [l.load(y), l.load(w)];
        if azimuth.is_few {
            for at in (0..4).step_by(2) {
                self.reach_rest(l, azimuth, [l.quads(y, at), l.quads(w, at)]);
            }
            for at in (4..count.min(HALF)).step_by(2) {
                self.reach_rest(l, azimuth, [l.quads(y, at), l.quads(w, at)]);
            }
        } else {
            for at in 0..count.min(HALF) {
                self.reach_rest(l, azimuth, [l.pair(y, at), l.pair(w, at)]);
            }
        }
    }

    /// Extends the span to one corner of each kind, at the first sixteen elevations.
    #[inline(always)]
    fn reach_pair(&mut self, l: L, azimuth: &Azimuth, [y, w]: [&[f32; LANES]; 2], at: usize) {
        let first = (&azimuth.cos, &azimuth.sin);
        let upper = height(l, (l.splat(y[at]), l.splat(w[at])), first);
        let lower = height(l, (l.splat(y[HALF + at]), l.splat(w[HALF + at])), first);
        self.top = l.max(upper, self.top);
        self.bottom = l.min(lower, self.bottom);
    }

    /// Extends the span to one corner of each kind at the other elevations, or to two if these are
    /// few.
    #[inline(always)]
    fn reach_rest(&mut self, l: L, azimuth: &Azimuth, [y, w]: [L::Floats; 2]) {
        let others = height(l, (y, w), (&azimuth.cos_rest, &azimuth.sin_rest));
        self.rest = l.max(others, self.rest);
    }

    /// Turns on the rows whose centres are below the top and not below the bottom: from the first
    /// centre strictly below the top to the last that is not below the bottom. A point at height v
    /// has passed floor(`offset` - v) centres.
    #[inline(always)]
    pub fn paint(&self, l: L, is_few: bool, offset: f32, rows: usize, column: &mut ImageColumn) {
        let (offset, rows) = (l.splat(offset), l.splat(as_pixels(rows)));
        let all = l.splat_word(64);
        let from = passed(l, l.sub(offset, self.top), rows);
        let to = passed(l, l.sub(offset, self.bottom), rows);
        merge(
            l,
            l.without(l.bits_from(from), l.bits_from(to)),
            &mut column.low,
        );
        let (from, to) = (l.sub_words(all, from), l.sub_words(all, to));
        merge(
            l,
            l.without(l.bits_but(to), l.bits_but(from)),
            &mut column.high,
        );
        let mut rest = self.rest;
        if is_few {
            rest = l.max(rest, l.swapped(rest));
        }
        let rest = l.mul(rest, l.load(&OPPOSITE));
        let both = passed(l, l.sub(offset, rest), rows);
        let (mut low, mut high) = ([0; LANES], [0; LANES]);
        l.store_words(l.bits_from(both), &mut low);
        l.store_words(l.bits_but(l.sub_words(all, both)), &mut high);
        let (low_rest, high_rest) = column.rest.split_at_mut(HALF);
        for lane in 0..HALF {
            low_rest[lane] |= low[lane] & !low[HALF + lane];
            high_rest[lane] |= high[HALF + lane] & !high[lane];
        }
    }
}

/// Sets the bits of `words` in `to`.
#[inline(always)]
fn merge<L: Wide>(l: L, words: L::Words, to: &mut [u32; LANES]) {
    l.store_words(l.or_words(l.load_words(to), words), to);
}

/// Returns the heights at which corners appear.
#[inline(always)]
fn height<L: Wide>(
    l: L,
    (y, w): (L::Floats, L::Floats),
    (cos, sin): (&[f32; LANES], &[f32; LANES]),
) -> L::Floats {
    l.sub(l.mul(y, l.load(cos)), l.mul(w, l.load(sin)))
}

/// Rounds counts down to whole numbers of rows.
#[inline(always)]
fn passed<L: Wide>(l: L, count: L::Floats, rows: L::Floats) -> L::Words {
    l.truncate(l.min(l.max(count, l.splat(0.0)), rows))
}

/// The signs of [`PlaneSpan::rest`].
const OPPOSITE: [f32; LANES] = [
    1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0,
];

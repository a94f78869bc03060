//! Gait Energy Images of one azimuth at all elevations, from the column rasteriser.
//!
//! Bits are counted in digits: one word holds one binary digit of 32 counts. Eight frames are
//! collected, which seven carry-save adders a word turn into four digits (Harley and Seal; Mula,
//! Kurz & Lemire 2018).

use super::Gei;
use crate::bit_adder;
use crate::budget::{LANES, MAX_COLUMNS, MAX_PIXELS, MAX_ROWS, TALLY_DIGITS};
use crate::raster::columns::{ElevationImages, ImageColumn};
use crate::silhouette::Size;
use crate::simd::{Simd, Wide, compiled, dispatch};
use core::ops::Range;

/// Frames that are counted together.
const BATCH: usize = 8;

/// A count, for each pixel, of the frames of a gait cycle in which it is on. 259 kB, which belong
/// in a static or on a heap.
#[derive(Clone, Debug)]
pub struct GeiTally {
    size: Size,
    simd: Simd,
    frames: u32,
    /// The digits of each column, from the lowest on.
    digits: [[ImageColumn; TALLY_DIGITS]; MAX_COLUMNS],
    waiting: [ElevationImages; BATCH],
    waits: usize,
    means: CountMeans,
}

impl GeiTally {
    /// The maximum number of frames in one cycle.
    pub const MAX_FRAMES: u32 = 1 << (TALLY_DIGITS - 1);

    /// Makes a tally without frames.
    #[must_use]
    pub fn new(size: Size) -> Self {
        Self::with_simd(size, Simd::widest())
    }

    /// Makes a tally that uses these registers. GEIs do not depend on them.
    #[must_use]
    pub const fn with_simd(size: Size, simd: Simd) -> Self {
        Self {
            size,
            simd,
            frames: 0,
            digits: [[ImageColumn::EMPTY; TALLY_DIGITS]; MAX_COLUMNS],
            waiting: [ElevationImages::empty(size); BATCH],
            waits: 0,
            means: CountMeans::NONE,
        }
    }

    /// Forgets all frames, for the next cycle.
    pub fn clear(&mut self) {
        let used = self.used();
        for digits in self.digits.iter_mut().take(self.size.columns()) {
            digits[..used].fill(ImageColumn::EMPTY);
        }
        self.frames = 0;
        self.waits = 0;
    }

    /// Counts one more frame, and returns its images to draw into; they hold old content. `None`
    /// after [`Self::MAX_FRAMES`] frames.
    pub fn next_frame(&mut self) -> Option<&mut ElevationImages> {
        if self.frames == Self::MAX_FRAMES {
            return None;
        }
        if self.waits == BATCH {
            self.settle();
        }
        self.frames += 1;
        self.waits += 1;
        self.waiting.get_mut(self.waits - 1)
    }

    /// Returns the number of frames counted.
    #[must_use]
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// Returns the mean of the frames so far at one elevation, rounded half up; black without
    /// frames.
    #[must_use]
    pub fn gei(&mut self, elevation: usize) -> Gei {
        self.settle();
        self.means.make(self.frames);
        let mut pixels = [0; MAX_PIXELS];
        dispatch!(self.simd, means(self, elevation, &mut pixels));
        Gei::from_means(self.size, pixels)
    }

    /// Counts the frames that wait.
    fn settle(&mut self) {
        if self.waits > 0 {
            self.waiting[self.waits..].fill(ElevationImages::empty(self.size));
            dispatch!(self.simd, count(self));
            self.waits = 0;
        }
    }

    /// Returns the number of digits of the count of all frames.
    const fn used(&self) -> usize {
        (u32::BITS - self.frames.leading_zeros()) as usize
    }
}

compiled!(fn count(tally: &mut GeiTally));
compiled!(fn means(tally: &GeiTally, elevation: usize, pixels: &mut [u8; MAX_PIXELS]));

/// Columns that are transposed into rows together, and as many rows.
const SQUARE: usize = 32;
/// Digits of a count that fit into a byte.
const BYTE: usize = 8;

/// The means of counts, with a table for the usual counts.
#[derive(Clone, Debug)]
struct CountMeans {
    frames: u32,
    known: [u8; 512],
}

impl CountMeans {
    const NONE: Self = Self {
        frames: 0,
        known: [0; 512],
    };

    /// Makes the table for this many frames.
    fn make(&mut self, frames: u32) {
        if self.frames != frames {
            self.frames = frames;
            for (mean, count) in self.known.iter_mut().zip(0..=frames) {
                *mean = mean_of(count, frames);
            }
        }
    }

    fn mean(&self, count: u32) -> u8 {
        let known = self.known.get(count as usize).copied();
        known.unwrap_or_else(|| mean_of(count, self.frames))
    }
}

/// Returns the mean of a pixel that is 255 in `count` of `frames` frames and otherwise 0, rounded
/// half up.
fn mean_of(count: u32, frames: u32) -> u8 {
    let frames = frames.max(1);
    u8::try_from((255 * count + frames / 2) / frames).unwrap_or(u8::MAX)
}

/// Computes the means of all pixels. All frames must have been counted.
#[inline(always)]
fn means<L: Wide>(l: L, tally: &GeiTally, elevation: usize, pixels: &mut [u8; MAX_PIXELS]) {
    let (used, width, rows) = (tally.used(), tally.size.columns(), tally.size.rows());
    let (table, _) = tally
        .means
        .known
        .split_first_chunk()
        .unwrap_or((&[0; 128], &[]));
    // The columns on the right first: bytes after a row's last column are black, and the next row
    // overwrites them.
    for left in (0..width).step_by(SQUARE).rev() {
        let (mut low, mut high) = ([[0; BYTE]; MAX_ROWS / 2], [[0; BYTE]; MAX_ROWS / 2]);
        planes(l, tally, elevation, left, 0..used.min(BYTE), &mut low);
        planes(l, tally, elevation, left, BYTE..used, &mut high);
        let pairs = low.iter().zip(&high).zip((0..rows).step_by(2));
        for ((low, high), row) in pairs {
            let mut means = l.numbers(&low[..used.min(BYTE)]);
            if used < BYTE {
                l.find(table, &mut means);
            } else {
                for (low, high) in means.iter_mut().zip(l.numbers(high)) {
                    *low = tally.means.mean(u32::from(*low) + 256 * u32::from(high));
                }
            }
            for (row, means) in (row..).zip(means.as_chunks::<SQUARE>().0) {
                let at = row * width + left;
                if let Some(pixels) = pixels.get_mut(at..at + SQUARE) {
                    pixels.copy_from_slice(means);
                }
            }
        }
    }
}

/// Writes digits of the counts in a square's columns, for each pair of rows: first of the upper
/// row's pixels, then of the lower row's.
#[inline(always)]
fn planes<L: Wide>(
    l: L,
    tally: &GeiTally,
    elevation: usize,
    left: usize,
    digits: Range<usize>,
    planes: &mut [[u64; BYTE]; MAX_ROWS / 2],
) {
    for (worth, digit) in digits.enumerate() {
        let [mut upper, mut lower] = [[0; SQUARE]; 2];
        let columns = tally.digits.as_chunks::<SQUARE>().0;
        let columns = &columns[left / SQUARE % columns.len()];
        // Two at a time: a gather of many words takes longer.
        for at in (0..SQUARE).step_by(2) {
            let [a, b] = [at, at + 1].map(|at| columns[at][digit % TALLY_DIGITS].halves(elevation));
            [upper[at], upper[at + 1]] = [a[0], b[0]];
            [lower[at], lower[at + 1]] = [a[1], b[1]];
        }
        let rows = [l.turn(&upper), l.turn(&lower)];
        for (planes, rows) in planes
            .iter_mut()
            .zip(rows.as_flattened().as_chunks::<2>().0)
        {
            planes[worth % BYTE] = u64::from(rows[0]) | u64::from(rows[1]) << SQUARE;
        }
    }
}

/// Adds eight frames to the counts.
#[inline(always)]
fn count<L: Wide>(_: L, tally: &mut GeiTally) {
    let used = tally.used();
    let columns = tally.digits.iter_mut().take(tally.size.columns());
    for (column, digits) in columns.enumerate() {
        let frames = tally.waiting.each_ref().map(|frame| frame.column(column));
        let mut carry = ImageColumn {
            low: add_eight(digits, &frames, |it| &it.low, |it| &mut it.low),
            high: add_eight(digits, &frames, |it| &it.high, |it| &mut it.high),
            rest: add_eight(digits, &frames, |it| &it.rest, |it| &mut it.rest),
        };
        for digit in digits.iter_mut().take(used).skip(3) {
            half_add(&mut digit.low, &mut carry.low);
            half_add(&mut digit.high, &mut carry.high);
            half_add(&mut digit.rest, &mut carry.rest);
        }
    }
}

/// Adds eight frames to the lowest three digits of one part of a column, and returns the
/// carries, each worth eight.
#[inline(always)]
fn add_eight(
    digits: &mut [ImageColumn; TALLY_DIGITS],
    frames: &[&ImageColumn; BATCH],
    part: impl Fn(&ImageColumn) -> &[u32; LANES],
    part_mut: impl Fn(&mut ImageColumn) -> &mut [u32; LANES],
) -> [u32; LANES] {
    let [one, two, four, ..] = digits;
    let (one, two, four) = (part_mut(one), part_mut(two), part_mut(four));
    let [a, b, c, d, e, f, g, h] = frames.map(part);
    let mut eights = [0; LANES];
    for lane in 0..LANES {
        let bits = [
            a[lane], b[lane], c[lane], d[lane], e[lane], f[lane], g[lane], h[lane],
        ];
        let (digits, carry) = bit_adder::add_eight([one[lane], two[lane], four[lane]], bits);
        [one[lane], two[lane], four[lane]] = digits;
        eights[lane] = carry;
    }
    eights
}

/// Replaces `digit + carry` by `digit + 2 carry`, bit by bit.
#[inline(always)]
fn half_add(digit: &mut [u32; LANES], carry: &mut [u32; LANES]) {
    for (digit, carry) in digit.iter_mut().zip(carry) {
        (*digit, *carry) = (*digit ^ *carry, *digit & *carry);
    }
}

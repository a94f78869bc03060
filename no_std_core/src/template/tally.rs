//! The Gait Energy Images of one azimuth at all elevations.
//!
//! Bits are counted in digits: one word holds one binary digit of 32 counts. Frames wait until
//! there are eight, which seven carry-save adders a word turn into four digits (Harley and
//! Seal; Mula, Kurz & Lemire 2018).

use super::Gei;
use super::sums::Scale;
use crate::adder;
use crate::budget::{LANES, MAX_COLUMNS, MAX_PIXELS, TALLY_DIGITS};
use crate::raster::columns::{Column, Images};
use crate::raster::simd::{Simd, Wide, compiled, dispatch};
use crate::silhouette::Size;

/// Frames that are counted at once.
const BATCH: usize = 8;

/// Counts in how many frames of a gait cycle each pixel is on. 258 kB, which belong into a
/// static or on a heap.
#[derive(Clone, Debug)]
pub struct GeiTally {
    size: Size,
    simd: Simd,
    frames: u32,
    /// For each column, digits from the lowest on.
    digits: [[Column; TALLY_DIGITS]; MAX_COLUMNS],
    waiting: [Images; BATCH],
    waits: usize,
}

impl GeiTally {
    /// Most frames of one cycle.
    pub const MAX_FRAMES: u32 = 1 << (TALLY_DIGITS - 1);

    /// No frame yet.
    #[must_use]
    pub fn new(size: Size) -> Self {
        Self::with_simd(size, Simd::widest())
    }

    /// A tally that uses these registers. GEIs do not depend on it.
    #[must_use]
    pub const fn with_simd(size: Size, simd: Simd) -> Self {
        Self {
            size,
            simd,
            frames: 0,
            digits: [[Column::EMPTY; TALLY_DIGITS]; MAX_COLUMNS],
            waiting: [Images::empty(size); BATCH],
            waits: 0,
        }
    }

    /// Forgets all frames, for the next cycle.
    pub fn clear(&mut self) {
        let used = self.used();
        for digits in self.digits.iter_mut().take(self.size.columns()) {
            digits[..used].fill(Column::EMPTY);
        }
        self.frames = 0;
        self.waits = 0;
    }

    /// Counts one frame more, and gives its images to draw into; they hold what was there
    /// before. `None` when [`Self::MAX_FRAMES`] were counted.
    pub fn next_frame(&mut self) -> Option<&mut Images> {
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

    /// How many frames were counted.
    #[must_use]
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// The mean of the frames so far at one elevation, rounded half up; black without any.
    #[must_use]
    pub fn gei(&mut self, elevation: usize) -> Gei {
        self.settle();
        let means = dispatch!(self.simd, means(self, elevation));
        Gei::from_means(self.size, means)
    }

    /// Counts the frames that wait.
    fn settle(&mut self) {
        if self.waits > 0 {
            self.waiting[self.waits..].fill(Images::empty(self.size));
            dispatch!(self.simd, count(self));
            self.waits = 0;
        }
    }

    /// How many digits the count of all frames has.
    const fn used(&self) -> usize {
        (u32::BITS - self.frames.leading_zeros()) as usize
    }
}

compiled!(fn count(tally: &mut GeiTally));
compiled!(fn means(tally: &GeiTally, elevation: usize) -> [u8; MAX_PIXELS]);

/// The means of all pixels, of frames that are all counted.
#[inline(always)]
fn means<L: Wide>(l: L, tally: &GeiTally, elevation: usize) -> [u8; MAX_PIXELS] {
    let mut means = [0; MAX_PIXELS];
    let scale = Scale::new(tally.frames.max(1));
    let (used, width) = (tally.used(), tally.size.columns());
    for (column, digits) in tally.digits.iter().enumerate().take(width) {
        let mut rows = [0; TALLY_DIGITS];
        for (rows, digit) in rows.iter_mut().zip(digits).take(used) {
            *rows = digit.rows(elevation);
        }
        for byte in 0..tally.size.rows().div_ceil(8) {
            // Eight counts, the lower byte of each and the higher one.
            let mut counts = [0; 2];
            for (worth, rows) in rows.iter().enumerate().take(used) {
                counts[worth / 8] |= l.spread(rows >> (8 * byte)) << (worth % 8);
            }
            let [low, high] = counts.map(u64::to_le_bytes);
            // Rows below the last one are black, and stay so.
            let first = 8 * byte * width + column;
            for row in 0..8 {
                let count = u32::from(low[row]) + 256 * u32::from(high[row]);
                means[(first + row * width) % MAX_PIXELS] = scale.mean(count);
            }
        }
    }
    means
}

/// Adds eight frames to the counts.
#[inline(always)]
fn count<L: Wide>(_: L, tally: &mut GeiTally) {
    let used = tally.used();
    let columns = tally.digits.iter_mut().take(tally.size.columns());
    for (column, digits) in columns.enumerate() {
        let frames = tally.waiting.each_ref().map(|frame| frame.column(column));
        let mut carry = Column {
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
    digits: &mut [Column; TALLY_DIGITS],
    frames: &[&Column; BATCH],
    part: impl Fn(&Column) -> &[u32; LANES],
    part_mut: impl Fn(&mut Column) -> &mut [u32; LANES],
) -> [u32; LANES] {
    let [one, two, four, ..] = digits;
    let (one, two, four) = (part_mut(one), part_mut(two), part_mut(four));
    let [a, b, c, d, e, f, g, h] = frames.map(part);
    let mut eights = [0; LANES];
    for lane in 0..LANES {
        let bits = [
            a[lane], b[lane], c[lane], d[lane], e[lane], f[lane], g[lane], h[lane],
        ];
        let (digits, carry) = adder::add_eight([one[lane], two[lane], four[lane]], bits);
        [one[lane], two[lane], four[lane]] = digits;
        eights[lane] = carry;
    }
    eights
}

/// `digit + carry` as `digit + 2 carry`, bit by bit.
#[inline(always)]
fn half_add(digit: &mut [u32; LANES], carry: &mut [u32; LANES]) {
    for (digit, carry) in digit.iter_mut().zip(carry) {
        (*digit, *carry) = (*digit ^ *carry, *digit & *carry);
    }
}

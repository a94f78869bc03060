//! The knots of an uncut clip: where they lie among its bits, and how four of them give a value.
//!
//! A block is a bit stream. For each channel in turn it holds the base of the channel's knots in
//! the block, the width of their differences from it, and the differences.

use crate::bits::BitReader;
use crate::format::{
    BLOCK_INTERVALS, INTEGER_WIDTH_BITS, MAX_INTEGER_WIDTH, SPACING_BITS, SPACING_CONSTANT,
    width_bits,
};

/// A channel's entry in the table of an uncut clip.
#[derive(Clone, Copy)]
pub(super) struct UncutChannel {
    spacing: u32,
    /// The smallest of its knots, in steps; the value of a channel without knots.
    least: i32,
    base_width: u32,
    widest: u32,
}

impl UncutChannel {
    /// Reads the next channel; `None` if it has integers wider than an uncut clip may have.
    pub(super) fn read(bits: &mut BitReader<'_>) -> Option<Self> {
        // Two numbers in one read: this is half of the time of a pose.
        let head = bits.unsigned(SPACING_BITS + INTEGER_WIDTH_BITS);
        let (spacing, least_width) = (head & SPACING_CONSTANT, head >> SPACING_BITS);
        if least_width > MAX_INTEGER_WIDTH {
            return None;
        }
        let least = bits.signed(least_width);
        let (base_width, widest) = if spacing == SPACING_CONSTANT {
            (0, 0)
        } else {
            let widths = bits.unsigned(2 * INTEGER_WIDTH_BITS);
            let base_width = widths & ((1 << INTEGER_WIDTH_BITS) - 1);
            (base_width, widths >> INTEGER_WIDTH_BITS)
        };
        (base_width.max(widest) <= MAX_INTEGER_WIDTH).then_some(Self {
            spacing,
            least,
            base_width,
            widest,
        })
    }

    /// Returns the number of its knots in a clip of this many intervals.
    const fn knots(&self, intervals: u64) -> u64 {
        if self.spacing == SPACING_CONSTANT {
            return 0;
        }
        intervals.div_ceil(1 << self.spacing).saturating_add(3)
    }

    /// Returns the number of its knots in a full block.
    const fn block_knots(&self) -> u64 {
        BLOCK_INTERVALS >> self.spacing
    }

    /// Returns the number of blocks that its knots take.
    pub(super) const fn blocks(&self, intervals: u64) -> u64 {
        self.knots(intervals).div_ceil(self.block_knots())
    }

    /// Returns its value at a moment, from the block that the moment lies in and the next one.
    /// Moves both readers past the channel.
    pub(super) fn value(&self, blocks: &mut [BitReader<'_>; 2], moment: &UncutMoment) -> KnotValue {
        let [first, second] = blocks;
        let runs = (
            KnotRun::read(first, self, moment.intervals, moment.block),
            KnotRun::read(
                second,
                self,
                moment.intervals,
                moment.block.saturating_add(1),
            ),
        );
        // `check` has read all runs, so a missing run has no knots.
        let (Some(first), Some(second)) = runs else {
            return KnotValue::constant(self.least);
        };
        let Some(&KnotShare { index, weights }) = moment.shares.get(self.spacing as usize) else {
            return KnotValue::constant(self.least);
        };
        let within = index - moment.block * self.block_knots();
        let (mut near, mut far) = (first.from(within), second.from(0));
        let knots = [0, 1, 2, 3].map(|tap| {
            if within + tap < self.block_knots() {
                first.base + near.unsigned(first.width).cast_signed()
            } else {
                second.base + far.unsigned(second.width).cast_signed()
            }
        });
        KnotValue::new(knots, weights)
    }
}

/// One channel's knots in one block.
pub(super) struct KnotRun<'a> {
    base: i32,
    width: u32,
    differences: BitReader<'a>,
}

impl<'a> KnotRun<'a> {
    /// Reads the channel's run in the block with this number, and moves past it; `None` if its
    /// differences are wider than the channel's widest.
    pub(super) fn read(
        bits: &mut BitReader<'a>,
        channel: &UncutChannel,
        intervals: u64,
        block: u64,
    ) -> Option<Self> {
        let before = block.saturating_mul(channel.block_knots());
        let knots = channel.knots(intervals).saturating_sub(before);
        let knots = knots.min(channel.block_knots());
        if knots == 0 {
            return Some(Self {
                base: channel.least,
                width: 0,
                differences: *bits,
            });
        }
        let base = channel.least + bits.unsigned(channel.base_width).cast_signed();
        let width = bits.unsigned(width_bits(channel.widest));
        if width > channel.widest {
            return None;
        }
        let run = Self {
            base,
            width,
            differences: *bits,
        };
        skip(bits, knots, width);
        Some(run)
    }

    /// Returns a reader at the difference with this number.
    fn from(&self, knot: u64) -> BitReader<'a> {
        let mut bits = self.differences;
        skip(&mut bits, knot, self.width);
        bits
    }
}

/// Skips this many integers, at most those of a block.
fn skip(bits: &mut BitReader<'_>, integers: u64, width: u32) {
    debug_assert!(integers <= BLOCK_INTERVALS);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "at most 16 integers of 25 bits"
    )]
    bits.skip((integers * u64::from(width)) as usize);
}

/// A moment of an uncut clip.
pub(super) struct UncutMoment {
    /// Intervals in the clip.
    intervals: u64,
    /// The block with the first knot that contributes.
    pub(super) block: u64,
    /// The share of the knots for each spacing.
    shares: [KnotShare; SPACING_CONSTANT as usize],
}

/// The knots of one spacing that contribute to a moment, and their weights.
#[derive(Clone, Copy)]
struct KnotShare {
    /// The first of four knots.
    index: u64,
    /// The weights of the first, third and fourth knot; the second has the rest.
    weights: [f32; 3],
}

impl UncutMoment {
    /// Makes a moment from a position in intervals, 0 to `intervals`, which is at least 1.
    pub(super) fn new(position: f64, intervals: u64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 or more, and saturates"
        )]
        let index = (position as u64).min(intervals - 1);
        let share = |spacing: u32| {
            let first = index >> spacing;
            #[expect(clippy::cast_precision_loss, reason = "exact up to 2^53 intervals")]
            let ahead = position - (first << spacing) as f64;
            #[expect(clippy::cast_possible_truncation, reason = "0 to 1")]
            let share = (ahead / f64::from(1u32 << spacing)) as f32;
            KnotShare {
                index: first,
                weights: weights(share),
            }
        };
        Self {
            intervals,
            block: index / BLOCK_INTERVALS,
            shares: [share(0), share(1), share(2)],
        }
    }
}

/// Returns the weights of the first, third and fourth knot of a uniform cubic B-spline at `x` in
/// 0..=1 between the second and the third (de Boor 1978, "A Practical Guide to Splines", chapter
/// IX, for knots 1 apart).
fn weights(x: f32) -> [f32; 3] {
    const SIXTH: f32 = 1.0 / 6.0;
    let rest = 1.0 - x;
    [
        SIXTH * rest * rest * rest,
        SIXTH * (1.0 + 3.0 * x * (1.0 + x * rest)),
        SIXTH * x * x * x,
    ]
}

/// A channel's value, in steps: a knot and a rest, so that ten thousand metres or turns still have
/// a precision of millimetres.
#[derive(Clone, Copy)]
pub(super) struct KnotValue {
    knot: i32,
    rest: f32,
}

impl KnotValue {
    pub(super) const ZERO: Self = Self::constant(0);

    const fn constant(knot: i32) -> Self {
        Self { knot, rest: 0.0 }
    }

    fn new(knots: [i32; 4], weights: [f32; 3]) -> Self {
        let [first, second, third, fourth] = knots;
        #[expect(clippy::cast_precision_loss, reason = "rounded as the sum is")]
        let off = [first, third, fourth].map(|knot| (knot - second) as f32);
        let ([a, b, c], [of_a, of_b, of_c]) = (off, weights);
        Self {
            knot: second,
            rest: of_a * a + of_b * b + of_c * c,
        }
    }

    /// Returns the value in radians or metres.
    pub(super) fn times(self, step: f32) -> f32 {
        #[expect(clippy::cast_precision_loss, reason = "the result is rounded as well")]
        let knot = self.knot as f32;
        (knot + self.rest) * step
    }

    /// Returns the value in radians or metres, in `f64`.
    pub(super) fn times_exactly(self, step: f32) -> f64 {
        (f64::from(self.knot) + f64::from(self.rest)) * f64::from(step)
    }
}

//! The knots of a take: where they lie among its bits, and what four of them make.
//!
//! A block is a bit stream. Each channel in turn states what its knots in the block are
//! differences to, how wide these are, and the differences.

use crate::bits::BitReader;
use crate::format::{
    BLOCK_INTERVALS, INTEGER_WIDTH_BITS, MAX_INTEGER_WIDTH, SPACING_BITS, SPACING_CONSTANT,
    width_bits,
};

/// What a take's table states of a channel.
#[derive(Clone, Copy)]
pub(super) struct UncutChannel {
    spacing: u32,
    /// The least of its knots, in steps: the value of a channel without any.
    least: i32,
    base_width: u32,
    widest: u32,
}

impl UncutChannel {
    /// The next channel; `None` where it has integers wider than a take may.
    pub(super) fn read(bits: &mut BitReader<'_>) -> Option<Self> {
        // Two numbers in one go: this is half of what a pose takes.
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

    /// How many knots it has in a take of so many intervals.
    const fn knots(&self, intervals: u64) -> u64 {
        if self.spacing == SPACING_CONSTANT {
            return 0;
        }
        intervals.div_ceil(1 << self.spacing).saturating_add(3)
    }

    /// How many of them a full block has.
    const fn block_knots(&self) -> u64 {
        BLOCK_INTERVALS >> self.spacing
    }

    /// How many blocks they take.
    pub(super) const fn blocks(&self, intervals: u64) -> u64 {
        self.knots(intervals).div_ceil(self.block_knots())
    }

    /// Its value at a moment, from the block that the moment lies in and the next one.
    /// Moves both behind the channel.
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
        // `parse` has been through all runs: one that is not there has no knots.
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
    /// The channel's run in the block with this number, and moves behind it; `None` where
    /// its differences are wider than the channel's widest.
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

    /// The differences from the one with this number on.
    fn from(&self, knot: u64) -> BitReader<'a> {
        let mut bits = self.differences;
        skip(&mut bits, knot, self.width);
        bits
    }
}

/// Moves over so many integers, at most those of a block.
fn skip(bits: &mut BitReader<'_>, integers: u64, width: u32) {
    debug_assert!(integers <= BLOCK_INTERVALS);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "at most 16 integers of 25 bits"
    )]
    bits.skip((integers * u64::from(width)) as usize);
}

/// A moment of a take.
pub(super) struct UncutMoment {
    /// Intervals that the take has.
    intervals: u64,
    /// The block with the first knot that decides it.
    pub(super) block: u64,
    /// For each spacing.
    shares: [KnotShare; SPACING_CONSTANT as usize],
}

/// What a moment takes of the knots of a spacing.
#[derive(Clone, Copy)]
struct KnotShare {
    /// The first of four.
    index: u64,
    /// How much of the first, the third and the fourth; the rest is the second's.
    weights: [f32; 3],
}

impl UncutMoment {
    /// `position`: in intervals, from 0 to `intervals`, which is 1 or more.
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

/// How much of the first, third and fourth knot a uniform cubic B-spline takes at `x` in
/// 0..=1 between the second and the third (de Boor 1978, "A Practical Guide to Splines",
/// chapter IX, for knots 1 apart).
fn weights(x: f32) -> [f32; 3] {
    const SIXTH: f32 = 1.0 / 6.0;
    let rest = 1.0 - x;
    [
        SIXTH * rest * rest * rest,
        SIXTH * (1.0 + 3.0 * x * (1.0 + x * rest)),
        SIXTH * x * x * x,
    ]
}

/// A channel's value, in steps: a knot and a rest, so that ten thousand metres or turns do
/// not take the precision of millimetres away.
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

    /// In radians or metres.
    pub(super) fn times(self, step: f32) -> f32 {
        #[expect(clippy::cast_precision_loss, reason = "the result is rounded alike")]
        let knot = self.knot as f32;
        (knot + self.rest) * step
    }

    /// The same in `f64`.
    pub(super) fn times_exactly(self, step: f32) -> f64 {
        (f64::from(self.knot) + f64::from(self.rest)) * f64::from(step)
    }
}

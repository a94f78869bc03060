//! Bitwise adders that work on all bits of a word in parallel, for counts stored in bit planes.

use core::ops::{BitAnd, BitOr, BitXor};

/// A word of independent bits.
pub(crate) trait Word:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self>
{
}

impl Word for u32 {}
impl Word for u64 {}

/// Returns the sum of three bits, and the carry.
#[inline(always)]
pub(crate) fn full_add<W: Word>(a: W, b: W, c: W) -> (W, W) {
    let half = a ^ b;
    (half ^ c, (a & b) | (half & c))
}

/// Adds eight bits to a count's lowest three digits, and returns these and the carry, which is
/// worth eight (Harley & Seal; Warren 2013, "Hacker's Delight", section 5-1).
#[inline(always)]
pub(crate) fn add_eight<W: Word>([one, two, four]: [W; 3], bits: [W; 8]) -> ([W; 3], W) {
    let [a, b, c, d, e, f, g, h] = bits;
    let (one, two_a) = full_add(one, a, b);
    let (one, two_b) = full_add(one, c, d);
    let (two, four_a) = full_add(two, two_a, two_b);
    let (one, two_a) = full_add(one, e, f);
    let (one, two_b) = full_add(one, g, h);
    let (two, four_b) = full_add(two, two_a, two_b);
    let (four, carry) = full_add(four, four_a, four_b);
    ([one, two, four], carry)
}

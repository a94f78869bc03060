//! Adders of single bits, as many at once as a word has: what counts in planes is made of.

use core::ops::{BitAnd, BitOr, BitXor};

/// A word of bits that do not depend on each other.
pub(crate) trait Word:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self>
{
}

impl Word for u32 {}
impl Word for u64 {}

/// The sum of three bits, and what it carries.
#[inline(always)]
pub(crate) fn full_add<W: Word>(a: W, b: W, c: W) -> (W, W) {
    let half = a ^ b;
    (half ^ c, (a & b) | (half & c))
}

/// Adds eight bits to a count's lowest three digits, and returns these and what is carried,
/// which is worth eight (Harley & Seal; Warren 2013, "Hacker's Delight", section 5-1).
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

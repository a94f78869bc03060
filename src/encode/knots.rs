//! Writing of the knots of an uncut motion, the inverse of the core's `clip/knots.rs`.

use super::bits::{BitWriter, signed_width};
use edgegait_core::format::{
    BLOCK_INTERVALS, INTEGER_WIDTH_BITS, MAX_INTEGER_WIDTH, SPACING_BITS, SPACING_CONSTANT,
    width_bits,
};

/// One channel of an uncut motion.
pub(super) struct KnotChannel {
    /// The binary logarithm of the distance between knots, in intervals; [`SPACING_CONSTANT`] for a
    /// constant channel.
    pub(super) spacing: u32,
    /// The knots in steps; a constant channel has one value.
    pub(super) knots: Vec<i32>,
}

impl KnotChannel {
    /// Returns the knots block by block.
    fn blocks(&self) -> impl Iterator<Item = &[i32]> {
        #[expect(clippy::cast_possible_truncation, reason = "16 or less")]
        let block = (BLOCK_INTERVALS >> self.spacing).max(1) as usize;
        let moving = if self.spacing == SPACING_CONSTANT {
            &[]
        } else {
            self.knots.as_slice()
        };
        moving.chunks(block)
    }
}

/// Writes the table of channels, the ends of the blocks, and the blocks. Returns `None` if an
/// integer is wider than the format holds.
pub(super) fn write(channels: &[KnotChannel]) -> Option<Vec<u8>> {
    let mut table = BitWriter::default();
    let heads: Option<Vec<Head>> = channels
        .iter()
        .map(|channel| Head::write(&mut table, channel))
        .collect();
    let heads = heads?;
    let mut bytes = table.into_bytes();
    let mut blocks: Vec<BitWriter> = Vec::new();
    for (channel, head) in channels.iter().zip(&heads) {
        for (number, knots) in channel.blocks().enumerate() {
            if number == blocks.len() {
                blocks.push(BitWriter::default());
            }
            head.write_block(&mut blocks[number], knots);
        }
    }
    let blocks: Vec<Vec<u8>> = blocks.into_iter().map(BitWriter::into_bytes).collect();
    let mut end = 0;
    for block in &blocks {
        end += block.len();
        bytes.extend(u32::try_from(end).ok()?.to_le_bytes());
    }
    bytes.extend(blocks.iter().flatten());
    Some(bytes)
}

/// A channel's entry in the table.
struct Head {
    least: i32,
    base_width: u32,
    widest: u32,
}

impl Head {
    fn write(bits: &mut BitWriter, channel: &KnotChannel) -> Option<Self> {
        let least = *channel.knots.iter().min()?;
        let least_width = signed_width(least);
        let mut head = Self {
            least,
            base_width: 0,
            widest: 0,
        };
        for knots in channel.blocks() {
            let (base, width) = head.base_and_width(knots)?;
            head.base_width = head.base_width.max(unsigned_width(base));
            head.widest = head.widest.max(width);
        }
        if least_width.max(head.base_width).max(head.widest) > MAX_INTEGER_WIDTH {
            return None;
        }
        bits.unsigned(channel.spacing, SPACING_BITS);
        bits.unsigned(least_width, INTEGER_WIDTH_BITS);
        bits.signed(least, least_width);
        if channel.spacing != SPACING_CONSTANT {
            bits.unsigned(head.base_width, INTEGER_WIDTH_BITS);
            bits.unsigned(head.widest, INTEGER_WIDTH_BITS);
        }
        Some(head)
    }

    /// Returns the least of a block's knots, relative to the channel's least, and the width of the
    /// differences to it; `None` without knots.
    fn base_and_width(&self, knots: &[i32]) -> Option<(u32, u32)> {
        let (least, most) = (*knots.iter().min()?, *knots.iter().max()?);
        Some((
            least.abs_diff(self.least),
            unsigned_width(most.abs_diff(least)),
        ))
    }

    fn write_block(&self, bits: &mut BitWriter, knots: &[i32]) {
        let Some((base, width)) = self.base_and_width(knots) else {
            return;
        };
        bits.unsigned(base, self.base_width);
        bits.unsigned(width, width_bits(self.widest));
        for knot in knots {
            bits.unsigned(knot.abs_diff(self.least) - base, width);
        }
    }
}

/// Returns the number of bits of `value`; 0 for 0.
const fn unsigned_width(value: u32) -> u32 {
    u32::BITS - value.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_in_the_table_alone() {
        // Spacing 11, width 3 as 11000, -3 as 101: 1 1 1 1 0 0 0 1 | 0 1.
        let still = KnotChannel {
            spacing: SPACING_CONSTANT,
            knots: vec![-3],
        };
        assert_eq!(write(&[still]).unwrap(), [0b1000_1111, 0b10]);
    }

    #[test]
    fn a_block_has_its_least_knot_and_differences() {
        // Spacing 00, least 0 in no bits 00000, bases in no bits 00000, widest 2 01000;
        // then one block that ends at byte 2: width 2 as 01, then 0, 1, 2, 3 as 00 10 01 11, lowest
        // bits first.
        let moving = KnotChannel {
            spacing: 0,
            knots: vec![0, 1, 2, 3],
        };
        let bytes = write(&[moving]).unwrap();
        assert_eq!(
            bytes,
            [0, 0b0010_0000, 0, 2, 0, 0, 0, 0b1001_0010, 0b11][..].to_vec()
        );
    }
}

//! Filling of rows between the lines that cross them, eight rows at a time.

use super::super::placement::as_pixels;
use super::outline::Strip;
use super::{BLOCK, BLOCKS, BitWindow, LANES, SampleBits, WORD};
use crate::simd::{Lanes, Wide};

/// Fills the hulls of the first `count` strips.
#[inline(always)]
pub fn fill_hulls<L: Wide, const N: usize>(l: L, window: &mut BitWindow, count: usize) {
    let BitWindow {
        strips,
        sampling,
        words,
        bits,
        ..
    } = window;
    let strips = strips.get(..count).unwrap_or_default();
    for hull in strips.split_inclusive(|strip| strip.is_last) {
        let all = |blocks, strip: &Strip| blocks | strip.crossing[0] | strip.crossing[1];
        let mut blocks = hull.iter().fold(0, all);
        while blocks != 0 {
            let block = blocks.trailing_zeros() / 8;
            blocks &= !(0xff << (8 * block));
            fill_block::<L::Half, N>(l.half(), hull, block, sampling.places(), bits, *words);
        }
    }
}

/// Fills eight rows with `N` by `N` samples a pixel.
#[inline(always)]
fn fill_block<L: Lanes<BLOCK>, const N: usize>(
    l: L,
    hull: &[Strip],
    block: u32,
    places: &[f32],
    bits: &mut SampleBits,
    words: usize,
) {
    let block = block as usize % BLOCKS;
    #[expect(clippy::cast_precision_loss, reason = "at most 128")]
    let width = l.splat((WORD * words) as f32);
    let zero = l.splat(0.0);
    let first = l.add(l.splat(as_pixels(BLOCK * block)), l.load(&ROW));
    let mut y = [zero; N];
    for (y, &place) in y.iter_mut().zip(places) {
        *y = l.add(first, l.splat(place));
    }
    let mut spans = [(width, zero); N];
    for strip in hull {
        let mut lines = strip.lines(block as u32);
        while lines != 0 {
            // Four lines without checking the count: a branch on it is hard to predict. After the
            // last line comes line 0, which changes nothing.
            for _ in 0..if N == 1 { 4 } else { 1 } {
                let line = lines.trailing_zeros() as usize % LANES;
                lines &= lines.wrapping_sub(1);
                let (top, bottom) = (l.splat(strip.top[line]), l.splat(strip.bottom[line]));
                let (start, slope) = (l.splat(strip.y[line]), l.splat(strip.slope[line]));
                let x = l.splat(strip.x[line]);
                for (span, &y) in spans.iter_mut().zip(&y) {
                    let x = l.add(x, l.mul(slope, l.sub(y, start)));
                    *span = l.reach(*span, x, [top, y, bottom]);
                }
            }
        }
    }
    for (down, (left, right)) in spans.into_iter().enumerate() {
        // Spans begin at the window's sides, so each end can only be beyond its own side.
        let left = l.max(left, zero);
        let right = l.min(right, width);
        for (across, &place) in places.iter().enumerate().take(N) {
            // The first column whose sample is right of an edge.
            let past = l.splat(1.0 - place);
            let from = l.truncate(l.add(left, past));
            let to = l.truncate(l.add(right, past));
            let Some(image) = bits.get_mut(across * N + down) else {
                return;
            };
            for (word, rows) in image.iter_mut().take(words).enumerate() {
                let (rows, _) = rows.as_chunks_mut();
                if let Some(rows) = rows.get_mut(block) {
                    let filled = l.or_words(l.load_words(rows), span(l, from, to, word));
                    l.store_words(filled, rows);
                }
            }
        }
    }
}

const ROW: [f32; BLOCK] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// Returns the bits of one word from column `from` on and before column `to`.
#[inline(always)]
fn span<L: Lanes<BLOCK>>(l: L, from: L::Words, to: L::Words, word: usize) -> L::Words {
    let (mut from, mut to) = (from, to);
    if word > 0 {
        #[expect(clippy::cast_possible_truncation, reason = "at most 128")]
        let start = l.splat_word((WORD * word) as u32);
        let none = l.splat_word(0);
        from = l.max_words(l.sub_words(from, start), none);
        to = l.max_words(l.sub_words(to, start), none);
    }
    // From 32 on there is no bit.
    l.between(from, to)
}

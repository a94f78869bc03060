//! Filling of rows between the lines that cross them, sixteen or eight rows at a time.

use super::outline::Strip;
use super::{LANES, SampleBits, WORD};
use crate::simd::Lanes;

/// Fills a hull, `N` rows at a time, with `S` by `S` samples a pixel.
#[inline(always)]
pub fn fill_hull<const S: usize, const N: usize, L: Lanes<N>>(
    l: L,
    hull: &[Strip],
    places: &[f32],
    bits: &mut SampleBits,
    words: usize,
) {
    #[expect(clippy::cast_precision_loss, reason = "at most 128")]
    let width = l.splat((WORD * words) as f32);
    let zero = l.splat(0.0);
    let numbers = match ROWS.first_chunk() {
        Some(rows) => l.load(rows),
        None => zero,
    };
    let mut row = hull
        .iter()
        .fold(i32::MAX, |row, strip| row.min(strip.first));
    let end = hull.iter().fold(0, |end, strip| end.max(strip.end));
    while row < end {
        #[expect(clippy::cast_precision_loss, reason = "at most 64")]
        let first = l.add(l.splat(row as f32), numbers);
        let mut y = [zero; S];
        for (y, &place) in y.iter_mut().zip(places) {
            *y = l.add(first, l.splat(place));
        }
        let mut spans = [(width, zero); S];
        for strip in hull {
            for line in 0..strip.len.min(LANES) {
                let (top, bottom) = (l.splat(strip.top[line]), l.splat(strip.bottom[line]));
                let (start, slope) = (l.splat(strip.y[line]), l.splat(strip.slope[line]));
                let x = l.splat(strip.x[line]);
                for (span, &y) in spans.iter_mut().zip(&y) {
                    let x = l.add(x, l.mul(slope, l.sub(y, start)));
                    *span = l.reach(*span, x, [top, y, bottom]);
                }
            }
        }
        for (down, (left, right)) in spans.into_iter().enumerate() {
            // Spans begin at the window's sides, so each end can only be beyond its own side.
            let left = l.max(left, zero);
            let right = l.min(right, width);
            for (across, &place) in places.iter().enumerate().take(S) {
                // The first column whose sample is right of an edge.
                let past = l.splat(1.0 - place);
                let from = l.truncate(l.add(left, past));
                let to = l.truncate(l.add(right, past));
                let Some(image) = bits.get_mut(across * S + down) else {
                    return;
                };
                for (word, rows) in image.iter_mut().take(words).enumerate() {
                    let rows = usize::try_from(row)
                        .ok()
                        .and_then(|row| rows.get_mut(row..));
                    if let Some(rows) = rows.and_then(<[u32]>::first_chunk_mut) {
                        let filled = l.or_words(l.load_words(rows), span(l, from, to, word));
                        l.store_words(filled, rows);
                    }
                }
            }
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_possible_wrap,
            reason = "8 or 16"
        )]
        let next = row + N as i32;
        row = next;
    }
}

const ROWS: [f32; LANES] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];

/// Returns the bits of one word from column `from` on and before column `to`.
#[inline(always)]
fn span<const N: usize, L: Lanes<N>>(l: L, from: L::Words, to: L::Words, word: usize) -> L::Words {
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

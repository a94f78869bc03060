//! Assembly of nine images of one sample a pixel into one picture of 3x3 samples a pixel.

/// The number of samples in a pixel along an axis.
pub(super) const FINE: usize = 3;

/// The number of pixels in a window of the core along an axis.
pub(super) const WINDOW: usize = 64;

/// Returns the first pixels of the fewest windows that hold every sample within `min..max` pixels
/// and within a picture of `count` pixels, `before` of them before pixel 0. There are no windows
/// if there are no such samples; a single window is centred on them.
pub(super) fn tiles((min, max): (f64, f64), before: usize, count: usize) -> Vec<isize> {
    let (first, end) = (
        -before.cast_signed(),
        count.cast_signed() - before.cast_signed(),
    );
    // The first sample of a pixel lies 1/6 after its start, the last one 5/6.
    #[expect(clippy::cast_possible_truncation, reason = "clamped")]
    let pixel = |at: f64| at.clamp(first as f64, end as f64) as isize;
    let from = pixel((min - 5.0 / 6.0).floor() + 1.0);
    let to = pixel((max - 1.0 / 6.0).ceil());
    let windows = (to - from).max(0).cast_unsigned().div_ceil(WINDOW);
    let spare = (windows * WINDOW).cast_signed() - (to - from);
    let start = from - spare / 2;
    (0..windows)
        .map(|window| start + (window * WINDOW).cast_signed())
        .collect()
}

/// Interleaves the bits of a row in three images, pixel by pixel.
pub(super) fn interleaved([a, b, c]: [u64; FINE]) -> [u64; FINE] {
    // Eight pixels take 24 bits.
    let eighth = |number: u32| -> u64 {
        let part = |phase: u64| u64::from(SPREAD[(phase >> (8 * number) & 0xff) as usize]);
        part(a) | part(b) << 1 | part(c) << 2
    };
    let [second, fifth] = [2, 5].map(eighth);
    [
        eighth(0) | eighth(1) << 24 | second << 48,
        second >> 16 | eighth(3) << 8 | eighth(4) << 32 | fifth << 56,
        fifth >> 8 | eighth(6) << 16 | eighth(7) << 40,
    ]
}

/// Every byte with two zeros after each of its bits.
const SPREAD: [u32; 256] = {
    let mut spread = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut bit = 0;
        while bit < 8 {
            spread[byte] |= ((byte >> bit & 1) as u32) << (FINE * bit);
            bit += 1;
        }
        byte += 1;
    }
    spread
};

/// Gathers every third bit of a word, from the lowest on (Morton 1966, inverted).
const fn gathered(bits: u64) -> u64 {
    let bits = bits & 0x9249_2492_4924_9249;
    let bits = (bits | bits >> 2) & 0x30c3_0c30_c30c_30c3;
    let bits = (bits | bits >> 4) & 0xf00f_00f0_0f00_f00f;
    let bits = (bits | bits >> 8) & 0x00ff_0000_ff00_00ff;
    let bits = (bits | bits >> 16) & 0xffff_0000_0000_ffff;
    (bits | bits >> 32) & 0x003f_ffff
}

/// Returns every third of the 192 columns of a row from `start` on; columns outside are off.
pub(super) fn thirds(row: &[u64], start: isize) -> u64 {
    let (first, shift) = (start.div_euclid(64), start.rem_euclid(64));
    let word = |number: isize| {
        let at = usize::try_from(first + number).ok();
        at.and_then(|at| row.get(at)).copied().unwrap_or(0)
    };
    let from = |number: isize| word(number) >> shift | word(number + 1) << 1 << (63 - shift);
    // The first word holds 22 multiples of three, the next ones 21 each.
    gathered(from(0)) | gathered(from(1) >> 2) << 22 | gathered(from(2) >> 1) << 43
}

/// Adds words to a row from column `offset` on, clipped to the row.
pub(super) fn merge(row: &mut [u64], [a, b, c]: [u64; FINE], offset: isize) {
    let (first, shift) = (offset.div_euclid(64), offset.rem_euclid(64));
    // The rest of a shifted word goes into the next one.
    let rest = |bits: u64| bits >> 1 >> (63 - shift);
    let parts = [
        a << shift,
        b << shift | rest(a),
        c << shift | rest(b),
        rest(c),
    ];
    for (at, part) in (first..).zip(parts) {
        let word = usize::try_from(at).ok().and_then(|at| row.get_mut(at));
        if let Some(word) = word {
            *word |= part;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_interleaved_and_merged_at_any_column() {
        let phases = [0x8000_f00f_1234_abcd, 0x1, 0xffff_0000_dead_beef];
        let words = interleaved(phases);
        for pixel in 0..WINDOW {
            for (phase, bits) in phases.iter().enumerate() {
                let at = FINE * pixel + phase;
                assert_eq!(words[at / 64] >> (at % 64) & 1, bits >> pixel & 1, "{at}");
            }
        }
        for offset in [-200, -65, -64, -3, 0, 1, 64, 70, 129, 250, 400] {
            let mut row = [0; 4];
            merge(&mut row, words, offset);
            for column in 0..256_usize {
                let from = usize::try_from(column.cast_signed() - offset);
                let from = from.ok().filter(|&from| from < 192);
                let expected = from.map_or(0, |from| words[from / 64] >> (from % 64) & 1);
                assert_eq!(
                    row[column / 64] >> (column % 64) & 1,
                    expected,
                    "{offset} {column}"
                );
            }
        }
    }

    #[test]
    fn every_third_bit_is_gathered() {
        for bits in [
            u64::MAX,
            0x8000_f00f_1234_abcd,
            1 << 63,
            0xffff_0000_dead_beef,
        ] {
            let expected = (0..22).map(|bit| (bits >> (FINE * bit) & 1) << bit);
            assert_eq!(gathered(bits), expected.sum::<u64>(), "{bits:x}");
        }
    }

    #[test]
    fn windows_hold_all_samples_and_one_holds_64_pixels() {
        assert_eq!(tiles((0.0, 64.0), 8, 80), [0]);
        assert_eq!(tiles((0.0, 50.0), 8, 66), [-7]);
        assert_eq!(tiles((-40.0, 60.0), 50, 120), [-54, 10]);
        // There is nothing to draw before or after the picture.
        assert_eq!(tiles((-90.0, -20.0), 8, 66), [0_isize; 0]);
        assert_eq!(tiles((70.0, 80.0), 8, 66), [0_isize; 0]);
    }
}

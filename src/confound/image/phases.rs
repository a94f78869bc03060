//! Nine drawings of one sample a pixel as one picture of three by three.

/// Samples of a pixel along an axis.
pub(super) const FINE: usize = 3;

/// Pixels that a window of the core has along an axis.
pub(super) const WINDOW: usize = 64;

/// The first pixels of the windows that hold every sample within `min..max` pixels and within a
/// picture of `count` pixels, `before` of them in front of pixel 0. None if there are no such
/// samples; the fewest, and a single one about their middle.
pub(super) fn tiles((min, max): (f64, f64), before: usize, count: usize) -> Vec<isize> {
    let (first, end) = (
        -before.cast_signed(),
        count.cast_signed() - before.cast_signed(),
    );
    // The last sample of a pixel is 5/6 behind its start, the first 1/6.
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

/// How far a phase's samples are from the pixels' centres, pixels.
pub(super) fn phase_offset(phase: usize) -> f64 {
    (phase as f64 - 1.0) / FINE as f64
}

/// An offset of samples as whole pixels, and a rest within half a pixel.
pub(super) fn within(offset: f64) -> (isize, f32) {
    let pixels = match offset {
        right if right > 0.5 => 1,
        left if left < -0.5 => -1,
        _ => 0,
    };
    #[expect(clippy::cast_possible_truncation, reason = "at most half a pixel")]
    let rest = (offset - pixels as f64) as f32;
    (pixels, rest.clamp(-0.5, 0.5))
}

/// Bits of three phases of a row, one after another for each pixel.
pub(super) fn interleaved(phases: [u64; FINE]) -> [u64; FINE] {
    let [a, b, c] = phases;
    // 16 pixels take 48 bits.
    let quarter = |number: u32| -> u128 {
        let part = |phase: u64| spread(phase >> (16 * number) & 0xffff);
        u128::from(part(a) | part(b) << 1 | part(c) << 2)
    };
    let low = quarter(0) | quarter(1) << 48 | quarter(2) << 96;
    let high = quarter(2) >> 32 | quarter(3) << 16;
    #[expect(clippy::cast_possible_truncation, reason = "word by word")]
    let words = [low as u64, (low >> 64) as u64, high as u64];
    words
}

/// Sixteen bits, each followed by two zeros (Morton 1966).
const fn spread(bits: u64) -> u64 {
    let bits = (bits | bits << 32) & 0x001f_0000_0000_ffff;
    let bits = (bits | bits << 16) & 0x001f_0000_ff00_00ff;
    let bits = (bits | bits << 8) & 0x100f_00f0_0f00_f00f;
    let bits = (bits | bits << 4) & 0x10c3_0c30_c30c_30c3;
    (bits | bits << 2) & 0x1249_2492_4924_9249
}

/// Adds words to a row from column `offset` on, as far as it goes.
pub(super) fn merge(row: &mut [u64], words: [u64; FINE], offset: isize) {
    let (whole, shift) = (offset.div_euclid(64), offset.rem_euclid(64));
    for (number, bits) in words.into_iter().enumerate() {
        let first = whole + number.cast_signed();
        let both = u128::from(bits) << shift;
        #[expect(clippy::cast_possible_truncation, reason = "word by word")]
        let parts = [(first, both as u64), (first + 1, (both >> 64) as u64)];
        for (at, part) in parts {
            let word = usize::try_from(at).ok().and_then(|at| row.get_mut(at));
            if let Some(word) = word {
                *word |= part;
            }
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
    fn windows_hold_all_samples_and_one_holds_64_pixels() {
        assert_eq!(tiles((0.0, 64.0), 8, 80), [0]);
        assert_eq!(tiles((0.0, 50.0), 8, 66), [-7]);
        assert_eq!(tiles((-40.0, 60.0), 50, 120), [-54, 10]);
        // Before the picture there is nothing to draw, and nothing behind it.
        assert_eq!(tiles((-90.0, -20.0), 8, 66), [0_isize; 0]);
        assert_eq!(tiles((70.0, 80.0), 8, 66), [0_isize; 0]);
    }
}

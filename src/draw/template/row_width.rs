//! Row-width-style vectors: the width of each row of a Gait Entropy Image.
//!
//! After Nandy, Pathak & Chakraborty, who describe each row by the width of its uncertain part.
//! The threshold and the scale are ours.

use edgegait_core::silhouette::Size;

/// Returns for each row the number of columns from the first to the last one whose entropy is
/// above `threshold`, or 0 if there is none. `geni` has the pixels of `size`, row by row.
#[must_use]
pub(crate) fn row_widths(geni: &[u8], size: Size, threshold: u8) -> Vec<usize> {
    let width = |row: &[u8]| {
        let first = row.iter().position(|&entropy| entropy > threshold);
        let last = row.iter().rposition(|&entropy| entropy > threshold);
        first.zip(last).map_or(0, |(first, last)| last - first + 1)
    };
    geni.chunks_exact(size.columns()).map(width).collect()
}

/// Returns widths as bytes: 255 w / columns, rounded half up.
#[must_use]
pub(crate) fn bytes(widths: &[usize], size: Size) -> Vec<u8> {
    let columns = size.columns();
    let byte = |width: &usize| (255 * width + columns / 2) / columns;
    let bytes = widths.iter().map(byte);
    bytes
        .map(|byte| u8::try_from(byte).unwrap_or(u8::MAX))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_width_runs_from_the_first_to_the_last_column_above_the_threshold() {
        let mut geni = vec![0; 1500];
        geni[1] = 255;
        // 3 to 7 with a gap.
        (geni[33], geni[37]) = (9, 10);
        geni[60..90].fill(1);
        let widths = row_widths(&geni, Size::S50x30, 0);
        assert_eq!((widths.len(), &widths[..4]), (50, &[1, 5, 30, 0][..]));
        assert_eq!(row_widths(&geni, Size::S50x30, 9)[..3], [1, 1, 0]);
        // 255/30 is 8.5.
        assert_eq!(bytes(&widths, Size::S50x30)[..4], [9, 43, 255, 0]);
    }

    #[test]
    fn the_widths_of_a_two_by_two_entropy_image_are_one() {
        // [[0, 1], [0, 0.811]] of the four frames of the other templates' tests.
        let mut geni = vec![0; 1500];
        (geni[1], geni[31]) = (255, 207);
        assert_eq!(row_widths(&geni, Size::S50x30, 0)[..3], [1, 1, 0]);
    }
}

//! Binary pictures of any size, one bit a sample.

use std::fmt;

/// A picture of samples that are on or off, in rows of 64-bit words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BitPicture {
    rows: usize,
    /// The number of words in a row.
    words: usize,
    /// The words: bit `c % 64` of word `c / 64` of a row is column `c`; row 0 is on top.
    bits: Vec<u64>,
}

/// The bounding box of all samples that are on, with exclusive ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleBounds {
    /// The first row.
    pub top: usize,
    /// The row after the last one.
    pub bottom: usize,
    /// The first column.
    pub left: usize,
    /// The column after the last one.
    pub right: usize,
}

/// Where a figure is in its picture, before effects.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FigureSamples {
    /// Its bounding box.
    pub(super) bounds: SampleBounds,
    /// How far right of the picture's the core's centroid is, pixels: 0 if both are in one column.
    pub(super) nudge: f64,
}

impl BitPicture {
    /// Creates a picture with all samples off, with 64 columns a word.
    #[must_use]
    pub(crate) fn empty(rows: usize, words: usize) -> Self {
        Self {
            rows,
            words,
            bits: vec![0; rows * words],
        }
    }

    /// Returns the number of rows.
    #[must_use]
    pub(crate) const fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of columns, a multiple of 64.
    #[must_use]
    pub(crate) const fn columns(&self) -> usize {
        64 * self.words
    }

    /// Returns whether a sample is on; all is off outside of the picture.
    #[must_use]
    pub(crate) fn is_on(&self, row: usize, column: usize) -> bool {
        column < self.columns() && row < self.rows && {
            let word = self.bits[row * self.words + column / 64];
            word >> (column % 64) & 1 == 1
        }
    }

    /// Returns the words of a row.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub(crate) fn row(&self, row: usize) -> &[u64] {
        &self.bits[row * self.words..][..self.words]
    }

    /// Returns the words of a row for writing.
    ///
    /// # Panics
    /// If there is no such row.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.bits[row * self.words..][..self.words]
    }

    /// Copies a row to another one.
    ///
    /// # Panics
    /// If there are no such rows.
    pub(super) fn copy_row(&mut self, from: usize, to: usize) {
        let from = from * self.words;
        self.bits
            .copy_within(from..from + self.words, to * self.words);
    }

    /// Returns all words, row by row.
    pub(super) fn words(&self) -> &[u64] {
        &self.bits
    }

    /// Returns all words for writing, row by row.
    pub(super) fn words_mut(&mut self) -> &mut [u64] {
        &mut self.bits
    }

    /// Returns the number of samples that are on.
    #[must_use]
    pub(crate) fn area(&self) -> u64 {
        let ones = self.bits.iter().map(|word| u64::from(word.count_ones()));
        ones.sum()
    }

    /// Returns the bounding box of the samples that are on, or `None` if all are off.
    #[must_use]
    pub(crate) fn bounds(&self) -> Option<SampleBounds> {
        let top = self.bits.iter().position(|&word| word != 0)? / self.words;
        let bottom = self.bits.iter().rposition(|&word| word != 0)? / self.words + 1;
        let mut columns = vec![0; self.words];
        for row in self.bits[top * self.words..bottom * self.words].chunks_exact(self.words) {
            for (all, word) in columns.iter_mut().zip(row) {
                *all |= word;
            }
        }
        let first = columns.iter().position(|&word| word != 0)?;
        let last = columns.iter().rposition(|&word| word != 0)?;
        Some(SampleBounds {
            top,
            bottom,
            left: 64 * first + columns[first].trailing_zeros() as usize,
            right: 64 * (last + 1) - columns[last].leading_zeros() as usize,
        })
    }

    /// Turns on the samples that are on in `other`.
    ///
    /// # Panics
    /// If the pictures differ in size.
    pub(crate) fn join(&mut self, other: &Self) {
        self.combine(other, |own, other| own | other);
    }

    /// Turns off the samples that are on in `other`.
    ///
    /// # Panics
    /// If the pictures differ in size.
    pub(crate) fn remove(&mut self, other: &Self) {
        self.combine(other, |own, other| own & !other);
    }

    /// Flips the samples that are on in `other`.
    ///
    /// # Panics
    /// If the pictures differ in size.
    pub(super) fn flip(&mut self, other: &Self) {
        self.combine(other, |own, other| own ^ other);
    }

    /// Turns off the samples that are off in `other`.
    ///
    /// # Panics
    /// If the pictures differ in size.
    #[cfg(test)]
    pub(crate) fn keep(&mut self, other: &Self) {
        self.combine(other, |own, other| own & other);
    }

    fn combine(&mut self, other: &Self, with: impl Fn(u64, u64) -> u64) {
        assert_eq!(
            (self.rows, self.words),
            (other.rows, other.words),
            "pictures of one layout"
        );
        for (own, &other) in self.bits.iter_mut().zip(&other.bits) {
            *own = with(*own, other);
        }
    }

    /// Turns columns `from..to` of a row on or off, clipped to the picture.
    pub(super) fn fill(&mut self, row: usize, from: isize, to: isize, on: bool) {
        let columns = self.columns().cast_signed();
        let (from, to) = (from.clamp(0, columns), to.clamp(0, columns));
        if row >= self.rows || from >= to {
            return;
        }
        let (from, to) = (from.cast_unsigned(), to.cast_unsigned());
        let row = self.row_mut(row);
        for (word, bits) in row
            .iter_mut()
            .enumerate()
            .take(to.div_ceil(64))
            .skip(from / 64)
        {
            let low = from.saturating_sub(64 * word);
            let high = (to - 64 * word).min(64);
            let mask = (u64::MAX << low) & (u64::MAX >> (64 - high));
            if on {
                *bits |= mask;
            } else {
                *bits &= !mask;
            }
        }
    }

    /// Returns how many of columns `from..to` of a row are on.
    pub(super) fn count(&self, row: usize, from: usize, to: usize) -> u32 {
        let to = to.min(self.columns());
        if row >= self.rows || from >= to {
            return 0;
        }
        let row = self.row(row).iter().enumerate();
        let words = row.take(to.div_ceil(64)).skip(from / 64);
        let ones = words.map(|(word, bits)| {
            let low = from.saturating_sub(64 * word);
            let high = (to - 64 * word).min(64);
            (bits & (u64::MAX << low) & (u64::MAX >> (64 - high))).count_ones()
        });
        ones.sum()
    }
}

/// Writes text art: a line of `#` and `.` for each row.
impl fmt::Display for BitPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in 0..self.rows {
            for column in 0..self.columns() {
                f.write_str(if self.is_on(row, column) { "#" } else { "." })?;
            }
            f.write_str("\n")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_what_is_on_and_counts_agree_with_samples() {
        let mut picture = BitPicture::empty(9, 3);
        assert_eq!(picture.bounds(), None);
        picture.fill(2, 60, 130, true);
        picture.fill(5, -7, 3, true);
        picture.fill(5, 190, 400, true);
        picture.fill(99, 0, 9, true);
        let bounds = SampleBounds {
            top: 2,
            bottom: 6,
            left: 0,
            right: 192,
        };
        assert_eq!(picture.bounds(), Some(bounds));
        assert_eq!(picture.area(), 70 + 3 + 2);
        picture.fill(5, -7, 500, false);
        picture.fill(2, 64, 128, false);
        assert_eq!(picture.area(), 4 + 2);
        for (from, to) in [(0, 192), (61, 129), (63, 64), (64, 128), (130, 900)] {
            let on = (from..to).filter(|&column| picture.is_on(2, column));
            assert_eq!(picture.count(2, from, to) as usize, on.count());
        }
        let bounds = picture.bounds().expect("six samples");
        assert_eq!((bounds.left, bounds.right), (60, 130));
    }

    #[test]
    fn pictures_join_remove_and_keep_sample_by_sample() {
        let of = |from: isize, to: isize| {
            let mut picture = BitPicture::empty(1, 2);
            picture.fill(0, from, to, true);
            picture
        };
        let (mut joined, mut removed, mut kept) = (of(0, 70), of(0, 70), of(0, 70));
        joined.join(&of(60, 100));
        removed.remove(&of(60, 100));
        kept.keep(&of(60, 100));
        assert_eq!((joined, removed, kept), (of(0, 100), of(0, 60), of(60, 70)));
    }
}

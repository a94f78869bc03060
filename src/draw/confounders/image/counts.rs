//! Counts of the samples that are on in each column, 64 columns at a time.

/// The number of samples that are on in each column, with one binary digit of 64 counts in each
/// word (bit-sliced counters of Harley & Seal; Warren 2013, section 5-1).
pub(super) struct ColumnCounts {
    words: usize,
    /// All words of the lowest digit, then those of the next digit, and so on.
    digits: Vec<u64>,
}

impl ColumnCounts {
    /// Counts the columns of at most `most` rows of `words` words each.
    pub(super) fn count<'a>(
        rows: impl Iterator<Item = &'a [u64]>,
        words: usize,
        most: usize,
    ) -> Self {
        let places = (usize::BITS - most.leading_zeros()) as usize;
        let mut digits = vec![0; places * words];
        for row in rows.take(most) {
            for (at, &bits) in row.iter().enumerate().take(words) {
                let mut carry = bits;
                for digit in digits.iter_mut().skip(at).step_by(words) {
                    (*digit, carry) = (*digit ^ carry, *digit & carry);
                }
            }
        }
        Self { words, digits }
    }

    /// Returns the count of a column, 0 outside of the rows.
    pub(super) fn of_column(&self, column: usize) -> u32 {
        if column / 64 >= self.words {
            return 0;
        }
        let digits = self.digits.chunks_exact(self.words).zip(0..);
        digits.fold(0, |count, (words, digit)| {
            count | ((words[column / 64] >> (column % 64) & 1) as u32) << digit
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_counted_one_by_one() {
        // Column c is on in the last c of 100 rows.
        let row = |number: u32| {
            let word = |first: u32| {
                let columns = (0..64).filter(|bit| first + bit > 99 - number);
                columns.fold(0, |bits, bit| bits | 1 << bit)
            };
            [word(0), word(64)]
        };
        let rows: Vec<[u64; 2]> = (0..100).map(row).collect();
        let counts = ColumnCounts::count(rows.iter().map(<[u64; 2]>::as_slice), 2, 100);
        for column in 0..128_u32 {
            assert_eq!(
                counts.of_column(column as usize),
                column.min(100),
                "{column}"
            );
        }
        assert_eq!(counts.of_column(128), 0);
        assert_eq!(ColumnCounts::count([].into_iter(), 2, 0).of_column(5), 0);
    }
}

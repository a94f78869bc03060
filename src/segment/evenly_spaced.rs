//! Keeps a few evenly spaced items of a sequence of unknown length.

/// A list of at most `most` evenly spaced items of a sequence. Whenever it is full, every second
/// item is dropped.
#[derive(Clone, Debug)]
pub(super) struct EvenlySpaced<T> {
    kept: Vec<T>,
    most: usize,
    /// Items whose numbers are multiples of this are kept.
    stride: usize,
    seen: usize,
}

impl<T> EvenlySpaced<T> {
    /// Makes a list of at most `most` items, an even number above 0.
    pub(super) fn new(most: usize) -> Self {
        assert!(most > 0 && most.is_multiple_of(2), "pairs");
        Self {
            kept: Vec::new(),
            most,
            stride: 1,
            seen: 0,
        }
    }

    /// Adds the next item, which is made only if it is kept.
    pub(super) fn push(&mut self, one: impl FnOnce() -> T) {
        if self.seen.is_multiple_of(self.stride) {
            if self.kept.len() == self.most {
                // Every second item is dropped. This one's number is a multiple of the new stride.
                let mut number = 0;
                self.kept.retain(|_| {
                    number += 1;
                    number % 2 == 1
                });
                self.stride *= 2;
            }
            self.kept.push(one());
        }
        self.seen += 1;
    }

    /// Returns the number of items so far.
    pub(super) const fn seen(&self) -> usize {
        self.seen
    }

    /// Returns the items that were kept, in order.
    pub(super) fn kept(&self) -> &[T] {
        &self.kept
    }

    /// Converts the list to the items that were kept.
    pub(super) fn into_kept(self) -> Vec<T> {
        self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_to_all_of_the_room_is_filled_by_every_so_many() {
        for (count, expected) in [
            (0, vec![]),
            (4, vec![0, 1, 2, 3]),
            (5, vec![0, 2, 4]),
            (8, vec![0, 2, 4, 6]),
            (9, vec![0, 4, 8]),
            (100, vec![0, 32, 64, 96]),
        ] {
            let mut spread = EvenlySpaced::new(4);
            for number in 0..count {
                spread.push(|| number);
            }
            assert_eq!((spread.kept(), spread.seen()), (&expected[..], count));
        }
    }
}

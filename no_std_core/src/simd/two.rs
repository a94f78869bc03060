//! Operations on sixteen numbers as two times eight.

use super::{LANES, Lanes};

const HALF: usize = LANES / 2;

/// Two halves of eight lanes, to each of which every operation is applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TwoHalves<H>(pub H);

#[inline(always)]
fn halves<T>(from: &[T; LANES]) -> [&[T; HALF]; 2] {
    match (from.first_chunk(), from.last_chunk()) {
        (Some(first), Some(last)) => [first, last],
        _ => unreachable!("sixteen are two times eight"),
    }
}

#[inline(always)]
fn halves_mut<T>(to: &mut [T; LANES]) -> [&mut [T; HALF]; 2] {
    match to.split_first_chunk_mut() {
        Some((first, last)) => match last.first_chunk_mut() {
            Some(last) => [first, last],
            None => unreachable!("sixteen are two times eight"),
        },
        None => unreachable!("sixteen are two times eight"),
    }
}

impl<H: Lanes<HALF>> Lanes<LANES> for TwoHalves<H> {
    type Floats = [H::Floats; 2];
    type Words = [H::Words; 2];
    type Mask = [H::Mask; 2];

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        [self.0.splat(value); 2]
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> Self::Floats {
        let [first, last] = halves(from);
        [self.0.load(first), self.0.load(last)]
    }
    #[inline(always)]
    fn store(self, floats: Self::Floats, to: &mut [f32; LANES]) {
        let [first, last] = halves_mut(to);
        self.0.store(floats[0], first);
        self.0.store(floats[1], last);
    }
    #[inline(always)]
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        [self.0.add(a[0], b[0]), self.0.add(a[1], b[1])]
    }
    #[inline(always)]
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        [self.0.sub(a[0], b[0]), self.0.sub(a[1], b[1])]
    }
    #[inline(always)]
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        [self.0.mul(a[0], b[0]), self.0.mul(a[1], b[1])]
    }
    #[inline(always)]
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        [self.0.div(a[0], b[0]), self.0.div(a[1], b[1])]
    }
    #[inline(always)]
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        [self.0.min(a[0], b[0]), self.0.min(a[1], b[1])]
    }
    #[inline(always)]
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        [self.0.max(a[0], b[0]), self.0.max(a[1], b[1])]
    }
    #[inline(always)]
    fn less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        [self.0.less(a[0], b[0]), self.0.less(a[1], b[1])]
    }
    #[inline(always)]
    fn not_less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        [self.0.not_less(a[0], b[0]), self.0.not_less(a[1], b[1])]
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        [self.0.and(a[0], b[0]), self.0.and(a[1], b[1])]
    }
    #[inline(always)]
    fn bits(self, mask: Self::Mask) -> u32 {
        self.0.bits(mask[0]) | self.0.bits(mask[1]) << HALF
    }
    #[inline(always)]
    fn reach(
        self,
        (left, right): (Self::Floats, Self::Floats),
        x: Self::Floats,
        [top, row, bottom]: [Self::Floats; 3],
    ) -> (Self::Floats, Self::Floats) {
        let (first, last) = (
            self.0
                .reach((left[0], right[0]), x[0], [top[0], row[0], bottom[0]]),
            self.0
                .reach((left[1], right[1]), x[1], [top[1], row[1], bottom[1]]),
        );
        ([first.0, last.0], [first.1, last.1])
    }
    #[inline(always)]
    fn truncate(self, floats: Self::Floats) -> Self::Words {
        [self.0.truncate(floats[0]), self.0.truncate(floats[1])]
    }

    #[inline(always)]
    fn round(self, floats: Self::Floats) -> Self::Words {
        [self.0.round(floats[0]), self.0.round(floats[1])]
    }

    #[inline(always)]
    fn splat_word(self, value: u32) -> Self::Words {
        [self.0.splat_word(value); 2]
    }
    #[inline(always)]
    fn load_words(self, from: &[u32; LANES]) -> Self::Words {
        let [first, last] = halves(from);
        [self.0.load_words(first), self.0.load_words(last)]
    }
    #[inline(always)]
    fn store_words(self, words: Self::Words, to: &mut [u32; LANES]) {
        let [first, last] = halves_mut(to);
        self.0.store_words(words[0], first);
        self.0.store_words(words[1], last);
    }
    #[inline(always)]
    fn add_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        [self.0.add_words(a[0], b[0]), self.0.add_words(a[1], b[1])]
    }
    #[inline(always)]
    fn sub_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        [self.0.sub_words(a[0], b[0]), self.0.sub_words(a[1], b[1])]
    }
    #[inline(always)]
    fn and_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        [self.0.and_words(a[0], b[0]), self.0.and_words(a[1], b[1])]
    }
    #[inline(always)]
    fn or_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        [self.0.or_words(a[0], b[0]), self.0.or_words(a[1], b[1])]
    }
    #[inline(always)]
    fn without(self, a: Self::Words, b: Self::Words) -> Self::Words {
        [self.0.without(a[0], b[0]), self.0.without(a[1], b[1])]
    }
    #[inline(always)]
    fn less_words(self, a: Self::Words, b: Self::Words) -> Self::Mask {
        [self.0.less_words(a[0], b[0]), self.0.less_words(a[1], b[1])]
    }
    #[inline(always)]
    fn max_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        [self.0.max_words(a[0], b[0]), self.0.max_words(a[1], b[1])]
    }
    #[inline(always)]
    fn fill_rows(self, from: Self::Words, to: Self::Words, rows: &mut [u64; LANES]) {
        let [first, last] = halves_mut(rows);
        self.0.fill_rows(from[0], to[0], first);
        self.0.fill_rows(from[1], to[1], last);
    }
    #[inline(always)]
    fn choose(self, mask: Self::Mask, a: Self::Words, b: Self::Words) -> Self::Words {
        [
            self.0.choose(mask[0], a[0], b[0]),
            self.0.choose(mask[1], a[1], b[1]),
        ]
    }
    #[inline(always)]
    fn mul_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        [self.0.mul_words(a[0], b[0]), self.0.mul_words(a[1], b[1])]
    }
    #[inline(always)]
    fn up<const BY: u32>(self, words: Self::Words) -> Self::Words {
        words.map(|words| self.0.up::<BY>(words))
    }
    #[inline(always)]
    fn down<const BY: u32>(self, words: Self::Words) -> Self::Words {
        words.map(|words| self.0.down::<BY>(words))
    }
    #[inline(always)]
    fn whole(self, floats: Self::Floats) -> Self::Floats {
        [self.0.whole(floats[0]), self.0.whole(floats[1])]
    }
    #[inline(always)]
    fn cut_off(self, floats: Self::Floats) -> Self::Words {
        [self.0.cut_off(floats[0]), self.0.cut_off(floats[1])]
    }
    #[inline(always)]
    fn slopes(self, across: Self::Words, down: Self::Words) -> Self::Words {
        [
            self.0.slopes(across[0], down[0]),
            self.0.slopes(across[1], down[1]),
        ]
    }
    #[inline(always)]
    fn min_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        [self.0.min_words(a[0], b[0]), self.0.min_words(a[1], b[1])]
    }
    #[inline(always)]
    fn widen(
        self,
        (left, right): (Self::Words, Self::Words),
        at: Self::Words,
        row: Self::Words,
        [first, last]: [Self::Words; 2],
    ) -> (Self::Words, Self::Words) {
        let (low, high) = (
            self.0
                .widen((left[0], right[0]), at[0], row[0], [first[0], last[0]]),
            self.0
                .widen((left[1], right[1]), at[1], row[1], [first[1], last[1]]),
        );
        ([low.0, high.0], [low.1, high.1])
    }
    #[inline(always)]
    fn bits_from(self, words: Self::Words) -> Self::Words {
        [self.0.bits_from(words[0]), self.0.bits_from(words[1])]
    }
    #[inline(always)]
    fn bits_but(self, words: Self::Words) -> Self::Words {
        [self.0.bits_but(words[0]), self.0.bits_but(words[1])]
    }
    #[inline(always)]
    fn count_ones(self, words: Self::Words) -> Self::Words {
        [self.0.count_ones(words[0]), self.0.count_ones(words[1])]
    }
}

//! Seeded choices: an execution depends on the seed, the target and its own number, and on nothing
//! else.

use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

pub struct Chance(ChaCha8Rng);

impl Chance {
    pub fn new(seed: u64, target: &str, number: u64) -> Self {
        // FNV-1a.
        let words = [&seed.to_le_bytes()[..], target.as_bytes()].concat();
        let hash = words.iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
        });
        let mut rng = ChaCha8Rng::seed_from_u64(hash);
        rng.set_stream(number);
        Self(rng)
    }

    /// A number below a bound; 0 if the bound is 0.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0.random_range(0..bound.max(1))
    }

    pub fn one_of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }

    pub fn is(&mut self, percent: u32) -> bool {
        self.0.random_ratio(percent, 100)
    }

    pub fn byte(&mut self) -> u8 {
        self.0.next_u32() as u8
    }

    /// A part of something of this length, mostly short; empty if there is nothing.
    pub fn span(&mut self, length: usize) -> Range<usize> {
        let most = self.one_of(&[1, 2, 4, 8, 16, 64, 512, 4096, length / 2 + 1]);
        let long = most.min(length);
        let start = self.below(length - long + 1);
        start..start + long
    }

    /// A place in something of this length, mostly near its beginning, where headers are.
    pub fn early(&mut self, length: usize) -> usize {
        let within = self.one_of(&[16, 64, 512, 4096, length]);
        self.below(within.min(length))
    }
}

#[test]
fn the_same_seed_target_and_number_give_the_same_choices() {
    let drawn = |seed, target, number| {
        let mut chance = Chance::new(seed, target, number);
        (0..8).map(|_| chance.below(1 << 30)).collect::<Vec<_>>()
    };
    let one = drawn(1, "bvh", 7);
    assert_eq!(one, drawn(1, "bvh", 7));
    assert_ne!(one, drawn(2, "bvh", 7));
    assert_ne!(one, drawn(1, "c3d", 7));
    assert_ne!(one, drawn(1, "bvh", 8));
}

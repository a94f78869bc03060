//! The order of an endless stream of items: every item once in each pass, shuffled.
//!
//! Each position of the stream is computed from its number alone, so that a stream can begin
//! anywhere and be shared among any number of readers without a list of its items.

/// Rounds of the permutation. Four make it pseudorandom (Luby & Rackoff 1988); two more are ours.
const ROUNDS: u64 = 6;

/// The order of items in a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ItemOrder {
    /// The seed of the shuffling.
    pub(super) seed: u64,
    /// The number of people.
    pub(super) people: u64,
    /// The number of items of each person.
    pub(super) items: u64,
    /// The number of people whose items are shuffled together.
    pub(super) at_once: u64,
    /// The number of items that stay together, in order: 1, or all items of a cycle.
    pub(super) together: u64,
}

impl ItemOrder {
    /// Returns the pass and the item at a position of the stream; none if there are no items, or
    /// beyond 2^32 passes.
    #[must_use]
    pub fn at(&self, place: u64) -> Option<(u32, usize)> {
        let (pass, group) = self.group_at(place / self.together)?;
        let item = group * self.together + place % self.together;
        usize::try_from(item).ok().map(|item| (pass, item))
    }

    /// Returns the pass, and the number of a group of items that stay together.
    fn group_at(&self, place: u64) -> Option<(u32, u64)> {
        let items = self.items / self.together;
        let all = self.people.checked_mul(items).filter(|all| *all > 0)?;
        let pass = u32::try_from(place / all).ok()?;
        let place = place % all;
        // Each pass shuffles people and divides them into blocks; each block shuffles its items.
        let block_items = self.at_once.saturating_mul(items).min(all);
        let (block, place) = (place / block_items, place % block_items);
        let first = block * self.at_once;
        let people = self.at_once.min(self.people - first);
        let key = mixed(self.seed ^ mixed(u64::from(pass)));
        let place = permuted(place, people * items, mixed(key ^ mixed(block + 1)));
        let person = permuted(first + place / items, self.people, key);
        Some((pass, person * items + place % items))
    }
}

/// Permutes the numbers below `count`: a Feistel network over the least even number of bits,
/// repeated until the result is below `count` (cycle walking; Black & Rogaway, CT-RSA 2002).
fn permuted(number: u64, count: u64, key: u64) -> u64 {
    let bits = 64 - count.saturating_sub(1).leading_zeros();
    let half = bits.div_ceil(2).max(1);
    let mask = (1 << half) - 1;
    let mut found = number;
    loop {
        let (mut left, mut right) = (found >> half, found & mask);
        for round in 0..ROUNDS {
            let turned = mixed(right ^ mixed(key.wrapping_add(round))) & mask;
            (left, right) = (right, left ^ turned);
        }
        found = left << half | right;
        if found < count {
            return found;
        }
    }
}

/// Mixes bits by the finaliser of splitmix64 (Steele, Lea & Flood, OOPSLA 2014).
const fn mixed(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    const ORDER: ItemOrder = ItemOrder {
        seed: 7,
        people: 10,
        items: 6,
        at_once: 4,
        together: 1,
    };

    fn taken(order: &ItemOrder, places: std::ops::Range<u64>) -> Vec<(u32, usize)> {
        places
            .map(|place| order.at(place).expect("a place"))
            .collect()
    }

    #[test]
    fn each_pass_has_every_item_once_in_an_order_of_its_own() {
        let mut orders = BTreeSet::new();
        for pass in 0..20 {
            let all = taken(&ORDER, 60 * pass..60 * (pass + 1));
            assert!(all.iter().all(|&(found, _)| u64::from(found) == pass));
            let items: Vec<usize> = all.iter().map(|&(_, item)| item).collect();
            let mut sorted = items.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..60).collect::<Vec<_>>());
            orders.insert(items);
        }
        assert_eq!(orders.len(), 20);
    }

    #[test]
    fn so_many_people_are_mixed_and_then_others() {
        let block = |places| -> BTreeSet<usize> {
            let items = taken(&ORDER, places).into_iter();
            items.map(|(_, item)| item / 6).collect()
        };
        let blocks = [block(0..24), block(24..48), block(48..60)];
        assert_eq!(blocks.each_ref().map(BTreeSet::len), [4, 4, 2]);
        let all: BTreeSet<usize> = blocks.iter().flatten().copied().collect();
        assert_eq!(all.len(), 10);
        // Not one person after another within a block.
        let people: Vec<usize> = taken(&ORDER, 0..24).iter().map(|it| it.1 / 6).collect();
        assert!(people.chunk_by(|a, b| a == b).count() > 12, "{people:?}");
    }

    #[test]
    fn every_place_is_as_likely() {
        // The position of item 0 in 6,000 passes of 12 items: 500 times at each, within 4 standard
        // deviations of 21.
        let order = ItemOrder {
            people: 3,
            items: 4,
            at_once: 3,
            ..ORDER
        };
        let mut counts = [0_i32; 12];
        for place in 0..6_000 * 12 {
            if order.at(place).expect("a place").1 == 0 {
                counts[place as usize % 12] += 1;
            }
        }
        assert!(
            counts.iter().all(|count| (count - 500).abs() < 86),
            "{counts:?}"
        );
    }

    #[test]
    fn views_of_a_cycle_stay_together() {
        let order = ItemOrder {
            together: 3,
            ..ORDER
        };
        let found = taken(&order, 0..60);
        let mut firsts = Vec::new();
        for cycle in found.chunks(3) {
            let first = cycle[0].1;
            assert_eq!(first % 3, 0);
            assert_eq!(cycle, [(0, first), (0, first + 1), (0, first + 2)]);
            firsts.push(first / 3);
        }
        // The same order as that of single items, if there are as many of them as cycles here.
        let cycles = ItemOrder { items: 2, ..ORDER };
        let expected: Vec<usize> = taken(&cycles, 0..20).iter().map(|it| it.1).collect();
        assert_eq!(firsts, expected);
    }

    #[test]
    fn one_item_and_none() {
        let one = ItemOrder {
            people: 1,
            items: 1,
            at_once: 64,
            ..ORDER
        };
        assert_eq!(taken(&one, 0..3), [(0, 0), (1, 0), (2, 0)]);
        let none = ItemOrder { people: 0, ..one };
        assert_eq!(none.at(0), None);
        assert_eq!(one.at(u64::MAX), None);
    }
}

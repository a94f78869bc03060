//! Splits cycles into training and test sets, by cycle or by take.

use super::example::Example;
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::collections::BTreeMap;

/// The share of a person's cycles or takes in the smaller part: the paper's 30 %.
const SMALLER: f64 = 0.3;

/// The unit by which a person's cycles are split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum SplitUnit {
    /// By cycle: the smaller part is a run of cycles. A cycle of the larger part that is next to
    /// one of the smaller part in the same take is left out: the guard.
    Cycle,
    /// By take.
    Take,
}

impl SplitUnit {
    /// Returns the name in results.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Cycle => "by cycle",
            Self::Take => "by take",
        }
    }
}

/// The numbers of the examples in each part of a split.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ExampleSplit {
    /// About 30 % of each person's examples.
    pub smaller: Vec<usize>,
    /// The other examples, except the guard.
    pub larger: Vec<usize>,
    /// The examples of people who cannot be split: one cycle, only neighbours, or one take.
    pub whole: Vec<usize>,
}

/// Splits the examples of each person at random by a seed.
///
/// By cycle, a person's cycles are ordered by take and time. The smaller part is a run of them that
/// starts at random, such that the larger part is not empty.
pub(crate) fn split(examples: &[Example], unit: SplitUnit, seed: u64) -> ExampleSplit {
    let mut people: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (number, example) in examples.iter().enumerate() {
        people.entry(example.person).or_default().push(number);
    }
    let mut split = ExampleSplit::default();
    for (&person, numbers) in &mut people {
        numbers.sort_by_key(|&number| (examples[number].take, examples[number].position));
        // A person's split does not depend on the other people.
        let mut rng =
            ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ person as u64);
        let smaller = match unit {
            SplitUnit::Cycle => run(examples, numbers, &mut rng),
            SplitUnit::Take => takes(examples, numbers, &mut rng),
        };
        if smaller.is_empty() {
            split.whole.extend(numbers.iter());
            continue;
        }
        let is_on_guard = |number: usize| {
            unit == SplitUnit::Cycle
                && smaller
                    .iter()
                    .any(|&other| are_neighbours(examples, number, other))
        };
        let larger = numbers.iter().copied();
        let larger = larger.filter(|number| !smaller.contains(number) && !is_on_guard(*number));
        split.larger.extend(larger);
        split.smaller.extend(&smaller);
    }
    split
}

fn are_neighbours(examples: &[Example], a: usize, b: usize) -> bool {
    let (a, b) = (&examples[a], &examples[b]);
    a.take == b.take && a.position.abs_diff(b.position) == 1
}

/// Returns the size of the smaller part of `of` items.
fn part(of: usize) -> usize {
    // Rounded; a small number.
    ((SMALLER * of as f64).round() as usize).clamp(1, of.max(1))
}

/// Chooses a run of a person's cycles that leaves some for the larger part.
fn run(examples: &[Example], numbers: &[usize], rng: &mut ChaCha8Rng) -> Vec<usize> {
    let length = part(numbers.len());
    let leaves_some = |start: &usize| {
        let run = &numbers[*start..*start + length];
        numbers.iter().any(|number| {
            !run.contains(number)
                && !run
                    .iter()
                    .any(|&other| are_neighbours(examples, *number, other))
        })
    };
    let starts: Vec<usize> = (0..=numbers.len() - length).filter(leaves_some).collect();
    if starts.is_empty() {
        return Vec::new();
    }
    let start = starts[rng.random_range(0..starts.len())];
    numbers[start..start + length].to_vec()
}

/// Chooses the cycles of some of a person's takes.
fn takes(examples: &[Example], numbers: &[usize], rng: &mut ChaCha8Rng) -> Vec<usize> {
    let mut takes: Vec<usize> = numbers
        .iter()
        .map(|&number| examples[number].take)
        .collect();
    takes.dedup();
    if takes.len() < 2 {
        return Vec::new();
    }
    takes.shuffle(rng);
    takes.truncate(part(takes.len()));
    let is_taken = |number: &usize| takes.contains(&examples[*number].take);
    numbers.iter().copied().filter(is_taken).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Makes examples from the number of cycles of each take of each person.
    fn examples(people: &[&[usize]]) -> Vec<Example> {
        let mut all = Vec::new();
        let mut take = 0;
        for (person, takes) in people.iter().enumerate() {
            for &cycles in *takes {
                all.extend((0..cycles).map(|position| Example {
                    person,
                    take,
                    position,
                    span_s: (0.0, 1.0),
                    frames: Vec::new(),
                    gei: Vec::new(),
                }));
                take += 1;
            }
        }
        all
    }

    #[test]
    fn by_cycle_no_neighbours_are_on_both_sides_and_everybody_who_can_be_is_on_both() {
        let all = examples(&[
            &[3],
            &[4],
            &[2, 2, 2],
            &[3, 3, 3, 3, 3, 3, 3, 3],
            &[2],
            &[1],
        ]);
        let mut seen = BTreeSet::new();
        for seed in 0..50 {
            let split = split(&all, SplitUnit::Cycle, seed);
            seen.insert(split.smaller.clone());
            for &a in &split.smaller {
                assert!(!split.larger.contains(&a));
                assert!(!split.larger.iter().any(|&b| are_neighbours(&all, a, b)));
            }
            let people = |numbers: &[usize]| -> BTreeSet<usize> {
                numbers.iter().map(|&number| all[number].person).collect()
            };
            let both = BTreeSet::from([0, 1, 2, 3]);
            assert_eq!(
                (people(&split.smaller), people(&split.larger)),
                (both.clone(), both)
            );
            // Two neighbouring cycles, and a single one, cannot be split.
            assert_eq!(people(&split.whole), BTreeSet::from([4, 5]));
            let of = |person| {
                split
                    .smaller
                    .iter()
                    .filter(|&&n| all[n].person == person)
                    .count()
            };
            assert_eq!([of(0), of(1), of(2), of(3)], [1, 1, 2, 7]);
        }
        assert!(seen.len() > 20, "the seed decides");
    }

    #[test]
    fn by_take_a_take_is_on_one_side() {
        let all = examples(&[&[3, 3], &[2, 2, 2, 2, 2, 2], &[3]]);
        for seed in 0..20 {
            let split = split(&all, SplitUnit::Take, seed);
            let takes = |numbers: &[usize]| -> BTreeSet<usize> {
                numbers.iter().map(|&number| all[number].take).collect()
            };
            let (smaller, larger) = (takes(&split.smaller), takes(&split.larger));
            assert!(smaller.is_disjoint(&larger));
            assert_eq!((smaller.len(), larger.len()), (3, 5));
            assert_eq!(takes(&split.whole), BTreeSet::from([8]));
        }
    }

    #[test]
    fn a_persons_part_does_not_depend_on_the_others() {
        let (few, many) = (examples(&[&[3, 3], &[4]]), examples(&[&[3, 3], &[4], &[3]]));
        for unit in [SplitUnit::Cycle, SplitUnit::Take] {
            let [few, many] = [&few, &many].map(|all| split(all, unit, 7).smaller);
            let known: Vec<usize> = many.into_iter().filter(|&number| number < 10).collect();
            assert_eq!(few, known);
        }
    }
}

//! Which cycles are trained on and which are looked for: by cycle, and by take.

use super::example::Example;
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::collections::BTreeMap;

/// Share of what a person has that is the smaller part: the paper's 30 %.
const SMALLER: f64 = 0.3;

/// How a person's cycles are parted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum SplitUnit {
    /// Into two runs of cycles. A cycle of the larger part that is next to one of the smaller part, in
    /// the same take, is left out: the guard.
    Cycle,
    /// Into takes.
    Take,
}

impl SplitUnit {
    /// What results call it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Cycle => "by cycle",
            Self::Take => "by take",
        }
    }
}

/// Numbers of examples, in two parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ExampleSplit {
    /// About 30 % of each person's.
    pub smaller: Vec<usize>,
    /// The others, but for those on guard.
    pub larger: Vec<usize>,
    /// Those of people who cannot be parted: one cycle, neighbours alone, or one take.
    pub whole: Vec<usize>,
}

/// Parts the examples of each person, drawn by a seed.
///
/// By cycle, a person's cycles stand in the order of takes and time, and the smaller part is a run of
/// them that begins anywhere where both parts have a cycle left.
pub(crate) fn split(examples: &[Example], unit: SplitUnit, seed: u64) -> ExampleSplit {
    let mut people: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (number, example) in examples.iter().enumerate() {
        people.entry(example.person).or_default().push(number);
    }
    let mut split = ExampleSplit::default();
    for (&person, numbers) in &mut people {
        numbers.sort_by_key(|&number| (examples[number].take, examples[number].position));
        // A person's draw does not depend on who else is there.
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

/// How many of so many things are the smaller part.
fn part(of: usize) -> usize {
    // Rounded; a small number.
    ((SMALLER * of as f64).round() as usize).clamp(1, of.max(1))
}

/// A run of a person's cycles beside which some are left.
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

/// The cycles of some of a person's takes.
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

    /// For each take of each person how many cycles it has.
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
            // Two cycles that are neighbours, and one alone, cannot be parted.
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

//! Draws a share of the gait cycles to train on.
//!
//! A cycle of a person is drawn with everything made from it: all viewpoints, all conditions,
//! mirrored and cropped copies. So no image of a cycle that is left out, and no variant of it, is
//! trained on.

use crate::dataset::sequences::SequenceOrigin;
use crate::error::{Result, TrainError};
use crate::files::sha256_of_bytes;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// A share of each person's gait cycles, drawn by a seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleShare {
    part: f64,
    seed: u64,
}

impl CycleShare {
    /// All cycles.
    pub const ALL: Self = Self { part: 1.0, seed: 0 };

    /// Makes a share above 0 and at most 1.
    ///
    /// # Errors
    /// If `part` is out of this range.
    pub fn new(part: f64, seed: u64) -> Result<Self> {
        if part > 0.0 && part <= 1.0 {
            return Ok(Self { part, seed });
        }
        Err(TrainError::OutOfRange {
            expected: "a share above 0 and at most 1",
            found: part,
        }
        .into())
    }

    /// Returns the share as a number.
    #[must_use]
    pub const fn part(self) -> f64 {
        self.part
    }

    /// Returns the ascending numbers of the images whose cycles are in the share; each image is
    /// given by its person and origin.
    ///
    /// # Guarantees
    /// Of a person's `n` cycles the share has `part * n`, rounded half up, and at least one. A walk
    /// of which some image shows the whole recording counts as one cycle. The share has the cycles
    /// whose SHA-256 of seed, person and cycle is lowest: another person, another source or another
    /// order changes nothing, and a smaller share is a part of a larger one.
    #[must_use]
    pub fn kept<'a>(
        self,
        pictures: impl Iterator<Item = (&'a str, &'a SequenceOrigin)> + Clone,
    ) -> Vec<usize> {
        if self.part >= 1.0 {
            return (0..pictures.count()).collect();
        }
        let whole = pictures
            .clone()
            .filter(|(_, origin)| origin.cycle.is_none());
        let whole: HashSet<(&str, &String)> = whole
            .map(|(person, origin)| (person, &origin.walk))
            .collect();
        let mut lots: HashMap<(&str, &SequenceOrigin), String> = HashMap::new();
        let mut of_person: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
        for (person, origin) in pictures.clone() {
            lots.entry((person, origin)).or_insert_with(|| {
                let is_whole = whole.contains(&(person, &origin.walk));
                let lot = self.lot(person, origin, origin.cycle.filter(|_| !is_whole));
                of_person.entry(person).or_default().insert(lot.clone());
                lot
            });
        }
        let last = |cycles: &BTreeSet<String>| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "0 to their count"
            )]
            let count = (self.part * cycles.len() as f64).round() as usize;
            cycles.iter().nth(count.max(1) - 1).cloned()
        };
        let last: HashMap<&str, Option<String>> = of_person
            .iter()
            .map(|(person, cycles)| (*person, last(cycles)))
            .collect();
        let is_kept = |(person, origin): (&'a str, &'a SequenceOrigin)| {
            let lot = lots.get(&(person, origin));
            lot <= last.get(person).and_then(Option::as_ref)
        };
        let numbered = pictures.enumerate();
        let kept = numbered.filter(|(_, picture)| is_kept(*picture));
        kept.map(|(number, _)| number).collect()
    }

    /// Returns the lot that a person's cycle, or the whole walk, draws.
    fn lot(self, person: &str, origin: &SequenceOrigin, cycle: Option<u32>) -> String {
        let SequenceOrigin {
            walk,
            variation,
            seed,
            ..
        } = origin;
        // The recorded cycle is the same whatever seed varies it.
        let varied = (*variation > 0).then_some((*variation, *seed));
        let text = format!("{} {person:?} {walk:?} {cycle:?} {varied:?}", self.seed);
        sha256_of_bytes(text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycle(walk: &str, cycle: u32) -> SequenceOrigin {
        SequenceOrigin {
            walk: walk.into(),
            cycle: Some(cycle),
            variation: 0,
            seed: 0,
        }
    }

    /// Returns those that are kept, by person and cycle.
    fn kept<'a>(
        share: CycleShare,
        all: &[(&'a str, &'a SequenceOrigin)],
    ) -> Vec<(&'a str, &'a SequenceOrigin)> {
        let kept = share.kept(all.iter().copied());
        assert!(kept.is_sorted());
        kept.into_iter().map(|at| all[at]).collect()
    }

    fn share(part: f64, seed: u64) -> CycleShare {
        CycleShare::new(part, seed).expect("in range")
    }

    fn count(kept: &[(&str, &SequenceOrigin)], person: &str) -> usize {
        kept.iter().filter(|(name, _)| *name == person).count()
    }

    #[test]
    fn each_person_keeps_the_share_of_their_own_cycles_rounded_and_at_least_one() {
        let cycles: Vec<SequenceOrigin> = (0..10).map(|at| cycle("w", at)).collect();
        let of = |person, count: usize| cycles[..count].iter().map(move |cycle| (person, cycle));
        let all: Vec<_> = of("ann", 10)
            .chain(of("bob", 3))
            .chain(of("cy", 1))
            .collect();
        // 7, 2.1 and 0.7; 1.5, 0.45 and 0.15; 2.5 is rounded up.
        for (part, expected) in [(0.7, [7, 2, 1]), (0.15, [2, 1, 1]), (0.25, [3, 1, 1])] {
            let kept = kept(share(part, 1), &all);
            let found = ["ann", "bob", "cy"].map(|person| count(&kept, person));
            assert_eq!(found, expected, "{part}");
        }
        assert_eq!(kept(share(1.0, 9), &all), all);
        assert_eq!(kept(CycleShare::ALL, &all), all);
    }

    #[test]
    fn all_pictures_of_a_cycle_are_on_one_side() {
        // Six images of each of four cycles: viewpoints, conditions and copies of it.
        let cycles: Vec<SequenceOrigin> = (0..4).map(|at| cycle("w", at)).collect();
        let all: Vec<_> = (0..24).map(|at| ("ann", &cycles[at % 4])).collect();
        let kept = kept(share(0.5, 3), &all);
        assert_eq!(kept.len(), 12);
        for one in &cycles {
            let pictures = kept.iter().filter(|(_, origin)| *origin == one).count();
            assert!([0, 6].contains(&pictures), "{pictures}");
        }
    }

    #[test]
    fn the_draw_does_not_depend_on_order_or_on_who_else_is_there() {
        let cycles: Vec<SequenceOrigin> = (0..9).map(|at| cycle("w", at)).collect();
        let ann: Vec<_> = cycles.iter().map(|cycle| ("ann", cycle)).collect();
        let mut all: Vec<_> = cycles.iter().map(|cycle| ("bob", cycle)).collect();
        all.extend(ann.iter().rev());
        let alone = kept(share(0.4, 7), &ann);
        let mut among: Vec<_> = kept(share(0.4, 7), &all);
        among.retain(|(person, _)| *person == "ann");
        among.reverse();
        assert_eq!(among, alone);
        assert_eq!(kept(share(0.4, 7), &ann), alone);
    }

    #[test]
    fn a_smaller_share_is_a_part_of_a_larger_one_and_another_seed_draws_another() {
        let cycles: Vec<SequenceOrigin> = (0..40).map(|at| cycle("w", at)).collect();
        let all: Vec<_> = cycles.iter().map(|cycle| ("ann", cycle)).collect();
        let (few, many) = (kept(share(0.3, 1), &all), kept(share(0.6, 1), &all));
        assert_eq!((few.len(), many.len()), (12, 24));
        assert!(few.iter().all(|cycle| many.contains(cycle)));
        assert_ne!(kept(share(0.3, 2), &all), few);
    }

    #[test]
    fn variations_are_cycles_of_their_own_and_the_recorded_one_has_no_seed() {
        let varied = |variation, seed| SequenceOrigin {
            variation,
            seed,
            ..cycle("w", 0)
        };
        let all = [varied(0, 1), varied(0, 2), varied(1, 1), varied(1, 2)];
        let all: Vec<_> = all.iter().map(|cycle| ("ann", cycle)).collect();
        for seed in 0..20 {
            // One of three cycles, the first of which has two images.
            let kept = kept(share(0.33, seed), &all);
            let variations: Vec<u32> = kept.iter().map(|(_, one)| one.variation).collect();
            assert!(
                [vec![0, 0], vec![1]].contains(&variations),
                "{variations:?}"
            );
        }
    }

    #[test]
    fn a_walk_that_is_seen_whole_from_somewhere_is_not_torn_apart() {
        let whole = |walk| SequenceOrigin {
            cycle: None,
            ..cycle(walk, 0)
        };
        let torn = [cycle("a", 0), cycle("a", 1), whole("a"), cycle("b", 0)];
        let all: Vec<_> = torn.iter().map(|cycle| ("ann", cycle)).collect();
        let mut walks = BTreeSet::new();
        for seed in 0..20 {
            let kept = kept(share(0.5, seed), &all);
            let pictures: Vec<&str> = kept.iter().map(|(_, one)| one.walk.as_str()).collect();
            walks.insert(pictures.concat());
        }
        assert_eq!(Vec::from_iter(walks), ["aaa", "b"]);
    }

    #[test]
    fn shares_out_of_range_are_refused() {
        for part in [0.0, -0.5, 1.01, f64::NAN, f64::INFINITY] {
            let error = CycleShare::new(part, 1)
                .expect_err("out of range")
                .to_string();
            assert!(error.contains("above 0 and at most 1, found"), "{error}");
        }
    }
}

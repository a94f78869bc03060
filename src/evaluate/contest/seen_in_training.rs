//! Probes that a recognizer was trained on, or that are variations of cycles in its training set.
//!
//! A recognizer recognizes its training data, and a seeded variation of a recording is that
//! recording with noise. Rank-1 on either says little about another walk of the same people.

use crate::dataset::sequences::Sequences;
use crate::inference::Contract;

/// Counts of probes that were seen in training.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SeenInTraining {
    probes: usize,
    /// Probes that are in the training set.
    shown: usize,
    /// Probes that are other variations of cycles in the training set.
    varied: usize,
}

impl SeenInTraining {
    /// Compares the probes among `sequences` with the training set that the contract states, by the
    /// names of people and walks, so that a walk of the same name in another file counts too.
    pub(super) fn compare(
        contract: &Contract,
        sequences: &Sequences,
        is_probe: impl Fn(usize) -> bool,
    ) -> Self {
        let training = &contract.training;
        let people = if training.subjects.is_empty() {
            &contract.classes
        } else {
            &training.subjects
        };
        let knows = |name: &String| people.contains(name);
        let is_known: Vec<bool> = sequences.subjects.iter().map(knows).collect();
        let is_of_training = |origin: &crate::dataset::sequences::SequenceOrigin| {
            let cycles = &training.cycles;
            let has = |cycle| cycles.is_empty() || cycles.contains(&cycle);
            training.walks.contains(&origin.walk) && origin.cycle.is_none_or(has)
        };
        let was_shown = |origin: &crate::dataset::sequences::SequenceOrigin| {
            let is_of = |seed| seed == training.seed || training.seeds.contains(&seed);
            (origin.variation == 0 || is_of(origin.seed))
                && training.variations.contains(&origin.variation)
        };
        let parts: Vec<(bool, bool)> = sequences
            .origins
            .iter()
            .map(|origin| (is_of_training(origin), was_shown(origin)))
            .collect();
        let mut seen = Self::default();
        for (number, sequence) in sequences.list.iter().enumerate() {
            if !is_probe(number) {
                continue;
            }
            seen.probes += 1;
            let (is_of_training, was_shown) = parts[sequence.origin];
            if is_known[sequences.subject(number)] && is_of_training {
                seen.shown += usize::from(was_shown);
                seen.varied += usize::from(!was_shown);
            }
        }
        seen
    }

    /// Returns the warnings for a user, about the recognizer.
    pub(super) fn warnings(self) -> impl Iterator<Item = String> {
        let Self {
            probes,
            shown,
            varied,
        } = self;
        let shown = (shown > 0).then(|| {
            format!(
                "{shown} of {probes} probes show cycles that it was trained on, judging by the names of people and walks (use other walks as probes)"
            )
        });
        let varied = (varied > 0).then(|| {
            format!(
                "{varied} of {probes} probes are seeded variations of cycles that it was trained on, not other walks: rank-1 shows only its robustness to noise and viewpoint"
            )
        });
        shown.into_iter().chain(varied)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::sequences::{
        Sequence, SequenceOrigin, SequencePurpose, SequenceTake, ViewLabel,
    };
    use crate::inference::Training;

    /// Returns one sequence for each (person, walk, stored cycle, variation, seed).
    fn sequences(of: &[(usize, &str, Option<u32>, u32, u64)]) -> Sequences {
        let take = |subject| SequenceTake {
            subject,
            name: "probe".into(),
            condition: String::new(),
        };
        Sequences {
            subjects: vec!["ann".into(), "bob".into()],
            takes: vec![take(0), take(1)],
            origins: of
                .iter()
                .map(|&(_, walk, cycle, variation, seed)| SequenceOrigin {
                    walk: walk.into(),
                    cycle,
                    variation,
                    seed,
                })
                .collect(),
            views: vec![ViewLabel::Angles(90.0, 0.0)],
            list: of
                .iter()
                .enumerate()
                .map(|(origin, &(take, ..))| Sequence {
                    take,
                    origin,
                    view: 0,
                    purpose: SequencePurpose::Any,
                })
                .collect(),
        }
    }

    /// Returns a contract trained on ann's cycles 0 and 2 of walk 1, variations 0 to 7 of seed 1.
    fn contract() -> Contract {
        Contract {
            classes: vec!["ann".into()],
            training: Training {
                walks: vec!["1".into()],
                cycles: vec![0, 2],
                variations: (0..8).collect(),
                seed: 1,
                ..Training::default()
            },
            ..Contract::default()
        }
    }

    fn seen(contract: &Contract, of: (usize, &str, Option<u32>, u32, u64)) -> (usize, usize) {
        let seen = SeenInTraining::compare(contract, &sequences(&[of]), |_| true);
        assert_eq!(seen.probes, 1);
        (seen.shown, seen.varied)
    }

    #[test]
    fn what_was_shown_and_what_varies_it_are_told_apart_from_what_is_new() {
        let contract = contract();
        let seen = |of| seen(&contract, of);
        assert_eq!(seen((0, "1", Some(2), 7, 1)), (1, 0));
        // Another variation, or the same one with another seed; variation 0 has no seed.
        assert_eq!(seen((0, "1", Some(2), 8, 1)), (0, 1));
        assert_eq!(seen((0, "1", Some(2), 7, 2)), (0, 1));
        assert_eq!(seen((0, "1", Some(2), 0, 2)), (1, 0));
        // Another cycle of the walk, another walk, another person.
        assert_eq!(seen((0, "1", Some(1), 0, 1)), (0, 0));
        assert_eq!(seen((0, "2", Some(2), 0, 1)), (0, 0));
        assert_eq!(seen((1, "1", Some(2), 0, 1)), (0, 0));
        // A whole recording has all of its cycles.
        assert_eq!(seen((0, "1", None, 0, 0)), (1, 0));
    }

    #[test]
    fn what_a_contract_leaves_open_counts_as_far_as_it_is_known() {
        let mut contract = contract();
        contract.training.cycles.clear();
        assert_eq!(seen(&contract, (0, "1", Some(9), 0, 1)), (1, 0));
        contract.training.subjects = vec!["bob".into()];
        assert_eq!(seen(&contract, (0, "1", Some(9), 0, 1)), (0, 0));
        assert_eq!(seen(&contract, (1, "1", Some(9), 0, 1)), (1, 0));
        // With several sources, variations may have several seeds.
        assert_eq!(seen(&contract, (1, "1", Some(9), 3, 5)), (0, 1));
        contract.training.seeds = vec![4, 5];
        assert_eq!(seen(&contract, (1, "1", Some(9), 3, 5)), (1, 0));
        assert_eq!(seen(&contract, (1, "1", Some(9), 3, 1)), (1, 0));
        contract.training.walks.clear();
        assert_eq!(seen(&contract, (1, "1", Some(9), 0, 1)), (0, 0));
    }

    #[test]
    fn only_probes_count() {
        let both = sequences(&[(0, "1", Some(0), 0, 1), (0, "1", Some(0), 1000, 1)]);
        let second = SeenInTraining::compare(&contract(), &both, |sequence| sequence == 1);
        assert_eq!((second.probes, second.shown, second.varied), (1, 0, 1));
        assert_eq!(second.warnings().count(), 1);
    }
}

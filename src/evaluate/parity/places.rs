//! Differences between two sides by input, person and viewpoint.

use super::difference::{AnswerDifference, VectorPair};
use crate::dataset::sequences::{Sequences, ViewLabel};
use crate::inference::answers::Answers;
use serde::Serialize;
use std::collections::BTreeMap;

/// Number of inputs that are listed.
const LISTED: usize = 5;

/// An input, and the difference between the answers to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct InputDifference {
    pub subject: String,
    pub take: String,
    pub view: ViewLabel,
    /// The greater one of the relative differences of embedding and scores; none where a number is
    /// not finite.
    pub relative: Option<f64>,
}

/// Differences over the inputs of one person or one viewpoint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ParityPart {
    pub name: String,
    pub inputs: u64,
    /// Inputs with a number that is not finite. The fields below are of the other inputs.
    pub non_finite: u64,
    /// The greatest [`InputDifference::relative`].
    pub greatest_relative: f64,
    pub mean_relative: f64,
}

/// The compared answers of two sides.
pub(super) struct ComparedAnswers {
    pub(super) embedding: Option<AnswerDifference>,
    pub(super) scores: Option<AnswerDifference>,
    /// [`InputDifference::relative`] by the number of a sequence that was shown.
    relatives: BTreeMap<usize, Option<f64>>,
}

impl ComparedAnswers {
    /// Compares the answers to the first `sequences` sequences, where there are any.
    pub(super) fn compare(reference: &Answers, other: &Answers, sequences: usize) -> Self {
        let embeddings = |at| VectorPair::new(reference.embedding(at), other.embedding(at));
        let scores = |at| VectorPair::new(reference.scores(at), other.scores(at));
        let numbers = |pair: VectorPair<'_>| {
            let mut numbers = pair.reference.iter().chain(pair.other);
            numbers.all(|number| number.is_finite())
        };
        let has_answer = |at: &usize| {
            !(embeddings(*at).reference.is_empty() && scores(*at).reference.is_empty())
        };
        let shown: Vec<usize> = (0..sequences).filter(has_answer).collect();
        let is_finite = |at: &usize| numbers(embeddings(*at)) && numbers(scores(*at));
        let finite: Vec<usize> = shown.iter().copied().filter(is_finite).collect();
        let mut relatives: BTreeMap<usize, Option<f64>> =
            shown.into_iter().map(|at| (at, None)).collect();
        let mut difference = |pairs: Vec<VectorPair<'_>>| {
            let (difference, found) = AnswerDifference::measure(&pairs)?;
            for (at, relative) in finite.iter().zip(found) {
                let greatest = relatives.entry(*at).or_default();
                *greatest = Some(greatest.map_or(relative, |before| before.max(relative)));
            }
            Some(difference)
        };
        let of_embeddings: Vec<VectorPair<'_>> = finite.iter().map(|&at| embeddings(at)).collect();
        let of_scores: Vec<VectorPair<'_>> = finite.iter().map(|&at| scores(at)).collect();
        // A model with one output has it as both.
        let is_one = of_embeddings == of_scores;
        let embedding = difference(of_embeddings);
        let scores = if is_one { None } else { difference(of_scores) };
        Self {
            embedding,
            scores,
            relatives,
        }
    }

    /// Returns the inputs with the greatest differences.
    pub(super) fn worst(&self, sequences: &Sequences) -> Vec<InputDifference> {
        let mut order: Vec<(usize, Option<f64>)> =
            self.relatives.iter().map(|(&at, &one)| (at, one)).collect();
        let key = |relative: Option<f64>| relative.unwrap_or(f64::INFINITY);
        // A stable sort: ties keep their order.
        order.sort_by(|a, b| {
            let finite = a.1.is_some().cmp(&b.1.is_some());
            finite.then(key(b.1).total_cmp(&key(a.1)))
        });
        let apart = order.into_iter().filter(|(_, one)| *one != Some(0.0));
        let place = |(at, relative): (usize, Option<f64>)| InputDifference {
            subject: sequences.subjects[sequences.subject(at)].clone(),
            take: sequences.takes[sequences.list[at].take].name.clone(),
            view: sequences.view_label(at).clone(),
            relative,
        };
        apart.take(LISTED).map(place).collect()
    }

    pub(super) fn by_subject(&self, sequences: &Sequences) -> Vec<ParityPart> {
        let names = sequences.subjects.clone();
        self.parts(names, |at| sequences.subject(at))
    }

    pub(super) fn by_view(&self, sequences: &Sequences) -> Vec<ParityPart> {
        let names = sequences.views.iter().map(ToString::to_string).collect();
        self.parts(names, |at| sequences.list[at].view)
    }

    /// Sums the differences by the part that an input belongs to; parts without inputs are left
    /// out.
    fn parts(&self, names: Vec<String>, part_of: impl Fn(usize) -> usize) -> Vec<ParityPart> {
        let part = |name| ParityPart {
            name,
            inputs: 0,
            non_finite: 0,
            greatest_relative: 0.0,
            mean_relative: 0.0,
        };
        let mut parts: Vec<ParityPart> = names.into_iter().map(part).collect();
        for (&at, relative) in &self.relatives {
            let part = &mut parts[part_of(at)];
            part.inputs += 1;
            match relative {
                None => part.non_finite += 1,
                Some(relative) => {
                    part.greatest_relative = part.greatest_relative.max(*relative);
                    part.mean_relative += relative;
                }
            }
        }
        parts.retain(|part| part.inputs > 0);
        for part in &mut parts {
            part.mean_relative /= (part.inputs - part.non_finite).max(1) as f64;
        }
        parts
    }
}

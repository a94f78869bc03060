//! Comparison of the answers of one model on several runtimes, or of several variants of a model.
//!
//! A side is a model on a runtime; the first side is the reference. All sides are shown the same
//! pictures, and are ranked under the protocol as in any contest. Their answers are compared number
//! by number and probe by probe. No cache is used, since it could hide a fault.

mod difference;
mod places;
mod ranks;
mod side;
mod verdict;

pub(crate) use difference::{AnswerDifference, VectorPair};
pub(crate) use places::{InputDifference, ParityPart};
pub(crate) use ranks::RankChanges;
pub(crate) use side::ParitySide;
pub(crate) use verdict::{Limits, Verdict};

use super::contest::{Contest, ContestAnswers, Entrant, ShownPicture};
use crate::error::{EvaluateError, Result};
use crate::files::ResultHeader;
use crate::inference::answers::Answers;
use places::ComparedAnswers;
use ranks::SideRanks;
use serde::Serialize;

/// The results of `edgegait parity`, as the JSON that it writes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ParityResults {
    #[serde(flatten)]
    pub header: ResultHeader,
    /// Whether all sides give the same answers as the first.
    pub verdict: Verdict,
    /// Number of templates or sequences of silhouettes that each side was shown.
    pub sequences: u64,
    /// Number of people in them.
    pub people: usize,
    /// Number of viewpoints or cameras.
    pub viewpoints: usize,
    /// Name of the protocol.
    pub protocol: String,
    /// The sides, the reference first.
    pub sides: Vec<ParitySide>,
    /// The comparison of each other side with the reference.
    pub comparisons: Vec<Comparison>,
}

/// The comparison of a side with the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Comparison {
    /// The number of the side, from 0 for the reference.
    pub side: usize,
    pub verdict: Verdict,
    /// Why the sides differ; empty if they do not.
    pub reasons: Vec<String>,
    pub limits: Limits,
    /// Differences of embeddings; none if no embedding is finite on both sides.
    pub embedding: Option<AnswerDifference>,
    /// Differences of class scores; none if there are no scores, they are the embedding, or no
    /// score is finite.
    pub scores: Option<AnswerDifference>,
    /// Changes in ranks; none if the embeddings of a side cannot be ranked.
    pub ranks: Option<RankChanges>,
    /// The inputs with the greatest differences, non-finite ones first.
    pub worst: Vec<InputDifference>,
    /// Differences by person, in the source's order.
    pub by_subject: Vec<ParityPart>,
    /// Differences by viewpoint or camera.
    pub by_view: Vec<ParityPart>,
}

/// The answers of all sides in the same contest.
pub(crate) struct SideAnswers<'a> {
    contest: &'a Contest<'a>,
    asked: ContestAnswers,
    ranked: Vec<Option<SideRanks>>,
}

impl<'a> SideAnswers<'a> {
    /// Runs all sides and ranks their answers; `seen` is called for each picture.
    ///
    /// # Errors
    /// If the answers of the sides differ in shape, or as [`Contest::run`]. A side without a finite
    /// answer is not an error.
    pub(crate) fn run(
        contest: &'a Contest<'a>,
        entrants: &[Entrant],
        seed: u64,
        seen: &mut dyn FnMut(ShownPicture<'_>) -> Result<()>,
    ) -> Result<Self> {
        let asked = contest.ask(entrants, seen)?;
        let names: Vec<&str> = entrants
            .iter()
            .map(|entrant| entrant.recognizer.name())
            .collect();
        for (answers, name) in asked.answers.iter().zip(&names).skip(1) {
            same_form(names[0], &asked.answers[0], name, answers)?;
        }
        let ranked = entrants.iter().zip(&asked.answers);
        let ranked =
            ranked.map(|(entrant, answers)| SideRanks::rank(contest, entrant, answers, seed));
        Ok(Self {
            ranked: ranked.collect::<Result<_>>()?,
            contest,
            asked,
        })
    }

    /// Returns the number of templates or sequences of silhouettes that each side was shown.
    pub(crate) const fn sequences(&self) -> u64 {
        self.asked.sequences
    }

    /// Fills in the fields of a side that depend on its own answers only.
    pub(crate) fn complete(&self, side: &mut ParitySide, at: usize) {
        let answers = &self.asked.answers[at];
        let numbers = || answers.embeddings.iter().chain(&answers.scores);
        side.numbers = numbers().count() as u64;
        side.non_finite = numbers().filter(|number| !number.is_finite()).count() as u64;
        side.rank1 = self.ranked[at].as_ref().map(|ranked| ranked.rank1);
    }

    /// Compares a side with the reference.
    pub(crate) fn compare(&self, sides: &[ParitySide], at: usize, limits: Limits) -> Comparison {
        let sequences = self.contest.source().sequences();
        let [reference, other] = [0, at].map(|side| &self.asked.answers[side]);
        let found = ComparedAnswers::compare(reference, other, sequences.list.len());
        let ranks = self.ranked[0].as_ref().zip(self.ranked[at].as_ref());
        let mut comparison = Comparison {
            side: at,
            verdict: Verdict::Same,
            reasons: Vec::new(),
            limits,
            ranks: ranks.map(|(reference, other)| RankChanges::compare(reference, other)),
            worst: found.worst(sequences),
            by_subject: found.by_subject(sequences),
            by_view: found.by_view(sequences),
            embedding: found.embedding,
            scores: found.scores,
        };
        comparison.judge([&sides[0], &sides[at]]);
        comparison
    }
}

/// Checks that the answers of two sides can be compared number by number.
fn same_form(name: &str, a: &Answers, other: &str, b: &Answers) -> Result<()> {
    let form = |answers: &Answers| match (answers.parts, answers.dims) {
        (0 | 1, dims) => format!("[{dims}]"),
        (parts, dims) => format!("[{}, {parts}]", dims / parts),
    };
    let scores = |answers: &Answers| answers.classes.to_string();
    for (what, values) in [
        ("form of embeddings", [form(a), form(b)]),
        ("number of class scores", [scores(a), scores(b)]),
    ] {
        if values[0] != values[1] {
            return Err(EvaluateError::SidesDiffer {
                what,
                sides: [name.to_owned(), other.to_owned()],
                values,
            }
            .into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;

//! Whether sides give the same answers: one model on several runtimes, or several forms of a model.
//!
//! A side is a model on a runtime, and the first is the reference of the others. All are shown the
//! same pictures, and ranked by the protocol as in any contest; what they answered is compared
//! number by number and probe by probe. Nothing is taken from a cache, which could hide a fault.

mod difference;
mod places;
mod ranks;
mod side;
mod verdict;

pub(crate) use difference::AnswerDifference;
pub(crate) use places::{InputDifference, ParityPart};
pub(crate) use ranks::RankChanges;
pub(crate) use side::ParitySide;
pub(crate) use verdict::{Limits, Verdict};

use super::contest::{Contest, ContestAnswers, Entrant, ShownPicture};
use crate::dataset::ResultHeader;
use crate::error::{EvaluateError, Result};
use crate::score::answers::Answers;
use places::ComparedAnswers;
use ranks::SideRanks;
use serde::Serialize;

/// What `edgegait parity` finds, as the JSON that it writes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ParityResults {
    #[serde(flatten)]
    pub header: ResultHeader,
    /// Whether all sides answer as the first.
    pub verdict: Verdict,
    /// Templates or sequences of silhouettes that each was shown.
    pub sequences: u64,
    /// People in them.
    pub people: usize,
    /// Viewpoints or cameras.
    pub viewpoints: usize,
    /// The protocol by which people are looked for.
    pub protocol: String,
    /// The sides, the reference first.
    pub sides: Vec<ParitySide>,
    /// Each of the others beside the reference.
    pub comparisons: Vec<Comparison>,
}

/// A side beside the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Comparison {
    /// The number of the side, from 0 for the reference.
    pub side: usize,
    pub verdict: Verdict,
    /// Why they differ; empty if they do not.
    pub reasons: Vec<String>,
    pub limits: Limits,
    /// Of embeddings; none if none is finite on both sides.
    pub embedding: Option<AnswerDifference>,
    /// Of class scores; none if there are none, they are the embedding, or none is finite.
    pub scores: Option<AnswerDifference>,
    /// None if the embeddings of a side cannot be ranked.
    pub ranks: Option<RankChanges>,
    /// Inputs at which they are farthest apart, those first that are not finite.
    pub worst: Vec<InputDifference>,
    /// By person, in the source's order.
    pub by_subject: Vec<ParityPart>,
    /// By viewpoint or camera.
    pub by_view: Vec<ParityPart>,
}

/// What sides answered to the same contest.
pub(crate) struct SideAnswers<'a> {
    contest: &'a Contest<'a>,
    asked: ContestAnswers,
    ranked: Vec<Option<SideRanks>>,
}

impl<'a> SideAnswers<'a> {
    /// Asks all sides, and ranks what they answer; `seen` is told of each picture.
    ///
    /// # Errors
    /// If the sides answer in different forms, and as [`Contest::run`]; a side of which nothing is
    /// finite is no error.
    pub(crate) fn of(
        contest: &'a Contest<'a>,
        entrants: &[Entrant],
        seed: u64,
        seen: &mut dyn FnMut(ShownPicture<'_>),
    ) -> Result<Self> {
        let asked = contest.ask(entrants, seen)?;
        let names: Vec<&str> = entrants.iter().map(|one| one.recognizer.name()).collect();
        for (answers, name) in asked.answers.iter().zip(&names).skip(1) {
            same_form(names[0], &asked.answers[0], name, answers)?;
        }
        let ranked = entrants.iter().zip(&asked.answers);
        let ranked =
            ranked.map(|(entrant, answers)| SideRanks::of(contest, entrant, answers, seed));
        Ok(Self {
            ranked: ranked.collect::<Result<_>>()?,
            contest,
            asked,
        })
    }

    /// Templates or sequences of silhouettes that each side was shown.
    pub(crate) const fn sequences(&self) -> u64 {
        self.asked.sequences
    }

    /// States of a side what it answered by itself.
    pub(crate) fn complete(&self, side: &mut ParitySide, at: usize) {
        let answers = &self.asked.answers[at];
        let numbers = || answers.embeddings.iter().chain(&answers.scores);
        side.numbers = numbers().count() as u64;
        side.non_finite = numbers().filter(|number| !number.is_finite()).count() as u64;
        side.rank1 = self.ranked[at].as_ref().map(|ranked| ranked.rank1);
    }

    /// A side beside the reference.
    pub(crate) fn compare(&self, sides: &[ParitySide], at: usize, limits: Limits) -> Comparison {
        let sequences = self.contest.source().sequences();
        let [reference, other] = [0, at].map(|side| &self.asked.answers[side]);
        let found = ComparedAnswers::of(reference, other, sequences.list.len());
        let ranks = self.ranked[0].as_ref().zip(self.ranked[at].as_ref());
        let mut comparison = Comparison {
            side: at,
            verdict: Verdict::Same,
            reasons: Vec::new(),
            limits,
            ranks: ranks.map(|(reference, other)| RankChanges::of(reference, other)),
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

/// Refuses answers that cannot be compared number by number.
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

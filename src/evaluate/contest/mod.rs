//! Recognizers against the same people, under one protocol.

mod baselines;
mod drawn;
mod entrant;
mod seen_in_training;

use super::paired;
use super::paired_results::PairedResult;
use super::protocol::{Decision, GalleryViews, Protocol, TakeRoles};
use super::results::{ProbeAnswer, RecognizerResult};
use super::totals::judge;
use super::trial::Trial;
use crate::error::{EvaluateError, Result};
use crate::score::Contract;
use crate::score::answers::{self, Answers, ask};
use crate::sequences::{SequenceSource, Shown};
use crate::sweep::{View, Views};
pub use baselines::Baselines;
pub use drawn::{ContestOptions, DrawnContest, usual};
pub use entrant::{Entrant, StoredTemplates};
use seen_in_training::SeenInTraining;

/// Most comparisons of two embeddings, or one with a class, in a contest: some minutes.
const MAX_COMPARISONS: u64 = 4_000_000_000;

/// People who are looked for, and how.
pub struct Contest<'a> {
    source: SequenceSource<'a>,
    protocol: Protocol,
    roles: TakeRoles,
}

/// What came of a contest.
pub struct ContestOutcome {
    /// Of each recognizer, in order.
    pub results: Vec<RecognizerResult>,
    /// How far they are apart.
    pub paired: Vec<PairedResult>,
    /// Sequences that were shown to any recognizer.
    pub sequences: u64,
    /// What was drawn for them.
    pub shown: Shown,
    /// What to know before trusting the results.
    pub warnings: Vec<String>,
}

/// What recognizers answered, before anybody judges it.
pub(crate) struct ContestAnswers {
    /// Of each recognizer, in order.
    pub answers: Vec<Answers>,
    /// Sequences that were shown to any of them.
    pub sequences: u64,
    /// What was drawn for them.
    pub shown: Shown,
}

/// A picture that a recognizer is shown.
#[derive(Clone, Copy, Debug)]
pub struct ShownPicture<'a> {
    /// Number of the sequence.
    pub sequence: usize,
    /// Number of the recognizer that takes it, the first of those who do.
    pub entrant: usize,
    /// Whether it is looked for, not known.
    pub is_probe: bool,
    /// Its bytes.
    pub bytes: &'a [u8],
}

/// The viewpoints of a recognizer's training, or the side view if it does not say.
///
/// # Errors
/// When its contract names angles that are no viewpoint.
pub fn training_views(contract: &Contract) -> Result<Vec<View>> {
    if contract.training.viewpoints.is_empty() {
        return Ok(Views::side()?.list);
    }
    let views = contract.training.viewpoints.iter();
    views.map(|&angles| View::at(angles.into())).collect()
}

impl<'a> Contest<'a> {
    /// A contest about the people of `source`.
    ///
    /// # Errors
    /// If none of its takes is known by or looked for.
    pub fn new(source: SequenceSource<'a>, protocol: Protocol) -> Result<Self> {
        let roles = protocol.roles(&source.sequences().takes)?;
        Ok(Self::with_roles(source, protocol, roles))
    }

    /// The same where it is known already which part each take has.
    const fn with_roles(source: SequenceSource<'a>, protocol: Protocol, roles: TakeRoles) -> Self {
        Self {
            source,
            protocol,
            roles,
        }
    }

    /// The people, for another contest.
    #[cfg(feature = "train")]
    #[must_use]
    pub(crate) fn into_source(self) -> SequenceSource<'a> {
        self.source
    }

    /// Who is looked for.
    #[must_use]
    pub const fn source(&self) -> &SequenceSource<'a> {
        &self.source
    }

    /// How they are looked for.
    #[must_use]
    pub const fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Shows all recognizers what they ask for, and judges their answers; `seed` draws people for
    /// intervals, `seen` is told of each picture, and `tell` of each answer.
    ///
    /// # Errors
    /// When a sequence cannot be shown, a recognizer fails, or there is too much to compare.
    pub fn run(
        &self,
        entrants: &[Entrant],
        seed: u64,
        seen: &mut dyn FnMut(ShownPicture<'_>),
        tell: &mut dyn FnMut(ProbeAnswer<'_>),
    ) -> Result<ContestOutcome> {
        let sequences = self.source.sequences();
        let asked = self.ask(entrants, seen)?;
        let trials = self.trials(entrants)?;
        let mut warnings = self.protocol.doubts(&sequences.takes, &self.roles);
        for (entrant, trial) in entrants.iter().zip(&trials) {
            if entrant.recognizer.is_baseline() {
                continue;
            }
            let contract = entrant.recognizer.contract();
            let seen = SeenInTraining::of(contract, sequences, |sequence| trial.is_probe(sequence));
            warnings.extend(seen.warnings(entrant.recognizer.name()));
        }
        let mut results = Vec::with_capacity(entrants.len());
        for (entrant, answers) in entrants.iter().zip(&asked.answers) {
            let result = self.judged(entrant, answers, seed, tell)?;
            if result.gallery_non_finite > 0 {
                warnings.push(format!(
                    "{}: {} embeddings of the gallery were not finite and left out",
                    result.name, result.gallery_non_finite
                ));
            }
            warnings.extend(doubts(&result));
            results.push(result);
        }
        Ok(ContestOutcome {
            paired: paired::each_from_each(&results, seed),
            results,
            sequences: asked.sequences,
            shown: asked.shown,
            warnings,
        })
    }

    /// What one recognizer's answers come to, as [`Self::run`] judges them.
    ///
    /// # Errors
    /// When nothing that it answered can be compared, or there is too much.
    pub(crate) fn judged(
        &self,
        entrant: &Entrant,
        answers: &Answers,
        seed: u64,
        tell: &mut dyn FnMut(ProbeAnswer<'_>),
    ) -> Result<RecognizerResult> {
        let recognizer = entrant.recognizer.as_ref();
        let trial = self.trial(recognizer.contract())?;
        judge(recognizer, &trial, answers, seed, tell)
    }

    /// Shows all recognizers what they ask for; `seen` is told of each picture.
    ///
    /// # Errors
    /// When a sequence cannot be shown, a recognizer fails, or there is too much to compare.
    pub(crate) fn ask(
        &self,
        entrants: &[Entrant],
        seen: &mut dyn FnMut(ShownPicture<'_>),
    ) -> Result<ContestAnswers> {
        let sequences = self.source.sequences();
        let trials = self.trials(entrants)?;
        let mut answers = vec![Answers::default(); entrants.len()];
        let mut shown: Option<Shown> = None;
        let mut all = vec![false; sequences.list.len()];
        for first in 0..entrants.len() {
            let form = entrants[first].form();
            let group: Vec<usize> = (first..entrants.len())
                .filter(|&at| entrants[at].form() == form)
                .collect();
            if entrants[..first].iter().any(|other| other.form() == form) {
                continue;
            }
            let wanted: Vec<usize> = (0..sequences.list.len())
                .filter(|&sequence| group.iter().any(|&at| trials[at].needs(sequence)))
                .collect();
            wanted.iter().for_each(|&sequence| all[sequence] = true);
            let needs = |at: usize| {
                let trial = &trials[at];
                move |sequence: usize| trial.needs(sequence)
            };
            let needs: Vec<_> = group.iter().map(|&at| needs(at)).collect();
            let recognizers: Vec<answers::Questioned<'_>> = { group.iter() }
                .zip(&needs)
                .map(|(&at, needs)| (entrants[at].recognizer.as_ref(), needs as _))
                .collect();
            let mut tell = |sequence: usize, bytes: &[u8]| {
                seen(ShownPicture {
                    sequence,
                    entrant: first,
                    is_probe: trials[first].is_probe(sequence),
                    bytes,
                });
            };
            let (found, now) = ask(&recognizers, &self.source, &wanted, &form, &mut tell)?;
            shown = Some(shown.map_or(now, |before| before.and(now)));
            for (&at, found) in group.iter().zip(found) {
                answers[at] = found;
            }
        }
        Ok(ContestAnswers {
            answers,
            sequences: all.iter().filter(|is_shown| **is_shown).count() as u64,
            shown: shown.unwrap_or_default(),
        })
    }

    /// Who is compared with whom by each of them.
    fn trials(&self, entrants: &[Entrant]) -> Result<Vec<Trial<'_>>> {
        let contracts = entrants.iter().map(|entrant| entrant.recognizer.contract());
        contracts.map(|contract| self.trial(contract)).collect()
    }

    /// Who is compared with whom by one recognizer.
    fn trial(&self, contract: &Contract) -> Result<Trial<'_>> {
        let sequences = self.source.sequences();
        let classes = match self.protocol.decision {
            Decision::NearestEmbedding => None,
            Decision::ClassScore => Some(classes_of(contract, &sequences.subjects)?),
        };
        let gallery_views = match self.protocol.gallery_views {
            GalleryViews::Training => Some(training_views(contract)?),
            _ => None,
        };
        let trial = Trial::new(
            &self.protocol,
            &self.roles,
            sequences,
            classes,
            gallery_views,
        )?;
        let comparisons = trial.comparisons();
        if comparisons > MAX_COMPARISONS {
            return Err(EvaluateError::TooManyComparisons {
                protocol: self.protocol.name.clone(),
                found: comparisons,
                most: MAX_COMPARISONS,
            }
            .into());
        }
        Ok(trial)
    }
}

/// What to know about a recognizer's result.
fn doubts(result: &RecognizerResult) -> Vec<String> {
    let mut doubts = Vec::new();
    for set in &result.probe_sets {
        let name = format!("{}, probe set {}", result.name, set.name);
        if set.tied > 0 {
            doubts.push(format!(
                "{name}: {} of {} answers are as near to another as to the right person; the one listed first counts",
                set.tied, set.probes
            ));
        }
        if set.probes > 0 && set.without_mate == set.probes {
            doubts.push(format!(
                "{name}: nobody who is looked for is in the gallery, so that all are misses (has everybody more than one take? walks and conditions tell them apart)"
            ));
        }
        if set.people == 1 {
            doubts.push(format!("{name}: it is of one person only"));
        }
    }
    if result.classes == 1 {
        doubts.push(format!(
            "{}: there is one person to choose from",
            result.name
        ));
    }
    doubts
}

/// The class of each person.
fn classes_of(contract: &Contract, subjects: &[String]) -> Result<Vec<usize>> {
    let class = |subject: &String| {
        let found = contract.classes.iter().position(|class| class == subject);
        found.ok_or_else(|| {
            EvaluateError::NoClass {
                model: contract.name.clone(),
                subject: subject.clone(),
            }
            .into()
        })
    };
    subjects.iter().map(class).collect()
}

#[cfg(test)]
mod tests;

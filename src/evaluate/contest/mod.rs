//! Contests: recognizers evaluated on the same people, under one protocol.

mod baselines;
mod drawn;
mod entrant;
mod seen_in_training;

use super::paired;
use super::paired_results::PairedResult;
use super::protocol::{Decision, GalleryViews, Protocol, TakeRoles};
use super::results::{ProbeAnswer, RecognizerResult};
use super::totals::judge;
use super::trial::{Trial, TrialTerms};
use crate::dataset::sequences::{SequencePurpose, SequenceSource, Sequences, ShownCounts};
use crate::draw::sweep::{View, Views};
use crate::draw::template::Template;
use crate::error::{EvaluateError, Result};
use crate::inference::Contract;
use crate::inference::answers::{self, Answers, ask};
pub use baselines::{BaselineKind, Baselines};
pub(crate) use drawn::unlike_protocols;
pub use drawn::{ContestOptions, DrawnContest, usual};
pub use entrant::{Entrant, StoredTemplates};
use seen_in_training::SeenInTraining;
use std::fmt;

/// The maximum number of comparisons in a contest, of two embeddings or of one with a class: some
/// minutes.
const MAX_COMPARISONS: u64 = 4_000_000_000;

/// An evaluation run: the sequences of people, and the protocol that divides them into gallery and
/// probes.
pub struct Contest<'a> {
    source: SequenceSource<'a>,
    protocol: Protocol,
    roles: TakeRoles,
}

/// The outcome of a contest.
pub struct ContestOutcome {
    /// The result of each recognizer, in order.
    pub results: Vec<RecognizerResult>,
    /// Paired differences between the recognizers.
    pub paired: Vec<PairedResult>,
    /// Number of sequences that were shown to any recognizer.
    pub sequences: u64,
    /// Totals of the silhouettes that were shown.
    pub shown: ShownCounts,
    /// Caveats for the results.
    pub warnings: Vec<ContestWarning>,
}

/// A caveat for the results of a contest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContestWarning {
    /// The recognizer that it is about as a whole; otherwise the text names what it is about.
    pub recognizer: Option<String>,
    /// The caveat.
    pub text: String,
}

impl ContestWarning {
    fn general(text: String) -> Self {
        Self {
            recognizer: None,
            text,
        }
    }

    fn about(recognizer: &str, text: impl Into<String>) -> Self {
        Self {
            recognizer: Some(recognizer.to_owned()),
            text: text.into(),
        }
    }
}

impl fmt::Display for ContestWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(recognizer) = &self.recognizer {
            write!(f, "{recognizer}: ")?;
        }
        f.write_str(&self.text)
    }
}

/// The raw answers of recognizers, before they are judged.
pub(crate) struct ContestAnswers {
    /// The answers of each recognizer, in order.
    pub answers: Vec<Answers>,
    /// Number of sequences that were shown to any recognizer.
    pub sequences: u64,
    /// Totals of the silhouettes that were shown.
    pub shown: ShownCounts,
}

/// A picture that a recognizer is shown.
#[derive(Clone, Copy, Debug)]
pub struct ShownPicture<'a> {
    /// Number of the sequence.
    pub sequence: usize,
    /// Number of the first recognizer that takes this picture.
    pub entrant: usize,
    /// Whether the picture is a probe rather than an entry of the gallery.
    pub is_probe: bool,
    /// The picture's bytes.
    pub bytes: &'a [u8],
}

/// Returns the viewpoints of a recognizer's training, or the side view if its contract states none.
///
/// # Errors
/// If its contract names angles that are not a viewpoint.
pub fn training_views(contract: &Contract) -> Result<Vec<View>> {
    if contract.training.viewpoints.is_empty() {
        return Ok(Views::side()?.list);
    }
    let views = contract.training.viewpoints.iter();
    views.map(|&angles| View::at(angles.into())).collect()
}

impl<'a> Contest<'a> {
    /// Creates a contest with the people of `source`.
    ///
    /// # Errors
    /// If no take is in the gallery or no take is a probe.
    pub fn new(source: SequenceSource<'a>, protocol: Protocol) -> Result<Self> {
        let roles = protocol.roles(&source.sequences().takes)?;
        Ok(Self::with_roles(source, protocol, roles))
    }

    /// Creates a contest with takes whose roles are already known.
    const fn with_roles(source: SequenceSource<'a>, protocol: Protocol, roles: TakeRoles) -> Self {
        Self {
            source,
            protocol,
            roles,
        }
    }

    /// Returns the source of sequences, for another contest.
    #[cfg(feature = "train")]
    #[must_use]
    pub(crate) fn into_source(self) -> SequenceSource<'a> {
        self.source
    }

    /// Returns the source of sequences.
    #[must_use]
    pub const fn source(&self) -> &SequenceSource<'a> {
        &self.source
    }

    /// Returns the protocol.
    #[must_use]
    pub const fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Shows the sequences to all recognizers, and judges their answers. `seed` is the seed for
    /// resampling people, `seen` is called for each picture, and `tell` for each answer.
    ///
    /// # Errors
    /// If a sequence cannot be shown, a recognizer fails, or there are too many comparisons.
    pub fn run(
        &self,
        entrants: &[Entrant],
        seed: u64,
        seen: &mut dyn FnMut(ShownPicture<'_>) -> Result<()>,
        tell: &mut dyn FnMut(ProbeAnswer<'_>) -> Result<()>,
    ) -> Result<ContestOutcome> {
        let sequences = self.source.sequences();
        let asked = self.ask(entrants, seen)?;
        let trials = self.trials(entrants)?;
        let doubts = self.protocol.doubts(&sequences.takes, &self.roles);
        let mut warnings: Vec<_> = doubts.into_iter().map(ContestWarning::general).collect();
        warnings.extend(unlike_probes(entrants, sequences).map(ContestWarning::general));
        for (entrant, trial) in entrants.iter().zip(&trials) {
            if entrant.recognizer.is_baseline() {
                continue;
            }
            let contract = entrant.recognizer.contract();
            let seen =
                SeenInTraining::compare(contract, sequences, |sequence| trial.is_probe(sequence));
            let about = |text| ContestWarning::about(entrant.recognizer.name(), text);
            warnings.extend(seen.warnings().map(about));
        }
        let mut results = Vec::with_capacity(entrants.len());
        for (entrant, answers) in entrants.iter().zip(&asked.answers) {
            let result = self.judged(entrant, answers, seed, tell)?;
            if result.gallery_non_finite > 0 {
                let count = result.gallery_non_finite;
                let text =
                    format!("{count} embeddings of the gallery were not finite and were left out");
                warnings.push(ContestWarning::about(&result.name, text));
            }
            warnings.extend(caveats(&result));
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

    /// Judges the answers of one recognizer, as [`Self::run`] does.
    ///
    /// # Errors
    /// If none of its answers can be compared, or there are too many comparisons.
    pub(crate) fn judged(
        &self,
        entrant: &Entrant,
        answers: &Answers,
        seed: u64,
        tell: &mut dyn FnMut(ProbeAnswer<'_>) -> Result<()>,
    ) -> Result<RecognizerResult> {
        let recognizer = entrant.recognizer.as_ref();
        let trial = self.trial(recognizer.contract())?;
        judge(recognizer, &trial, answers, seed, tell)
    }

    /// Shows the sequences to all recognizers; `seen` is called for each picture.
    ///
    /// # Errors
    /// If a sequence cannot be shown, a recognizer fails, or there are too many comparisons.
    pub(crate) fn ask(
        &self,
        entrants: &[Entrant],
        seen: &mut dyn FnMut(ShownPicture<'_>) -> Result<()>,
    ) -> Result<ContestAnswers> {
        let sequences = self.source.sequences();
        let trials = self.trials(entrants)?;
        let mut answers = vec![Answers::default(); entrants.len()];
        let mut shown: Option<ShownCounts> = None;
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
            let recognizers: Vec<answers::RecognizerNeeds<'_>> = { group.iter() }
                .zip(&needs)
                .map(|(&at, needs)| answers::RecognizerNeeds {
                    recognizer: entrants[at].recognizer.as_ref(),
                    needs,
                })
                .collect();
            let mut tell = |sequence: usize, bytes: &[u8]| {
                seen(ShownPicture {
                    sequence,
                    entrant: first,
                    is_probe: trials[first].is_probe(sequence),
                    bytes,
                })
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

    /// Returns the comparisons of each recognizer.
    fn trials(&self, entrants: &[Entrant]) -> Result<Vec<Trial<'_>>> {
        let contracts = entrants.iter().map(|entrant| entrant.recognizer.contract());
        contracts.map(|contract| self.trial(contract)).collect()
    }

    /// Returns the comparisons of one recognizer.
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
        let terms = TrialTerms {
            template: contract.template,
            classes,
            gallery_views,
        };
        let trial = Trial::new(&self.protocol, &self.roles, sequences, terms)?;
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

/// Returns why some recognizers have other probes than others, if they have.
fn unlike_probes(entrants: &[Entrant], sequences: &Sequences) -> Option<String> {
    let mut purposes = sequences.list.iter().map(|sequence| sequence.purpose);
    purposes.find(|purpose| *purpose == SequencePurpose::Silhouettes)?;
    let names = |of_silhouettes: bool| {
        let takes = |entrant: &&Entrant| {
            let recognizer = &entrant.recognizer;
            let is_of = recognizer.contract().template == Template::Silhouettes;
            !recognizer.is_baseline() && is_of == of_silhouettes
        };
        let names = entrants.iter().filter(takes);
        let names: Vec<&str> = names.map(|entrant| entrant.recognizer.name()).collect();
        names.join(", ")
    };
    Some(format!(
        "probes are whole recordings for {}, which take silhouettes, and their gait cycles for {}, which take templates: only recognizers with the same probes are compared with each other",
        names(true),
        names(false)
    ))
}

/// Returns the caveats of a recognizer's result.
fn caveats(result: &RecognizerResult) -> Vec<ContestWarning> {
    let mut caveats = Vec::new();
    for set in &result.probe_sets {
        let mut add = |text: &str| {
            let text = format!("{}, probe set {}: {text}", result.name, set.name);
            caveats.push(ContestWarning::general(text));
        };
        if set.tied > 0 {
            add(&format!(
                "{} of {} answers are as near to another person as to the right one; ties go to the person listed first",
                set.tied, set.probes
            ));
        }
        if set.probes > 0 && set.without_mate == set.probes {
            add(
                "no probe's person is in the gallery, so all probes are misses (does everybody have more than one take? takes differ in walk or condition)",
            );
        }
        if set.people == 1 {
            add("its probes are of one person only");
        }
    }
    if result.classes == 1 {
        let text = "there is only one person to choose from";
        caveats.push(ContestWarning::about(&result.name, text));
    }
    caveats
}

/// Returns the class of each person.
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

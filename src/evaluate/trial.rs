//! Comparisons of probes with the gallery under a protocol, and their outcomes.

use super::identification::{ProbeRank, rank};
use super::protocol::{GalleryViews, Protocol, TakeRoles};
use super::rank1::ProbeOutcome;
use super::results::ProbeAnswer;
use super::verification::Pairs;
use crate::dataset::sequences::{SequencePurpose, Sequences, ViewLabel};
use crate::draw::sweep::View;
use crate::draw::template::Template;
use crate::error::{EvaluateError, Result};
use crate::inference::Recognizer;
use crate::inference::answers::Answers;
use std::ops::Neg;

/// The maximum number of viewpoints of which all pairs are compared.
const MAX_CROSS_VIEWS: usize = 1024;

/// The comparisons of one recognizer under a protocol.
#[derive(Debug)]
pub(crate) struct Trial<'a> {
    pub(super) protocol: &'a Protocol,
    pub(super) roles: &'a TakeRoles,
    pub(super) sequences: &'a Sequences,
    /// The template that the recognizer takes.
    pub(super) template: Template,
    /// The class of each person, if class scores decide.
    pub(super) classes: Option<Vec<usize>>,
    /// Sequences of the gallery by viewpoint, in rising order.
    pub(super) gallery: Vec<Vec<usize>>,
}

/// What the comparisons of a recognizer depend on, besides the protocol and the sequences.
pub(super) struct TrialTerms {
    /// The template that it takes.
    pub template: Template,
    /// The class of each person, if class scores decide.
    pub classes: Option<Vec<usize>>,
    /// The viewpoints of its gallery, beside all cameras with a name only; none for all.
    pub gallery_views: Option<Vec<View>>,
}

/// The comparison of one probe with one gallery.
pub(super) struct ProbeComparison {
    /// The gallery's viewpoint, if each is compared separately.
    pub gallery_view: Option<usize>,
    pub ranked: ProbeRank,
    /// Number of the nearest person (or class), and its distance.
    pub nearest: Option<(usize, f64)>,
    /// Distance of the right person.
    pub right: Option<f64>,
    /// Whether the right person and another one are equally near.
    pub is_tied: bool,
    pub pairs: Pairs,
}

impl ProbeComparison {
    pub(super) fn outcome(&self) -> ProbeOutcome {
        match self.ranked {
            ProbeRank::Found {
                strangers_before: 0,
                ..
            } => ProbeOutcome::Hit,
            ProbeRank::Found { .. } | ProbeRank::NoMate => ProbeOutcome::Miss,
            ProbeRank::NonFinite => ProbeOutcome::NonFinite,
        }
    }
}

impl<'a> Trial<'a> {
    /// Returns the comparisons, which depend on nothing but these arguments: not on the other
    /// recognizers.
    ///
    /// # Errors
    /// If the gallery is empty, or there are too many viewpoints to compare all pairs.
    pub(super) fn new(
        protocol: &'a Protocol,
        roles: &'a TakeRoles,
        sequences: &'a Sequences,
        terms: TrialTerms,
    ) -> Result<Self> {
        let TrialTerms {
            template,
            classes,
            gallery_views,
        } = terms;
        let is_seen = |label: &ViewLabel| match (&gallery_views, label.angles_deg()) {
            (Some(views), Some(at)) => views.iter().any(|view| view.angles_deg() == at),
            _ => true,
        };
        let mut gallery = vec![Vec::new(); sequences.views.len()];
        for (number, sequence) in sequences.list.iter().enumerate() {
            if roles.gallery[sequence.take]
                && sequence.purpose.suits(template)
                && is_seen(&sequences.views[sequence.view])
            {
                gallery[sequence.view].push(number);
            }
        }
        if classes.is_none() && gallery.iter().all(Vec::is_empty) {
            return Err(EvaluateError::NobodyEnrolled(protocol.name.clone()).into());
        }
        let views = sequences.views.len();
        if protocol.gallery_views == GalleryViews::Each && views > MAX_CROSS_VIEWS {
            return Err(EvaluateError::TooManyViews {
                protocol: protocol.name.clone(),
                found: views,
                most: MAX_CROSS_VIEWS,
            }
            .into());
        }
        Ok(Self {
            protocol,
            roles,
            sequences,
            template,
            classes,
            gallery,
        })
    }

    /// Returns whether a sequence is a probe.
    #[must_use]
    pub(crate) fn is_probe(&self, sequence: usize) -> bool {
        let found = &self.sequences.list[sequence];
        found.purpose != SequencePurpose::Gallery
            && found.purpose.suits(self.template)
            && self.roles.is_probed(found.take)
    }

    /// Returns the probes.
    pub(crate) fn probes(&self) -> impl Iterator<Item = usize> {
        (0..self.sequences.list.len()).filter(|&sequence| self.is_probe(sequence))
    }

    /// Returns whether the recognizer has to be shown a sequence.
    #[must_use]
    pub(crate) fn needs(&self, sequence: usize) -> bool {
        let view = self.sequences.list[sequence].view;
        self.is_probe(sequence) || self.gallery[view].binary_search(&sequence).is_ok()
    }

    /// Returns an upper bound of the number of comparisons, of two embeddings or of one with a
    /// class.
    #[must_use]
    pub(crate) fn comparisons(&self) -> u64 {
        let all: usize = self.gallery.iter().map(Vec::len).sum();
        let of_probe = |sequence: usize| match (&self.classes, self.protocol.gallery_views) {
            (Some(classes), _) => classes.len(),
            (None, GalleryViews::Same) => self.gallery[self.sequences.list[sequence].view].len(),
            (None, _) => all,
        };
        let probes = self.probes();
        probes.map(|sequence| of_probe(sequence) as u64).sum()
    }

    /// Returns the galleries of a probe: lists of sequences, each with its viewpoint if viewpoints
    /// are compared separately.
    fn galleries(&self, probe: usize) -> Vec<(Option<usize>, Vec<usize>)> {
        let own = &self.sequences.list[probe];
        // The same recording, under any condition.
        let takes = &self.sequences.takes;
        let is_own = |other: usize| {
            other == own.take
                || (takes[other].subject, &takes[other].name)
                    == (takes[own.take].subject, &takes[own.take].name)
        };
        let kept = |&other: &usize| {
            let other_take = self.sequences.list[other].take;
            other != probe && !(self.protocol.exclude_own_take && is_own(other_take))
        };
        let of_view = |view: usize| self.gallery[view].iter().copied().filter(kept);
        match self.protocol.gallery_views {
            GalleryViews::Each => (0..self.gallery.len())
                .filter(|&view| !self.gallery[view].is_empty())
                .map(|view| (Some(view), of_view(view).collect()))
                .collect(),
            GalleryViews::Same => vec![(None, of_view(own.view).collect())],
            GalleryViews::All | GalleryViews::Training => {
                vec![(None, (0..self.gallery.len()).flat_map(of_view).collect())]
            }
        }
    }

    /// Compares a probe with its galleries.
    pub(super) fn meet(
        &self,
        recognizer: &dyn Recognizer,
        answers: &Answers,
        probe: usize,
        keep_pairs: bool,
    ) -> Vec<ProbeComparison> {
        let person = self.sequences.subject(probe);
        let meeting = |gallery_view, distances: Vec<f64>, label: &dyn Fn(usize) -> usize, right| {
            let is_mate = |at: usize| label(at) == right;
            let ranked = rank(&distances, is_mate);
            let own_view = gallery_view == Some(self.sequences.list[probe].view);
            let nearest = |of_mate: bool| {
                let all = distances.iter().copied().enumerate();
                let of = all.filter(|(at, _)| is_mate(*at) == of_mate);
                of.reduce(|best, next| if next.1 < best.1 { next } else { best })
            };
            let (mate, stranger) = match ranked {
                ProbeRank::NonFinite => (None, None),
                _ => (nearest(true), nearest(false)),
            };
            let is_tied = mate.zip(stranger).is_some_and(|(a, b)| a.1 == b.1);
            // Ties go to the one listed first.
            let both = mate.into_iter().chain(stranger);
            let first = both.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            let mut pairs = Pairs::default();
            if keep_pairs && !own_view {
                for (at, distance) in distances.into_iter().enumerate() {
                    if is_mate(at) {
                        pairs.genuine.push(distance);
                    } else {
                        pairs.impostor.push(distance);
                    }
                }
            }
            ProbeComparison {
                gallery_view,
                ranked,
                nearest: first.map(|(at, distance)| (label(at), distance)),
                right: mate.map(|(_, distance)| distance),
                is_tied,
                pairs,
            }
        };
        if let Some(classes) = &self.classes {
            // The higher a score, the nearer the class.
            let distances = answers.scores(probe).iter().map(|&score| -f64::from(score));
            let right = classes[person];
            return vec![meeting(None, distances.collect(), &|class| class, right)];
        }
        let contract = recognizer.contract();
        let seen_from = self.sequences.view_label(probe).angles_deg();
        let (embedding, seen_from) = (answers.embedding(probe), contract.view_number(seen_from));
        let of = |(view, gallery): (Option<usize>, Vec<usize>)| {
            let label = |at: usize| self.sequences.subject(gallery[at]);
            let others = gallery.iter().map(|&other| answers.embedding(other));
            let others: Vec<&[f32]> = others.collect();
            let distance = contract.distance;
            let distances =
                distance.over_gallery(embedding, seen_from, &others, &label, answers.parts);
            meeting(view, distances, &label, person)
        };
        self.galleries(probe).into_iter().map(of).collect()
    }

    /// Returns the name of the wrong person that a recognizer identified a probe as, if it is a
    /// miss.
    pub(super) fn taken_for<'s>(
        &'s self,
        recognizer: &'s dyn Recognizer,
        meeting: &ProbeComparison,
    ) -> Option<&'s str> {
        if meeting.outcome() != ProbeOutcome::Miss {
            return None;
        }
        let names = match self.classes {
            Some(_) => &recognizer.contract().classes,
            None => &self.sequences.subjects,
        };
        let (label, _) = meeting.nearest?;
        names.get(label).map(String::as_str)
    }

    /// Returns a recognizer's answer to a probe.
    pub(super) fn answered<'s>(
        &'s self,
        recognizer: &'s dyn Recognizer,
        probe_set: &'s str,
        probe: usize,
        meeting: &ProbeComparison,
    ) -> ProbeAnswer<'s> {
        let sequence = &self.sequences.list[probe];
        let take = &self.sequences.takes[sequence.take];
        let origin = self.sequences.origin(probe);
        let seen = self.sequences.view_label(probe);
        let gallery = meeting.gallery_view.map(|view| &self.sequences.views[view]);
        let gallery_at = gallery.and_then(ViewLabel::angles_deg);
        let names = match self.classes {
            Some(_) => &recognizer.contract().classes,
            None => &self.sequences.subjects,
        };
        let answer = meeting.nearest.and_then(|(label, _)| names.get(label));
        let nearest = meeting.nearest.map(|(_, distance)| distance);
        let by_distance = self.classes.is_none();
        ProbeAnswer {
            sequence: probe,
            recognizer: recognizer.name(),
            probe_set,
            subject: &self.sequences.subjects[take.subject],
            take: &take.name,
            walk: &origin.walk,
            cycle: origin.cycle,
            variation: origin.variation,
            azimuth_deg: seen.angles_deg().map(|at| at.0),
            elevation_deg: seen.angles_deg().map(|at| at.1),
            view: seen.name(),
            gallery_azimuth_deg: gallery_at.map(|at| at.0),
            gallery_elevation_deg: gallery_at.map(|at| at.1),
            gallery_view: gallery.and_then(ViewLabel::name),
            answer: answer.map(String::as_str),
            distance: by_distance.then_some(nearest).flatten(),
            right_distance: by_distance.then_some(meeting.right).flatten(),
            score: (!by_distance).then_some(nearest).flatten().map(Neg::neg),
            right_score: (!by_distance)
                .then_some(meeting.right)
                .flatten()
                .map(Neg::neg),
            rank: match meeting.ranked {
                ProbeRank::Found {
                    strangers_before, ..
                } => Some(strangers_before + 1),
                ProbeRank::NoMate | ProbeRank::NonFinite => None,
            },
        }
    }
}

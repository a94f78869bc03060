//! Recognizers against the same probes, under one protocol.
//!
//! People whom every recognizer has a class for are recognized by the highest class
//! score. Otherwise they are enrolled first, and the nearest embedding decides.

use super::rank::{Gallery, Outcome, Tally, closed_set};
use super::results::{Contestant, Protocol, RecognizerResult};
use crate::error::{Error, Result};
use crate::score::{Outputs, Recognizer};
use crate::sweep::{View, Views};
use std::collections::HashMap;

/// Most GEIs given to a recognizer at once: 3 MB of input at 50x30, 8 MB at 64x64.
const BATCH: usize = 512;

/// Recognizers and what they have achieved so far.
pub struct Contest<'a> {
    people: Vec<String>,
    protocol: Protocol,
    entrants: Vec<Entrant<'a>>,
    /// Viewpoints in order of first appearance, by the bits of their angles.
    viewpoints: HashMap<(u64, u64), usize>,
    angles: Vec<(f64, f64)>,
}

struct Entrant<'a> {
    recognizer: &'a dyn Recognizer,
    /// The class of each person.
    classes: Vec<usize>,
    enrolled: Vec<f32>,
    labels: Vec<usize>,
    gallery: Option<Gallery>,
    by_viewpoint: Vec<Tally>,
    by_person: Vec<Tally>,
}

impl<'a> Contest<'a> {
    /// A contest about these people; names may repeat.
    #[must_use]
    pub fn new<'n>(
        recognizers: &'a [Box<dyn Recognizer>],
        people: impl IntoIterator<Item = &'n str>,
    ) -> Self {
        let mut names: Vec<String> = Vec::new();
        for name in people {
            if !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        let knows = |recognizer: &dyn Recognizer, name: &String| {
            let classes = &recognizer.contract().classes;
            classes.iter().position(|class| class == name)
        };
        let closed = recognizers.iter().all(|recognizer| {
            names
                .iter()
                .all(|name| knows(recognizer.as_ref(), name).is_some())
        });
        let entrants = recognizers.iter().map(|recognizer| Entrant {
            recognizer: recognizer.as_ref(),
            classes: names
                .iter()
                .filter_map(|name| knows(recognizer.as_ref(), name))
                .collect(),
            enrolled: Vec::new(),
            labels: Vec::new(),
            gallery: None,
            by_viewpoint: Vec::new(),
            by_person: vec![Tally::default(); names.len()],
        });
        Self {
            entrants: entrants.collect(),
            people: names,
            protocol: if closed {
                Protocol::ClassScore
            } else {
                Protocol::NearestEmbedding
            },
            viewpoints: HashMap::new(),
            angles: Vec::new(),
        }
    }

    /// Whether class scores decide, so that nobody needs to be enrolled.
    #[must_use]
    pub fn is_closed_set(&self) -> bool {
        self.protocol == Protocol::ClassScore
    }

    /// From where the people are enrolled for a recognizer: its training viewpoints, or the
    /// side view if it does not say.
    ///
    /// # Errors
    /// When its contract names angles that are no viewpoint.
    pub fn gallery_views(&self, recognizer: usize) -> Result<Vec<View>> {
        let contract = self.entrants[recognizer].recognizer.contract();
        if contract.training.viewpoints.is_empty() {
            return Ok(Views::side()?.list);
        }
        let views = contract.training.viewpoints.iter();
        #[expect(clippy::cast_possible_truncation, reason = "degrees")]
        views
            .map(|&[azimuth, elevation]| View::new(azimuth as f32, elevation as f32))
            .collect()
    }

    /// Adds GEIs of a person to a recognizer's gallery.
    ///
    /// # Errors
    /// When the recognizer fails, or the person is not in the contest.
    pub fn enrol<'g>(
        &mut self,
        recognizer: usize,
        person: &str,
        geis: impl IntoIterator<Item = &'g [u8]>,
    ) -> Result<()> {
        let label = self.person(person)?;
        let entrant = &mut self.entrants[recognizer];
        let geis: Vec<&[u8]> = geis.into_iter().collect();
        for batch in geis.chunks(BATCH) {
            let outputs = run(entrant.recognizer, batch)?;
            entrant.enrolled.extend(outputs.embedding);
            entrant
                .labels
                .extend(std::iter::repeat_n(label, batch.len()));
        }
        Ok(())
    }

    /// Ends enrolment.
    ///
    /// # Errors
    /// When nobody was enrolled, or an enrolled embedding is not finite.
    pub fn close_gallery(&mut self) -> Result<()> {
        for entrant in &mut self.entrants {
            let labels = std::mem::take(&mut entrant.labels);
            let enrolled = std::mem::take(&mut entrant.enrolled);
            if labels.is_empty() {
                return Err(Error::Failed(format!(
                    "nobody is enrolled for {}: expected GEIs at its training viewpoints",
                    entrant.recognizer.name()
                )));
            }
            let width = enrolled.len() / labels.len();
            let gallery = Gallery::new(enrolled, width, labels);
            entrant.gallery = Some(gallery.map_err(|error| {
                Error::Failed(format!("{}: {error}", entrant.recognizer.name()))
            })?);
        }
        Ok(())
    }

    /// Shows GEIs of a person, one for each viewpoint ((azimuth, elevation) in degrees), to
    /// all recognizers.
    ///
    /// # Errors
    /// When a recognizer fails, or the person is not in the contest.
    pub fn probe<'g>(
        &mut self,
        person: &str,
        viewpoints: impl IntoIterator<Item = (f64, f64)>,
        geis: impl IntoIterator<Item = &'g [u8]>,
    ) -> Result<()> {
        let person = self.person(person)?;
        let places: Vec<usize> = viewpoints
            .into_iter()
            .map(|at| self.viewpoint(at))
            .collect();
        let geis: Vec<&[u8]> = geis.into_iter().collect();
        let viewpoints = self.angles.len();
        for entrant in &mut self.entrants {
            entrant.by_viewpoint.resize(viewpoints, Tally::default());
            for (places, batch) in places.chunks(BATCH).zip(geis.chunks(BATCH)) {
                let outputs = run(entrant.recognizer, batch)?;
                for (index, &place) in places.iter().enumerate() {
                    let outcome = entrant.outcome(&outputs, index, person);
                    entrant.by_viewpoint[place].add(outcome);
                    entrant.by_person[person].add(outcome);
                }
            }
        }
        Ok(())
    }

    /// The results of all recognizers; `seed` draws people for their interval.
    #[must_use]
    pub fn results(&self, seed: u64) -> Vec<RecognizerResult> {
        let of = |entrant: &Entrant<'_>| {
            let contract = entrant.recognizer.contract();
            let contestant = Contestant {
                name: entrant.recognizer.name().to_owned(),
                runtime: entrant.recognizer.runtime().clone(),
                protocol: self.protocol,
                classes: match self.protocol {
                    Protocol::ClassScore => contract.classes.len(),
                    _ => self.people.len(),
                },
                trained_at: contract
                    .training
                    .viewpoints
                    .iter()
                    .map(|&[a, e]| (a, e))
                    .collect(),
            };
            let tallies: Vec<_> = self
                .angles
                .iter()
                .copied()
                .zip(entrant.by_viewpoint.iter().copied())
                .collect();
            // People who were never probed say nothing about the spread between people.
            let people: Vec<Tally> = entrant
                .by_person
                .iter()
                .copied()
                .filter(|tally| *tally != Tally::default())
                .collect();
            RecognizerResult::new(contestant, &tallies).with_subjects(&people, seed)
        };
        self.entrants.iter().map(of).collect()
    }

    fn person(&self, name: &str) -> Result<usize> {
        let found = self.people.iter().position(|person| person == name);
        found.ok_or_else(|| Error::Failed(format!("{name:?} is not among the people scored")))
    }

    fn viewpoint(&mut self, at: (f64, f64)) -> usize {
        let key = (at.0.to_bits(), at.1.to_bits());
        *self.viewpoints.entry(key).or_insert_with(|| {
            self.angles.push(at);
            self.angles.len() - 1
        })
    }
}

impl Entrant<'_> {
    /// Whether one row of the outputs is right.
    fn outcome(&self, outputs: &Outputs, row: usize, person: usize) -> Outcome {
        let slice = |numbers: &[f32], width: usize| {
            numbers
                .get(row * width..(row + 1) * width)
                .unwrap_or_default()
                .to_vec()
        };
        match (&self.gallery, &outputs.scores) {
            (Some(gallery), _) => {
                gallery.identify(&slice(&outputs.embedding, outputs.embedding_dims), person)
            }
            (None, Some(scores)) => {
                closed_set(&slice(scores, outputs.classes), self.classes[person])
            }
            // A model with classes and without scores answers nothing.
            (None, None) => Outcome::Miss,
        }
    }
}

/// Runs a recognizer on bytes.
///
/// # Errors
/// When the recognizer fails.
pub fn run(recognizer: &dyn Recognizer, geis: &[&[u8]]) -> Result<Outputs> {
    let range = recognizer.contract().input_range;
    let mut input = Vec::with_capacity(geis.len() * recognizer.contract().pixels());
    for gei in geis {
        input.extend(gei.iter().map(|&byte| range.of_byte(byte)));
    }
    recognizer.run(&input, geis.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::{Contract, InputRange, RuntimeName};

    /// Answers with the first two pixels of a GEI, as embedding and as class scores.
    struct FirstTwoPixels {
        contract: Contract,
        runtime: RuntimeName,
    }

    impl Recognizer for FirstTwoPixels {
        fn runtime(&self) -> &RuntimeName {
            &self.runtime
        }

        fn contract(&self) -> &Contract {
            &self.contract
        }

        fn run(&self, geis: &[f32], _batch: usize) -> Result<Outputs> {
            let two: Vec<f32> = geis
                .chunks(self.contract.pixels())
                .flat_map(|gei| [gei[0], gei[1]])
                .map(|pixel| if pixel == 13.0 { f32::NAN } else { pixel })
                .collect();
            Ok(Outputs {
                scores: Some(two.clone()),
                embedding: two,
                embedding_dims: 2,
                classes: 2,
                non_finite: 0,
            })
        }
    }

    fn recognizer(classes: &[&str]) -> Vec<Box<dyn Recognizer>> {
        vec![Box::new(FirstTwoPixels {
            contract: Contract {
                input_range: InputRange::Byte,
                classes: classes.iter().map(|&name| name.to_owned()).collect(),
                ..Contract::default()
            },
            runtime: RuntimeName {
                name: "test".into(),
                version: "1".into(),
            },
        })]
    }

    fn gei(first: u8, second: u8) -> Vec<u8> {
        let mut pixels = vec![0; Contract::default().pixels()];
        pixels[..2].copy_from_slice(&[first, second]);
        pixels
    }

    const FRONT: (f64, f64) = (0.0, 0.0);
    const SIDE: (f64, f64) = (90.0, 0.0);

    #[test]
    fn people_with_classes_are_recognized_by_the_highest_score() {
        let recognizers = recognizer(&["ann", "bob"]);
        // The contest's order of people is not the model's order of classes.
        let mut contest = Contest::new(&recognizers, ["bob", "ann", "bob"]);
        assert!(contest.is_closed_set());
        contest
            .probe("ann", [FRONT, SIDE], [&gei(9, 1)[..], &gei(1, 9)[..]])
            .expect("two probes");
        contest
            .probe("bob", [SIDE], [&gei(1, 9)[..]])
            .expect("a probe");
        let result = &contest.results(1)[0];
        assert_eq!((result.probes, result.classes), (3, 2));
        assert!((result.rank1 - 2.0 / 3.0).abs() < 1e-12);
        let by_view: Vec<_> = result
            .by_viewpoint
            .iter()
            .map(|view| (view.azimuth_deg, view.probes, view.rank1))
            .collect();
        assert_eq!(by_view, [(0.0, 1, 1.0), (90.0, 2, 0.5)]);
    }

    #[test]
    fn people_without_classes_are_recognized_by_the_nearest_enrolled() {
        let recognizers = recognizer(&["ann", "bob"]);
        let mut contest = Contest::new(&recognizers, ["ann", "cid"]);
        assert!(!contest.is_closed_set());
        contest
            .enrol(0, "ann", [&gei(0, 0)[..]])
            .expect("one enrolled");
        contest
            .enrol(0, "cid", [&gei(200, 0)[..]])
            .expect("another");
        contest.close_gallery().expect("two enrolled");
        contest
            .probe("ann", [SIDE, SIDE], [&gei(90, 0)[..], &gei(110, 0)[..]])
            .expect("two probes");
        let result = &contest.results(1)[0];
        assert_eq!(result.protocol, Protocol::NearestEmbedding);
        assert_eq!((result.probes, result.rank1), (2, 0.5));
    }

    #[test]
    fn answers_that_are_not_finite_are_misses_and_counted() {
        let recognizers = recognizer(&["ann", "bob"]);
        let mut contest = Contest::new(&recognizers, ["ann"]);
        contest
            .probe("ann", [SIDE, SIDE], [&gei(13, 0)[..], &gei(9, 0)[..]])
            .expect("two probes");
        let result = &contest.results(1)[0];
        assert_eq!(
            (result.probes, result.rank1, result.non_finite),
            (2, 0.5, 1)
        );
    }

    #[test]
    fn an_empty_gallery_and_strangers_are_refused() {
        let recognizers = recognizer(&[]);
        let mut contest = Contest::new(&recognizers, ["ann"]);
        assert!(contest.close_gallery().is_err());
        let error = contest.probe("eve", [SIDE], [&gei(0, 0)[..]]);
        assert!(error.is_err_and(|error| error.to_string().contains("eve")));
    }
}

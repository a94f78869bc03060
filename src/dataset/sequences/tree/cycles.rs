//! Trees whose takes are single gait cycles.

#![cfg(feature = "train")]

use super::Recordings;
use crate::dataset::sequences::{Labels, Sequences, ViewLabel};
use std::collections::HashMap;

impl Recordings {
    /// Returns the number of people.
    pub(crate) fn people(&self) -> usize {
        self.sequences.subjects.len()
    }

    /// Returns whether any person has several takes.
    pub(crate) fn has_others(&self) -> bool {
        let takes = &self.sequences.takes;
        takes.len() > self.people()
    }

    /// Returns azimuth and elevation of each viewpoint, degrees, or `None` if any is unknown.
    pub(crate) fn viewpoints(&self) -> Option<Vec<(f64, f64)>> {
        self.sequences
            .views
            .iter()
            .map(ViewLabel::angles_deg)
            .collect()
    }

    /// Makes each gait cycle a take of its own. Leaves out the second cycle of each person's first
    /// take, which is nearly a copy of the first cycle.
    #[must_use]
    pub(crate) fn by_cycle(self) -> Self {
        let Sequences {
            subjects,
            takes,
            origins,
            views,
            list,
        } = &self.sequences;
        let mut labels = Labels::default();
        let mut parts = Vec::new();
        let mut first = HashMap::new();
        for (sequence, part) in list.iter().zip(&self.parts) {
            let take = &takes[sequence.take];
            let origin = &origins[sequence.origin];
            let cycle = origin.cycle.unwrap_or(0);
            let is_first = *first.entry(take.subject).or_insert(sequence.take) == sequence.take;
            if is_first && cycle == 1 {
                continue;
            }
            let name = format!("{}, cycle {cycle}", take.name);
            let own = labels.take(&subjects[take.subject], &name, &take.condition);
            let view = labels.view(views[sequence.view].clone());
            let origin = labels.origin(origin.clone());
            labels.push(own, origin, view);
            parts.push(part.clone());
        }
        Self {
            parts,
            sequences: labels.sequences,
            ..self
        }
    }
}

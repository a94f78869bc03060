//! What a tree contains, recording by recording.

use super::Recordings;
use crate::dataset::TreeSequence;
use crate::error::Result;
use rayon::prelude::*;
use serde::Serialize;

/// A recording of a tree, and its gait cycles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct RecordingSummary {
    /// The person.
    pub(crate) subject: String,
    /// The take.
    pub(crate) take: String,
    /// The view.
    pub(crate) view: String,
    /// The number of frames; none if it is not known before they are read.
    pub(crate) frames: Option<usize>,
    /// The first and the last frame of each gait cycle, counted from 0; empty if none is known.
    pub(crate) cycles: Vec<[usize; 2]>,
    /// Why no gait cycle was found, where one was searched.
    pub(crate) no_cycle: Option<String>,
}

impl Recordings {
    /// Returns the number of a sequence's first frame in its recording, from 0.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub(crate) fn first_frame(&self, sequence: usize) -> usize {
        self.parts[sequence].frames.start
    }

    /// Lists the recordings that are kept, in the tree's order. Reads the names of all frames.
    ///
    /// # Errors
    /// If a folder cannot be read.
    pub(crate) fn listed(&self) -> Result<Vec<RecordingSummary>> {
        let listed = |&number: &usize| {
            let TreeSequence {
                subject,
                take,
                view,
                ..
            } = &self.tree.sequences()[number];
            let cycles = self.cycles.get(number).map_or(&[][..], Vec::as_slice);
            Ok(RecordingSummary {
                subject: subject.clone(),
                take: take.clone(),
                view: view.clone(),
                frames: self.tree.frames(number)?,
                cycles: cycles.iter().map(|of| [of.start, of.end - 1]).collect(),
                no_cycle: self.no_cycle.get(&number).map(ToString::to_string),
            })
        };
        self.numbers().par_iter().map(listed).collect()
    }
}

//! A stopwatch that is read after each stage of the pipeline.

use super::histogram::Histogram;
use crate::bench::statistics::Times;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The stages of the pipeline, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathStage {
    /// Reading and decoding a frame's file.
    Decode,
    /// Segmenting the figure.
    Segment,
    /// Scaling the figure to the model's size and framing.
    Framing,
    /// Measuring the legs and detecting the gait cycle.
    Cycle,
    /// Making the model's input from a cycle's silhouettes.
    Template,
    /// Running the network.
    Network,
}

/// The number of stages that each frame has: the first ones.
const OF_FRAMES: usize = 4;

/// The times of each stage: the first four over all frames, template and network over all answers.
/// Together they are the whole measured time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stages {
    /// The times of reading and decoding a frame's file.
    pub decode: Times,
    /// The times of segmenting a frame.
    pub segment: Times,
    /// The times of framing the figure.
    pub framing: Times,
    /// The times of measuring the legs and detecting the gait cycle.
    pub cycle: Times,
    /// The times of making the model's input from a cycle's silhouettes.
    pub template: Times,
    /// The times of an inference.
    pub network: Times,
    /// The times of a frame from its file on, with the answers that it leads to. Answers at the end
    /// of a recording count towards the next frame.
    pub frame: Times,
}

/// A clock and the times measured with it.
pub(super) struct Laps<'c> {
    clock: &'c mut (dyn FnMut() -> Duration + Send),
    last: Duration,
    /// The times of the current frame so far.
    frame: [Duration; OF_FRAMES],
    whole: Duration,
    stages: [Histogram; 6],
    frames: Histogram,
    total: Duration,
}

impl<'c> Laps<'c> {
    /// Starts with no times; the clock returns the time since any fixed moment, and never goes
    /// back.
    pub(super) fn new(clock: &'c mut (dyn FnMut() -> Duration + Send)) -> Self {
        let last = clock();
        Self {
            clock,
            last,
            frame: [Duration::ZERO; OF_FRAMES],
            whole: Duration::ZERO,
            stages: std::array::from_fn(|_| Histogram::new()),
            frames: Histogram::new(),
            total: Duration::ZERO,
        }
    }

    /// Adds the time since the last call of this method or of [`Self::resume`] to a stage.
    pub(super) fn lap(&mut self, stage: PathStage) {
        let now = (self.clock)();
        let took = now.saturating_sub(self.last);
        self.last = now;
        self.total += took;
        self.whole += took;
        match self.frame.get_mut(stage as usize) {
            Some(of_frame) => *of_frame += took,
            None => self.stages[stage as usize].add(ns(took)),
        }
    }

    /// Ends a frame.
    pub(super) fn close(&mut self) {
        for (stage, took) in self.stages.iter_mut().zip(&mut self.frame) {
            stage.add(ns(std::mem::take(took)));
        }
        self.frames.add(ns(std::mem::take(&mut self.whole)));
    }

    /// Ignores the time since the last call.
    pub(super) fn resume(&mut self) {
        self.last = (self.clock)();
    }

    /// Returns the time measured so far.
    pub(super) const fn total(&self) -> Duration {
        self.total
    }

    /// Returns the times of all stages; none until each has occurred.
    pub(super) fn stages(&self) -> Option<Stages> {
        let [decode, segment, framing, cycle, template, network] = &self.stages;
        Some(Stages {
            decode: decode.times()?,
            segment: segment.times()?,
            framing: framing.times()?,
            cycle: cycle.times()?,
            template: template.times()?,
            network: network.times()?,
            frame: self.frames.times()?,
        })
    }
}

/// Returns the time in whole nanoseconds.
pub(super) fn ns(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

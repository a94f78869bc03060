//! A watch that is read after each stage of the path.

use super::histogram::Histogram;
use crate::bench::statistics::Times;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// What is done one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathStage {
    /// A frame's file is read and decoded.
    Decode,
    /// The figure is found in it.
    Segment,
    /// It is brought to the model's size and framing.
    Framing,
    /// Its legs are measured, and the gait cycle followed.
    Cycle,
    /// The model's input is made of a cycle's silhouettes.
    Template,
    /// The network answers.
    Network,
}

/// Stages that each frame has, the first ones.
const OF_FRAMES: usize = 4;

/// The time of each stage. Those of a frame are of all frames, the others of all answers. All of them
/// together are the time that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stages {
    /// Reading a frame's file and decoding it.
    pub decode: Times,
    /// Segmenting it.
    pub segment: Times,
    /// Framing the figure.
    pub framing: Times,
    /// Measuring the legs and following the gait cycle.
    pub cycle: Times,
    /// Making the model's input of a cycle's silhouettes.
    pub template: Times,
    /// An inference.
    pub network: Times,
    /// A frame from its file on, with the answers that it leads to. At the end of a recording, what is
    /// still to be answered belongs to the frame after it.
    pub frame: Times,
}

/// A clock and the times that it told.
pub(super) struct Laps<'c> {
    clock: &'c mut (dyn FnMut() -> Duration + Send),
    last: Duration,
    /// Of this frame so far.
    frame: [Duration; OF_FRAMES],
    whole: Duration,
    stages: [Histogram; 6],
    frames: Histogram,
    total: Duration,
}

impl<'c> Laps<'c> {
    /// Nothing told yet; the clock gives the time since any moment, and never goes back.
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

    /// What was since the last call, this one or [`Self::resume`], was this stage.
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

    /// A frame is done with.
    pub(super) fn close(&mut self) {
        for (stage, took) in self.stages.iter_mut().zip(&mut self.frame) {
            stage.add(ns(std::mem::take(took)));
        }
        self.frames.add(ns(std::mem::take(&mut self.whole)));
    }

    /// What was since the last call does not count.
    pub(super) fn resume(&mut self) {
        self.last = (self.clock)();
    }

    /// Time that was measured so far.
    pub(super) const fn total(&self) -> Duration {
        self.total
    }

    /// Times of all stages; none before each was there.
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

/// Whole nanoseconds.
pub(super) fn ns(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

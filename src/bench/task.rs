//! What is to be measured of a model.

use super::inputs::DrawnInputs;
use super::process::MeasuringProgress;
use super::windows::TimingPlan;
use crate::error::Result;
use crate::score::{Model, Runtime};
use std::path::Path;
use std::time::Duration;

/// What is to be measured.
pub(crate) struct Task<'a> {
    /// Reads the model.
    pub open: &'a dyn Fn() -> Result<Model>,
    /// Starts the runtime.
    pub start: &'a dyn Fn() -> Result<Runtime>,
    /// Threads inside of one inference.
    pub threads: usize,
    /// Inferences of a batch, of each size that is measured; at least one.
    pub batches: &'a [usize],
    /// Whether to measure its rank-1.
    pub with_accuracy: bool,
    /// Whether to measure what each operator takes, where the runtime tells.
    pub with_operators: bool,
    /// How long.
    pub plan: TimingPlan,
    /// How long all of it may take from the first inference on; no end if none.
    pub most: Option<Duration>,
    /// Is told how far it is.
    pub tell: &'a (dyn Fn(&MeasuringProgress) + Sync),
    /// Whether to compare with a loop around nothing but the runtime.
    pub bare: bool,
    /// What is drawn.
    pub scene: DrawnInputs<'a>,
    /// Seed of the intervals of accuracy.
    pub seed: u64,
    /// Where the machine's files are.
    pub root: &'a Path,
}

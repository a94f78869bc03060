//! What to measure of a model.

use super::inputs::DrawnInputs;
use super::process::MeasuringProgress;
use super::windows::TimingPlan;
use crate::error::Result;
use crate::inference::{Model, Runtime};
use std::path::Path;
use std::time::Duration;

/// The measurement of a model.
pub(crate) struct Task<'a> {
    /// A function that reads the model.
    pub open: &'a dyn Fn() -> Result<Model>,
    /// A function that starts the runtime.
    pub start: &'a dyn Fn() -> Result<Runtime>,
    /// The number of threads within one inference.
    pub threads: usize,
    /// The batch sizes that are measured; at least one.
    pub batches: &'a [usize],
    /// Whether to measure rank-1.
    pub with_accuracy: bool,
    /// Whether to measure the time of each operator, where the runtime reports it.
    pub with_operators: bool,
    /// The timing plan.
    pub plan: TimingPlan,
    /// The time limit from the first inference on; none for no limit.
    pub most: Option<Duration>,
    /// A function that is called with the progress.
    pub tell: &'a (dyn Fn(&MeasuringProgress) + Sync),
    /// Whether to compare with loops around the runtime alone.
    pub bare: bool,
    /// The inputs that are drawn.
    pub scene: DrawnInputs<'a>,
    /// The seed of the accuracy's intervals.
    pub seed: u64,
    /// The root folder of the machine's files.
    pub root: &'a Path,
}

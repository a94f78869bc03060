//! Runs recognizers on templates and sequences of silhouettes, with the embedded runtime or ONNX
//! Runtime.
//!
//! A [`Model`] is a checked file; a [`Runtime`] loads it as a [`Recognizer`]. Neither runtime
//! checks the intended shape or whether numbers are finite, so this module does.

mod affine;
pub(crate) mod answers;
pub(crate) mod baseline;
mod cached;
mod contract;
mod find_runtime;
mod firmware;
mod graph;
mod guess;
mod input;
mod library;
mod model;
mod onnx;
mod ports;
mod profile;
mod protobuf;
mod provider;
mod quantize;
mod rten;
mod runtime;
pub mod shipped;

pub use affine::{Affine, AffineScores};
pub use cached::CachedRecognizer;
#[cfg(feature = "train")]
pub(crate) use contract::SAME_VIEW_DEG;
pub use contract::{Contract, OutputNames, Training};
pub use find_runtime::find_library;
pub use firmware::Firmware;
pub use graph::{Dimension, Graph, Port};
pub use input::{Distance, InputLayout, InputRange};
pub use model::{Model, model_memory};
pub(crate) use ports::list_of;
pub use ports::{Batching, EMBEDDING, SCORES};
pub use profile::{Arithmetic, OperatorTime, ProfiledOperations};
pub use provider::{BareLoop, BareOutputs, Provider, RuntimeName};
pub use quantize::GeiForm;
pub use runtime::Runtime;

use crate::error::{InferenceError, Result};
use ports::Ports;

/// A loaded recognizer: it turns templates or sequences of silhouettes into embeddings and class
/// scores.
pub trait Recognizer: Send + Sync {
    /// Returns the name for reports.
    fn name(&self) -> &str {
        &self.contract().name
    }

    /// Returns the runtime that runs it.
    fn runtime(&self) -> &RuntimeName;

    /// Returns the contract: what the model expects and gives.
    fn contract(&self) -> &Contract;

    /// Computes the outputs of `batch` inputs that lie one after another, in the form that
    /// [`Contract::feed`] writes: templates, or sequences that all have the same number of
    /// silhouettes (which follows from the length of `input`). If the contract has an input of
    /// viewpoints, each input ends with its viewpoint ([`Contract::feed_view`]).
    ///
    /// Under ONNX Runtime, calls from several threads wait for each other.
    ///
    /// # Errors
    /// If `input` does not hold `batch` inputs of the contract's size and number of frames,
    /// `batch` is 0, or the runtime fails.
    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs>;

    /// Returns the largest useful batch: a larger one delays progress reports, and loses more work
    /// if the run is interrupted.
    fn at_once(&self) -> usize {
        usize::MAX
    }

    /// Returns whether it is a baseline, which has learnt nothing.
    fn is_baseline(&self) -> bool {
        false
    }

    /// Returns the recognizer that computes, if this one caches its answers.
    fn behind(&self) -> Option<&dyn Recognizer> {
        None
    }

    /// Runs `work` where calls of [`Self::run`] cost least: on the runtime's own thread, if it has
    /// one, so that no call has to wake it.
    fn beside(&self, work: &mut (dyn FnMut() + Send)) {
        work();
    }
}

/// The outputs of a recognizer for a batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// Embeddings, one input after another; each `[dims / parts][parts]`.
    pub embedding: Vec<f32>,
    /// Numbers in one embedding, all parts together.
    pub embedding_dims: usize,
    /// Parts of one embedding, compared separately (OpenGait's `[n, c, p]`); 1 if it is flat.
    pub embedding_parts: usize,
    /// Class scores, one input after another, if the model has any.
    pub scores: Option<Vec<f32>>,
    /// Class scores of one input; 0 if the model has none.
    pub classes: usize,
    /// Numbers that are NaN or infinite, in all outputs. A sound recognizer has none.
    pub non_finite: usize,
}

impl Outputs {
    /// Counts the numbers that are NaN or infinite.
    pub fn count_non_finite(&mut self) {
        let numbers = self.embedding.iter().chain(self.scores.iter().flatten());
        self.non_finite = numbers.filter(|number| !number.is_finite()).count();
    }
}

/// An output tensor of a runtime.
#[derive(Clone)]
struct OutputTensor {
    shape: Vec<usize>,
    numbers: Vec<f32>,
}

/// The inputs of one call of a runtime.
#[derive(Clone, Copy)]
struct GivenInputs<'a> {
    numbers: &'a [f32],
    shape: &'a [usize],
    /// Azimuth and elevation of each input, degrees; empty for a model that does not take them.
    views: &'a [f32],
}

impl GivenInputs<'_> {
    /// Returns the shape of the viewpoints.
    fn views_shape(&self) -> [usize; 2] {
        [self.views.len() / 2, 2]
    }
}

/// The outputs of a model for some inputs.
struct ModelOutputs {
    embedding: OutputTensor,
    scores: Option<OutputTensor>,
}

/// Runs a batch through `run_once`, which returns embeddings and scores: in one call, or one input
/// at a time if the model takes no more.
fn run_batch(
    contract: &Contract,
    ports: &Ports,
    input: &[f32],
    batch: usize,
    mut run_once: impl FnMut(GivenInputs<'_>) -> Result<ModelOutputs>,
) -> Result<Outputs> {
    let frames = contract.frames_in(input.len(), batch)?;
    let step = if ports.batching.is_one() { 1 } else { batch };
    let shape = contract.input_shape(step, frames);
    let mut outputs = Outputs::default();
    let each = frames * contract.input_numbers() + contract.view_numbers();
    for input in input.chunks_exact(step * each) {
        let (numbers, views) = contract.apart(input, step);
        let ModelOutputs { embedding, scores } = run_once(GivenInputs {
            numbers: &numbers,
            shape: &shape,
            views: &views,
        })?;
        let refuse = |name: &str, expected: String, found: &OutputTensor| InferenceError::Output {
            model: contract.name.clone(),
            output: name.to_owned(),
            expected,
            found: format!("{:?}", found.shape),
        };
        let [dims, parts] = match *embedding.shape.as_slice() {
            [rows, dims] if rows == step && dims > 0 => [dims, 1],
            [rows, dims, parts] if rows == step && dims > 0 && parts > 0 => [dims * parts, parts],
            _ => {
                let expected = format!("[{step}, numbers] or [{step}, numbers, parts]");
                return Err(refuse(&ports.embedding, expected, &embedding).into());
            }
        };
        (outputs.embedding_dims, outputs.embedding_parts) = (dims, parts);
        join(&mut outputs.embedding, embedding.numbers);
        if let (Some(scores), Some(name)) = (scores, &ports.scores) {
            let people = contract.classes.len();
            outputs.classes = match *scores.shape.as_slice() {
                [rows, classes]
                    if rows == step && classes > 0 && [0, classes].contains(&people) =>
                {
                    classes
                }
                _ => {
                    let people = if people > 0 {
                        people.to_string()
                    } else {
                        "classes".into()
                    };
                    return Err(refuse(name, format!("[{step}, {people}]"), &scores).into());
                }
            };
            join(outputs.scores.get_or_insert_default(), scores.numbers);
        }
    }
    outputs.count_non_finite();
    Ok(outputs)
}

/// Appends numbers, without a copy if `all` is empty.
fn join(all: &mut Vec<f32>, mut more: Vec<f32>) {
    if all.is_empty() {
        *all = more;
    } else {
        all.append(&mut more);
    }
}

#[cfg(test)]
pub(crate) mod testing;

#[cfg(test)]
mod tests;

//! Runs recognizers on GEIs and sequences of silhouettes, with the embedded runtime or with ONNX Runtime.
//!
//! A [`Model`] is a checked file, a [`Runtime`] is chosen once, and what it
//! loads is a [`Recognizer`]. Neither runtime checks what matters here (which
//! shape is meant, whether the numbers are finite), so it is checked around them.

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
pub use model::Model;
pub(crate) use ports::list_of;
pub use ports::{Batching, EMBEDDING, SCORES};
pub use profile::{Arithmetic, OperatorTime, Ran};
pub use provider::{BareLoop, BareOutputs, Provider, RuntimeName};
pub use quantize::GeiForm;
pub use runtime::Runtime;

use crate::error::{Result, ScoreError};
use ports::Ports;

/// Something that turns GEIs or sequences of silhouettes into embeddings and class scores.
pub trait Recognizer: Send + Sync {
    /// What to call it in reports.
    fn name(&self) -> &str {
        &self.contract().name
    }

    /// What runs it.
    fn runtime(&self) -> &RuntimeName;

    /// What it expects and promises.
    fn contract(&self) -> &Contract;

    /// Recognizes `batch` GEIs that lie one after another, rows top first, in the contract's
    /// input range ([`Contract::feed`]); or `batch` sequences, each of the same number of
    /// silhouettes one after another, which follows from `input`'s length. Where the contract has an
    /// input of viewpoints, each ends with its own ([`Contract::feed_view`]).
    ///
    /// Calls from several threads wait for each other under ONNX Runtime.
    ///
    /// # Errors
    /// If `input` does not hold `batch` inputs of the contract's size and number of frames,
    /// `batch` is 0, or the runtime fails.
    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs>;

    /// How many inputs are worth giving it at once: more take longer than anybody waits for a sign, or
    /// likes to lose.
    fn at_once(&self) -> usize {
        usize::MAX
    }

    /// Whether it has learnt nothing, and is there for others to be compared with.
    fn is_baseline(&self) -> bool {
        false
    }

    /// The recognizer that computes, if this one remembers what that one answered.
    fn behind(&self) -> Option<&dyn Recognizer> {
        None
    }

    /// Does `work` where a call of [`Self::run`] costs least: on the runtime's own thread, if it
    /// has one, so that no call has to wake it.
    fn beside(&self, work: &mut (dyn FnMut() + Send)) {
        work();
    }
}

/// What a recognizer computed for a batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// Embeddings, one input after another; each `[dims / parts][parts]`.
    pub embedding: Vec<f32>,
    /// Numbers in one embedding, all parts together.
    pub embedding_dims: usize,
    /// Parts of one embedding that are compared apart (OpenGait's `[n, c, p]`); 1 if it is flat.
    pub embedding_parts: usize,
    /// Class scores, one input after another, if the model has any.
    pub scores: Option<Vec<f32>>,
    /// Scores of one input; 0 without scores.
    pub classes: usize,
    /// How many of all these numbers are NaN or infinite: a recognizer with any is broken.
    pub non_finite: usize,
}

impl Outputs {
    /// Counts the numbers that are NaN or infinite.
    pub fn count_non_finite(&mut self) {
        let numbers = self.embedding.iter().chain(self.scores.iter().flatten());
        self.non_finite = numbers.filter(|number| !number.is_finite()).count();
    }
}

/// What a runtime gave back.
#[derive(Clone)]
struct OutputTensor {
    shape: Vec<usize>,
    numbers: Vec<f32>,
}

/// What a runtime is given at once.
#[derive(Clone, Copy)]
struct GivenInputs<'a> {
    numbers: &'a [f32],
    shape: &'a [usize],
    /// Azimuth and elevation of each input, degrees; empty for a model that does not take them.
    views: &'a [f32],
}

impl GivenInputs<'_> {
    /// The shape of the viewpoints.
    fn views_shape(&self) -> [usize; 2] {
        [self.views.len() / 2, 2]
    }
}

/// Runs a batch through `run_once`, which gives the embedding and the scores: all at once, or one
/// at a time if the model must not get more.
fn run_batch(
    contract: &Contract,
    ports: &Ports,
    (input, batch): (&[f32], usize),
    mut run_once: impl FnMut(GivenInputs<'_>) -> Result<(OutputTensor, Option<OutputTensor>)>,
) -> Result<Outputs> {
    let frames = contract.frames_in(input.len(), batch)?;
    let step = if ports.batching.is_one() { 1 } else { batch };
    let shape = contract.input_shape(step, frames);
    let mut outputs = Outputs::default();
    let each = frames * contract.input_numbers() + contract.view_numbers();
    for input in input.chunks_exact(step * each) {
        let (numbers, views) = contract.apart(input, step);
        let (embedding, scores) = run_once(GivenInputs {
            numbers: &numbers,
            shape: &shape,
            views: &views,
        })?;
        let refuse = |name: &str, expected: String, found: &OutputTensor| ScoreError::Output {
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

/// Appends, without a copy if there was nothing.
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

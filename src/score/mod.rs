//! Runs recognizers on GEIs, with the embedded runtime or with ONNX Runtime.
//!
//! A [`Model`] is a checked file, a [`Runtime`] is chosen once, and what it
//! loads is a [`Recognizer`]. Neither runtime checks what matters here (which
//! shape is meant, whether the numbers are finite), so it is checked around them.

mod contract;
mod graph;
mod library;
mod model;
mod onnx;
pub mod pixels;
mod protobuf;
mod rten;
pub mod shipped;

use std::path::Path;

pub use contract::{Contract, InputRange, Layout, OutputNames, Training};
pub use graph::{Dimension, Graph, Port};
pub use model::Model;

use crate::error::{Error, Result};
use model::Ports;

/// Something that turns GEIs into embeddings and class scores.
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
    /// input range.
    ///
    /// Calls from several threads wait for each other under ONNX Runtime.
    ///
    /// # Errors
    /// If `geis` does not hold `batch` GEIs, `batch` is 0, or the runtime fails.
    fn run(&self, geis: &[f32], batch: usize) -> Result<Outputs>;
}

/// What a recognizer computed for a batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// Embeddings, one GEI after another.
    pub embedding: Vec<f32>,
    /// Numbers in one embedding.
    pub embedding_dims: usize,
    /// Class scores, one GEI after another, if the model has any.
    pub scores: Option<Vec<f32>>,
    /// Scores of one GEI; 0 without scores.
    pub classes: usize,
    /// How many of all these numbers are NaN or infinite: a recognizer with any is broken.
    pub non_finite: usize,
}

/// Which software runs a model, for results.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RuntimeName {
    /// `rten` or `onnxruntime`.
    pub name: String,
    /// Its version.
    pub version: String,
}

/// A runtime that is ready to load models.
#[derive(Clone, Debug)]
pub struct Runtime {
    engine: Engine,
    threads: usize,
}

#[derive(Clone, Debug)]
enum Engine {
    Rten,
    Ort(onnx::Ort),
}

impl Runtime {
    /// The embedded runtime: needs nothing, always there. One thread.
    #[must_use]
    pub const fn rten() -> Self {
        Self {
            engine: Engine::Rten,
            threads: 1,
        }
    }

    /// ONNX Runtime, from a shared library of version 1.18 or later. One thread.
    ///
    /// The library is in the `onnxruntime` wheel from 1.19 on, as
    /// `onnxruntime/capi/libonnxruntime.so.*`. It stays loaded, so that a process has one: a
    /// second call has to name the same file. Loading runs the library's code: name only one
    /// that you trust. Telemetry is off.
    ///
    /// # Errors
    /// If the file is missing, cut short, for another system, not ONNX Runtime or too old, or
    /// another one is loaded already.
    pub fn ort(library: impl AsRef<Path>) -> Result<Self> {
        Ok(Self {
            engine: Engine::Ort(onnx::Ort::load(library.as_ref())?),
            threads: 1,
        })
    }

    /// The same runtime, with `threads` (at least 1) for the work inside one call.
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        self.threads = threads.max(1);
        self
    }

    /// Its name and version.
    #[must_use]
    pub fn name(&self) -> RuntimeName {
        match &self.engine {
            Engine::Rten => rten::runtime_name(),
            Engine::Ort(ort) => ort.runtime_name().clone(),
        }
    }

    /// Prepares `model` for running.
    ///
    /// # Errors
    /// If the runtime does not support one of the model's operators, or refuses the file.
    pub fn load(&self, model: &Model) -> Result<Box<dyn Recognizer>> {
        Ok(match &self.engine {
            Engine::Rten => Box::new(rten::RtenRecognizer::load(model, self.threads)?),
            Engine::Ort(ort) => Box::new(onnx::OrtRecognizer::load(ort, model, self.threads)?),
        })
    }
}

/// A matrix that a runtime gave back: rows, columns, numbers.
type Matrix = (usize, usize, Vec<f32>);

/// Runs a batch through `run_once`, which takes GEIs and their count and gives the embedding and
/// the scores: all at once, or one at a time if the model takes no more.
fn run_batch(
    contract: &Contract,
    ports: &Ports,
    (geis, batch): (&[f32], usize),
    mut run_once: impl FnMut(&[f32], usize) -> Result<(Matrix, Option<Matrix>)>,
) -> Result<Outputs> {
    let pixels = contract.pixels();
    if batch == 0 || batch.checked_mul(pixels) != Some(geis.len()) {
        return Err(Error::Failed(format!(
            "{}: expected {batch} GEIs of {} x {} = {pixels} numbers and at least one, found {} numbers",
            contract.name,
            contract.rows,
            contract.columns,
            geis.len()
        )));
    }
    let step = if ports.one_at_a_time { 1 } else { batch };
    let mut outputs = Outputs::default();
    for geis in geis.chunks_exact(step * pixels) {
        let (embedding, scores) = run_once(geis, step)?;
        let embedding = checked(contract, &ports.embedding, step, embedding)?;
        outputs.embedding_dims = embedding.1;
        join(&mut outputs.embedding, embedding.2);
        if let (Some(scores), Some(name)) = (scores, &ports.scores) {
            let scores = checked(contract, name, step, scores)?;
            let people = contract.classes.len();
            if people > 0 && scores.1 != people {
                return Err(Error::Failed(format!(
                    "{}: expected a score for each of the {people} classes in the contract, found {}",
                    contract.name, scores.1
                )));
            }
            outputs.classes = scores.1;
            join(outputs.scores.get_or_insert_default(), scores.2);
        }
    }
    let numbers = outputs
        .embedding
        .iter()
        .chain(outputs.scores.iter().flatten());
    outputs.non_finite = numbers.filter(|number| !number.is_finite()).count();
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

fn checked(contract: &Contract, output: &str, batch: usize, matrix: Matrix) -> Result<Matrix> {
    let (rows, columns, numbers) = &matrix;
    if *rows == batch && *columns > 0 && numbers.len() == rows * columns {
        return Ok(matrix);
    }
    Err(Error::Failed(format!(
        "{}: expected the output {output:?} as [{batch}, numbers], found [{rows}, {columns}]",
        contract.name
    )))
}

/// The shape of an output, if it is a matrix.
fn matrix_shape(contract: &Contract, output: &str, shape: &[usize]) -> Result<(usize, usize)> {
    if let [rows, columns] = *shape {
        return Ok((rows, columns));
    }
    Err(Error::Failed(format!(
        "{}: expected the output {output:?} as [N, numbers], found {shape:?}",
        contract.name
    )))
}

#[cfg(test)]
pub(crate) mod testing;

#[cfg(test)]
mod tests;

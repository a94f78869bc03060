//! The embedded runtime: rten, pure Rust.
//!
//! It needs no library, so a fresh machine can score at once. It computes
//! `ConvInteger` wrongly on some processors without an error, and has no LRN and
//! no `ai.onnx.ml`: such models are refused before they are loaded.

use std::sync::Arc;

use rten::{ModelOptions, NodeId, RunOptions, ThreadPool, Value, ValueView};

use super::model::Model;
use super::ports::Ports;
use super::{Contract, Outputs, Provider, Recognizer, RuntimeName, Tensor, run_batch};
use crate::error::{Error, Result};

/// The version in `Cargo.lock`, which a test compares.
const VERSION: &str = "0.27.0";

/// What to do about a model that does not run here.
const WAY_OUT: &str = "use --runtime ort --ort-lib PATH";

/// A model loaded by rten.
pub(super) struct RtenRecognizer {
    model: rten::Model,
    pool: Arc<ThreadPool>,
    runtime: RuntimeName,
    contract: Contract,
    ports: Ports,
    input: NodeId,
    outputs: Vec<NodeId>,
}

pub(super) fn runtime_name() -> RuntimeName {
    RuntimeName {
        name: "rten".into(),
        version: VERSION.into(),
        provider: Provider::Cpu.name().into(),
    }
}

/// Why an operator must not run here, if so.
fn objection(operator: &str) -> Option<&'static str> {
    match operator {
        "ConvInteger" => Some("computes ConvInteger wrongly on some processors"),
        "LRN" => Some("has no LRN"),
        _ if operator.starts_with("ai.onnx.ml.") => Some("has no operators of ai.onnx.ml"),
        _ => None,
    }
}

impl RtenRecognizer {
    pub fn load(model: &Model, threads: usize) -> Result<Self> {
        let refuse = |problem: String| Error::input(model.path(), format!("{problem} ({WAY_OUT})"));
        for operator in model.graph().operators.keys() {
            if let Some(reason) = objection(operator) {
                return Err(refuse(format!(
                    "the model uses {operator}, and the embedded runtime {reason}"
                )));
            }
        }
        let loaded = ModelOptions::with_all_ops()
            .load(model.bytes().to_vec())
            .map_err(|error| refuse(format!("the embedded runtime refuses the model: {error}")))?;
        let ports = model.ports().clone();
        let node = |name: &str| {
            loaded.find_node(name).ok_or_else(|| {
                refuse(format!(
                    "the embedded runtime finds nothing called {name:?} in the model"
                ))
            })
        };
        let input = node(&ports.input)?;
        let mut outputs = vec![node(&ports.embedding)?];
        if let Some(scores) = ports
            .scores
            .as_deref()
            .filter(|name| *name != ports.embedding)
        {
            outputs.push(node(scores)?);
        }
        Ok(Self {
            model: loaded,
            pool: Arc::new(ThreadPool::with_num_threads(threads)),
            runtime: runtime_name(),
            contract: model.contract().clone(),
            ports,
            input,
            outputs,
        })
    }

    fn run_once(&self, input: &[f32], shape: &[usize]) -> Result<(Tensor, Option<Tensor>)> {
        let failed = |problem: String| {
            Error::Failed(format!(
                "{}: the embedded runtime: {problem}",
                self.contract.name
            ))
        };
        let input =
            ValueView::from_shape(shape, input).map_err(|error| failed(error.to_string()))?;
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(&self.pool)));
        let mut values = self
            .model
            .run(
                vec![(self.input, input.into())],
                &self.outputs,
                Some(options),
            )
            .map_err(|error| failed(error.to_string()))?
            .into_iter();
        let embedding = values
            .next()
            .ok_or_else(|| failed("no output came back".into()))?;
        let embedding = self.tensor(&self.ports.embedding, embedding)?;
        let scores = match &self.ports.scores {
            Some(name) if *name == self.ports.embedding => Some(embedding.clone()),
            Some(name) => values
                .next()
                .map(|value| self.tensor(name, value))
                .transpose()?,
            None => None,
        };
        Ok((embedding, scores))
    }

    fn tensor(&self, output: &str, value: Value) -> Result<Tensor> {
        use rten_tensor::prelude::*;
        let found = value.dtype();
        let Some(tensor) = value.into_tensor::<f32>() else {
            return Err(Error::Failed(format!(
                "{}: expected the output {output:?} as f32, found {found:?}",
                self.contract.name
            )));
        };
        Ok(Tensor {
            shape: tensor.shape().to_vec(),
            numbers: tensor.into_data(),
        })
    }
}

impl Recognizer for RtenRecognizer {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
        run_batch(
            &self.contract,
            &self.ports,
            (input, batch),
            |input, shape| self.run_once(input, shape),
        )
    }

    fn beside(&self, work: &mut (dyn FnMut() + Send)) {
        self.pool.run(work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{bytes_with_operator, small_model};

    #[test]
    fn the_version_is_the_one_in_the_lock_file() {
        let lock = include_str!("../../Cargo.lock");
        assert!(lock.contains(&format!("name = \"rten\"\nversion = \"{VERSION}\"\n")));
    }

    #[test]
    fn operators_that_come_out_wrong_are_refused_with_a_way_out() {
        for (operator, domain) in [
            ("ConvInteger", ""),
            ("LRN", "ai.onnx"),
            ("Scaler", "ai.onnx.ml"),
            ("NoSuch", ""),
        ] {
            let bytes = bytes_with_operator(operator, domain);
            let model = Model::from_bytes("m.onnx", bytes, Contract::default()).expect("a graph");
            let Err(error) = RtenRecognizer::load(&model, 1) else {
                panic!("{operator} was loaded");
            };
            let text = error.to_string();
            assert!(
                text.contains(operator) && text.ends_with("(use --runtime ort --ort-lib PATH)"),
                "{text}"
            );
        }
    }

    #[test]
    fn two_threads_give_what_one_gives() {
        let geis = vec![0.25_f32; 5 * 1500];
        let [one, two] = [1, 2].map(|threads| {
            let recognizer = RtenRecognizer::load(&small_model(), threads).expect("our own model");
            recognizer.run(&geis, 5).expect("five GEIs")
        });
        for (a, b) in one.embedding.iter().zip(&two.embedding) {
            assert!((a - b).abs() <= 1e-6 * b.abs().max(1.0), "{a} {b}");
        }
    }
}

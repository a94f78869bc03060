//! The embedded runtime: rten, pure Rust.
//!
//! It needs no library. It silently computes `ConvInteger` wrongly on some processors, and has no
//! LRN, no `ai.onnx.ml` and no windows over more than two axes: models with these are rejected
//! before they are loaded.

use super::graph::SlidingWindow;
use super::model::Model;
use super::ports::{Element, Ports, byte_of};
use super::provider::{Provider, RuntimeName};
use super::{Contract, GivenInputs, ModelOutputs, OutputTensor, Outputs, Recognizer, run_batch};
use crate::error::{Cause, Error, InferenceError, Remedy, Result};
use rten::{ModelOptions, NodeId, RunOptions, ThreadPool, Value, ValueOrView, ValueView};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// rten's version; a test compares it with `Cargo.lock`.
const VERSION: &str = "0.27.0";

/// A model loaded by rten.
pub(super) struct RtenRecognizer {
    model: rten::Model,
    /// The threads that work on a call: the first for calls of rayon's workers, and in turns for calls
    /// of other threads, so that these run at the same time. Each is made when it is first used.
    pools: Vec<OnceLock<Arc<ThreadPool>>>,
    turn: AtomicUsize,
    threads: usize,
    runtime: RuntimeName,
    contract: Contract,
    at_once: usize,
    ports: Ports,
    input: NodeId,
    view: Option<NodeId>,
    outputs: Vec<NodeId>,
}

pub(super) fn runtime_name() -> RuntimeName {
    RuntimeName {
        name: "rten".into(),
        version: VERSION.into(),
        provider: Provider::Cpu.name().into(),
    }
}

/// Returns why rten must not run an operator, if it must not.
fn objection(operator: &str) -> Option<&'static str> {
    match operator {
        "ConvInteger" => Some("computes ConvInteger wrongly on some processors"),
        "LRN" => Some("has no LRN"),
        _ if operator.starts_with("ai.onnx.ml.") => Some("has no operators of ai.onnx.ml"),
        _ => None,
    }
}

/// Returns why rten cannot slide a window, if it cannot. rten 0.27 itself reports it only at run
/// time, in `ops::conv`, `ops::conv_transpose` and `ops::pooling`. (Its global pooling has no
/// limits.)
fn window_objection(window: &SlidingWindow<'_>) -> Option<String> {
    match window.axes {
        Some(axes) if axes > 2 => Some(format!(
            "slides over {axes} axes, and the embedded runtime supports 1 or 2"
        )),
        _ if !window.has_strides => Some(
            "leaves out strides or the kernel's shape, and the embedded runtime needs them stated"
                .into(),
        ),
        _ => None,
    }
}

/// The process that started the runtime, which keeps threads for folding constants.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Checks that the process has not forked since the runtime was started: the threads stay behind in
/// the parent, and waiting for them would never end.
fn check_process(now: u32) -> Result<()> {
    if *PROCESS.get_or_init(|| now) == now {
        Ok(())
    } else {
        Err(InferenceError::Forked.into())
    }
}

/// Checks that these threads could be started: the runtime itself would then work on the calling
/// thread, and end the process when it needs others.
fn check_threads(pool: &ThreadPool) -> Result<()> {
    let own = || std::thread::current().id();
    if pool.run(own) == own() {
        let problem = "the embedded runtime got fewer than it asked for";
        return Err(Error::Threads(std::io::Error::other(problem)));
    }
    Ok(())
}

impl RtenRecognizer {
    pub(super) fn load(model: &Model, threads: usize) -> Result<Self> {
        check_process(std::process::id())?;
        // It folds constants on threads of its own.
        check_threads(rten::thread_pool())?;
        let pools: Vec<_> = (0..rayon::current_num_threads())
            .map(|_| OnceLock::new())
            .collect();
        let first = ThreadPool::with_num_threads(threads);
        check_threads(&first)?;
        let _ = pools[0].set(Arc::new(first));
        let refuse =
            |problem: String| Error::input(model.path(), problem).with_remedy(Remedy::OnnxRuntime);
        for operator in model.graph().operators.keys() {
            if let Some(reason) = objection(operator) {
                return Err(refuse(format!(
                    "the model uses {operator}, and the embedded runtime {reason}"
                )));
            }
        }
        if model.ports().element == Element::F64 {
            return Err(refuse(
                "the model takes f64, and the embedded runtime does not support it".into(),
            ));
        }
        for window in model.graph().windows() {
            if let Some(reason) = window_objection(&window) {
                return Err(refuse(format!(
                    "the model's {} ({:?}) {reason}",
                    window.operator, window.output
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
        let view = ports.view.as_deref().map(node).transpose()?;
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
            pools,
            turn: AtomicUsize::new(0),
            threads,
            runtime: runtime_name(),
            contract: model.contract().clone(),
            at_once: model.at_once(),
            ports,
            input,
            view,
            outputs,
        })
    }

    /// Returns the threads that work on a call of the current thread. A worker of rayon would take
    /// other work while it waits for them.
    fn pool(&self) -> &Arc<ThreadPool> {
        let at = match rayon::current_thread_index() {
            Some(_) => 0,
            None => self.turn.fetch_add(1, Ordering::Relaxed) % self.pools.len(),
        };
        self.pool_at(at)
    }

    fn pool_at(&self, at: usize) -> &Arc<ThreadPool> {
        self.pools[at].get_or_init(|| Arc::new(ThreadPool::with_num_threads(self.threads)))
    }

    fn run_once(&self, given: GivenInputs<'_>) -> Result<ModelOutputs> {
        let failed = |cause: Cause| InferenceError::Embedded {
            model: self.contract.name.clone(),
            cause,
        };
        let bytes: Vec<u8>;
        let input: ValueOrView<'_> = match self.ports.element {
            Element::U8 => {
                bytes = given.numbers.iter().copied().map(byte_of).collect();
                let view = ValueView::from_shape(given.shape, &bytes[..]);
                view.map_err(|error| failed(error.into()))?.into()
            }
            _ => {
                let view = ValueView::from_shape(given.shape, given.numbers);
                view.map_err(|error| failed(error.into()))?.into()
            }
        };
        let mut inputs = vec![(self.input, input)];
        if let Some(view) = self.view {
            let views = ValueView::from_shape(&given.views_shape(), given.views);
            inputs.push((view, views.map_err(|error| failed(error.into()))?.into()));
        }
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(self.pool())));
        let mut values = self
            .model
            .run(inputs, &self.outputs, Some(options))
            .map_err(|error| failed(error.into()))?
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
        Ok(ModelOutputs { embedding, scores })
    }

    fn tensor(&self, output: &str, value: Value) -> Result<OutputTensor> {
        use rten_tensor::prelude::*;
        let found = value.dtype();
        let Some(tensor) = value.into_tensor::<f32>() else {
            return Err(InferenceError::Output {
                model: self.contract.name.clone(),
                output: output.to_owned(),
                expected: "f32".into(),
                found: format!("{found:?}"),
            }
            .into());
        };
        Ok(OutputTensor {
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

    fn at_once(&self) -> usize {
        self.at_once
    }

    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
        run_batch(&self.contract, &self.ports, input, batch, |given| {
            self.run_once(given)
        })
    }

    fn beside(&self, work: &mut (dyn FnMut() + Send)) {
        self.pool_at(0).run(work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::graph::written;
    use crate::inference::testing::{bytes_with_operator, small_model};

    #[test]
    fn a_process_that_forked_off_has_no_threads_to_load_a_model_with() {
        let own = std::process::id();
        assert!(check_process(own).is_ok());
        let said = check_process(own + 1).expect_err("another process");
        assert!(
            said.to_string()
                .starts_with("the embedded runtime was started before this process forked")
        );
    }

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
                text.contains(operator) && text.contains("the embedded runtime"),
                "{text}"
            );
        }
    }

    #[test]
    fn windows_over_three_axes_are_refused_with_a_way_out() {
        let five = [8, 1, 1, 3, 3];
        let sources = [
            vec![written::weights("w", 1, &five)],
            vec![
                written::weights("v", 1, &five),
                written::node("Identity", "v", "w", &[]),
            ],
        ];
        let stated: &[&str] = &["kernel_shape=[1,3,3]", "strides=[1,1,1]"];
        for source in sources {
            for (operator, attributes) in [
                ("Conv", &[][..]),
                ("ConvTranspose", stated),
                ("MaxPool", stated),
                ("AveragePool", stated),
            ] {
                let text = refusal(&[
                    source.concat(),
                    written::integers("five", &[-1, 1, 1, 50, 30]),
                    written::node("Reshape", "x five", "clip", &[]),
                    written::node(operator, "clip w", "c", attributes),
                ]);
                assert_eq!(
                    text,
                    format!(
                        "m.onnx: the model's {operator} (\"c\") slides over 3 axes, and the \
                         embedded runtime supports 1 or 2"
                    )
                );
            }
        }
    }

    #[test]
    fn windows_that_leave_out_what_the_runtime_needs_are_refused_with_a_way_out() {
        let pool = written::node("MaxPool", "x", "c", &["kernel_shape=[2,2]"]);
        assert_eq!(
            refusal(&[pool]),
            "m.onnx: the model's MaxPool (\"c\") leaves out strides or the kernel's shape, and the \
             embedded runtime needs them stated"
        );
    }

    /// Returns the error from loading a model of these parts, from `x` to `c`.
    fn refusal(parts: &[Vec<u8>]) -> String {
        let output = written::stated(12, "out", &[0, 8]);
        let flat = written::node("Flatten", "c", "out", &[]);
        let parts = [parts, &[flat, output]].concat();
        let bytes = written::bytes(&[0, 1, 50, 30], &parts);
        let model = Model::from_bytes("m.onnx", bytes, Contract::default()).expect("a graph");
        let Err(error) = RtenRecognizer::load(&model, 1) else {
            panic!("it was loaded");
        };
        let remedy = Some(Remedy::OnnxRuntime);
        assert!(matches!(&error, Error::Input { remedy: found, .. } if *found == remedy));
        error.to_string()
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

//! Runs the command's subcommands, with Python callables as recognizers.

use crate::attend::{self, LOOK};
use crate::errors::exception;
use crate::pack::PyPack;
use edgegait::cli::embed::{self, EmbeddedInputs, Stop};
use edgegait::inference::{Contract, Outputs, Recognizer, RuntimeName};
use ndarray::ArrayD;
use numpy::{IntoPyArray as _, PyArrayDyn, PyArrayMethods as _, PyUntypedArrayMethods as _};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::panic::resume_unwind;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;

/// Number of inputs in a call of a callable.
const AT_ONCE: usize = 256;

/// A request of the working thread to the thread that holds the interpreter: to call a callable with
/// inputs in this shape, and their viewpoints.
struct CallRequest {
    callable: usize,
    input: Vec<f32>,
    shape: Vec<usize>,
    views: Vec<f32>,
    answer: Sender<edgegait::Result<Outputs>>,
}

/// A Python callable as a recognizer. It is called by the thread that called `score`, where context
/// managers are in effect.
struct Callable {
    number: usize,
    contract: Contract,
    runtime: RuntimeName,
    messages: Mutex<Sender<CallRequest>>,
}

impl Recognizer for Callable {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn run(&self, input: &[f32], batch: usize) -> edgegait::Result<Outputs> {
        let frames = self.contract.frames_in(input.len(), batch)?;
        let (answer, answered) = channel();
        let (input, views) = self.contract.apart(input, batch);
        let message = CallRequest {
            callable: self.number,
            input: input.into_owned(),
            shape: self.contract.input_shape(batch, frames),
            views,
            answer,
        };
        let messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        messages
            .send(message)
            .map_err(|_| edgegait::Error::Cancelled)?;
        drop(messages);
        answered.recv().map_err(|_| edgegait::Error::Cancelled)?
    }

    fn at_once(&self) -> usize {
        AT_ONCE
    }
}

/// Runs a subcommand by words of the command line, and returns its results as JSON. Callables are
/// pairs of a function and its contract as JSON.
#[pyfunction]
#[pyo3(signature = (words, program, callables = Vec::new(), pack = None))]
pub(crate) fn command(
    py: Python<'_>,
    words: Vec<OsString>,
    program: Vec<OsString>,
    callables: Vec<(Py<PyAny>, String)>,
    pack: Option<&PyPack>,
) -> PyResult<String> {
    let (sender, receiver) = channel();
    let stop = Stop::default();
    let mut held = EmbeddedInputs {
        pack: pack.map(PyPack::source),
        program,
        stop: stop.clone(),
        ..EmbeddedInputs::default()
    };
    for (number, (_, contract)) in callables.iter().enumerate() {
        held.recognizers.push(Arc::new(Callable {
            number,
            contract: contract_of(contract)?,
            runtime: RuntimeName {
                name: "python".into(),
                version: Python::version_str()
                    .split(' ')
                    .next()
                    .unwrap_or_default()
                    .into(),
                provider: String::new(),
            },
            messages: Mutex::new(sender.clone()),
        }));
    }
    let functions: Vec<RecognizerFunction> = callables
        .into_iter()
        .zip(&held.recognizers)
        .map(|((function, _), one)| RecognizerFunction {
            function,
            classes: Some(one.contract().classes.len()).filter(|&count| count > 0),
        })
        .collect();
    py.detach(move || {
        std::thread::scope(|scope| {
            let worker = move || {
                // The receiver waits until it is dropped.
                let _sender = sender;
                embed::results(&words, held)
            };
            let worker = Builder::new().spawn_scoped(scope, worker);
            let worker = worker.map_err(|error| exception(&edgegait::Error::Threads(error)))?;
            let raised = served(&receiver, &functions, &stop);
            let done = worker.join().unwrap_or_else(|panic| resume_unwind(panic));
            match raised {
                Some(raised) => Err(raised),
                None => done.map_err(|error| exception(&error)),
            }
        })
    })
}

/// A recognizer in Python.
struct RecognizerFunction {
    function: Py<PyAny>,
    /// The number of its contract's classes, if it has any.
    classes: Option<usize>,
}

/// Calls functions until the work is done, and checks for signals. Returns the first exception that
/// either raised, which ends the work.
fn served(
    messages: &Receiver<CallRequest>,
    functions: &[RecognizerFunction],
    stop: &Stop,
) -> Option<PyErr> {
    let mut raised = None;
    loop {
        match messages.recv_timeout(LOOK) {
            Ok(CallRequest {
                callable,
                input,
                shape,
                views,
                answer,
            }) => {
                let outputs = if raised.is_none() {
                    let called = Python::attach(|py| {
                        py.check_signals()?;
                        call(py, &functions[callable], input, shape, views)
                    });
                    called.map_err(|error| {
                        raised = Some(error);
                        stop.end();
                        edgegait::Error::Cancelled
                    })
                } else {
                    Err(edgegait::Error::Cancelled)
                };
                // The requester may be gone.
                let _ = answer.send(outputs);
            }
            Err(RecvTimeoutError::Disconnected) => return raised,
            Err(RecvTimeoutError::Timeout) => {
                if raised.is_none() {
                    raised = attend::raised();
                    if raised.is_some() {
                        stop.end();
                    }
                }
            }
        }
    }
}

/// Checks that JSON is the contract of a recognizer.
#[pyfunction]
pub(crate) fn check_contract(json: &str) -> PyResult<()> {
    contract_of(json).map(drop)
}

/// Reads the contract of a recognizer from JSON.
fn contract_of(json: &str) -> PyResult<Contract> {
    let contract: Contract = serde_json::from_str(json).map_err(|error| {
        let text = error.to_string();
        // The user has not seen this JSON, so its line numbers are omitted.
        let text = text.split(" at line ").next().unwrap_or_default();
        PyValueError::new_err(format!("the contract of a recognizer: {text}"))
    })?;
    contract
        .check(Path::new("the contract of a recognizer"))
        .map_err(|error| exception(&error))?;
    Ok(contract)
}

/// Calls a function with an array, and with viewpoints if there are any, and returns its embeddings
/// and scores, if any.
fn call(
    py: Python<'_>,
    recognizer: &RecognizerFunction,
    input: Vec<f32>,
    shape: Vec<usize>,
    views: Vec<f32>,
) -> PyResult<Outputs> {
    let batch = shape.first().copied().unwrap_or(0);
    let input = ArrayD::from_shape_vec(shape, input)
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let input = input.into_pyarray(py);
    let answer = if views.is_empty() {
        recognizer.function.call1(py, (input,))?
    } else {
        let views = ArrayD::from_shape_vec(vec![batch, 2], views)
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        recognizer
            .function
            .call1(py, (input, views.into_pyarray(py)))?
    };
    let (embedding, scores): (Py<PyAny>, Option<Py<PyAny>>) = answer.extract(py)?;
    let (sides, embedding) = numbers(py, &embedding, "embeddings", batch)?;
    let (embedding_dims, embedding_parts) = match sides[..] {
        [dims] => (dims, 1),
        [dims, parts] => (dims * parts, parts),
        _ => {
            return Err(PyValueError::new_err(format!(
                "expected embeddings [{batch}, numbers] or [{batch}, numbers, parts], found {} axes",
                sides.len() + 1
            )));
        }
    };
    let mut outputs = Outputs {
        embedding,
        embedding_dims,
        embedding_parts,
        ..Outputs::default()
    };
    if let Some(scores) = scores {
        let (sides, scores) = numbers(py, &scores, "scores", batch)?;
        let [classes] = sides[..] else {
            return Err(PyValueError::new_err(format!(
                "expected scores [{batch}, classes]"
            )));
        };
        if recognizer
            .classes
            .is_some_and(|expected| expected != classes)
        {
            return Err(PyValueError::new_err(format!(
                "expected scores of the {} classes of the contract, found {classes}",
                recognizer.classes.unwrap_or_default()
            )));
        }
        (outputs.scores, outputs.classes) = (Some(scores), classes);
    }
    outputs.count_non_finite();
    Ok(outputs)
}

/// Returns the shape of an array of f32 without the first axis, which is `batch`, and its values.
fn numbers(
    py: Python<'_>,
    array: &Py<PyAny>,
    what: &str,
    batch: usize,
) -> PyResult<(Vec<usize>, Vec<f32>)> {
    let array = array.bind(py).cast::<PyArrayDyn<f32>>()?;
    let shape = array.shape();
    if shape.first() != Some(&batch) || shape.len() < 2 || shape[1..].contains(&0) {
        return Err(PyValueError::new_err(format!(
            "expected {what} of {batch} inputs along the first axis, found an array of shape {shape:?}"
        )));
    }
    Ok((
        shape[1..].to_vec(),
        array.readonly().as_array().iter().copied().collect(),
    ))
}

/// Runs the command of these words, the first of which is its own name, and returns its exit code.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, words: Vec<OsString>, program: Vec<OsString>) -> u8 {
    py.detach(|| edgegait::cli::code_of(words, program))
}

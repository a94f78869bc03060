//! ONNX Runtime, loaded from a shared library: the only file that names `ort`.
//!
//! `ort` panics if it has to find the library by itself, so nothing of it may be
//! called before [`Ort::load`] has succeeded, not even to make an error.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ort::environment::Environment;
use ort::session::{HasSelectedOutputs, builder::SessionBuilder};
use ort::session::{OutputSelector, RunOptions, Session, SessionOutputs};
use ort::value::TensorRef;

use super::library::Library;
use super::model::{Model, Ports};
use super::{Contract, Matrix, Outputs, Recognizer, RuntimeName, matrix_shape, run_batch};
use crate::error::{Error, Result};

/// The library that this process has loaded.
#[derive(Clone, Debug)]
pub(super) struct Ort {
    environment: Environment,
    library: PathBuf,
    runtime: RuntimeName,
}

/// A process has one ONNX Runtime, and `ort` one environment, which cannot be made again.
static LOADED: Mutex<Option<Ort>> = Mutex::new(None);

impl Ort {
    pub fn load(path: &Path) -> Result<Self> {
        let library = Library::inspect(path)?;
        let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(ort) = loaded.as_ref() {
            if ort.library == library.path {
                return Ok(ort.clone());
            }
            return Err(Error::input(
                path,
                format!(
                    "a process loads one ONNX Runtime, and has {}",
                    ort.library.display()
                ),
            ));
        }
        let builder =
            ort::init_from(&library.path).map_err(|error| Error::input(path, reason(&error)))?;
        let environment = builder
            .with_name("edgegait")
            .with_telemetry(false)
            .build()
            .map_err(|error| Error::input(path, format!("ONNX Runtime does not start: {error}")))?;
        if std::env::var_os("ORT_LOG").is_none() {
            // Whatever goes wrong comes back as an error: standard error stays clean.
            environment.set_log_level(ort::logging::LogLevel::Fatal);
        }
        let version = library.version.unwrap_or_else(version_of_build);
        let ort = Self {
            environment,
            library: library.path,
            runtime: RuntimeName {
                name: "onnxruntime".into(),
                version,
            },
        };
        *loaded = Some(ort.clone());
        Ok(ort)
    }

    pub fn runtime_name(&self) -> &RuntimeName {
        &self.runtime
    }
}

/// The loader's own words, which `ort` leaves out.
fn reason(error: &ort::LoadDynamicError) -> String {
    let source = match error {
        ort::LoadDynamicError::Dlopen { error, .. } => std::error::Error::source(error),
        _ => None,
    };
    match source {
        Some(source) => format!("cannot be loaded: {source}"),
        None => format!("cannot be used: {error}"),
    }
}

/// What ONNX Runtime says about its build, where the file does not state a version.
fn version_of_build() -> String {
    let branch = ort::info()
        .split([' ', ','])
        .find_map(|word| word.strip_prefix("git-branch=rel-"));
    branch.unwrap_or("unknown").to_owned()
}

/// A model loaded by ONNX Runtime.
pub(super) struct OrtRecognizer {
    /// Sessions are not thread safe (see the documentation of [`Session`]).
    session: Mutex<(Session, RunOptions<HasSelectedOutputs>)>,
    runtime: RuntimeName,
    contract: Contract,
    ports: Ports,
}

impl OrtRecognizer {
    pub fn load(ort: &Ort, model: &Model, threads: usize) -> Result<Self> {
        let refuse = |error: ort::Error| {
            Error::input(
                model.path(),
                format!("ONNX Runtime refuses the model: {error}"),
            )
        };
        let ports = model.ports().clone();
        let session = builder(ort, threads)
            .and_then(|mut builder| builder.commit_from_memory(model.bytes()))
            .map_err(refuse)?;
        let mut selected = OutputSelector::no_default().with(&ports.embedding);
        if let Some(scores) = ports
            .scores
            .as_ref()
            .filter(|name| **name != ports.embedding)
        {
            selected = selected.with(scores);
        }
        let options = RunOptions::new().map_err(refuse)?.with_outputs(selected);
        Ok(Self {
            session: Mutex::new((session, options)),
            runtime: ort.runtime.clone(),
            contract: model.contract().clone(),
            ports,
        })
    }

    fn run_once(&self, geis: &[f32], batch: usize) -> Result<(Matrix, Option<Matrix>)> {
        let failed = |error: ort::Error| {
            Error::Failed(format!("{}: ONNX Runtime: {error}", self.contract.name))
        };
        let shape = [batch, 1, self.contract.rows, self.contract.columns];
        let input = TensorRef::from_array_view((shape, geis)).map_err(failed)?;
        let mut guard = self.session.lock().unwrap_or_else(PoisonError::into_inner);
        let (session, options) = &mut *guard;
        let outputs = session
            .run_with_options(ort::inputs![input], options)
            .map_err(failed)?;
        let embedding = self.matrix(&outputs, &self.ports.embedding)?;
        let scores = match &self.ports.scores {
            Some(name) => Some(self.matrix(&outputs, name)?),
            None => None,
        };
        Ok((embedding, scores))
    }

    fn matrix(&self, outputs: &SessionOutputs<'_>, name: &str) -> Result<Matrix> {
        let failed = |problem: String| Error::Failed(format!("{}: {problem}", self.contract.name));
        let output = outputs
            .get(name)
            .ok_or_else(|| failed(format!("ONNX Runtime gave no output {name:?}")))?;
        let (shape, numbers) = output
            .try_extract_tensor::<f32>()
            .map_err(|error| failed(format!("expected the output {name:?} as f32: {error}")))?;
        let shape: Vec<usize> = shape
            .iter()
            .map(|&size| usize::try_from(size).unwrap_or(0))
            .collect();
        let (rows, columns) = matrix_shape(&self.contract, name, &shape)?;
        Ok((rows, columns, numbers.to_vec()))
    }
}

fn builder(ort: &Ort, threads: usize) -> ort::Result<SessionBuilder> {
    Ok(Session::builder(&ort.environment)?
        .with_intra_threads(threads)?
        .with_inter_threads(1)?)
}

impl Recognizer for OrtRecognizer {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn run(&self, geis: &[f32], batch: usize) -> Result<Outputs> {
        run_batch(&self.contract, &self.ports, (geis, batch), |geis, batch| {
            self.run_once(geis, batch)
        })
    }
}

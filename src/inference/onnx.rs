//! ONNX Runtime, loaded from a shared library: the only file that names `ort`.
//!
//! `ort` panics if it has to find the library by itself, so none of its functions may be called
//! before [`Ort::load`] has succeeded, not even to construct an error.

use super::library::Library;
use super::model::Model;
use super::ports::{Element, Ports, byte_of};
use super::profile;
use super::provider::{BareLoop, BareOutputs, Provider, RuntimeName};
use super::{
    Contract, GivenInputs, ModelOutputs, OperatorTime, OutputTensor, Outputs, ProfiledOperations,
    Recognizer, run_batch,
};
use crate::error::{Cause, Error, InferenceError, Result, SettingError};
use crate::files::Staging;
use ort::environment::Environment;
use ort::ep::{self, ExecutionProvider, ExecutionProviderDispatch};
use ort::memory::Allocator;
use ort::session::builder::SessionBuilder;
use ort::session::{
    HasSelectedOutputs, OutputSelector, RunOptions, Session, SessionInputValue, SessionOutputs,
};
use ort::value::{Tensor as OrtTensor, TensorRef};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The library that this process has loaded.
#[derive(Clone, Debug)]
pub(super) struct Ort {
    environment: Environment,
    library: PathBuf,
    version: String,
}

/// The loaded library. A process has one ONNX Runtime, and `ort` one environment, which cannot be
/// created again.
static LOADED: Mutex<Option<Ort>> = Mutex::new(None);

impl Ort {
    pub(super) fn load(path: &Path) -> Result<Self> {
        let library = Library::inspect(path)?;
        let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(ort) = loaded.as_ref() {
            if ort.library == library.path {
                return Ok(ort.clone());
            }
            return Err(Error::input(
                path,
                format!(
                    "a process can load only one ONNX Runtime, and has loaded {}",
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
            // Failures come back as errors, so standard error stays clean.
            environment.set_log_level(ort::logging::LogLevel::Fatal);
        }
        let version = library.version.unwrap_or_else(version_of_build);
        let ort = Self {
            environment,
            library: library.path,
            version,
        };
        *loaded = Some(ort.clone());
        Ok(ort)
    }

    pub(super) fn runtime_name(&self, provider: Provider) -> RuntimeName {
        RuntimeName {
            name: "onnxruntime".into(),
            version: self.version.clone(),
            provider: provider.name().into(),
        }
    }

    pub(super) fn library(&self) -> &Path {
        &self.library
    }

    /// Checks that the library was built with this provider.
    pub(super) fn require(&self, provider: Provider) -> Result<()> {
        if is_built_with(provider) {
            return Ok(());
        }
        let known = Provider::ALL.into_iter();
        let known = known.filter(|&provider| is_built_with(provider));
        let problem = SettingError::Provider {
            provider: provider.name(),
            known: known.map(|provider| provider.name().to_owned()).collect(),
            library: self.library.clone(),
        };
        Err(problem.refuses("provider", provider.name()))
    }
}

/// `ort`'s form of a provider, and the function that checks whether the library has it.
struct Registered {
    dispatch: ExecutionProviderDispatch,
    is_available: fn() -> ort::Result<bool>,
}

fn registered<P>(provider: P) -> Registered
where
    P: ExecutionProvider + Into<ExecutionProviderDispatch>,
{
    Registered {
        dispatch: provider.into().error_on_failure(),
        is_available: P::is_available,
    }
}

/// Returns `ort`'s form of a provider. `threads` are for providers that have threads of their own.
fn execution_provider(provider: Provider, threads: usize) -> Registered {
    match provider {
        Provider::Cpu => registered(ep::CPU::default()),
        Provider::Xnnpack => {
            let threads = NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN);
            registered(ep::XNNPACK::default().with_intra_op_num_threads(threads))
        }
        Provider::Acl => registered(ep::ACL::default()),
        #[expect(
            deprecated,
            reason = "ONNX Runtime 1.18 to 1.21, which boards have, knows it"
        )]
        Provider::Armnn => registered(ep::ArmNN::default()),
        Provider::Nnapi => registered(ep::NNAPI::default()),
        Provider::Coreml => registered(ep::CoreML::default()),
        Provider::Qnn => registered(ep::QNN::default()),
        Provider::Rknpu => registered(ep::RKNPU::default()),
        Provider::Cuda => registered(ep::CUDA::default()),
        Provider::Tensorrt => registered(ep::TensorRT::default()),
        Provider::Openvino => registered(ep::OpenVINO::default()),
    }
}

fn is_built_with(provider: Provider) -> bool {
    (execution_provider(provider, 1).is_available)().unwrap_or(false)
}

/// Returns the reason with the loader's own message, which `ort` leaves out.
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

/// Returns the version in ONNX Runtime's build information, for a file that does not state one.
fn version_of_build() -> String {
    let branch = ort::info()
        .split([' ', ','])
        .find_map(|word| word.strip_prefix("git-branch=rel-"));
    branch.unwrap_or("unknown").to_owned()
}

/// The maximum number of values in an input that is copied into an existing tensor: copying 6 kB
/// takes less than creating and releasing a tensor, copying 100 kB does not.
const SMALL: usize = 4096;

/// A model loaded by ONNX Runtime.
pub(super) struct OrtRecognizer {
    /// Sessions are not thread safe (see the documentation of [`Session`]).
    loaded: Mutex<LoadedSession>,
    runtime: RuntimeName,
    contract: Contract,
    at_once: usize,
    ports: Ports,
}

struct LoadedSession {
    session: Session,
    options: RunOptions<HasSelectedOutputs>,
    ready: Option<Ready>,
}

/// The tensors of the last small input. The next input of the same shape reuses them, which saves a
/// model of 5 us a tenth.
struct Ready {
    shape: Vec<usize>,
    input: OrtTensor<f32>,
    /// Options that hold the outputs' tensors.
    options: RunOptions<HasSelectedOutputs>,
}

/// Returns a model's inputs by name, in the element type that it takes.
fn inputs<'a>(
    ports: &'a Ports,
    given: GivenInputs<'a>,
) -> ort::Result<Vec<(&'a str, SessionInputValue<'a>)>> {
    let GivenInputs { numbers, shape, .. } = given;
    let input = match ports.element {
        Element::F32 => TensorRef::from_array_view((shape, numbers))?.into(),
        Element::F64 => {
            let numbers: Vec<f64> = numbers.iter().copied().map(f64::from).collect();
            OrtTensor::from_array((shape.to_vec(), numbers))?.into()
        }
        Element::U8 => {
            let bytes: Vec<u8> = numbers.iter().copied().map(byte_of).collect();
            OrtTensor::from_array((shape.to_vec(), bytes))?.into()
        }
    };
    let mut all = vec![(ports.input.as_str(), input)];
    if let Some(view) = &ports.view {
        let views = TensorRef::from_array_view((given.views_shape(), given.views))?;
        all.push((view, views.into()));
    }
    Ok(all)
}

impl OrtRecognizer {
    pub(super) fn load(
        ort: &Ort,
        model: &Model,
        provider: Provider,
        threads: usize,
    ) -> Result<Self> {
        let refuse = |error: ort::Error| {
            Error::input(
                model.path(),
                format!("ONNX Runtime refuses the model: {error}"),
            )
        };
        let ports = model.ports().clone();
        let session = builder(ort, provider, threads)
            .and_then(|mut builder| builder.commit_from_memory(model.bytes()))
            .map_err(refuse)?;
        let options = RunOptions::new()
            .map_err(refuse)?
            .with_outputs(selected(&ports));
        Ok(Self {
            loaded: Mutex::new(LoadedSession {
                session,
                options,
                ready: None,
            }),
            runtime: ort.runtime_name(provider),
            contract: model.contract().clone(),
            at_once: model.at_once(),
            ports,
        })
    }

    /// Returns a loop body with this session and nothing around it.
    pub(super) fn into_bare(self, input: &[f32], outputs: BareOutputs) -> Result<BareLoop> {
        let shape = self
            .contract
            .input_shape(1, self.contract.frames_in(input.len(), 1)?);
        if self.ports.element != Element::F32 || self.ports.view.is_some() {
            return Err(self
                .failed("expected a model that takes f32, and no viewpoints, for a loop around the runtime alone")
                .into());
        }
        let found = self.run_once(GivenInputs {
            numbers: input,
            shape: &shape,
            views: &[],
        })?;
        let ready = self
            .ready(&shape, &found)
            .map_err(|error| self.failed(error))?;
        let input = OrtTensor::from_array((shape, input.to_vec()));
        let input = input.map_err(|error| self.failed(error))?;
        let name = self.contract.name;
        let failed = move |error: ort::Error| InferenceError::OnnxRuntime {
            model: name.clone(),
            cause: error.into(),
        };
        let loaded = self.loaded.into_inner();
        let loaded = loaded.unwrap_or_else(PoisonError::into_inner);
        let options = match outputs {
            BareOutputs::New => loaded.options,
            BareOutputs::Reused => ready.options,
        };
        let mut session = loaded.session;
        Ok(Box::new(move || {
            let outputs = session
                .run_with_options(ort::inputs![&input], &options)
                .map_err(&failed)?;
            let mut sum = 0.0;
            for (_, output) in &outputs {
                let (_, numbers) = output.try_extract_tensor::<f32>().map_err(&failed)?;
                sum += numbers.first().copied().unwrap_or_default();
            }
            Ok(sum)
        }))
    }

    fn run_once(&self, given: GivenInputs<'_>) -> Result<ModelOutputs> {
        let GivenInputs {
            numbers: input,
            shape,
            ..
        } = given;
        let failed = |error: ort::Error| self.failed(error);
        let mut guard = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        let LoadedSession {
            session,
            options,
            ready,
        } = &mut *guard;
        if let Some(tensors) = ready.as_mut().filter(|ready| ready.shape == shape) {
            tensors.input.extract_tensor_mut().1.copy_from_slice(input);
            let run = session.run_with_options(ort::inputs![&tensors.input], &tensors.options);
            if let Ok(outputs) = run {
                return self.found(&outputs);
            }
        }
        // Outputs whose shape depends on the input's numbers may not fit the last tensors.
        *ready = None;
        let inputs = inputs(&self.ports, given).map_err(failed)?;
        let outputs = session.run_with_options(inputs, options).map_err(failed)?;
        let found = self.found(&outputs)?;
        if input.len() <= SMALL && self.is_plain(&outputs) {
            *ready = Some(self.ready(shape, &found).map_err(failed)?);
        }
        Ok(found)
    }

    /// Creates tensors for inputs and outputs of these shapes.
    fn ready(&self, shape: &[usize], found: &ModelOutputs) -> ort::Result<Ready> {
        let allocator = Allocator::default();
        let mut outputs = selected(&self.ports);
        let scores = self.ports.scores.iter().zip(&found.scores);
        for (name, tensor) in
            std::iter::once((&self.ports.embedding, &found.embedding)).chain(scores)
        {
            let tensor = OrtTensor::<f32>::new(&allocator, tensor.shape.clone())?;
            outputs = outputs.preallocate(name, tensor);
        }
        Ok(Ready {
            shape: shape.to_vec(),
            input: OrtTensor::new(&allocator, shape.to_vec())?,
            options: RunOptions::new()?.with_outputs(outputs),
        })
    }

    /// Returns whether all inputs and outputs are f32, as reused tensors are.
    fn is_plain(&self, outputs: &SessionOutputs<'_>) -> bool {
        let is_f32 = |name: &String| {
            let output = outputs.get(name);
            output.is_some_and(|output| output.try_extract_tensor::<f32>().is_ok())
        };
        let used = std::iter::once(&self.ports.embedding).chain(&self.ports.scores);
        self.ports.element == Element::F32 && self.ports.view.is_none() && { used }.all(is_f32)
    }

    fn failed(&self, cause: impl Into<Cause>) -> InferenceError {
        InferenceError::OnnxRuntime {
            model: self.contract.name.clone(),
            cause: cause.into(),
        }
    }

    fn found(&self, outputs: &SessionOutputs<'_>) -> Result<ModelOutputs> {
        let embedding = self.tensor(outputs, &self.ports.embedding)?;
        let scores = match &self.ports.scores {
            Some(name) => Some(self.tensor(outputs, name)?),
            None => None,
        };
        Ok(ModelOutputs { embedding, scores })
    }

    fn tensor(&self, outputs: &SessionOutputs<'_>, name: &str) -> Result<OutputTensor> {
        let output = outputs
            .get(name)
            .ok_or_else(|| self.failed(format!("there is no output {name:?}")))?;
        let sizes = |shape: &[i64]| {
            let sizes = shape.iter();
            sizes
                .map(|&size| usize::try_from(size).unwrap_or(0))
                .collect()
        };
        if let Ok((shape, numbers)) = output.try_extract_tensor::<f64>() {
            #[expect(clippy::cast_possible_truncation, reason = "embeddings are f32")]
            let numbers = numbers.iter().map(|&number| number as f32).collect();
            return Ok(OutputTensor {
                shape: sizes(shape),
                numbers,
            });
        }
        let (shape, numbers) = output.try_extract_tensor::<f32>().map_err(|error| {
            self.failed(format!("expected the output {name:?} as f32: {error}"))
        })?;
        Ok(OutputTensor {
            shape: sizes(shape),
            numbers: numbers.to_vec(),
        })
    }
}

/// Profiles what ran each operation of a model on one input, in a session of its own.
pub(super) fn profile(
    ort: &Ort,
    model: &Model,
    provider: Provider,
    threads: usize,
    input: &[f32],
) -> Result<Vec<ProfiledOperations>> {
    let times = operator_times(ort, model, provider, threads, input, 1)?;
    Ok(times.into_iter().map(|timed| timed.ran).collect())
}

/// Profiles the operations of a model and their times in `runs` inferences, in a session of its
/// own.
pub(super) fn operator_times(
    ort: &Ort,
    model: &Model,
    provider: Provider,
    threads: usize,
    input: &[f32],
    runs: usize,
) -> Result<Vec<OperatorTime>> {
    let contract = model.contract();
    let failed = |cause: Cause| InferenceError::OnnxRuntime {
        model: contract.name.clone(),
        cause,
    };
    let shape = contract.input_shape(1, contract.frames_in(input.len(), 1)?);
    let (numbers, views) = input.split_at(input.len() - contract.view_numbers());
    let given = GivenInputs {
        numbers,
        shape: &shape,
        views,
    };
    let folder = Staging::temporary()?;
    let written = || -> ort::Result<String> {
        let mut session = builder(ort, provider, threads)?
            .with_profiling(folder.path().join("profile"))?
            .commit_from_memory(model.bytes())?;
        for _ in 0..runs {
            session.run(inputs(model.ports(), given)?)?;
        }
        session.end_profiling()
    };
    let path = written().map_err(|error| failed(error.into()))?;
    let text = crate::files::read_to_string(&path)?;
    let times = profile::read_times(&text, runs);
    times.map_err(|error| failed(format!("its profile cannot be read: {error}").into()).into())
}

/// Selects the outputs that are used, each once.
fn selected(ports: &Ports) -> OutputSelector {
    let embedding = OutputSelector::no_default().with(&ports.embedding);
    match &ports.scores {
        Some(name) if *name != ports.embedding => embedding.with(name),
        _ => embedding,
    }
}

fn builder(ort: &Ort, provider: Provider, threads: usize) -> ort::Result<SessionBuilder> {
    let builder = Session::builder(&ort.environment)?.with_inter_threads(1)?;
    Ok(match provider {
        Provider::Cpu => builder.with_intra_threads(threads)?,
        // It has its own thread pool, with which the session's would compete.
        Provider::Xnnpack => builder
            .with_intra_threads(1)?
            .with_execution_providers([execution_provider(provider, threads).dispatch])?,
        _ => builder
            .with_intra_threads(threads)?
            .with_execution_providers([execution_provider(provider, threads).dispatch])?,
    })
}

impl Recognizer for OrtRecognizer {
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
}

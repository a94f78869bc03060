//! A recognizer's file, checked against its contract before any runtime sees it.
//!
//! No runtime compares a model with the inputs that a caller intends: with a wrong but consistent
//! shape it runs and scores nonsense. So the graph is compared with the contract here, once.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::contract::{Contract, OutputNames};
use super::graph::Graph;
use super::guess;
use super::ports::{Batching, EMBEDDING, Ports, list_of};
use crate::error::{Error, Result};
use crate::files::{InputFile, sha256_of_bytes};
use edgegait_core::format::RECOGNIZER_MAGIC;
use edgegait_core::silhouette::Size;

/// The maximum number of bytes a model may have (our choice; protobuf's limit is 2 GiB).
const MAX_BYTES: u64 = 1 << 30;
/// Multiply-accumulates of a batch: a fraction of a second on one core, some seconds on a small
/// board. Our choice.
const MACS_AT_ONCE: u64 = 2_000_000_000;
/// The most memory of one tensor, and of the process that tries a model, MB. Our choice.
const MEMORY_MB: u64 = 2048;
/// The variable of the environment that replaces it.
const MEMORY_VARIABLE: &str = "EDGEGAIT_MODEL_MB";
/// Inputs of a batch if the model's operations cannot be counted. Our choice.
const UNCOUNTED_AT_ONCE: usize = 32;

/// Returns the memory that a foreign model may have when it is tried, bytes: 2,048 MB, or what the
/// variable `EDGEGAIT_MODEL_MB` of the environment says. A tensor of more is refused beforehand.
///
/// # Errors
/// If the variable is not a number of 1 to 1,000,000.
pub fn model_memory() -> Result<u64> {
    let Some(stated) = std::env::var_os(MEMORY_VARIABLE) else {
        return Ok(MEMORY_MB << 20);
    };
    let number = stated.to_str().and_then(|text| text.parse::<u64>().ok());
    let number = number.filter(|number| (1..=1_000_000).contains(number));
    number.map(|number| number << 20).ok_or_else(|| {
        let stated = stated.to_string_lossy();
        Error::Usage(format!(
            "{MEMORY_VARIABLE}: expected megabytes of 1 to 1,000,000, found {stated:?}"
        ))
    })
}

/// A model whose inputs and outputs agree with its contract.
#[derive(Clone, Debug)]
pub struct Model {
    path: PathBuf,
    bytes: Cow<'static, [u8]>,
    graph: Graph,
    contract: Contract,
    ports: Ports,
    /// Whether it was read from a file, with the contract beside it if there is one.
    is_file: bool,
    /// Whether no contract lies beside it, so that the contract is guessed from its shape.
    is_guessed: bool,
}

impl Model {
    /// Reads `path` and the contract beside it. Without one, the contract is guessed from the shape
    /// of the model's input, or else the default; a warning states this.
    ///
    /// # Errors
    /// If a file cannot be read, or as [`Self::from_bytes`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::opened(path.as_ref(), None)
    }

    /// Reads `path` and the contract beside it. Without one, the contract is `usual`.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_or(path: impl AsRef<Path>, usual: &Contract) -> Result<Self> {
        Self::opened(path.as_ref(), Some(usual))
    }

    fn opened(path: &Path, usual: Option<&Contract>) -> Result<Self> {
        let metadata = std::fs::metadata(path).map_err(|error| Error::io(path, error))?;
        if !metadata.is_file() {
            return Err(Error::input(
                path,
                "expected an ONNX model, found no regular file",
            ));
        }
        if metadata.len() > MAX_BYTES {
            return Err(Error::input(
                path,
                format!(
                    "expected a model of at most {MAX_BYTES} bytes, found {}",
                    metadata.len()
                ),
            ));
        }
        let bytes = crate::files::read(path)?;
        if bytes.starts_with(&RECOGNIZER_MAGIC) {
            return Err(Error::input(
                path,
                "expected an ONNX model, found a recognizer for firmware (which edgegait score takes)",
            ));
        }
        let stated = Contract::stated_beside(path)?;
        let graph = Graph::read(path, &bytes)?;
        let guessed = match (&stated, usual) {
            (None, None) => guess::contract(&graph),
            _ => None,
        };
        // Without a stated contract, even the default is a guess.
        let is_guessed = stated.is_none() && usual.is_none();
        let contract = stated.or_else(|| usual.cloned()).or(guessed);
        Ok(Self {
            is_file: true,
            is_guessed,
            ..Self::checked(path, bytes.into(), graph, contract.unwrap_or_default())?
        })
    }

    /// Checks a model in memory; `path` is for messages, and its stem names the recognizer if the
    /// contract does not.
    ///
    /// # Errors
    /// If the bytes are not an ONNX model, or its inputs and outputs do not agree with `contract`.
    pub fn from_bytes(
        path: impl AsRef<Path>,
        bytes: impl Into<Cow<'static, [u8]>>,
        contract: Contract,
    ) -> Result<Self> {
        let (path, bytes) = (path.as_ref(), bytes.into());
        let graph = Graph::read(path, &bytes)?;
        Self::checked(path, bytes, graph, contract)
    }

    fn checked(
        path: &Path,
        bytes: Cow<'static, [u8]>,
        graph: Graph,
        mut contract: Contract,
    ) -> Result<Self> {
        if contract.size().is_none() {
            return Err(Error::input(
                path,
                format!(
                    "silhouettes are drawn as {}: found {} rows and {} columns in its .toml (the defaults are 50 and 30; \
                     if the model takes another size, export it for one of these)",
                    Size::ALL.map(Size::name).join(", "),
                    contract.rows,
                    contract.columns
                ),
            ));
        }
        let (ports, frames) =
            Ports::find(&graph, &contract).map_err(|problem| Error::input(path, problem))?;
        contract.frames = contract.frames.or(frames);
        let shape = contract.input_shape(1, contract.frames.unwrap_or(1));
        let shape: Vec<u64> = shape.iter().map(|&side| side as u64).collect();
        graph
            .check_memory(&shape, model_memory()?)
            .map_err(|problem| Error::input(path, problem))?;
        if contract.name.is_empty() {
            let stem = path.file_stem().unwrap_or(path.as_os_str());
            contract.name = stem.to_string_lossy().into_owned();
        }
        Ok(Self {
            path: path.to_path_buf(),
            bytes,
            graph,
            contract,
            ports,
            is_file: false,
            is_guessed: false,
        })
    }

    /// Renames the model in results and messages.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.contract.name = name.into();
        self
    }

    /// Returns the path of the model.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the file's path and hash, for results.
    #[must_use]
    pub fn input(&self) -> InputFile {
        InputFile {
            path: self.path.display().to_string(),
            sha256: sha256_of_bytes(&self.bytes),
        }
    }

    /// Returns the model's file and, if the contract was read from one, the contract's file.
    ///
    /// # Errors
    /// If the contract's file can no longer be read.
    pub fn inputs(&self) -> Result<Vec<InputFile>> {
        let contract = Contract::path_beside(&self.path);
        let is_read = self.is_file && contract.is_file();
        let contract = is_read.then(|| InputFile::read(contract)).transpose()?;
        Ok(std::iter::once(self.input()).chain(contract).collect())
    }

    /// Returns whether no contract lies beside it, so that the contract is guessed from its shape.
    #[must_use]
    pub fn is_guessed(&self) -> bool {
        self.is_guessed
    }

    /// Returns whether it was read from a file, which can be anybody's.
    #[must_use]
    pub fn is_file(&self) -> bool {
        self.is_file
    }

    /// Returns the file's content.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the description of the model in its file.
    #[must_use]
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Returns the contract. Its name is never empty, and its frames are set if the file fixes
    /// their number.
    #[must_use]
    pub fn contract(&self) -> &Contract {
        &self.contract
    }

    /// Returns how many inputs one call may have.
    #[must_use]
    pub fn batching(&self) -> Batching {
        self.ports.batching
    }

    /// Counts the multiply-accumulates of one input (of one frame if their number is free). Returns
    /// `None` if the operations cannot be counted.
    pub(super) fn macs(&self) -> Option<u64> {
        let frames = self.contract.frames.unwrap_or(1);
        let shape = self.contract.input_shape(1, frames);
        let shape: Vec<u64> = shape.iter().map(|&side| side as u64).collect();
        self.graph.macs(&shape).ok()
    }

    /// Returns the largest useful batch: as many inputs as take 2,000 million multiply-accumulates,
    /// at least one; 32 if its operations cannot be counted.
    #[must_use]
    pub fn at_once(&self) -> usize {
        let count = |macs: u64| usize::try_from(MACS_AT_ONCE / macs.max(1)).unwrap_or(usize::MAX);
        let counted = self.macs().map(count);
        counted.unwrap_or(UNCOUNTED_AT_ONCE).max(1)
    }

    /// Returns warnings for readers of its results.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let named = |warning| format!("{}: {warning}", self.contract.name);
        self.own_warnings().map(named).collect()
    }

    /// Returns the same warnings without the model's name.
    pub(crate) fn own_warnings(&self) -> impl Iterator<Item = String> {
        let guessed = self.is_guessed.then(|| guess::said(&self.contract));
        let is_alone = self.batching() == Batching::DynamicQuantization;
        let alone = is_alone.then(|| {
            "quantised dynamically, so results would depend on the other inputs of a batch: inputs are run one \
             at a time (static QDQ quantisation has no such limit)"
                .to_owned()
        });
        let others = self.graph.outputs.len() > 1 && !self.are_outputs_named();
        let taken = others.then(|| {
            format!(
                "of the outputs {}, {:?} is used as the embedding{} (a .toml can name others under [outputs])",
                list_of(&self.graph.outputs),
                self.ports.embedding,
                match &self.ports.scores {
                    Some(scores) => format!(", and {scores:?} as class scores"),
                    None => String::new(),
                }
            )
        });
        let idle = self.contract.outputs.scores.is_some() && self.contract.classes.is_empty();
        let idle = idle.then(|| {
            "class scores are not used because its .toml names no classes: the nearest embedding decides"
                .to_owned()
        });
        let training = self.graph.is_in_training_mode().then(|| {
            "was exported in training mode, so its answers depend on chance or on the other inputs of a batch \
             (call .eval() before the export)"
                .to_owned()
        });
        let all = guessed.into_iter().chain(alone).chain(taken);
        all.chain(idle).chain(training)
    }

    /// Returns whether the contract or the outputs' names state which output is which.
    fn are_outputs_named(&self) -> bool {
        let OutputNames { embedding, scores } = &self.contract.outputs;
        embedding.is_some() || scores.is_some() || self.ports.embedding == EMBEDDING
    }

    /// Returns the contract with the names of the outputs that are used.
    #[must_use]
    pub fn stated_contract(&self) -> Contract {
        let mut contract = self.contract.clone();
        contract.outputs = OutputNames {
            embedding: Some(self.ports.embedding.clone()),
            scores: self.ports.scores.clone(),
        };
        contract
    }

    pub(super) fn ports(&self) -> &Ports {
        &self.ports
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::testing::{
        bytes_of_a_mean_over_frames, bytes_with_operator, contract_of_sequences,
    };

    #[test]
    fn frames_that_the_file_fixes_enter_the_contract() {
        let bytes = bytes_of_a_mean_over_frames(None, Some(30));
        let model = Model::from_bytes("m.onnx", bytes, contract_of_sequences()).expect("usable");
        assert_eq!(model.contract().frames, Some(30));
    }

    #[test]
    fn dynamically_quantized_models_are_run_one_at_a_time_with_a_warning() {
        for (operator, domain) in [
            ("DynamicQuantizeLinear", ""),
            ("DynamicQuantizeMatMul", "com.microsoft"),
        ] {
            let bytes = bytes_with_operator(operator, domain);
            let model = Model::from_bytes("m.onnx", bytes, Contract::default()).expect("a graph");
            assert_eq!(model.batching(), Batching::DynamicQuantization);
            let warnings = model.warnings();
            assert!(
                warnings[0].starts_with("m: quantised dynamically"),
                "{warnings:?}"
            );
        }
        let plain = bytes_with_operator("QuantizeLinear", "");
        let model = Model::from_bytes("m.onnx", plain, Contract::default()).expect("a graph");
        assert_eq!(
            (model.batching(), model.warnings()),
            (Batching::Any, Vec::new())
        );
    }

    #[test]
    fn the_longer_an_input_takes_the_fewer_are_given_at_once() {
        let linear = Model::open("models/side.onnx").expect("a model");
        assert_eq!(linear.at_once(), 2_000_000_000 / 38_150);
        let sequences = bytes_of_a_mean_over_frames(None, Some(30));
        let model = Model::from_bytes("m.onnx", sequences, contract_of_sequences());
        assert!(model.expect("usable").at_once() >= 1);
        let unknown = bytes_with_operator("Unheard", "of.nobody");
        let model = Model::from_bytes("m.onnx", unknown, Contract::default()).expect("a graph");
        assert_eq!(model.at_once(), 32);
    }

    #[test]
    fn the_contract_is_an_input_where_it_was_read_from_a_file() {
        let paths = |model: &Model| -> Vec<String> {
            let inputs = model.inputs().expect("readable");
            inputs.into_iter().map(|input| input.path).collect()
        };
        let opened = Model::open("models/side.onnx").expect("a model");
        assert_eq!(paths(&opened), ["models/side.onnx", "models/side.toml"]);
        let bytes = opened.bytes().to_vec();
        let built_in = Model::from_bytes("models/side.onnx", bytes, opened.contract().clone());
        assert_eq!(paths(&built_in.expect("the same")), ["models/side.onnx"]);
    }

    #[test]
    fn files_that_are_missing_or_folders_are_refused() {
        assert!(matches!(
            Model::open("/no/such.onnx"),
            Err(Error::Io { .. })
        ));
        assert!(
            Model::open("/")
                .expect_err("a folder")
                .to_string()
                .contains("no regular file")
        );
    }
}

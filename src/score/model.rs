//! A recognizer's file, checked against its contract before any runtime sees it.
//!
//! No runtime compares a model with what a caller means to feed it: a wrong but
//! consistent shape runs and scores nonsense. The graph is compared here once.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::contract::Contract;
use super::graph::{Dimension, Graph, Port};
use crate::error::{Error, Result};
use crate::train::onnx::{EMBEDDING, SCORES};

/// Most bytes a model may have (ours; protobuf itself ends at 2 GiB).
const MAX_BYTES: u64 = 1 << 30;

/// A model whose inputs and outputs agree with its contract.
#[derive(Clone, Debug)]
pub struct Model {
    path: PathBuf,
    bytes: Cow<'static, [u8]>,
    graph: Graph,
    contract: Contract,
    ports: Ports,
}

/// Which inputs and outputs of a model are used, and how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Ports {
    pub input: String,
    pub embedding: String,
    pub scores: Option<String>,
    /// Whether the file takes one GEI at a time only.
    pub one_at_a_time: bool,
}

impl Model {
    /// Reads `path` and the contract beside it.
    ///
    /// # Errors
    /// If a file cannot be read, or as [`Self::from_bytes`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
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
        let bytes = std::fs::read(path).map_err(|error| Error::io(path, error))?;
        Self::from_bytes(path, bytes, Contract::beside(path)?)
    }

    /// Checks a model that is in memory; `path` is for messages, and its stem names the
    /// recognizer if the contract does not.
    ///
    /// # Errors
    /// If the bytes are no ONNX model, or its inputs and outputs do not agree with `contract`.
    pub fn from_bytes(
        path: impl AsRef<Path>,
        bytes: impl Into<Cow<'static, [u8]>>,
        mut contract: Contract,
    ) -> Result<Self> {
        let (path, bytes) = (path.as_ref().to_path_buf(), bytes.into());
        let graph = Graph::read(&path, &bytes)?;
        let ports =
            Ports::find(&graph, &contract).map_err(|problem| Error::input(&path, problem))?;
        if contract.name.is_empty() {
            let stem = path.file_stem().unwrap_or(path.as_os_str());
            contract.name = stem.to_string_lossy().into_owned();
        }
        Ok(Self {
            path,
            bytes,
            graph,
            contract,
            ports,
        })
    }

    /// Where the model is from.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's content.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// What the file says about itself.
    #[must_use]
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// What the model expects and promises; its name is never empty.
    #[must_use]
    pub fn contract(&self) -> &Contract {
        &self.contract
    }

    pub(super) fn ports(&self) -> &Ports {
        &self.ports
    }
}

impl Ports {
    fn find(graph: &Graph, contract: &Contract) -> std::result::Result<Self, String> {
        let (rows, columns) = (contract.rows, contract.columns);
        let [input] = graph.inputs.as_slice() else {
            return Err(format!(
                "expected one input of f32 [N, 1, {rows}, {columns}], found {}",
                list(&graph.inputs)
            ));
        };
        let wrong = || {
            format!(
                "expected the input as f32 [N, 1, {rows}, {columns}], found {input} \
                 (rows and columns can be given in the .toml beside the model)"
            )
        };
        let one_at_a_time = match input.shape.as_deref() {
            Some([batch, channels, height, width])
                if input.element == FLOAT
                    && may_be(channels, 1)
                    && may_be(height, rows)
                    && may_be(width, columns) =>
            {
                match batch {
                    Dimension::Fixed(1) => true,
                    Dimension::Fixed(size) => {
                        return Err(format!(
                            "expected a free batch axis or one of 1, found {size} \
                             (export it with dynamic_axes)"
                        ));
                    }
                    _ => false,
                }
            }
            _ => return Err(wrong()),
        };

        let scores = match &contract.outputs.scores {
            Some(name) => Some(named(graph, name)?),
            None => graph.outputs.iter().find(|port| port.name == SCORES),
        };
        let embedding = match &contract.outputs.embedding {
            Some(name) => named(graph, name)?,
            None => graph
                .outputs
                .iter()
                .find(|port| port.name == EMBEDDING)
                .or_else(|| graph.outputs.iter().find(|port| Some(*port) != scores))
                .or(scores)
                .ok_or("expected an output, found none")?,
        };
        for port in std::iter::once(embedding).chain(scores) {
            let is_matrix = port.shape.as_ref().is_none_or(|shape| shape.len() == 2);
            if port.element != FLOAT || !is_matrix {
                return Err(format!(
                    "expected the output {:?} as f32 [N, numbers], found {port} (end the model with Flatten)",
                    port.name
                ));
            }
        }
        if let (Some(port), people @ 1..) = (scores, contract.classes.len())
            && let Some([_, width]) = port.shape.as_deref()
            && !may_be(width, people)
        {
            return Err(format!(
                "expected a score for each of the {people} classes in the contract, found {port}"
            ));
        }
        Ok(Self {
            input: input.name.clone(),
            embedding: embedding.name.clone(),
            scores: scores.map(|port| port.name.clone()),
            one_at_a_time,
        })
    }
}

/// `TensorProto.DataType.FLOAT`.
const FLOAT: u64 = 1;

fn may_be(dimension: &Dimension, size: usize) -> bool {
    !matches!(dimension, Dimension::Fixed(fixed) if *fixed != size as u64)
}

fn named<'a>(graph: &'a Graph, name: &str) -> std::result::Result<&'a Port, String> {
    graph
        .outputs
        .iter()
        .find(|port| port.name == name)
        .ok_or_else(|| {
            format!(
                "expected an output {name:?} as the contract says, found {}",
                list(&graph.outputs)
            )
        })
}

fn list(ports: &[Port]) -> String {
    if ports.is_empty() {
        return "none".into();
    }
    ports
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{bytes_with, small_model};

    fn refusal(bytes: Vec<u8>, contract: Contract) -> String {
        Model::from_bytes("m.onnx", bytes, contract)
            .expect_err("does not agree")
            .to_string()
    }

    #[test]
    fn our_own_model_agrees_with_the_default_contract() {
        let model = small_model();
        assert_eq!(model.contract().name, "small");
        let ports = Ports {
            input: "gei".into(),
            embedding: "embedding".into(),
            scores: Some("scores".into()),
            one_at_a_time: false,
        };
        assert_eq!(model.ports(), &ports);
    }

    #[test]
    fn a_wrong_input_shape_is_refused_with_both_shapes() {
        let contract = Contract {
            rows: 64,
            columns: 44,
            ..Contract::default()
        };
        assert_eq!(
            refusal(small_model().bytes().to_vec(), contract),
            "m.onnx: expected the input as f32 [N, 1, 64, 44], found \"gei\" f32 [N, 1, 50, 30] \
             (rows and columns can be given in the .toml beside the model)"
        );
    }

    #[test]
    fn inputs_that_are_not_f32_or_not_images_are_refused() {
        let text = refusal(
            bytes_with(2, &[None, Some(1), Some(50), Some(30)], 1, 2),
            Contract::default(),
        );
        assert!(text.contains("found \"gei\" u8 [N, 1, 50, 30]"), "{text}");
        let text = refusal(
            bytes_with(1, &[None, Some(1500)], 1, 2),
            Contract::default(),
        );
        assert!(text.contains("found \"gei\" f32 [N, 1500]"), "{text}");
        let text = refusal(
            bytes_with(1, &[Some(8), Some(1), Some(50), Some(30)], 1, 2),
            Contract::default(),
        );
        assert!(
            text.contains("expected a free batch axis or one of 1, found 8"),
            "{text}"
        );
    }

    #[test]
    fn outputs_that_are_not_f32_matrices_are_refused() {
        let image = [None, Some(1), Some(50), Some(30)];
        let text = refusal(bytes_with(1, &image, 7, 2), Contract::default());
        assert!(text.contains("found \"out\" i64 [N, 4]"), "{text}");
        let text = refusal(bytes_with(1, &image, 1, 3), Contract::default());
        assert!(text.contains("found \"out\" f32 [N, 4, 4]"), "{text}");
    }

    #[test]
    fn a_batch_of_one_and_a_single_output_of_any_name_will_do() {
        let bytes = bytes_with(1, &[Some(1), Some(1), Some(50), Some(30)], 1, 2);
        let model = Model::from_bytes("m.onnx", bytes, Contract::default()).expect("usable");
        assert!(model.ports().one_at_a_time);
        assert_eq!(
            (model.ports().embedding.as_str(), &model.ports().scores),
            ("out", &None)
        );
    }

    #[test]
    fn names_and_classes_of_the_contract_are_compared() {
        let classes = ["a", "b", "c"].map(String::from).to_vec();
        let mut contract = Contract {
            classes,
            ..Contract::default()
        };
        let text = refusal(small_model().bytes().to_vec(), contract.clone());
        assert!(
            text.contains("each of the 3 classes in the contract, found \"scores\" f32 [N, 2]"),
            "{text}"
        );
        contract.outputs.embedding = Some("features".into());
        let text = refusal(small_model().bytes().to_vec(), contract);
        assert!(
            text.contains(
                "expected an output \"features\" as the contract says, found \"embedding\""
            ),
            "{text}"
        );
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

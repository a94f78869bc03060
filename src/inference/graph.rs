//! Reads the description of a model in an ONNX file, without running or unpacking it.
//!
//! Neither runtime lists a model's operators, and one of them silently computes some wrongly, so
//! the file is read before it is loaded.

mod kernels;
mod macs;
mod memory;
mod operands;
mod rules;
mod walk;
mod windows;
#[cfg(test)]
pub(super) mod written;

use super::profile::is_of_8_bits;
use super::protobuf::{Malformed, ProtobufReader};
use crate::error::{Error, FilePlace, Result};
use std::collections::BTreeMap;
use std::path::Path;
use walk::GraphWalk;

pub(super) use windows::SlidingWindow;

/// The description of a model in an ONNX file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    /// Version of the file format.
    pub ir_version: u64,
    /// Version of the default operator set.
    pub opset: u64,
    /// The program that wrote the file; empty if the file does not state it.
    pub producer: String,
    /// How often each operator occurs, subgraphs and functions included. Operators outside the
    /// default domain begin with their domain: `ai.onnx.ml.Scaler`.
    pub operators: BTreeMap<String, usize>,
    /// Weights: numbers in floating-point, 8-bit and 32-bit integer tensors that the file holds,
    /// as initialisers or as constants, scales and zero points of quantisation included.
    /// 64-bit integers are shapes and indices, and do not count.
    pub parameters: u64,
    /// Inputs that a caller has to give.
    pub inputs: Vec<Port>,
    /// Outputs, in order.
    pub outputs: Vec<Port>,
    /// Class names of a classifier of `ai.onnx.ml`, in the order of its scores; empty if there is
    /// no classifier, or it numbers its classes.
    pub labels: Vec<String>,
    /// The operations of the outermost graph, in order.
    nodes: Vec<Node>,
    /// The operations of inner graphs and of functions.
    inner: Vec<Node>,
    /// The initialisers of the outermost graph, by name.
    initializers: BTreeMap<String, StoredTensor>,
    /// Shapes that the file states for the outputs of operations.
    stated: BTreeMap<String, Vec<Dimension>>,
}

/// An operation of a graph.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Node {
    /// The operator with its domain, as in [`Graph::operators`].
    operator: String,
    /// Names of the inputs; empty for optional ones that are left out.
    inputs: Vec<String>,
    outputs: Vec<String>,
    attributes: BTreeMap<String, AttributeValue>,
}

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq, Eq)]
enum AttributeValue {
    Integer(i64),
    Integers(Vec<i64>),
    Text(String),
    Tensor(StoredTensor),
    /// A floating-point number, a graph, or a list of these.
    Other,
}

/// A tensor that the file holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct StoredTensor {
    shape: Vec<u64>,
    /// Its numbers, if it has few 64-bit integers: a shape, axes or indices.
    integers: Option<Vec<i64>>,
}

/// An input or output of a model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// `TensorProto.DataType`: 1 is f32, 0 unknown.
    pub element: u64,
    /// Its shape, if the file states it.
    pub shape: Option<Vec<Dimension>>,
}

/// A dimension of an input or output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Always this size.
    Fixed(u64),
    /// Any size, the same wherever the name occurs.
    Named(String),
    /// Any size.
    Unknown,
}

impl Graph {
    /// Reads a file's content; `path` is only for messages.
    ///
    /// Time and memory are bounded by the file's size, whatever lengths it claims.
    ///
    /// # Errors
    /// If the content is not an ONNX model, is cut short, or keeps weights in another file.
    pub fn read(path: &Path, bytes: &[u8]) -> Result<Self> {
        let refuse = |problem: &str| Err(Error::input(path, format!("expected {problem}")));
        if bytes.is_empty() {
            return refuse("an ONNX model, found an empty file");
        }
        if bytes.starts_with(b"version https://git-lfs") {
            return refuse("an ONNX model, found a Git LFS pointer (run git lfs pull)");
        }
        let mut walk = GraphWalk::default();
        walk.model(ProtobufReader::new(bytes))
            .map_err(|Malformed { byte, problem }| {
                let problem = format!("not an ONNX model, or cut short: {problem}");
                Error::at(path, FilePlace::Byte(byte), problem)
            })?;
        if !walk.has_graph {
            return refuse("an ONNX model, found no graph in it");
        }
        if let Some(name) = walk.external {
            return refuse(&format!(
                "the weights inside the file, found {name:?} in another one \
                 (onnx.save_model with save_as_external_data=False)"
            ));
        }
        let mut graph = walk.graph;
        graph
            .inputs
            .retain(|port| !graph.initializers.contains_key(&port.name));
        Ok(graph)
    }
}

impl Graph {
    /// Returns whether any operator computes in 8-bit integers or converts numbers to them.
    #[must_use]
    pub fn is_quantized(&self) -> bool {
        self.operators.keys().any(|name| is_of_8_bits(name))
    }

    /// Returns whether an operation is set to training mode, as dropout and batch normalisation can
    /// be.
    #[must_use]
    pub fn is_in_training_mode(&self) -> bool {
        let mut nodes = self.nodes.iter().chain(&self.inner);
        nodes.any(|node| node.attributes.get("training_mode") == Some(&AttributeValue::Integer(1)))
    }
}

impl Port {
    /// Returns whether it has two numbers for each input, like viewpoints.
    pub(super) fn is_pair(&self) -> bool {
        matches!(self.shape.as_deref(), Some([_, Dimension::Fixed(2)]))
    }
}

impl std::fmt::Display for Port {
    /// Writes name, type and shape: `"gei" f32 [N, 1, 50, 30]`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?} {} ", self.name, element_name(self.element))?;
        let Some(shape) = &self.shape else {
            return f.write_str("of any shape");
        };
        let dims: Vec<String> = shape.iter().map(ToString::to_string).collect();
        write!(f, "[{}]", dims.join(", "))
    }
}

impl std::fmt::Display for Dimension {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Fixed(size) => write!(f, "{size}"),
            Self::Named(name) => f.write_str(name),
            Self::Unknown => f.write_str("?"),
        }
    }
}

/// Returns the name of a `TensorProto.DataType`.
fn element_name(element: u64) -> &'static str {
    const NAMES: &str = "unknown f32 u8 i8 u16 i16 i32 i64 string bool f16 f64 u32 u64 complex64 \
                         complex128 bf16";
    let at = usize::try_from(element).unwrap_or(0);
    NAMES.split(' ').nth(at).unwrap_or("unknown")
}

#[cfg(test)]
mod tests {
    use super::written::field;
    use super::*;
    use crate::train::{onnx, testing::small_recognizer};

    fn read(bytes: &[u8]) -> Result<Graph> {
        Graph::read(Path::new("m.onnx"), bytes)
    }

    #[test]
    fn our_own_file_is_described_fully() {
        let recognizer = small_recognizer();
        let graph = read(&onnx::write(&recognizer, "small", &[])).expect("our own file");
        assert_eq!(
            (graph.ir_version, graph.opset, graph.producer.as_str()),
            (8, 17, "edgegait")
        );
        let operators: Vec<_> = graph
            .operators
            .iter()
            .map(|(name, n)| (name.as_str(), *n))
            .collect();
        assert_eq!(operators, [("Flatten", 1), ("Gemm", 2)]);
        assert_eq!(graph.parameters, 1500 + 1 + 2 + 2);
        let ports: Vec<String> = graph
            .inputs
            .iter()
            .chain(&graph.outputs)
            .map(ToString::to_string)
            .collect();
        assert_eq!(
            ports,
            [
                "\"gei\" f32 [N, 1, 50, 30]",
                "\"embedding\" f32 [N, 1]",
                "\"scores\" f32 [N, 2]"
            ]
        );
    }

    #[test]
    fn what_is_not_a_model_is_refused() {
        let refusal = |bytes: &[u8]| read(bytes).expect_err("not a model").to_string();
        assert_eq!(
            refusal(b""),
            "m.onnx: expected an ONNX model, found an empty file"
        );
        assert!(refusal(b"version https://git-lfs.github.com/spec/v1\n").contains("git lfs pull"));
        assert!(refusal(b"<!DOCTYPE html><html>404</html>").contains("not an ONNX model"));
        assert_eq!(
            refusal(b"\x08\x08"),
            "m.onnx: expected an ONNX model, found no graph in it"
        );
    }

    #[test]
    fn no_prefix_of_a_model_and_no_changed_byte_panics() {
        let bytes = onnx::write(&small_recognizer(), "small", &[]);
        for length in (0..700)
            .chain((700..bytes.len()).step_by(97))
            .chain([bytes.len() - 1])
        {
            // A cut between two top-level fields leaves a valid, poorer message.
            let _ = read(&bytes[..length]);
        }
        assert!(read(&bytes[..bytes.len() / 2]).is_err());
        let mut changed = bytes.clone();
        for at in (0..bytes.len()).filter(|at| *at < 400 || at + 400 > bytes.len()) {
            for flip in [0x01, 0x80, 0xFF] {
                changed[at] ^= flip;
                let _ = read(&changed);
                changed[at] = bytes[at];
            }
        }
    }

    #[test]
    fn graphs_and_sequences_nested_without_end_are_refused() {
        // GraphProto.node { NodeProto.attribute { AttributeProto.g { ... } } }
        let graph = (0..5000).fold(Vec::new(), |inner, _| {
            field(1, &field(5, &field(6, &inner)))
        });
        // TypeProto.sequence_type { TypeProto.Sequence.elem_type { ... } }
        let kind = (0..5000).fold(Vec::new(), |inner, _| field(4, &field(1, &inner)));
        let sequence = field(11, &field(2, &kind));
        for graph in [graph, sequence] {
            let text = read(&field(7, &graph)).expect_err("too deep").to_string();
            assert!(text.contains("nested more than 16 deep"), "{text}");
        }
    }

    #[test]
    fn strings_longer_than_the_file_are_refused_wherever_the_embedded_runtime_reads_them() {
        // Field 1, of 2^38 bytes.
        let string = b"\x0A\x80\x80\x80\x80\x80\x08";
        for path in [
            &[14][..],            // metadata
            &[7, 5, 13],          // where an initialiser's numbers are
            &[7, 1, 5, 5, 13],    // the same of an attribute
            &[7, 1, 5, 6, 11],    // an input of an inner graph
            &[7, 11, 2, 4],       // a sequence as input
            &[7, 13, 2, 4, 1, 4], // a sequence of sequences
        ] {
            let nested = path.iter().rev();
            let bytes = nested.fold(string.to_vec(), |inner, &number| field(number, &inner));
            let text = read(&bytes).expect_err("too long").to_string();
            assert!(
                text.contains("expected 274877906944 more bytes, found 0"),
                "{path:?}: {text}"
            );
        }
    }

    #[test]
    fn tensors_of_more_than_64_axes_are_refused() {
        for tensor in [
            written::weights("w", 1, &[1; 65]),
            written::stated(13, "y", &[1; 65]),
        ] {
            let bytes = written::bytes(&[0, 1, 50, 30], &[tensor]);
            let text = read(&bytes).expect_err("too many").to_string();
            assert!(
                text.contains("a tensor has 65 axes, more than 64"),
                "{text}"
            );
        }
    }

    #[test]
    fn weights_in_another_file_are_refused() {
        // ModelProto.graph { initializer { name "w", data_location EXTERNAL } }
        let text = read(b"\x3A\x07\x2A\x05\x42\x01w\x70\x01")
            .expect_err("external")
            .to_string();
        assert!(text.contains("found \"w\" in another one"), "{text}");
    }

    #[test]
    fn operators_of_other_domains_keep_their_name() {
        // ModelProto.graph { node { op_type "Scaler", domain "ai.onnx.ml" } }
        let graph = read(b"\x3A\x16\x0A\x14\x22\x06Scaler\x3A\x0Aai.onnx.ml").expect("a graph");
        assert_eq!(
            graph.operators.keys().collect::<Vec<_>>(),
            ["ai.onnx.ml.Scaler"]
        );
    }
}

//! Writes a linear recognizer as an ONNX file.
//!
//! By hand, since the crates that write ONNX each fail somewhere: what onnx-rs
//! and prost write (packed `dims`), rten cannot read. IR 8 and opset 17 load in
//! every runtime from ONNX Runtime 1.18 on. Field numbers are those of
//! `onnx.proto3` (onnx 1.23). What is written passes
//! `onnx.checker.check_model(m, full_check=True)`; the ignored test
//! `writes_a_model_its_probes_and_its_scores` writes a file to check.

use ndarray::Array2;

use super::{Classifier, LinearRecognizer};
use crate::score::{Affine, EMBEDDING, SCORES};
use crate::template::{Shape, Template};

/// `IR_VERSION` of the file.
pub const IR_VERSION: u64 = 8;
/// Version of the default operator set.
pub const OPSET: u64 = 17;

/// `TensorProto.DataType.FLOAT`.
const FLOAT: u64 = 1;

/// A model file that computes `recognizer`: Flatten, Gemm, Gemm.
///
/// The input is called as the template: f32 `[N, 1, rows, columns]` of a GEI, numbers in 0..1.
/// `name` becomes the graph's name; `properties` are stored as model metadata, in this order.
///
/// # Guarantees
/// Equal arguments give equal bytes.
#[must_use]
pub fn write(recognizer: &LinearRecognizer, name: &str, properties: &[(&str, &str)]) -> Vec<u8> {
    let input = match recognizer.template {
        // No other name has a hyphen, which ONNX does not take.
        Template::RowWidth => "row_width",
        template => template.name(),
    };
    let sides = match recognizer.template.shape(recognizer.size) {
        Shape::Image {
            planes,
            rows,
            columns,
        } => vec![planes, rows, columns],
        Shape::Vector(numbers) => vec![numbers],
    };
    let sides = sides.into_iter().map(Axis::Size);
    let numbers: Vec<Axis> = std::iter::once(Axis::Named("N")).chain(sides).collect();
    let outputs = |size| [Axis::Named("N"), Axis::Size(size)];

    let score_weights = match recognizer.classifier {
        Classifier::Centroids(_) => "centroids",
        Classifier::Svm(_) => "scores_weights",
    };
    let mut graph = Message::default();
    graph.message(1, &node("Flatten", &[input], "pixels"));
    graph.message(
        1,
        &node(
            "Gemm",
            &["pixels", "embedding_weights", "embedding_bias"],
            EMBEDDING,
        ),
    );
    graph.message(
        1,
        &node("Gemm", &[EMBEDDING, score_weights, "scores_bias"], SCORES),
    );
    graph.text(2, name);
    tensors(
        &mut graph,
        ["embedding_weights", "embedding_bias"],
        &recognizer.embedding,
    );
    tensors(
        &mut graph,
        [score_weights, "scores_bias"],
        &recognizer.score_map(),
    );
    graph.message(11, &value_info(input, &numbers));
    graph.message(12, &value_info(EMBEDDING, &outputs(recognizer.dims())));
    graph.message(12, &value_info(SCORES, &outputs(recognizer.classes())));

    let mut model = Message::default();
    model.number(1, IR_VERSION);
    model.text(2, "edgegait");
    model.text(3, env!("CARGO_PKG_VERSION"));
    model.message(7, &graph);
    let mut operators = Message::default();
    operators.text(1, "");
    operators.number(2, OPSET);
    model.message(8, &operators);
    for (key, value) in properties {
        let mut entry = Message::default();
        entry.text(1, key);
        entry.text(2, value);
        model.message(14, &entry);
    }
    model.bytes
}

/// A dimension of an input or output.
enum Axis {
    Named(&'static str),
    Size(usize),
}

fn node(operator: &str, inputs: &[&str], output: &str) -> Message {
    let mut node = Message::default();
    for input in inputs {
        node.text(1, input);
    }
    node.text(2, output);
    node.text(3, &format!("{output}_{}", operator.to_lowercase()));
    node.text(4, operator);
    node
}

/// Gemm multiplies from the right, so the weights are stored transposed, `[inputs, outputs]`.
fn tensors(graph: &mut Message, [weights, bias]: [&str; 2], affine: &Affine) {
    let transposed: Array2<f32> = affine.weights.t().as_standard_layout().into_owned();
    let (inputs, outputs) = transposed.dim();
    graph.message(5, &tensor(weights, &[inputs, outputs], transposed.iter()));
    graph.message(5, &tensor(bias, &[outputs], affine.bias.iter()));
}

fn tensor<'a>(name: &str, dims: &[usize], values: impl Iterator<Item = &'a f32>) -> Message {
    let mut tensor = Message::default();
    for &dim in dims {
        tensor.number(1, dim as u64);
    }
    tensor.number(2, FLOAT);
    tensor.text(8, name);
    let raw: Vec<u8> = values.flat_map(|value| value.to_le_bytes()).collect();
    tensor.delimited(9, &raw);
    tensor
}

fn value_info(name: &str, axes: &[Axis]) -> Message {
    let mut shape = Message::default();
    for axis in axes {
        let mut dim = Message::default();
        match *axis {
            Axis::Size(size) => dim.number(1, size as u64),
            Axis::Named(symbol) => dim.text(2, symbol),
        }
        shape.message(1, &dim);
    }
    let mut tensor = Message::default();
    tensor.number(1, FLOAT);
    tensor.message(2, &shape);
    let mut value_type = Message::default();
    value_type.message(1, &tensor);
    let mut info = Message::default();
    info.text(1, name);
    info.message(2, &value_type);
    info
}

/// A protobuf message being written.
#[derive(Default)]
struct Message {
    bytes: Vec<u8>,
}

impl Message {
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }

    fn number(&mut self, field: u64, value: u64) {
        self.varint(field << 3);
        self.varint(value);
    }

    fn delimited(&mut self, field: u64, content: &[u8]) {
        self.varint(field << 3 | 2);
        self.varint(content.len() as u64);
        self.bytes.extend_from_slice(content);
    }

    fn text(&mut self, field: u64, content: &str) {
        self.delimited(field, content.as_bytes());
    }

    fn message(&mut self, field: u64, content: &Self) {
        self.delimited(field, &content.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::testing::small_recognizer;

    #[test]
    fn three_hundred_is_written_as_ac_02() {
        // The worked example of protobuf.dev/programming-guides/encoding.
        let mut message = Message::default();
        message.varint(300);
        assert_eq!(message.bytes, [0xAC, 0x02]);
        let mut message = Message::default();
        message.text(2, "testing");
        assert_eq!(message.bytes, *b"\x12\x07testing");
    }

    #[test]
    fn equal_recognizers_give_equal_bytes() {
        let properties = [("people", "2")];
        let bytes = write(&small_recognizer(), "small", &properties);
        assert_eq!(bytes, write(&small_recognizer(), "small", &properties));
        assert_ne!(bytes, write(&small_recognizer(), "other", &properties));
    }

    #[test]
    fn a_file_is_little_more_than_its_weights() {
        let recognizer = small_recognizer();
        let weights =
            4 * (1500 * recognizer.dims() + recognizer.dims() + 2 * recognizer.dims() + 2);
        let bytes = write(&recognizer, "small", &[]);
        assert!(
            (weights..weights + 600).contains(&bytes.len()),
            "{}",
            bytes.len()
        );
    }
}

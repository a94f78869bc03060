//! Writes a linear recognizer as an ONNX file.
//!
//! By hand, since the crates that write ONNX each fail somewhere: what onnx-rs
//! and prost write (packed `dims`), rten cannot read, and rten-onnx 0.27 writes
//! graphs without the name that ONNX demands. IR 8 and opset 17 load in
//! every runtime from ONNX Runtime 1.18 on. Field numbers are those of
//! `onnx.proto3` (onnx 1.23). What is written passes
//! `onnx.checker.check_model(m, full_check=True)`; the ignored test
//! `writes_a_model_its_probes_and_its_scores` writes a file to check.

use ndarray::Array2;

use super::{Classifier, LinearRecognizer};
use crate::score::{EMBEDDING, SCORES};
use crate::template::{Shape, Template};

/// `IR_VERSION` of the file.
pub const IR_VERSION: u64 = 8;
/// Version of the default operator set.
pub const OPSET: u64 = 17;

/// `TensorProto.DataType.FLOAT` and `INT64`.
const FLOAT: u64 = 1;
const INT64: u64 = 7;

/// A model file that computes `recognizer`: Flatten, Gemm, Gemm, and a Reshape where an embedding has
/// parts.
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
    let parts = recognizer.parts;
    let flat = if parts == 1 { EMBEDDING } else { "numbers" };
    let embedding = ["pixels", "embedding_weights", "embedding_bias"];
    let scores = [flat, score_weights, "scores_bias"];
    let mut nodes = Message::default()
        .message(1, node("Flatten", &[input], "pixels"))
        .message(1, node("Gemm", &embedding, flat))
        .message(1, node("Gemm", &scores, SCORES));
    let mut embedding_axes = vec![Axis::Named("N"), Axis::Size(recognizer.dims() / parts)];
    if parts > 1 {
        nodes = nodes.message(1, node("Reshape", &[flat, "embedding_shape"], EMBEDDING));
        embedding_axes.push(Axis::Size(parts));
    }
    let nodes = nodes.text(2, name);
    let layers = [
        (embedding, &recognizer.embedding),
        (scores, &recognizer.score_map()),
    ];
    let graph = layers
        .into_iter()
        .fold(nodes, |graph, ([_, weights, bias], affine)| {
            // Gemm multiplies from the right, so the weights are stored transposed.
            let transposed: Array2<f32> = affine.weights.t().as_standard_layout().into_owned();
            let (inputs, outputs) = transposed.dim();
            graph
                .message(5, tensor(weights, &[inputs, outputs], transposed.iter()))
                .message(5, tensor(bias, &[outputs], affine.bias.iter()))
        })
        .message(11, value_info(input, &numbers))
        .message(12, value_info(EMBEDDING, &embedding_axes))
        .message(12, value_info(SCORES, &outputs(recognizer.classes())));
    let graph = if parts == 1 {
        graph
    } else {
        // 0 is the size that the numbers have there: N.
        let shape = [0, (recognizer.dims() / parts) as u64, parts as u64];
        let raw: Vec<u8> = shape.iter().flat_map(|side| side.to_le_bytes()).collect();
        graph.message(5, tensor_of(INT64, "embedding_shape", &[3], &raw))
    };
    let model = Message::default()
        .number(1, IR_VERSION)
        .text(2, "edgegait")
        .text(3, env!("CARGO_PKG_VERSION"))
        .message(7, graph)
        .message(8, Message::default().text(1, "").number(2, OPSET));
    let entry = |(key, value): &(&str, &str)| Message::default().text(1, key).text(2, value);
    properties
        .iter()
        .fold(model, |model, property| model.message(14, entry(property)))
        .bytes
}

/// A dimension of an input or output.
enum Axis {
    Named(&'static str),
    Size(usize),
}

fn node(operator: &str, inputs: &[&str], output: &str) -> Message {
    inputs
        .iter()
        .fold(Message::default(), |node, input| node.text(1, input))
        .text(2, output)
        .text(3, &format!("{output}_{}", operator.to_lowercase()))
        .text(4, operator)
}

fn tensor<'a>(name: &str, dims: &[usize], values: impl Iterator<Item = &'a f32>) -> Message {
    let raw: Vec<u8> = values.flat_map(|value| value.to_le_bytes()).collect();
    tensor_of(FLOAT, name, dims, &raw)
}

fn tensor_of(kind: u64, name: &str, dims: &[usize], raw: &[u8]) -> Message {
    dims.iter()
        .fold(Message::default(), |tensor, &dim| {
            tensor.number(1, dim as u64)
        })
        .number(2, kind)
        .text(8, name)
        .delimited(9, raw)
}

fn value_info(name: &str, axes: &[Axis]) -> Message {
    let shape = axes.iter().fold(Message::default(), |shape, axis| {
        let dim = match *axis {
            Axis::Size(size) => Message::default().number(1, size as u64),
            Axis::Named(symbol) => Message::default().text(2, symbol),
        };
        shape.message(1, dim)
    });
    let tensor = Message::default().number(1, FLOAT).message(2, shape);
    Message::default()
        .text(1, name)
        .message(2, Message::default().message(1, tensor))
}

/// A protobuf message being written.
#[derive(Default)]
struct Message {
    bytes: Vec<u8>,
}

impl Message {
    fn varint(mut self, mut value: u64) -> Self {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
        self
    }

    fn number(self, field: u64, value: u64) -> Self {
        self.varint(field << 3).varint(value)
    }

    fn delimited(self, field: u64, content: &[u8]) -> Self {
        let mut message = self.varint(field << 3 | 2).varint(content.len() as u64);
        message.bytes.extend_from_slice(content);
        message
    }

    fn text(self, field: u64, content: &str) -> Self {
        self.delimited(field, content.as_bytes())
    }

    fn message(self, field: u64, content: Self) -> Self {
        self.delimited(field, &content.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::testing::small_recognizer;

    #[test]
    fn three_hundred_is_written_as_ac_02() {
        // The worked example of protobuf.dev/programming-guides/encoding.
        assert_eq!(Message::default().varint(300).bytes, [0xAC, 0x02]);
        let message = Message::default().text(2, "testing");
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

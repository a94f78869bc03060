//! Writes ONNX files, without a crate.
//!
//! The crates that write ONNX do not suffice: rten cannot read what onnx-rs and prost write (packed
//! `dims`), and rten-onnx 0.27 writes graphs without the name that ONNX requires. IR 8 and opset 17
//! load in every runtime from ONNX Runtime 1.18 on. Field numbers are those of `onnx.proto3` (onnx
//! 1.23).

/// `IR_VERSION` of the file.
const IR_VERSION: u64 = 8;
/// Version of the default operator set.
const OPSET: u64 = 17;

/// `TensorProto.DataType.FLOAT` and `INT64`.
const FLOAT: u64 = 1;
const INT64: u64 = 7;

/// A graph that is being written, and the file around it.
#[derive(Default)]
pub(super) struct OnnxFile {
    nodes: ProtobufMessage,
    initializers: ProtobufMessage,
    ports: ProtobufMessage,
}

/// An attribute of a node.
pub(super) enum NodeAttribute<'a> {
    Integer(i64),
    Integers(&'a [i64]),
}

impl OnnxFile {
    /// Appends an operation without attributes.
    pub(super) fn node(&mut self, operator: &str, inputs: &[&str], output: &str) {
        self.node_with(operator, inputs, output, &[]);
    }

    /// Appends an operation.
    pub(super) fn node_with(
        &mut self,
        operator: &str,
        inputs: &[&str],
        output: &str,
        attributes: &[(&str, NodeAttribute<'_>)],
    ) {
        let node = inputs
            .iter()
            .fold(ProtobufMessage::default(), |node, input| {
                node.text(1, input)
            })
            .text(2, output)
            .text(3, &format!("{output}_{}", operator.to_lowercase()))
            .text(4, operator);
        let node = attributes.iter().fold(node, |node, (name, attribute)| {
            let named = ProtobufMessage::default().text(1, name);
            // `AttributeProto.type` 2 is INT, 7 is INTS.
            let attribute = match attribute {
                NodeAttribute::Integer(number) => named.number(3, *number as u64).number(20, 2),
                NodeAttribute::Integers(numbers) => numbers
                    .iter()
                    .fold(named, |named, &number| named.number(8, number as u64))
                    .number(20, 7),
            };
            node.message(5, attribute)
        });
        self.nodes.add(1, &node);
    }

    /// Appends a constant of numbers, row by row.
    pub(super) fn numbers<'a>(
        &mut self,
        name: &str,
        dims: &[usize],
        values: impl IntoIterator<Item = &'a f32>,
    ) {
        let raw: Vec<u8> = { values.into_iter() }
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.initializers.add(5, &tensor(FLOAT, name, dims, &raw));
    }

    /// Appends a list of integers.
    pub(super) fn integers(&mut self, name: &str, values: &[i64]) {
        let raw: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let tensor = tensor(INT64, name, &[values.len()], &raw);
        self.initializers.add(5, &tensor);
    }

    /// Appends an input of f32, of shape N by these sizes.
    pub(super) fn input(&mut self, name: &str, sizes: &[usize]) {
        self.ports.add(11, &value_info(name, sizes));
    }

    /// Appends an output of f32, of shape N by these sizes.
    pub(super) fn output(&mut self, name: &str, sizes: &[usize]) {
        self.ports.add(12, &value_info(name, sizes));
    }

    /// Returns the file: `name` becomes the graph's name, `properties` its metadata, in this order.
    pub(super) fn bytes(self, name: &str, properties: &[(&str, &str)]) -> Vec<u8> {
        let mut graph = self.nodes.text(2, name);
        graph.bytes.extend(self.initializers.bytes);
        graph.bytes.extend(self.ports.bytes);
        let model = ProtobufMessage::default()
            .number(1, IR_VERSION)
            .text(2, "edgegait")
            .text(3, env!("CARGO_PKG_VERSION"))
            .message(7, graph)
            .message(8, ProtobufMessage::default().text(1, "").number(2, OPSET));
        let entry =
            |(key, value): &(&str, &str)| ProtobufMessage::default().text(1, key).text(2, value);
        properties
            .iter()
            .fold(model, |model, property| model.message(14, entry(property)))
            .bytes
    }
}

fn tensor(kind: u64, name: &str, dims: &[usize], raw: &[u8]) -> ProtobufMessage {
    dims.iter()
        .fold(ProtobufMessage::default(), |tensor, &dim| {
            tensor.number(1, dim as u64)
        })
        .number(2, kind)
        .text(8, name)
        .delimited(9, raw)
}

fn value_info(name: &str, sizes: &[usize]) -> ProtobufMessage {
    let batch = ProtobufMessage::default().message(1, ProtobufMessage::default().text(2, "N"));
    let shape = sizes.iter().fold(batch, |shape, &size| {
        shape.message(1, ProtobufMessage::default().number(1, size as u64))
    });
    let tensor = ProtobufMessage::default()
        .number(1, FLOAT)
        .message(2, shape);
    ProtobufMessage::default()
        .text(1, name)
        .message(2, ProtobufMessage::default().message(1, tensor))
}

/// A protobuf message being written.
#[derive(Default)]
struct ProtobufMessage {
    bytes: Vec<u8>,
}

impl ProtobufMessage {
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

    /// Appends a message to this one.
    fn add(&mut self, field: u64, content: &Self) {
        *self = std::mem::take(self).delimited(field, &content.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_hundred_is_written_as_ac_02() {
        // The worked example of protobuf.dev/programming-guides/encoding.
        assert_eq!(ProtobufMessage::default().varint(300).bytes, [0xAC, 0x02]);
        let message = ProtobufMessage::default().text(2, "testing");
        assert_eq!(message.bytes, *b"\x12\x07testing");
    }

    #[test]
    fn a_negative_integer_has_ten_bytes() {
        // Two's complement of 64 bits, as protobuf encodes int64.
        let mut file = OnnxFile::default();
        file.node_with(
            "ArgMin",
            &["a"],
            "b",
            &[("axis", NodeAttribute::Integer(-1))],
        );
        let ones = [
            0x18, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 1,
        ];
        let bytes = file.nodes.bytes;
        assert!(bytes.windows(11).any(|window| window == ones));
    }
}

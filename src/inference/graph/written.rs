//! Writes ONNX graphs for tests.

use std::path::Path;

use super::Graph;

/// Returns a protobuf field of bytes.
pub(crate) fn field(number: u64, content: &[u8]) -> Vec<u8> {
    let mut bytes = varint(number << 3 | 2);
    bytes.extend(varint(content.len() as u64));
    bytes.extend_from_slice(content);
    bytes
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

fn number(field: u64, value: i64) -> Vec<u8> {
    [varint(field << 3), varint(value.cast_unsigned())].concat()
}

/// Returns a node. Names are separated by spaces, and `-` is an empty name. Attributes are lists of
/// integers, one integer, or text (as in `auto_pad=SAME_UPPER`).
pub(crate) fn node(operator: &str, inputs: &str, outputs: &str, attributes: &[&str]) -> Vec<u8> {
    let names = |number, names: &str| -> Vec<u8> {
        let names = names.split_whitespace().map(|name| name.trim_matches('-'));
        names
            .flat_map(|name| field(number, name.as_bytes()))
            .collect()
    };
    let mut node = [
        names(1, inputs),
        names(2, outputs),
        field(4, operator.as_bytes()),
    ]
    .concat();
    for attribute in attributes {
        let (name, value) = attribute.split_once('=').expect("name=value");
        let mut message = field(1, name.as_bytes());
        match value.strip_prefix('[') {
            Some(list) => {
                for item in list.trim_end_matches(']').split(',') {
                    message.extend(number(8, item.parse().expect("an integer")));
                }
            }
            None => match value.parse() {
                Ok(integer) => message.extend(number(3, integer)),
                Err(_) => message.extend(field(4, value.as_bytes())),
            },
        }
        node.extend(field(5, &message));
    }
    field(1, &node)
}

/// Returns an initialiser of zeros of element type `element`: 1 (f32), 3 (i8) or 6 (i32).
pub(crate) fn weights(name: &str, element: i64, shape: &[i64]) -> Vec<u8> {
    let width = if element == 3 { 1 } else { 4 };
    let bytes = vec![0; width * shape.iter().product::<i64>() as usize];
    let mut tensor: Vec<u8> = shape.iter().flat_map(|&size| number(1, size)).collect();
    tensor.extend(number(2, element));
    tensor.extend(field(8, name.as_bytes()));
    tensor.extend(field(9, &bytes));
    field(5, &tensor)
}

/// Returns an initialiser of 64-bit integers.
pub(crate) fn integers(name: &str, values: &[i64]) -> Vec<u8> {
    let raw: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    let mut tensor = [number(1, values.len() as i64), number(2, 7)].concat();
    tensor.extend(field(8, name.as_bytes()));
    tensor.extend(field(9, &raw));
    field(5, &tensor)
}

/// Returns the stated shape of a tensor; 0 is the named dimension N.
pub(crate) fn stated(number_of_field: u64, name: &str, shape: &[i64]) -> Vec<u8> {
    let dimensions = shape.iter().flat_map(|&size| match size {
        0 => field(1, &field(2, b"N")),
        _ => field(1, &number(1, size)),
    });
    let shape: Vec<u8> = dimensions.collect();
    let tensor = [number(1, 1), field(2, &shape)].concat();
    let kind = field(2, &field(1, &tensor));
    field(number_of_field, &[field(1, name.as_bytes()), kind].concat())
}

/// Returns an operation with an inner graph as its attribute.
pub(crate) fn inner(parts: &[Vec<u8>]) -> Vec<u8> {
    let attribute = [field(1, b"body"), field(6, &parts.concat())].concat();
    let node = [field(2, b"y"), field(4, b"Loop"), field(5, &attribute)].concat();
    field(1, &node)
}

/// Returns a file whose input `x` has this shape.
pub(crate) fn bytes(input: &[i64], parts: &[Vec<u8>]) -> Vec<u8> {
    let graph = [stated(11, "x", input), parts.concat()].concat();
    let operators = field(8, &number(2, 17));
    [number(1, 8), field(7, &graph), operators].concat()
}

/// Returns the graph of [`bytes`].
pub(crate) fn graph(input: &[i64], parts: &[Vec<u8>]) -> Graph {
    Graph::read(Path::new("m.onnx"), &bytes(input, parts)).expect("a graph")
}

//! A network for sequences whose inference time can be chosen, as the bytes of an ONNX file.
//!
//! A matrix turns each silhouette of 64x44 into 512 numbers. Each layer then multiplies them by one
//! other matrix, the same for all layers. The embedding is the mean over the frames. More layers
//! take more time, but the file does not grow.

use std::fs;
use std::path::Path;

const PIXELS: usize = 64 * 44;
const WIDTH: usize = 512;

/// Returns the multiply-accumulates of one frame.
pub fn macs_of_a_frame(layers: usize) -> u64 {
    (PIXELS * WIDTH + layers * WIDTH * WIDTH) as u64
}

/// Writes a network of `layers` layers with its contract. The file fixes the number of frames if
/// `frames` is given.
pub fn write_network(folder: &Path, name: &str, layers: usize, frames: Option<u64>) {
    let path = folder.join(name);
    fs::write(path.with_extension("onnx"), bytes(layers, frames)).expect("written");
    let contract = "template = \"silhouettes\"\nlayout = \"NTHW\"\nrows = 64\ncolumns = 44\n";
    fs::write(path.with_extension("toml"), contract).expect("written");
}

/// Writes a network for sequences of silhouettes of 50x30, whose embedding has 30 numbers: the means
/// of the columns over all frames and rows. It takes hardly any time.
pub fn write_column_means(folder: &Path, name: &str) {
    let axes = [field(1, b"axes"), number(8, 1), number(8, 2), number(20, 7)].concat();
    let keepdims = [field(1, b"keepdims"), number(3, 0), number(20, 2)].concat();
    let graph = [
        field(1, &node("ReduceMean", &["x"], "y", &[axes, keepdims])),
        field(2, b"g"),
        field(11, &port("x", &[None, None, Some(50), Some(30)])),
        field(12, &port("y", &[None, Some(30)])),
    ]
    .concat();
    let bytes = [number(1, 8), field(7, &graph), field(8, &number(2, 17))].concat();
    let path = folder.join(name);
    fs::write(path.with_extension("onnx"), bytes).expect("written");
    let contract = "template = \"silhouettes\"\nlayout = \"NTHW\"\nrows = 50\ncolumns = 30\n";
    fs::write(path.with_extension("toml"), contract).expect("written");
}

/// Encodes the network by the descriptions of ONNX (onnx.proto3) and of protobuf's encoding.
fn bytes(layers: usize, frames: Option<u64>) -> Vec<u8> {
    let mut seed = 1_u64;
    let mut sign = || {
        // Knuth's multiplier.
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        if seed >> 63 == 0 { 1.0_f32 } else { -1.0 }
    };
    let scale = (PIXELS as f32).sqrt().recip();
    let first: Vec<f32> = (0..PIXELS * WIDTH).map(|_| scale * sign()).collect();
    // A Householder reflection with columns shifted by one, which keeps lengths.
    let v: Vec<f32> = (0..WIDTH)
        .map(|_| (WIDTH as f32).sqrt().recip() * sign())
        .collect();
    let reflected = |row: usize, column: usize| {
        let unit = if row == column { 1.0 } else { 0.0 };
        unit - 2.0 * v[row] * v[column]
    };
    let layer: Vec<f32> = (0..WIDTH * WIDTH)
        .map(|at| reflected(at / WIDTH, (at % WIDTH + 1) % WIDTH))
        .collect();
    let mut nodes = vec![
        node("Reshape", &["x", "flat"], "f", &[]),
        node("MatMul", &["f", "first"], "m0", &[]),
    ];
    for at in 0..layers {
        let (from, to) = (format!("m{at}"), format!("m{}", at + 1));
        nodes.push(node("MatMul", &[&from, "layer"], &to, &[]));
    }
    let attributes = [
        [field(1, b"axes"), number(8, 1), number(20, 7)].concat(),
        [field(1, b"keepdims"), number(3, 0), number(20, 2)].concat(),
    ];
    nodes.push(node(
        "ReduceMean",
        &[&format!("m{layers}")],
        "y",
        &attributes,
    ));
    // The zeros keep the sizes of the batch and of the frames.
    let flat: Vec<u8> = [0_i64, 0, PIXELS as i64]
        .iter()
        .flat_map(|size| size.to_le_bytes())
        .collect();
    let floats = |numbers: &[f32]| -> Vec<u8> {
        numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect()
    };
    let graph = [
        nodes.iter().flat_map(|node| field(1, node)).collect(),
        field(2, b"g"),
        field(5, &tensor("first", 1, &[PIXELS, WIDTH], &floats(&first))),
        field(5, &tensor("layer", 1, &[WIDTH, WIDTH], &floats(&layer))),
        field(5, &tensor("flat", 7, &[3], &flat)),
        field(11, &port("x", &[None, frames, Some(64), Some(44)])),
        field(12, &port("y", &[None, Some(WIDTH as u64)])),
    ]
    .concat();
    [number(1, 8), field(7, &graph), field(8, &number(2, 17))].concat()
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push((value & 0x7F) as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

fn number(field: u64, value: u64) -> Vec<u8> {
    [varint(field << 3), varint(value)].concat()
}

fn field(number: u64, content: &[u8]) -> Vec<u8> {
    let mut bytes = varint(number << 3 | 2);
    bytes.extend(varint(content.len() as u64));
    bytes.extend_from_slice(content);
    bytes
}

fn node(operator: &str, inputs: &[&str], output: &str, attributes: &[Vec<u8>]) -> Vec<u8> {
    let inputs: Vec<u8> = inputs
        .iter()
        .flat_map(|name| field(1, name.as_bytes()))
        .collect();
    let attributes: Vec<u8> = attributes.iter().flat_map(|one| field(5, one)).collect();
    let (output, operator) = (field(2, output.as_bytes()), field(4, operator.as_bytes()));
    [inputs, output, operator, attributes].concat()
}

fn tensor(name: &str, element: u64, shape: &[usize], raw: &[u8]) -> Vec<u8> {
    let shape: Vec<u8> = shape
        .iter()
        .flat_map(|&size| number(1, size as u64))
        .collect();
    [
        shape,
        number(2, element),
        field(8, name.as_bytes()),
        field(9, raw),
    ]
    .concat()
}

fn port(name: &str, shape: &[Option<u64>]) -> Vec<u8> {
    let shape = shape.iter().enumerate().flat_map(|(axis, size)| {
        let size = size.map_or_else(|| field(2, &[b'N' + axis as u8]), |size| number(1, size));
        field(1, &size)
    });
    let tensor = [number(1, 1), field(2, &shape.collect::<Vec<u8>>())].concat();
    [field(1, name.as_bytes()), field(2, &field(1, &tensor))].concat()
}

//! Shared parts of this module's tests: small models, and the real ONNX Runtime if there is one.

use super::provider::RuntimeName;
use super::{Contract, InputLayout, Model, Outputs, Recognizer};
use crate::draw::template::Template;
use crate::error::Result;
use crate::train::onnx;
use crate::train::testing::small_recognizer;
use std::path::PathBuf;

/// Returns the library that `EDGEGAIT_ORT_LIB` names, for tests that are ignored without it.
pub(crate) fn ort_library() -> PathBuf {
    let path = std::env::var_os("EDGEGAIT_ORT_LIB");
    path.expect(
        "EDGEGAIT_ORT_LIB: expected the path of ONNX Runtime's library, found no such variable",
    )
    .into()
}

/// Returns a model of two people, with the default contract.
pub(crate) fn small_model() -> Model {
    let bytes = onnx::write(&small_recognizer(), "small", &[]);
    Model::from_bytes("small.onnx", bytes, Contract::default()).expect("our own model")
}

/// A recognizer whose class scores or embedding are a function of its input. It has no scores if
/// the function returns none.
pub(crate) struct MadeUp {
    contract: Contract,
    runtime: RuntimeName,
    function: fn(&[f32]) -> Vec<f32>,
    embeds: bool,
}

impl MadeUp {
    pub(crate) fn new(contract: Contract, function: fn(&[f32]) -> Vec<f32>) -> Self {
        Self {
            contract,
            runtime: RuntimeName::default(),
            function,
            embeds: false,
        }
    }

    pub(crate) fn embedding(contract: Contract, function: fn(&[f32]) -> Vec<f32>) -> Self {
        Self {
            embeds: true,
            ..Self::new(contract, function)
        }
    }
}

impl Recognizer for MadeUp {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
        let each = input.chunks_exact(input.len() / batch);
        let scores: Vec<f32> = each.flat_map(self.function).collect();
        if self.embeds {
            return Ok(Outputs {
                embedding_dims: scores.len() / batch,
                embedding_parts: 1,
                non_finite: scores.iter().filter(|number| !number.is_finite()).count(),
                embedding: scores,
                ..Outputs::default()
            });
        }
        Ok(Outputs {
            classes: scores.len() / batch,
            scores: (!scores.is_empty()).then_some(scores),
            ..Outputs::default()
        })
    }
}

fn delimited(field: u8, content: &[u8]) -> Vec<u8> {
    assert!(
        content.len() < 0x4000,
        "two bytes of length are enough for tests"
    );
    let length = content.len();
    let mut bytes = vec![field << 3 | 2, length as u8 | 0x80, (length >> 7) as u8];
    bytes.extend_from_slice(content);
    bytes
}

fn port(name: &str, element: u8, dims: &[Option<u16>]) -> Vec<u8> {
    let shape: Vec<u8> = dims
        .iter()
        .enumerate()
        .flat_map(|(axis, dim)| {
            let name = if axis == 0 { b"N" } else { b"T" };
            let dim = dim.map_or_else(
                || delimited(2, name),
                |size| vec![0x08, size as u8 | 0x80, (size >> 7) as u8],
            );
            delimited(1, &dim)
        })
        .collect();
    let tensor = [vec![0x08, element], delimited(2, &shape)].concat();
    let kind = delimited(2, &delimited(1, &tensor));
    [delimited(1, name.as_bytes()), kind].concat()
}

fn model(nodes: &[Vec<u8>], input: &[u8], output: &[u8]) -> Vec<u8> {
    let mut graph: Vec<u8> = nodes.iter().flat_map(|node| delimited(1, node)).collect();
    graph.extend(delimited(2, b"g"));
    graph.extend(delimited(11, input));
    graph.extend(delimited(12, output));
    [
        vec![0x08, 8],
        delimited(7, &graph),
        delimited(8, &[0x0A, 0, 0x10, 17]),
    ]
    .concat()
}

fn node(operator: &str, inputs: &[&str], outputs: &[&str]) -> Vec<u8> {
    let names = |field, names: &[&str]| -> Vec<u8> {
        let fields = names.iter().map(|name| delimited(field, name.as_bytes()));
        fields.flatten().collect()
    };
    let operator = delimited(4, operator.as_bytes());
    [names(1, inputs), names(2, outputs), operator].concat()
}

/// Returns a model without operators whose input has this type and shape; its output `out` has
/// `[N, 4, ...]` of this element and rank.
pub(crate) fn bytes_with(
    element: u8,
    dims: &[Option<u16>],
    out_element: u8,
    out_rank: usize,
) -> Vec<u8> {
    let mut out = vec![Some(4); out_rank];
    out[0] = None;
    model(
        &[],
        &port("gei", element, dims),
        &port("out", out_element, &out),
    )
}

/// Returns a model of one operator from `gei` to `out`.
pub(crate) fn bytes_with_operator(operator: &str, domain: &str) -> Vec<u8> {
    let mut node = node(operator, &["gei"], &["out"]);
    node.extend(delimited(7, domain.as_bytes()));
    let image = [None, Some(1), Some(50), Some(30)];
    model(
        &[node],
        &port("gei", 1, &image),
        &port("out", 1, &[None, Some(4)]),
    )
}

/// Returns a model that averages sequences `[N, T, 64, 44]` over their frames: rows are channels
/// and columns are parts of the embedding `out`, `[N, 64, 44]`.
pub(crate) fn bytes_of_a_mean_over_frames(batch: Option<u16>, frames: Option<u16>) -> Vec<u8> {
    // AttributeProto: name, ints or i, type INTS or INT.
    let axes = [delimited(1, b"axes"), vec![0x40, 1, 0xA0, 1, 7]].concat();
    let keep = [delimited(1, b"keepdims"), vec![0x18, 0, 0xA0, 1, 2]].concat();
    let mut node = node("ReduceMean", &["gei"], &["out"]);
    node.extend([delimited(5, &axes), delimited(5, &keep)].concat());
    model(
        &[node],
        &port("gei", 1, &[batch, frames, Some(64), Some(44)]),
        &port("out", 1, &[batch, Some(64), Some(44)]),
    )
}

/// Returns the contract of [`bytes_of_a_mean_over_frames`].
pub(crate) fn contract_of_sequences() -> Contract {
    Contract {
        rows: 64,
        columns: 44,
        template: Template::Silhouettes,
        layout: InputLayout::Nthw,
        ..Contract::default()
    }
}

/// Returns a model that flattens `gei` and takes the logarithm: NaN and infinities for numbers that
/// are not positive.
pub(crate) fn bytes_of_a_logarithm(batch: Option<u16>) -> Vec<u8> {
    let nodes = [
        node("Flatten", &["gei"], &["flat"]),
        node("Log", &["flat"], &["out"]),
    ];
    let image = [batch, Some(1), Some(50), Some(30)];
    model(
        &nodes,
        &port("gei", 1, &image),
        &port("out", 1, &[batch, Some(1500)]),
    )
}

/// Returns a model that rounds `gei` to 256 steps from the least to the largest number of the whole
/// batch, and flattens it.
pub(crate) fn bytes_of_a_dynamic_quantization() -> Vec<u8> {
    let quantized = ["steps", "scale", "zero"];
    let nodes = [
        node("DynamicQuantizeLinear", &["gei"], &quantized),
        node("DequantizeLinear", &quantized, &["coarse"]),
        node("Flatten", &["coarse"], &["out"]),
    ];
    let image = [None, Some(1), Some(50), Some(30)];
    model(
        &nodes,
        &port("gei", 1, &image),
        &port("out", 1, &[None, Some(1500)]),
    )
}

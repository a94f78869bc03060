//! Walks the messages of an ONNX file.
//!
//! Field numbers are those of `onnx.proto3` (onnx 1.23).

use super::{AttributeValue, Dimension, Graph, Node, Port, StoredTensor};
use crate::inference::protobuf::{Malformed, ProtobufField, ProtobufReader};

/// The deepest nesting of graphs (If, Loop, Scan) or of sequences that is accepted.
const MAX_DEPTH: usize = 16;
/// The maximum number of values in a tensor that are kept: a shape, axes or indices have no more.
pub(super) const MAX_INTEGERS: u64 = 1024;
/// The maximum number of axes in a tensor (numpy 2's limit).
pub(super) const MAX_RANK: usize = 64;

/// The maximum number of class labels that are kept.
const MAX_LABELS: usize = 1 << 16;
/// The attribute in which classifiers of `ai.onnx.ml` name their classes.
const CLASS_LABELS: &str = "classlabels_strings";

/// `TensorProto.DataLocation.EXTERNAL`.
const EXTERNAL: u64 = 1;
/// `TensorProto.DataType.INT64`.
const INT64: u64 = 7;

/// A graph being read.
#[derive(Default)]
pub(super) struct GraphWalk {
    pub graph: Graph,
    pub has_graph: bool,
    /// The first tensor whose numbers are in another file.
    pub external: Option<String>,
}

type Read<T> = Result<T, Malformed>;

impl GraphWalk {
    pub(super) fn model(&mut self, mut model: ProtobufReader<'_>) -> Read<()> {
        while let Some((number, field)) = model.next()? {
            match (number, field) {
                (1, ProtobufField::Number(version)) => self.graph.ir_version = version,
                (2, ProtobufField::Bytes(name)) => self.graph.producer = name.text()?,
                (7, ProtobufField::Bytes(graph)) => {
                    self.has_graph = true;
                    self.graph(graph, 0)?;
                }
                (8, ProtobufField::Bytes(set)) => self.operator_set(set)?,
                (14, ProtobufField::Bytes(property)) => property.skim()?,
                (25, ProtobufField::Bytes(function)) => self.function(function)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn operator_set(&mut self, mut set: ProtobufReader<'_>) -> Read<()> {
        let (mut domain, mut version) = (String::new(), 0);
        while let Some((number, field)) = set.next()? {
            match (number, field) {
                (1, ProtobufField::Bytes(name)) => domain = name.text()?,
                (2, ProtobufField::Number(number)) => version = number,
                _ => {}
            }
        }
        if is_default(&domain) {
            self.graph.opset = version;
        }
        Ok(())
    }

    fn function(&mut self, mut function: ProtobufReader<'_>) -> Read<()> {
        while let Some((number, field)) = function.next()? {
            if let (7, ProtobufField::Bytes(node)) = (number, field) {
                self.node(node, 1)?;
            }
        }
        Ok(())
    }

    fn graph(&mut self, mut graph: ProtobufReader<'_>, depth: usize) -> Read<()> {
        if depth > MAX_DEPTH {
            return Err(graph.malformed(format!("graphs are nested more than {MAX_DEPTH} deep")));
        }
        while let Some((number, field)) = graph.next()? {
            match (number, field) {
                (1, ProtobufField::Bytes(node)) => self.node(node, depth)?,
                (5, ProtobufField::Bytes(tensor)) => {
                    let (name, tensor) = self.tensor(tensor)?;
                    if depth == 0 {
                        self.graph.initializers.insert(name, tensor);
                    }
                }
                (11..=13, ProtobufField::Bytes(info)) => {
                    let port = port(info)?;
                    match number {
                        _ if depth > 0 => {}
                        11 => self.graph.inputs.push(port),
                        _ => {
                            let stated = port.shape.clone();
                            let stated = stated.map(|shape| (port.name.clone(), shape));
                            self.graph.stated.extend(stated);
                            if number == 12 {
                                self.graph.outputs.push(port);
                            }
                        }
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn node(&mut self, mut node: ProtobufReader<'_>, depth: usize) -> Read<()> {
        let (mut found, mut domain) = (Node::default(), String::new());
        while let Some((number, field)) = node.next()? {
            match (number, field) {
                (1, ProtobufField::Bytes(name)) => found.inputs.push(name.text()?),
                (2, ProtobufField::Bytes(name)) => found.outputs.push(name.text()?),
                (4, ProtobufField::Bytes(name)) => found.operator = name.text()?,
                (5, ProtobufField::Bytes(attribute)) => {
                    let (name, value) = self.attribute(attribute, depth)?;
                    found.attributes.insert(name, value);
                }
                (7, ProtobufField::Bytes(name)) => domain = name.text()?,
                _ => {}
            }
        }
        if !is_default(&domain) {
            found.operator = format!("{domain}.{}", found.operator);
        }
        let operator = found.operator.clone();
        *self.graph.operators.entry(operator).or_default() += 1;
        if depth == 0 {
            self.graph.nodes.push(found);
        } else {
            self.graph.inner.push(found);
        }
        Ok(())
    }

    /// Reads an `AttributeProto`: its name and value.
    fn attribute(
        &mut self,
        mut attribute: ProtobufReader<'_>,
        depth: usize,
    ) -> Read<(String, AttributeValue)> {
        let (mut name, mut integers, mut value) =
            (String::new(), Vec::new(), AttributeValue::Other);
        let mut strings = Vec::new();
        while let Some((number, field)) = attribute.next()? {
            match (number, field) {
                (1, ProtobufField::Bytes(text)) => name = text.text()?,
                (3, ProtobufField::Number(number)) => {
                    value = AttributeValue::Integer(number.cast_signed());
                }
                // Bytes that are not text cannot be a padding mode.
                (4, ProtobufField::Bytes(text)) => {
                    value = text
                        .text()
                        .map_or(AttributeValue::Other, AttributeValue::Text);
                }
                (5, ProtobufField::Bytes(tensor)) => {
                    value = AttributeValue::Tensor(self.tensor(tensor)?.1);
                }
                (10, ProtobufField::Bytes(tensor)) => {
                    self.tensor(tensor)?;
                }
                (6 | 11, ProtobufField::Bytes(graph)) => self.graph(graph, depth + 1)?,
                (8, field) => push_integers(field, &mut integers)?,
                (9, ProtobufField::Bytes(text)) if strings.len() < MAX_LABELS => strings.push(text),
                _ => {}
            }
        }
        if name == CLASS_LABELS {
            let texts = strings.iter().map(ProtobufReader::text);
            self.graph.labels = texts.collect::<Read<_>>()?;
        }
        if !integers.is_empty() {
            value = AttributeValue::Integers(integers);
        }
        Ok((name, value))
    }

    /// Reads a tensor and counts its numbers. Returns its name and the part that is kept.
    fn tensor(&mut self, mut tensor: ProtobufReader<'_>) -> Read<(String, StoredTensor)> {
        let (mut found, mut element, mut name) = (StoredTensor::default(), 0, String::new());
        let (mut sizes, mut integers) = (Vec::new(), Vec::new());
        let (mut external, mut raw) = (false, None);
        while let Some((number, field)) = tensor.next()? {
            match (number, field) {
                (1, field) => push_integers(field, &mut sizes)?,
                (2, ProtobufField::Number(kind)) => element = kind,
                (7, field) => push_integers(field, &mut integers)?,
                (8, ProtobufField::Bytes(text)) => name = text.text()?,
                (9, ProtobufField::Bytes(bytes)) => raw = Some(bytes.bytes()),
                (13, ProtobufField::Bytes(place)) => place.skim()?,
                (14, ProtobufField::Number(location)) => external = location == EXTERNAL,
                _ => {}
            }
        }
        check_rank(sizes.len(), tensor)?;
        found.shape = sizes.into_iter().map(i64::cast_unsigned).collect();
        let size = elements(&found.shape);
        // FLOAT, UINT8, INT8, INT32 (biases of quantised models), FLOAT16, DOUBLE, BFLOAT16.
        if matches!(element, 1 | 2 | 3 | 6 | 10 | 11 | 16) {
            self.graph.parameters = self.graph.parameters.saturating_add(size);
        }
        if external {
            self.external.get_or_insert_with(|| name.clone());
        }
        if element == INT64 && size <= MAX_INTEGERS {
            if let Some(raw) = raw {
                let (numbers, _) = raw.as_chunks();
                integers = numbers.iter().copied().map(i64::from_le_bytes).collect();
            }
            found.integers = Some(integers).filter(|integers| integers.len() as u64 == size);
        }
        Ok((name, found))
    }
}

fn check_rank(rank: usize, at: ProtobufReader<'_>) -> Read<()> {
    if rank > MAX_RANK {
        return Err(at.malformed(format!("a tensor has {rank} axes, more than {MAX_RANK}")));
    }
    Ok(())
}

/// Returns how many numbers a tensor of this shape has.
pub(super) fn elements(shape: &[u64]) -> u64 {
    shape.iter().fold(1, |size, &dim| size.saturating_mul(dim))
}

/// Appends one integer, or packed ones.
fn push_integers(field: ProtobufField<'_>, integers: &mut Vec<i64>) -> Read<()> {
    match field {
        ProtobufField::Number(number) => integers.push(number.cast_signed()),
        ProtobufField::Bytes(mut packed) => {
            while let Some(number) = packed.packed_number()? {
                integers.push(number.cast_signed());
            }
        }
        ProtobufField::Fixed => {}
    }
    Ok(())
}

fn is_default(domain: &str) -> bool {
    domain.is_empty() || domain == "ai.onnx"
}

/// Reads a `ValueInfoProto`.
fn port(mut info: ProtobufReader<'_>) -> Read<Port> {
    let mut port = Port::default();
    while let Some((number, field)) = info.next()? {
        match (number, field) {
            (1, ProtobufField::Bytes(name)) => port.name = name.text()?,
            (2, ProtobufField::Bytes(of)) => type_of(of, &mut port, 0)?,
            _ => {}
        }
    }
    Ok(port)
}

/// Reads a `TypeProto`.
fn type_of(mut of: ProtobufReader<'_>, port: &mut Port, depth: usize) -> Read<()> {
    if depth > MAX_DEPTH {
        return Err(of.malformed(format!("sequences are nested more than {MAX_DEPTH} deep")));
    }
    while let Some((number, field)) = of.next()? {
        match (number, field) {
            (1, ProtobufField::Bytes(tensor)) => tensor_type(tensor, port)?,
            (4, ProtobufField::Bytes(mut sequence)) => {
                while let Some((number, field)) = sequence.next()? {
                    if let (1, ProtobufField::Bytes(element)) = (number, field) {
                        type_of(element, &mut Port::default(), depth + 1)?;
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// Reads a `TypeProto.Tensor`.
fn tensor_type(mut tensor: ProtobufReader<'_>, port: &mut Port) -> Read<()> {
    while let Some((number, field)) = tensor.next()? {
        match (number, field) {
            (1, ProtobufField::Number(element)) => port.element = element,
            (2, ProtobufField::Bytes(mut shape)) => {
                let dimensions = port.shape.get_or_insert_default();
                while let Some((number, field)) = shape.next()? {
                    if let (1, ProtobufField::Bytes(dim)) = (number, field) {
                        dimensions.push(dimension(dim)?);
                    }
                }
                check_rank(dimensions.len(), shape)?;
            }
            _ => {}
        }
    }
    Ok(())
}

fn dimension(mut dim: ProtobufReader<'_>) -> Read<Dimension> {
    let mut found = Dimension::Unknown;
    while let Some((number, field)) = dim.next()? {
        found = match (number, field) {
            // Some exporters write -1 or 0 for "any".
            (1, ProtobufField::Number(0)) => Dimension::Unknown,
            (1, ProtobufField::Number(size)) if size > i64::MAX as u64 => Dimension::Unknown,
            (1, ProtobufField::Number(size)) => Dimension::Fixed(size),
            (2, ProtobufField::Bytes(name)) if !name.is_empty() => Dimension::Named(name.text()?),
            _ => found,
        };
    }
    Ok(found)
}

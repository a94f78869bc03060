//! Walks the messages of an ONNX file.
//!
//! Field numbers are those of `onnx.proto3` (onnx 1.23).

use super::{Attribute, Dimension, Graph, Node, Port, Tensor};
use crate::score::protobuf::{Field, Malformed, Reader};

/// Deepest nesting of graphs in graphs (If, Loop, Scan), or of sequences, that is followed.
const MAX_DEPTH: usize = 16;
/// Most numbers of a tensor that are kept: a shape, axes or indices have no more.
pub(super) const MAX_INTEGERS: u64 = 1024;
/// Most axes of a tensor (as many as numpy 2 has).
pub(super) const MAX_RANK: usize = 64;

/// Most labels of classes that are kept.
const MAX_LABELS: usize = 1 << 16;
/// In which classifiers of `ai.onnx.ml` name their classes.
const CLASS_LABELS: &str = "classlabels_strings";

/// `TensorProto.DataLocation.EXTERNAL`.
const EXTERNAL: u64 = 1;
/// `TensorProto.DataType.INT64`.
const INT64: u64 = 7;

/// A graph being read.
#[derive(Default)]
pub(super) struct Walk {
    pub graph: Graph,
    pub has_graph: bool,
    /// The first tensor whose numbers are in another file.
    pub external: Option<String>,
}

type Read<T> = Result<T, Malformed>;

impl Walk {
    pub(super) fn model(&mut self, mut model: Reader<'_>) -> Read<()> {
        while let Some((number, field)) = model.next()? {
            match (number, field) {
                (1, Field::Number(version)) => self.graph.ir_version = version,
                (2, Field::Bytes(name)) => self.graph.producer = name.text()?,
                (7, Field::Bytes(graph)) => {
                    self.has_graph = true;
                    self.graph(graph, 0)?;
                }
                (8, Field::Bytes(set)) => self.operator_set(set)?,
                (14, Field::Bytes(property)) => property.skim()?,
                (25, Field::Bytes(function)) => self.function(function)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn operator_set(&mut self, mut set: Reader<'_>) -> Read<()> {
        let (mut domain, mut version) = (String::new(), 0);
        while let Some((number, field)) = set.next()? {
            match (number, field) {
                (1, Field::Bytes(name)) => domain = name.text()?,
                (2, Field::Number(number)) => version = number,
                _ => {}
            }
        }
        if is_default(&domain) {
            self.graph.opset = version;
        }
        Ok(())
    }

    fn function(&mut self, mut function: Reader<'_>) -> Read<()> {
        while let Some((number, field)) = function.next()? {
            if let (7, Field::Bytes(node)) = (number, field) {
                self.node(node, 1)?;
            }
        }
        Ok(())
    }

    fn graph(&mut self, mut graph: Reader<'_>, depth: usize) -> Read<()> {
        if depth > MAX_DEPTH {
            return Err(graph.malformed(format!("graphs are nested more than {MAX_DEPTH} deep")));
        }
        while let Some((number, field)) = graph.next()? {
            match (number, field) {
                (1, Field::Bytes(node)) => self.node(node, depth)?,
                (5, Field::Bytes(tensor)) => {
                    let (name, tensor) = self.tensor(tensor)?;
                    if depth == 0 {
                        self.graph.initializers.insert(name, tensor);
                    }
                }
                (11..=13, Field::Bytes(info)) => {
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

    fn node(&mut self, mut node: Reader<'_>, depth: usize) -> Read<()> {
        let (mut found, mut domain) = (Node::default(), String::new());
        while let Some((number, field)) = node.next()? {
            match (number, field) {
                (1, Field::Bytes(name)) => found.inputs.push(name.text()?),
                (2, Field::Bytes(name)) => found.outputs.push(name.text()?),
                (4, Field::Bytes(name)) => found.operator = name.text()?,
                (5, Field::Bytes(attribute)) => {
                    let (name, value) = self.attribute(attribute, depth)?;
                    found.attributes.insert(name, value);
                }
                (7, Field::Bytes(name)) => domain = name.text()?,
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

    /// `AttributeProto`: its name and value.
    fn attribute(&mut self, mut attribute: Reader<'_>, depth: usize) -> Read<(String, Attribute)> {
        let (mut name, mut integers, mut value) = (String::new(), Vec::new(), Attribute::Other);
        let mut strings = Vec::new();
        while let Some((number, field)) = attribute.next()? {
            match (number, field) {
                (1, Field::Bytes(text)) => name = text.text()?,
                (3, Field::Number(number)) => value = Attribute::Integer(number.cast_signed()),
                // Bytes that are no text are nobody's padding mode.
                (4, Field::Bytes(text)) => {
                    value = text.text().map_or(Attribute::Other, Attribute::Text);
                }
                (5, Field::Bytes(tensor)) => value = Attribute::Tensor(self.tensor(tensor)?.1),
                (10, Field::Bytes(tensor)) => {
                    self.tensor(tensor)?;
                }
                (6 | 11, Field::Bytes(graph)) => self.graph(graph, depth + 1)?,
                (8, field) => push_integers(field, &mut integers)?,
                (9, Field::Bytes(text)) if strings.len() < MAX_LABELS => strings.push(text),
                _ => {}
            }
        }
        if name == CLASS_LABELS {
            let texts = strings.iter().map(Reader::text);
            self.graph.labels = texts.collect::<Read<_>>()?;
        }
        if !integers.is_empty() {
            value = Attribute::Integers(integers);
        }
        Ok((name, value))
    }

    /// Counts a tensor's numbers; its name, and what is kept of it.
    fn tensor(&mut self, mut tensor: Reader<'_>) -> Read<(String, Tensor)> {
        let (mut found, mut element, mut name) = (Tensor::default(), 0, String::new());
        let (mut sizes, mut integers) = (Vec::new(), Vec::new());
        let (mut external, mut raw) = (false, None);
        while let Some((number, field)) = tensor.next()? {
            match (number, field) {
                (1, field) => push_integers(field, &mut sizes)?,
                (2, Field::Number(kind)) => element = kind,
                (7, field) => push_integers(field, &mut integers)?,
                (8, Field::Bytes(text)) => name = text.text()?,
                (9, Field::Bytes(bytes)) => raw = Some(bytes.bytes()),
                (13, Field::Bytes(place)) => place.skim()?,
                (14, Field::Number(location)) => external = location == EXTERNAL,
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

fn check_rank(rank: usize, at: Reader<'_>) -> Read<()> {
    if rank > MAX_RANK {
        return Err(at.malformed(format!("a tensor has {rank} axes, more than {MAX_RANK}")));
    }
    Ok(())
}

/// Numbers in a tensor of this shape.
pub(super) fn elements(shape: &[u64]) -> u64 {
    shape.iter().fold(1, |size, &dim| size.saturating_mul(dim))
}

/// One integer, or packed ones.
fn push_integers(field: Field<'_>, integers: &mut Vec<i64>) -> Read<()> {
    match field {
        Field::Number(number) => integers.push(number.cast_signed()),
        Field::Bytes(mut packed) => {
            while let Some(number) = packed.packed_number()? {
                integers.push(number.cast_signed());
            }
        }
        Field::Fixed => {}
    }
    Ok(())
}

fn is_default(domain: &str) -> bool {
    domain.is_empty() || domain == "ai.onnx"
}

/// `ValueInfoProto`.
fn port(mut info: Reader<'_>) -> Read<Port> {
    let mut port = Port::default();
    while let Some((number, field)) = info.next()? {
        match (number, field) {
            (1, Field::Bytes(name)) => port.name = name.text()?,
            (2, Field::Bytes(of)) => type_of(of, &mut port, 0)?,
            _ => {}
        }
    }
    Ok(port)
}

/// `TypeProto`.
fn type_of(mut of: Reader<'_>, port: &mut Port, depth: usize) -> Read<()> {
    if depth > MAX_DEPTH {
        return Err(of.malformed(format!("sequences are nested more than {MAX_DEPTH} deep")));
    }
    while let Some((number, field)) = of.next()? {
        match (number, field) {
            (1, Field::Bytes(tensor)) => tensor_type(tensor, port)?,
            (4, Field::Bytes(mut sequence)) => {
                while let Some((number, field)) = sequence.next()? {
                    if let (1, Field::Bytes(element)) = (number, field) {
                        type_of(element, &mut Port::default(), depth + 1)?;
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// `TypeProto.Tensor`.
fn tensor_type(mut tensor: Reader<'_>, port: &mut Port) -> Read<()> {
    while let Some((number, field)) = tensor.next()? {
        match (number, field) {
            (1, Field::Number(element)) => port.element = element,
            (2, Field::Bytes(mut shape)) => {
                let dimensions = port.shape.get_or_insert_default();
                while let Some((number, field)) = shape.next()? {
                    if let (1, Field::Bytes(dim)) = (number, field) {
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

fn dimension(mut dim: Reader<'_>) -> Read<Dimension> {
    let mut found = Dimension::Unknown;
    while let Some((number, field)) = dim.next()? {
        found = match (number, field) {
            // Some exporters write -1 or 0 for "any".
            (1, Field::Number(0)) => Dimension::Unknown,
            (1, Field::Number(size)) if size > i64::MAX as u64 => Dimension::Unknown,
            (1, Field::Number(size)) => Dimension::Fixed(size),
            (2, Field::Bytes(name)) if !name.is_empty() => Dimension::Named(name.text()?),
            _ => found,
        };
    }
    Ok(found)
}

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

/// The maximum number of elements that a file may state for a tensor: numbers of 16 bytes then
/// have a size of 64 bits.
const MAX_ELEMENTS: u64 = 1 << 58;

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
                (20, ProtobufField::Bytes(mut training)) => {
                    while let Some((number, field)) = training.next()? {
                        if let (1 | 2, ProtobufField::Bytes(graph)) = (number, field) {
                            self.graph(graph, 1)?;
                        }
                    }
                }
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
            match (number, field) {
                (7, ProtobufField::Bytes(node)) => self.node(node, 1)?,
                (11, ProtobufField::Bytes(attribute)) => drop(self.attribute(attribute, 1)?),
                _ => {}
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
                (15, ProtobufField::Bytes(sparse)) => self.sparse(sparse)?,
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
                (22 | 23, ProtobufField::Bytes(sparse)) => self.sparse(sparse)?,
                (6 | 11, ProtobufField::Bytes(graph)) => self.graph(graph, depth + 1)?,
                (8, field) => {
                    push_integers(field, &mut integers)?;
                }
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

    /// Reads a `SparseTensorProto`: its values and indices.
    fn sparse(&mut self, mut sparse: ProtobufReader<'_>) -> Read<()> {
        while let Some((number, field)) = sparse.next()? {
            match (number, field) {
                (1 | 2, ProtobufField::Bytes(tensor)) => drop(self.tensor(tensor)?),
                (3, field) => sides(field, &mut Vec::new(), sparse)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// Reads a tensor and counts its numbers. Returns its name and the part that is kept.
    fn tensor(&mut self, mut tensor: ProtobufReader<'_>) -> Read<(String, StoredTensor)> {
        let (mut found, mut element, mut name) = (StoredTensor::default(), 0, String::new());
        let (mut integers, mut entries) = (Vec::new(), 0);
        let (mut external, mut raw) = (false, None);
        while let Some((number, field)) = tensor.next()? {
            match (number, field) {
                (1, field) => sides(field, &mut found.shape, tensor)?,
                (2, ProtobufField::Number(kind)) => element = enumerator(kind),
                (4, field) => entries += fixed_entries(&field, 4),
                (5 | 11, field) => entries += push_integers(field, &mut Vec::new())?,
                (6, ProtobufField::Bytes(_)) => entries += 1,
                (7, field) => entries += push_integers(field, &mut integers)?,
                (8, ProtobufField::Bytes(text)) => name = text.text()?,
                (9, ProtobufField::Bytes(bytes)) => raw = Some(bytes.bytes()),
                (10, field) => entries += fixed_entries(&field, 8),
                (13, ProtobufField::Bytes(place)) => place.skim()?,
                (14, ProtobufField::Number(location)) => external = enumerator(location) != 0,
                _ => {}
            }
        }
        check_rank(found.shape.len(), tensor)?;
        let size = checked_elements(&found.shape, tensor)?;
        if external {
            self.external.get_or_insert_with(|| name.clone());
        } else {
            let raw = raw.map(<[u8]>::len);
            check_length(&name, size, element, raw, entries).map_err(|it| tensor.malformed(it))?;
        }
        // FLOAT, UINT8, INT8, INT32 (biases of quantised models), FLOAT16, DOUBLE, BFLOAT16.
        if matches!(element, 1 | 2 | 3 | 6 | 10 | 11 | 16) {
            self.graph.parameters = self.graph.parameters.saturating_add(size);
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

/// Returns an enumerator as every reader of protobuf takes it: its low 32 bits.
const fn enumerator(number: u64) -> u64 {
    number & 0xFFFF_FFFF
}

/// Appends the sides of a tensor.
fn sides(field: ProtobufField<'_>, sides: &mut Vec<u64>, at: ProtobufReader<'_>) -> Read<()> {
    let mut numbers = Vec::new();
    push_integers(field, &mut numbers)?;
    for side in numbers {
        let side = u64::try_from(side);
        sides.push(side.map_err(|_| at.malformed("a tensor has a side below 0"))?);
    }
    Ok(())
}

/// Counts the elements of a tensor. Both runtimes multiply without a check for overflow.
fn checked_elements(shape: &[u64], at: ProtobufReader<'_>) -> Read<u64> {
    let kept = shape.iter().filter(|&&side| side > 0);
    let size = { kept }.try_fold(1_u64, |size, &side| size.checked_mul(side));
    match size {
        Some(size) if size <= MAX_ELEMENTS => Ok(elements(shape)),
        _ => Err(at.malformed(format!(
            "a tensor of shape {shape:?} has more than {MAX_ELEMENTS} numbers"
        ))),
    }
}

/// Checks that a tensor has as many numbers as its shape says.
fn check_length(
    name: &str,
    size: u64,
    element: u64,
    raw: Option<usize>,
    entries: u64,
) -> Result<(), String> {
    let Some(bits) = element_bits(element) else {
        return Err(format!(
            "the tensor {name:?} has elements of unknown type {element}"
        ));
    };
    let (unit, expected, found) = match raw {
        Some(raw) => ("bytes", (size * bits).div_ceil(8), raw as u64),
        None if bits < 8 => ("entries", (size * bits).div_ceil(8), entries),
        // COMPLEX64 and COMPLEX128 are pairs.
        None if matches!(element, 14 | 15) => ("entries", 2 * size, entries),
        None => ("entries", size, entries),
    };
    if expected == found {
        return Ok(());
    }
    Err(format!(
        "the tensor {name:?}: expected {expected} {unit} for its {size} numbers, found {found}"
    ))
}

/// Returns the size of a `TensorProto.DataType`, bits; a string counts as a byte.
const fn element_bits(element: u64) -> Option<u64> {
    Some(match element {
        2 | 3 | 8 | 9 | 17..=20 | 24 => 8,
        4 | 5 | 10 | 16 => 16,
        1 | 6 | 12 => 32,
        7 | 11 | 13 | 14 => 64,
        15 => 128,
        21..=23 => 4,
        _ => return None,
    })
}

/// Counts the entries of a field of fixed-size numbers, of this many bytes each.
fn fixed_entries(field: &ProtobufField<'_>, bytes: usize) -> u64 {
    match field {
        ProtobufField::Bytes(packed) => (packed.bytes().len() / bytes) as u64,
        ProtobufField::Fixed => 1,
        ProtobufField::Number(_) => 0,
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

/// Appends one integer, or packed ones, and returns their number.
fn push_integers(field: ProtobufField<'_>, integers: &mut Vec<i64>) -> Read<u64> {
    let before = integers.len();
    match field {
        ProtobufField::Number(number) => integers.push(number.cast_signed()),
        ProtobufField::Bytes(mut packed) => {
            while let Some(number) = packed.packed_number()? {
                integers.push(number.cast_signed());
            }
        }
        ProtobufField::Fixed => {}
    }
    Ok((integers.len() - before) as u64)
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
                let fixed = dimensions.iter().map(|dimension| match dimension {
                    Dimension::Fixed(size) => *size,
                    _ => 1,
                });
                checked_elements(&fixed.collect::<Vec<_>>(), shape)?;
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

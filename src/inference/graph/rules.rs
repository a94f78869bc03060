//! The output shape of each operator, from its specification (onnx 1.23, `Operators.md`).
//!
//! rten-shape-inference 0.27 guesses, which must not happen here: it ignores the third axis of a
//! convolution, accepts channels or sums that do not fit, and truncates sizes to 32 bits.

use super::kernels::{conv, gemm, global_pool, matmul, pool};
use super::operands::{Operands, broadcast, sizes};
use super::walk::{MAX_INTEGERS, MAX_RANK, elements};
use super::{AttributeValue, StoredTensor};

/// Operators whose first output has the shape of their first input.
const KEEPING: &str = "Abs BatchNormalization Cast Ceil Celu Clip DequantizeLinear Dropout Elu Erf \
    Exp Floor Gelu GroupNormalization HardSigmoid HardSwish Identity InstanceNormalization LRN \
    LayerNormalization LeakyRelu Log LogSoftmax LpNormalization Mish Neg Not PRelu QuantizeLinear \
    Reciprocal Relu Round Selu Sigmoid Sign Softmax Softplus Sqrt Tanh ThresholdedRelu";
/// Operators that broadcast their inputs.
const BROADCASTING: &str =
    "Add And Div Equal Greater Less Max Mean Min Mod Mul Or Pow Sub Sum Where";

/// Infers the outputs of an operation; empty if its inputs do not determine them. Returns `None` if
/// the operator is unknown, since it may multiply.
pub(super) fn outputs(of: &Operands<'_>) -> Option<Vec<StoredTensor>> {
    let shapes = shapes(of)?;
    if shapes.iter().any(|shape| shape.len() > MAX_RANK) {
        return Some(Vec::new());
    }
    let mut integers = integers(of).filter(|integers| integers.len() as u64 <= MAX_INTEGERS);
    let tensor = |shape| {
        let integers = integers.take();
        StoredTensor { shape, integers }
    };
    Some(shapes.into_iter().map(tensor).collect())
}

/// Infers the shapes of [`outputs`].
fn shapes(of: &Operands<'_>) -> Option<Vec<Vec<u64>>> {
    let operator = of.node.operator.as_str();
    let is_in = |list: &str| list.split(' ').any(|name| name == operator);
    let shape = match operator {
        _ if is_in(KEEPING) => of.shape(0).map(<[u64]>::to_vec),
        _ if is_in(BROADCASTING) => broadcast_all(of),
        _ if operator.starts_with("Reduce") => reduce(of),
        "ArgMin" | "ArgMax" => arg(of),
        "Conv" => conv(of),
        "MaxPool" | "AveragePool" | "LpPool" => pool(of),
        "GlobalAveragePool" | "GlobalMaxPool" | "GlobalLpPool" => global_pool(of),
        "Gemm" => gemm(of),
        "MatMul" => matmul(of),
        "Flatten" => flatten(of),
        "Reshape" => reshape(of),
        "Expand" => expand(of),
        "ConstantOfShape" => of.known(0).and_then(sizes),
        "Tile" => tile(of),
        "Resize" => resize(of),
        "Range" => range(of),
        "Transpose" => transpose(of),
        "Squeeze" => squeeze(of),
        "Unsqueeze" => unsqueeze(of),
        "Concat" => concat(of),
        "Split" => return Some(split(of).unwrap_or_default()),
        "Slice" => slice(of),
        "Gather" => gather(of),
        "Pad" => pad(of),
        "Constant" => constant(of).map(|constant| constant.shape),
        // With attributes, its output is a part of the shape.
        "Shape" if !of.node.attributes.is_empty() => None,
        "Shape" => of.shape(0).map(|shape| vec![shape.len() as u64]),
        _ => return None,
    };
    Some(shape.into_iter().collect())
}

/// Infers the numbers of an output that holds a shape, axes or indices, if they are known.
fn integers(of: &Operands<'_>) -> Option<Vec<i64>> {
    match of.node.operator.as_str() {
        "Constant" => constant(of)?.integers,
        "Shape" if of.node.attributes.is_empty() => {
            let sizes = of.shape(0)?.iter().map(|&size| i64::try_from(size).ok());
            sizes.collect()
        }
        // INT64: other elements round.
        "Cast" if of.integer("to", 0) == 7 => of.known(0).map(<[i64]>::to_vec),
        "Identity" | "Squeeze" | "Unsqueeze" => of.known(0).map(<[i64]>::to_vec),
        "Concat" => (0..of.node.inputs.len()).try_fold(Vec::new(), |mut list, at| {
            list.extend(of.known(at)?);
            (list.len() as u64 <= MAX_INTEGERS).then_some(list)
        }),
        "Gather" => {
            let from = of.known(0)?;
            let picked = of.known(1)?.iter().map(|&at| {
                let at = normal(at, from.len())?;
                from.get(at).copied()
            });
            picked.collect()
        }
        "Add" => elementwise(of, i64::checked_add),
        "Sub" => elementwise(of, i64::checked_sub),
        "Mul" => elementwise(of, i64::checked_mul),
        "Div" => elementwise(of, i64::checked_div),
        _ => None,
    }
}

fn elementwise(of: &Operands<'_>, f: impl Fn(i64, i64) -> Option<i64>) -> Option<Vec<i64>> {
    let (a, b) = (of.known(0)?, of.known(1)?);
    let length = a.len().max(b.len());
    let at = |list: &[i64], at: usize| match list {
        [single] => Some(*single),
        _ => list.get(at).copied(),
    };
    (0..length).map(|i| f(at(a, i)?, at(b, i)?)).collect()
}

/// Converts an axis or index to one that counts from the start.
fn normal(axis: i64, length: usize) -> Option<usize> {
    let length = i64::try_from(length).ok()?;
    let axis = if axis < 0 { axis + length } else { axis };
    usize::try_from(axis).ok().filter(|_| axis < length)
}

fn broadcast_all(of: &Operands<'_>) -> Option<Vec<u64>> {
    (0..of.node.inputs.len()).try_fold(Vec::new(), |shape, at| broadcast(&shape, of.shape(at)?))
}

fn flatten(of: &Operands<'_>) -> Option<Vec<u64>> {
    let shape = of.shape(0)?;
    let axis = of.integer("axis", 1);
    let (before, after) = match usize::try_from(axis) {
        Ok(axis) => shape.split_at_checked(axis)?,
        Err(_) => shape.split_at(normal(axis, shape.len())?),
    };
    Some(vec![elements(before), elements(after)])
}

fn reshape(of: &Operands<'_>) -> Option<Vec<u64>> {
    let from = of.shape(0)?;
    let keeps_zero = of.integer("allowzero", 0) != 0;
    let asked = of
        .known(1)?
        .iter()
        .enumerate()
        .map(|(at, &size)| match size {
            -1 => Some(None),
            0 if !keeps_zero => from.get(at).copied().map(Some),
            _ => u64::try_from(size).ok().map(Some),
        });
    let asked: Vec<Option<u64>> = asked.collect::<Option<_>>()?;
    let stated: Vec<u64> = asked.iter().copied().flatten().collect();
    let rest = elements(from).checked_div(elements(&stated))?;
    let shape: Vec<u64> = asked.iter().map(|size| size.unwrap_or(rest)).collect();
    let free = asked.len() - stated.len();
    (free <= 1 && elements(&shape) == elements(from)).then_some(shape)
}

fn expand(of: &Operands<'_>) -> Option<Vec<u64>> {
    broadcast(of.shape(0)?, &sizes(of.known(1)?)?)
}

fn tile(of: &Operands<'_>) -> Option<Vec<u64>> {
    let (shape, repeats) = (of.shape(0)?, sizes(of.known(1)?)?);
    let sides = shape.iter().zip(&repeats);
    (shape.len() == repeats.len()).then(|| sides.map(|(a, b)| a.saturating_mul(*b)).collect())
}

/// Returns the sizes that a Resize states; scales are numbers that are not kept.
fn resize(of: &Operands<'_>) -> Option<Vec<u64>> {
    let (shape, sizes) = (of.shape(0)?, sizes(of.known(3)?)?);
    let is_plain = of.list("axes").is_none() && sizes.len() == shape.len();
    is_plain.then_some(sizes)
}

fn range(of: &Operands<'_>) -> Option<Vec<u64>> {
    let single = |at: usize| match of.known(at)? {
        [number] => Some(i128::from(*number)),
        _ => None,
    };
    let (start, limit, delta) = (single(0)?, single(1)?, single(2)?);
    let span = (limit - start) * delta.signum();
    let count = (span + delta.abs() - 1).checked_div(delta.abs())?;
    Some(vec![u64::try_from(count.max(0)).unwrap_or(u64::MAX)])
}

fn transpose(of: &Operands<'_>) -> Option<Vec<u64>> {
    let shape = of.shape(0)?;
    let Some(order) = of.list("perm") else {
        return Some(shape.iter().rev().copied().collect());
    };
    let axes = normal_all(order, shape.len())?;
    (axes.len() == shape.len()).then(|| axes.iter().map(|&axis| shape[axis]).collect())
}

fn squeeze(of: &Operands<'_>) -> Option<Vec<u64>> {
    let shape = of.shape(0)?;
    let Some(axes) = of.list_or_input("axes", 1).ok()? else {
        return Some(shape.iter().copied().filter(|&size| size != 1).collect());
    };
    let axes = normal_all(axes, shape.len())?;
    if axes.iter().any(|&axis| shape[axis] != 1) {
        return None;
    }
    let kept = (0..shape.len()).filter(|axis| !axes.contains(axis));
    Some(kept.map(|axis| shape[axis]).collect())
}

fn unsqueeze(of: &Operands<'_>) -> Option<Vec<u64>> {
    let axes = of.list_or_input("axes", 1).ok()??;
    let mut kept = of.shape(0)?.iter();
    let rank = kept.len() + axes.len();
    let axes = normal_all(axes, rank)?;
    let sizes = (0..rank).map(|axis| {
        let one = axes.contains(&axis).then_some(1);
        one.or_else(|| kept.next().copied())
    });
    sizes.collect()
}

fn normal_all(axes: &[i64], rank: usize) -> Option<Vec<usize>> {
    let axes = Some(axes).filter(|axes| axes.len() <= MAX_RANK)?;
    axes.iter().map(|&axis| normal(axis, rank)).collect()
}

fn concat(of: &Operands<'_>) -> Option<Vec<u64>> {
    let mut shape = of.shape(0)?.to_vec();
    let axis = normal(of.integer("axis", 0), shape.len())?;
    for at in 1..of.node.inputs.len() {
        let next = of.shape(at)?;
        let fits = |i: usize| i == axis || next[i] == shape[i];
        if next.len() != shape.len() || !(0..next.len()).all(fits) {
            return None;
        }
        shape[axis] = shape[axis].checked_add(next[axis])?;
    }
    Some(shape)
}

fn split(of: &Operands<'_>) -> Option<Vec<Vec<u64>>> {
    let shape = of.shape(0)?;
    let axis = normal(of.integer("axis", 0), shape.len())?;
    let parts = of.node.outputs.len();
    let lengths = match of.list_or_input("split", 1).ok()? {
        Some(lengths) => sizes(lengths)?,
        None => vec![shape[axis].checked_div(parts as u64)?; parts],
    };
    let part = |length| {
        let mut part = shape.to_vec();
        part[axis] = length;
        part
    };
    let total = lengths
        .iter()
        .try_fold(0_u64, |sum, &length| sum.checked_add(length))?;
    let fits = lengths.len() == parts && total == shape[axis];
    fits.then(|| lengths.into_iter().map(part).collect())
}

fn slice(of: &Operands<'_>) -> Option<Vec<u64>> {
    let mut shape = of.shape(0)?.to_vec();
    let starts = of.list_or_input("starts", 1).ok()??;
    let ends = of.list_or_input("ends", 2).ok()??;
    let all: Vec<i64> = (0..).take(starts.len()).collect();
    let axes = of.list_or_input("axes", 3).ok()?.unwrap_or(&all);
    let ones = vec![1; starts.len()];
    let steps = of.list_or_input("steps", 4).ok()?.unwrap_or(&ones);
    for (((&start, &end), &axis), &step) in starts.iter().zip(ends).zip(axes).zip(steps) {
        let axis = normal(axis, shape.len())?;
        let length = i64::try_from(shape[axis]).ok()?;
        let bound = |at: i64| if at < 0 { at + length } else { at }.clamp(0, length);
        let step = u64::try_from(step).ok().filter(|&step| step > 0)?;
        let span = u64::try_from(bound(end) - bound(start)).unwrap_or(0);
        shape[axis] = span.div_ceil(step);
    }
    Some(shape)
}

fn gather(of: &Operands<'_>) -> Option<Vec<u64>> {
    let (shape, indices) = (of.shape(0)?, of.shape(1)?);
    let axis = normal(of.integer("axis", 0), shape.len())?;
    Some([&shape[..axis], indices, &shape[axis + 1..]].concat())
}

fn pad(of: &Operands<'_>) -> Option<Vec<u64>> {
    let mut shape = of.shape(0)?.to_vec();
    let pads = of.list_or_input("pads", 1).ok()??;
    let all: Vec<i64> = (0..).take(shape.len()).collect();
    let axes = match of.name(3) {
        Some(_) => of.known(3)?,
        None => &all,
    };
    for (at, &axis) in axes.iter().enumerate() {
        let axis = normal(axis, shape.len())?;
        let more = pads.get(at)?.checked_add(*pads.get(at + axes.len())?)?;
        shape[axis] = shape[axis].checked_add_signed(more)?;
    }
    Some(shape)
}

fn reduce(of: &Operands<'_>) -> Option<Vec<u64>> {
    let shape = of.shape(0)?;
    let axes = of.list_or_input("axes", 1).ok()?.unwrap_or_default();
    let axes = normal_all(axes, shape.len())?;
    if axes.is_empty() && of.integer("noop_with_empty_axes", 0) != 0 {
        return Some(shape.to_vec());
    }
    let keeps = of.integer("keepdims", 1) != 0;
    let sizes = shape.iter().enumerate().filter_map(|(axis, &size)| {
        let is_reduced = axes.is_empty() || axes.contains(&axis);
        if is_reduced {
            keeps.then_some(1)
        } else {
            Some(size)
        }
    });
    Some(sizes.collect())
}

fn arg(of: &Operands<'_>) -> Option<Vec<u64>> {
    let mut shape = of.shape(0)?.to_vec();
    let axis = normal(of.integer("axis", 0), shape.len())?;
    if of.integer("keepdims", 1) != 0 {
        shape[axis] = 1;
    } else {
        shape.remove(axis);
    }
    Some(shape)
}

fn constant(of: &Operands<'_>) -> Option<StoredTensor> {
    let (shape, integers) = match of.node.attributes.iter().next()? {
        (_, AttributeValue::Tensor(tensor)) => return Some(tensor.clone()),
        (name, AttributeValue::Integers(values)) if name == "value_ints" => {
            (vec![values.len() as u64], Some(values.clone()))
        }
        (name, AttributeValue::Integer(value)) if name == "value_int" => {
            (Vec::new(), Some(vec![*value]))
        }
        (name, _) if name == "value_float" => (Vec::new(), None),
        _ => return None,
    };
    Some(StoredTensor { shape, integers })
}

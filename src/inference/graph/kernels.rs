//! Operators that multiply, and operators that slide windows.

use super::AttributeValue;
use super::operands::{Operands, broadcast, sizes};
use super::walk::elements;

/// Returns how many products each number of the output sums: 0 for operators that do not count, and
/// `None` if it is not known.
pub(super) fn summed(of: &Operands<'_>) -> Option<u64> {
    match of.node.operator.as_str() {
        "Conv" => Some(elements(of.shape(1)?.get(1..)?)),
        "Gemm" => {
            let axis = usize::from(of.integer("transA", 0) == 0);
            of.shape(0)?.get(axis).copied()
        }
        "MatMul" => of.shape(0)?.last().copied(),
        _ => Some(0),
    }
}

/// Returns the sizes of the spatial axes after windows of `kernel` have slid over `input`.
fn slide(of: &Operands<'_>, input: &[u64], kernel: &[u64]) -> Option<Vec<u64>> {
    let rank = input.len();
    if kernel.len() != rank {
        return None;
    }
    let ones = vec![1; rank];
    let strides = of.list("strides").unwrap_or(&ones);
    let dilations = of.list("dilations").unwrap_or(&ones);
    let zeros = vec![0; 2 * rank];
    let pads = of.list("pads").unwrap_or(&zeros);
    let automatic = match of.node.attributes.get("auto_pad") {
        Some(AttributeValue::Text(mode)) => mode.as_str(),
        _ => "NOTSET",
    };
    let rounds_up = of.integer("ceil_mode", 0) != 0;
    (0..rank)
        .map(|axis| {
            let stride = u64::try_from(*strides.get(axis)?).ok().filter(|&s| s > 0)?;
            let dilation = u64::try_from(*dilations.get(axis)?).ok()?;
            let reach = dilation
                .checked_mul(kernel[axis].checked_sub(1)?)?
                .checked_add(1)?;
            let (before, after) = match automatic {
                "NOTSET" => (
                    u64::try_from(*pads.get(axis)?).ok()?,
                    u64::try_from(*pads.get(axis + rank)?).ok()?,
                ),
                "VALID" => (0, 0),
                "SAME_UPPER" | "SAME_LOWER" => return Some(input[axis].div_ceil(stride)),
                _ => return None,
            };
            let room = input[axis]
                .checked_add(before)?
                .checked_add(after)?
                .checked_sub(reach)?;
            let up = room.div_ceil(stride);
            // Runtimes disagree about a last window that would begin in the padding.
            let is_clear = up.saturating_mul(stride) < input[axis].saturating_add(before);
            match rounds_up {
                false => (room / stride).checked_add(1),
                true => up.checked_add(1).filter(|_| is_clear),
            }
        })
        .collect()
}

pub(super) fn conv(of: &Operands<'_>) -> Option<Vec<u64>> {
    let (&[batch, channels, ref input @ ..], &[filters, depth, ref kernel @ ..]) =
        (of.shape(0)?, of.shape(1)?)
    else {
        return None;
    };
    let groups = u64::try_from(of.integer("group", 1)).ok()?;
    if depth.checked_mul(groups)? != channels {
        return None;
    }
    Some([vec![batch, filters], slide(of, input, kernel)?].concat())
}

pub(super) fn pool(of: &Operands<'_>) -> Option<Vec<u64>> {
    let &[batch, channels, ref input @ ..] = of.shape(0)? else {
        return None;
    };
    let kernel = sizes(of.list("kernel_shape")?)?;
    Some([vec![batch, channels], slide(of, input, &kernel)?].concat())
}

pub(super) fn global_pool(of: &Operands<'_>) -> Option<Vec<u64>> {
    let shape = of.shape(0)?;
    let kept = shape.get(..2)?;
    Some([kept, &vec![1; shape.len() - 2]].concat())
}

pub(super) fn gemm(of: &Operands<'_>) -> Option<Vec<u64>> {
    let (&[a0, a1], &[b0, b1]) = (of.shape(0)?, of.shape(1)?) else {
        return None;
    };
    let turned = |name, [a, b]: [u64; 2]| match of.integer(name, 0) {
        0 => [a, b],
        _ => [b, a],
    };
    let [rows, summed] = turned("transA", [a0, a1]);
    let [depth, columns] = turned("transB", [b0, b1]);
    (summed == depth).then(|| vec![rows, columns])
}

pub(super) fn matmul(of: &Operands<'_>) -> Option<Vec<u64>> {
    let (a, b) = (of.shape(0)?, of.shape(1)?);
    let (&[ref a_batch @ .., rows, summed], &[ref b_batch @ .., depth, columns]) = (a, b) else {
        return None;
    };
    if summed != depth {
        return None;
    }
    let mut shape = broadcast(a_batch, b_batch)?;
    shape.extend([rows, columns]);
    Some(shape)
}

//! What a model takes, as far as its file tells, where no contract stands beside it.

use super::contract::Contract;
use super::graph::{Dimension, Graph, Port};
use super::input::{Axis, Layout};
use super::ports::FLOAT;
use crate::template::Template;
use edgegait_core::silhouette::Size;

/// The contract of a model whose only float input has the shape of GEIs or silhouettes of a size that
/// can be drawn; none where its shape leaves that open.
///
/// GEIs come before silhouettes: of `[N, 1, 50, 30]` the 1 is a channel. What no shape tells (the
/// template, framing, range and distance) is as [`Contract::default`] has it.
pub(super) fn contract(graph: &Graph) -> Option<Contract> {
    let [input] = graph.inputs.as_slice() else {
        return None;
    };
    let templates = [Template::Gei, Template::Silhouettes].into_iter();
    let mut all = templates.flat_map(|template| {
        let layouts = Layout::ALL.into_iter();
        let held = layouts.filter(move |layout| layout.holds(template));
        held.flat_map(move |layout| Size::ALL.map(|size| (template, layout, size)))
    });
    let of = |(template, layout, size): (Template, Layout, Size)| Contract {
        template,
        layout,
        rows: size.rows(),
        columns: size.columns(),
        ..Contract::default()
    };
    all.find_map(|guess| Some(of(guess)).filter(|contract| is_shape_of(input, contract)))
}

/// Whether the sizes that a contract fixes are those that an input states; the batch and the number of
/// frames may be any, but that 3 frames are rather the channels of a picture.
fn is_shape_of(input: &Port, contract: &Contract) -> bool {
    let Some(shape) = input.shape.as_deref().filter(|_| input.element == FLOAT) else {
        return false;
    };
    let axes = contract.layout.axes();
    let size = contract.input_shape(1, 1);
    let is_like = |(axis, (size, dimension)): (&Axis, (&usize, &Dimension))| match axis {
        Axis::Batch => true,
        Axis::Frame => *dimension != Dimension::Fixed(3),
        _ => *dimension == Dimension::Fixed(*size as u64),
    };
    let sizes = size.iter().zip(shape);
    shape.len() == axes.len() && axes.iter().zip(sizes).all(is_like)
}

/// What was taken for granted about a model, in words.
pub(super) fn said(contract: &Contract) -> String {
    format!(
        "{}: no .toml lies beside it: its shape was taken for {} of {}x{} ({}), and framing height, input \
         range 0..1 and {} distance were assumed (a .toml states otherwise)",
        contract.name,
        contract.template.plural(),
        contract.rows,
        contract.columns,
        contract.layout.name(),
        contract.distance.name(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(dimensions: &[Option<u64>]) -> Graph {
        let dimension = |size: &Option<u64>| size.map_or(Dimension::Unknown, Dimension::Fixed);
        let mut graph = Graph::default();
        graph.inputs.push(Port {
            name: "x".into(),
            element: FLOAT,
            shape: Some(dimensions.iter().map(dimension).collect()),
        });
        graph
    }

    #[test]
    fn shapes_tell_template_layout_and_size() {
        use Layout::{Nchw, Ncthw, Nd, Nhw, Nhwc, Ntchw, Nthw};
        use Template::{Gei, Silhouettes};
        let any = None;
        let cases = [
            (
                vec![any, Some(1), Some(64), Some(44)],
                Gei,
                Nchw,
                Size::S64x44,
            ),
            (
                vec![Some(1), Some(1), Some(50), Some(30)],
                Gei,
                Nchw,
                Size::S50x30,
            ),
            (
                vec![any, Some(64), Some(64), Some(1)],
                Gei,
                Nhwc,
                Size::S64x64,
            ),
            (vec![any, Some(64), Some(44)], Gei, Nhw, Size::S64x44),
            (vec![any, Some(1500)], Gei, Nd, Size::S50x30),
            (vec![any, Some(2816)], Gei, Nd, Size::S64x44),
            (
                vec![any, any, Some(64), Some(44)],
                Silhouettes,
                Nthw,
                Size::S64x44,
            ),
            (
                vec![any, Some(30), Some(64), Some(44)],
                Silhouettes,
                Nthw,
                Size::S64x44,
            ),
            (
                vec![any, any, Some(1), Some(64), Some(44)],
                Silhouettes,
                Ntchw,
                Size::S64x44,
            ),
            (
                vec![any, Some(1), any, Some(64), Some(44)],
                Silhouettes,
                Ncthw,
                Size::S64x44,
            ),
        ];
        for (shape, template, layout, size) in cases {
            let found = contract(&graph(&shape)).expect("a guess");
            let is = (found.template, found.layout, (found.rows, found.columns));
            assert_eq!(
                is,
                (template, layout, (size.rows(), size.columns())),
                "{shape:?}"
            );
        }
    }

    #[test]
    fn what_a_shape_leaves_open_is_not_guessed() {
        let open = [
            vec![],
            vec![None, None],
            vec![None, Some(60)],
            vec![None, Some(1), None, None],
            vec![None, Some(1), Some(128), Some(88)],
            vec![None, Some(3), Some(64), Some(44)],
            vec![None, Some(1), Some(44), Some(64)],
            vec![None, None, None, Some(64), Some(44)],
        ];
        for shape in open {
            assert_eq!(contract(&graph(&shape)), None, "{shape:?}");
        }
        let mut two = graph(&[None, Some(1), Some(50), Some(30)]);
        two.inputs.push(two.inputs[0].clone());
        assert_eq!(contract(&two), None);
        let mut bytes = graph(&[None, Some(1), Some(50), Some(30)]);
        bytes.inputs[0].element = 2;
        assert_eq!(contract(&bytes), None);
    }
}

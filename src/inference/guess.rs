//! Guesses the contract of a model from its file, if there is none beside it.

use super::contract::{Contract, OutputNames};
use super::graph::{Dimension, Graph, Port};
use super::input::{InputAxis, InputLayout, InputRange};
use super::ports::Element;
use crate::draw::template::Template;
use edgegait_core::silhouette::Size;

/// Channels of pictures in colour.
const COLOURS: usize = 3;

/// Returns the contract of a model whose only input has the shape of GEIs or silhouettes of a size
/// that can be drawn; `None` if its shape leaves that open.
///
/// An input with the name of a template takes that template. GEIs come before silhouettes: the 1 of
/// `[N, 1, 50, 30]` and the 3 of `[N, 3, 50, 30]` are channels. What a shape does not show
/// (framing, range and distance) is as in [`Contract::default`], except that bytes are 0 to 255. A
/// scikit-learn classifier names the classes. A second input, f32 `[N, 2]`, takes viewpoints.
pub(super) fn contract(graph: &Graph) -> Option<Contract> {
    let (input, view) = match graph.inputs.as_slice() {
        [input] => (input, None),
        [input, view] | [view, input] if is_of_views(view) => (input, Some(view)),
        _ => return None,
    };
    let input_range = match Element::from_data_type(input.element)? {
        Element::U8 => InputRange::Byte,
        Element::F32 | Element::F64 => InputRange::Unit,
    };
    // In files that EdgeGait writes, the input has the name of its template.
    let named = { Template::ALL.into_iter() }.find(|template| template.name() == input.name);
    let templates = [
        (named.unwrap_or(Template::Gei), 1),
        (Template::Gei, 1),
        (Template::Gei, COLOURS),
        (Template::Silhouettes, 1),
    ];
    let mut all = templates.into_iter().flat_map(|(template, channels)| {
        let layouts = InputLayout::ALL.into_iter();
        let held = layouts.filter(move |layout| layout.holds(template));
        let held = held.filter(move |layout| channels == 1 || layout.has_channels());
        held.flat_map(move |layout| Size::ALL.map(|size| (template, channels, layout, size)))
    });
    let of = |(template, channels, layout, size): (Template, usize, InputLayout, Size)| Contract {
        input_range,
        template,
        channels,
        layout,
        rows: size.rows(),
        columns: size.columns(),
        view_input: view.map(|port| port.name.clone()),
        ..Contract::default()
    };
    let mut found =
        all.find_map(|guess| Some(of(guess)).filter(|contract| is_shape_of(input, contract)))?;
    if let Some(scores) = scores(graph) {
        found.classes.clone_from(&graph.labels);
        found.outputs = OutputNames {
            scores: Some(scores.name.clone()),
            embedding: None,
        };
    }
    Some(found)
}

/// Returns whether an input can take viewpoints: f32 `[N, 2]`.
fn is_of_views(port: &Port) -> bool {
    port.is_pair() && Element::from_data_type(port.element) == Some(Element::F32)
}

/// Returns the output that has a number for each class that the graph names.
fn scores(graph: &Graph) -> Option<&Port> {
    let is_scores = |port: &&Port| {
        let width = match port.shape.as_deref() {
            Some([_, Dimension::Fixed(width)]) => Some(*width),
            Some([_, _]) => None,
            _ => return false,
        };
        let is_number = matches!(
            Element::from_data_type(port.element),
            Some(Element::F32 | Element::F64)
        );
        is_number && width.is_none_or(|width| width == graph.labels.len() as u64)
    };
    let mut outputs = graph.outputs.iter().filter(|_| !graph.labels.is_empty());
    outputs.find(is_scores)
}

/// Returns whether an input states the sizes that a contract fixes; batch and number of frames may
/// differ.
fn is_shape_of(input: &Port, contract: &Contract) -> bool {
    let Some(shape) = input.shape.as_deref() else {
        return false;
    };
    let axes = contract.layout.axes();
    let size = contract.input_shape(1, 1);
    let is_like = |(axis, (size, dimension)): (&InputAxis, (&usize, &Dimension))| match axis {
        InputAxis::Batch | InputAxis::Frame => true,
        _ => *dimension == Dimension::Fixed(*size as u64),
    };
    let sizes = size.iter().zip(shape);
    shape.len() == axes.len() && axes.iter().zip(sizes).all(is_like)
}

/// Describes the assumptions about a model.
pub(super) fn said(contract: &Contract) -> String {
    let classes = match contract.classes.len() {
        0 => String::new(),
        count => format!(", its {count} classes as people"),
    };
    let view = match &contract.view_input {
        None => String::new(),
        Some(name) => format!(", its input {name:?} as viewpoints"),
    };
    format!(
        "no .toml lies beside it: its shape was read as {}{classes}{view}; framing height, \
         input range {} and {} distance were assumed (edgegait contract writes a .toml to state \
         otherwise)",
        contract.given(),
        contract.input_range.name(),
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
            element: 1,
            shape: Some(dimensions.iter().map(dimension).collect()),
        });
        graph
    }

    #[test]
    fn shapes_tell_template_layout_and_size() {
        use InputLayout::{Nchw, Ncthw, Nd, Nhw, Nhwc, Ntchw, Nthw};
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
        bytes.inputs[0].element = 7;
        assert_eq!(contract(&bytes), None);
    }

    #[test]
    fn a_second_input_of_pairs_is_taken_for_viewpoints() {
        let mut two = graph(&[None, Some(1), Some(50), Some(30)]);
        two.inputs.push(Port {
            name: "angles".into(),
            ..graph(&[None, Some(2)]).inputs[0].clone()
        });
        for _ in 0..2 {
            let found = contract(&two).expect("a guess");
            assert_eq!(found.view_input.as_deref(), Some("angles"));
            assert!(said(&found).contains("its input \"angles\" as viewpoints"));
            two.inputs.reverse();
        }
    }

    #[test]
    fn an_input_that_is_called_as_a_template_is_of_it() {
        let mut three = graph(&[None, Some(3), Some(50), Some(30)]);
        let found = contract(&three).expect("a guess");
        assert_eq!((found.template, found.channels), (Template::Gei, 3));
        three.inputs[0].name = "frequency".into();
        let found = contract(&three).expect("a guess");
        assert_eq!((found.template, found.channels), (Template::Frequency, 1));
    }

    #[test]
    fn bytes_are_of_255_and_three_channels_are_equal() {
        let mut bytes = graph(&[None, Some(1), Some(50), Some(30)]);
        bytes.inputs[0].element = 2;
        let found = contract(&bytes).expect("a guess");
        assert_eq!((found.input_range, found.channels), (InputRange::Byte, 1));
        for (shape, layout) in [
            (vec![None, Some(3), Some(64), Some(44)], InputLayout::Nchw),
            (vec![None, Some(64), Some(44), Some(3)], InputLayout::Nhwc),
        ] {
            let found = contract(&graph(&shape)).expect("a guess");
            let is = (found.template, found.channels, found.layout);
            assert_eq!(is, (Template::Gei, 3, layout));
            assert!(
                said(&found).contains("64x44 in 3 equal channels"),
                "{}",
                said(&found)
            );
        }
    }

    #[test]
    fn classes_that_a_classifier_names_are_people() {
        let port = |name: &str, element, shape: &[Option<u64>]| Port {
            name: name.into(),
            element,
            ..graph(shape).inputs[0].clone()
        };
        let mut of_scikit = graph(&[None, Some(1500)]);
        of_scikit.labels = vec!["ann".into(), "bob".into()];
        of_scikit.outputs = vec![
            port("label", 8, &[None]),
            port("probabilities", 1, &[None, Some(2)]),
        ];
        let found = contract(&of_scikit).expect("a guess");
        assert_eq!(found.classes, ["ann", "bob"]);
        assert_eq!(found.outputs.scores.as_deref(), Some("probabilities"));
        of_scikit.outputs[1] = port("probabilities", 1, &[None, Some(3)]);
        assert_eq!(contract(&of_scikit).expect("a guess").classes, [""; 0]);
    }
}

//! Which inputs and outputs of a graph are used, and whether they fit a contract.

use super::contract::Contract;
use super::graph::{Dimension, Graph, Port};
use super::input::{Axis, Layout};
use crate::train::onnx::{EMBEDDING, SCORES};

/// Which inputs and outputs of a model are used, and how many inputs at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Ports {
    pub input: String,
    pub embedding: String,
    pub scores: Option<String>,
    pub batching: Batching,
}

/// How many inputs a model may be given at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Batching {
    /// Any number: its batch axis is free.
    Any,
    /// One: its batch axis is 1.
    FixedOne,
    /// One, though its batch axis is free: it scales numbers to integers by the least and the
    /// largest of the whole batch, so that a result would depend on its batch mates.
    DynamicQuantization,
}

impl Batching {
    /// Whether inputs are run one by one.
    #[must_use]
    pub fn is_one(self) -> bool {
        self != Self::Any
    }
}

impl Ports {
    /// The ports, and the number of frames if the file fixes it.
    pub fn find(graph: &Graph, contract: &Contract) -> Result<(Self, Option<usize>), String> {
        let expected = expected_input(contract);
        let [input] = graph.inputs.as_slice() else {
            return Err(format!(
                "expected one input of {expected}, found {}",
                list(&graph.inputs)
            ));
        };
        let axes = contract.layout.axes();
        let shape = match &input.shape {
            Some(shape) if input.element == FLOAT && fits(shape, contract) => shape,
            _ => {
                return Err(format!(
                    "expected the input as {expected}, found {input} ({})",
                    remedy(input, contract)
                ));
            }
        };
        let fixed = |wanted: Axis| {
            let at = axes.iter().position(|axis| *axis == wanted)?;
            match shape.get(at)? {
                Dimension::Fixed(size) => usize::try_from(*size).ok(),
                _ => None,
            }
        };
        let batching = match fixed(Axis::Batch) {
            Some(1) => Batching::FixedOne,
            Some(size) => {
                return Err(format!(
                    "expected a free batch axis or one of 1, found {size} \
                     (export it with dynamic_axes)"
                ));
            }
            None if graph.operators.keys().any(|name| quantizes(name)) => {
                Batching::DynamicQuantization
            }
            None => Batching::Any,
        };
        let (embedding, scores) = outputs(graph, contract)?;
        let ports = Self {
            input: input.name.clone(),
            embedding: embedding.name.clone(),
            scores: scores.map(|port| port.name.clone()),
            batching,
        };
        Ok((ports, fixed(Axis::Frame)))
    }
}

/// The outputs that are used: embedding and scores.
fn outputs<'a>(
    graph: &'a Graph,
    contract: &Contract,
) -> Result<(&'a Port, Option<&'a Port>), String> {
    let scores = match &contract.outputs.scores {
        Some(name) => Some(named(graph, name)?),
        None => graph.outputs.iter().find(|port| port.name == SCORES),
    };
    let embedding = match &contract.outputs.embedding {
        Some(name) => named(graph, name)?,
        None => graph
            .outputs
            .iter()
            .find(|port| port.name == EMBEDDING)
            .or_else(|| graph.outputs.iter().find(|port| Some(*port) != scores))
            .or(scores)
            .ok_or("expected an output, found none")?,
    };
    let rank_is = |port: &Port, ranks: &[usize]| {
        let rank = port.shape.as_ref().map(Vec::len);
        port.element == FLOAT && rank.is_none_or(|rank| ranks.contains(&rank))
    };
    if !rank_is(embedding, &[2, 3]) {
        return Err(format!(
            "expected the embedding as f32 [N, numbers] or [N, numbers, parts], found {embedding} \
             (end the model with Flatten, or name another output as embedding under [outputs] in the .toml)"
        ));
    }
    let people = contract.classes.len();
    let Some(port) = scores else {
        if people > 0 {
            return Err(format!(
                "expected an output \"scores\" for the {people} classes in the contract, found {} \
                 (name it as scores under [outputs] in the .toml)",
                list(&graph.outputs)
            ));
        }
        return Ok((embedding, None));
    };
    if !rank_is(port, &[2]) {
        return Err(format!(
            "expected the scores as f32 [N, classes], found {port} (reduce or flatten it before export)"
        ));
    }
    if let Some([_, width]) = port.shape.as_deref()
        && people > 0
        && !may_be(width, people)
    {
        return Err(format!(
            "expected a score for each of the {people} classes in the contract, found {port}"
        ));
    }
    Ok((embedding, scores))
}

/// The input as the contract has it: `f32 [N, 1, 50, 30]`.
fn expected_input(contract: &Contract) -> String {
    let size = |axis: &Axis| match axis {
        Axis::Batch => "N".to_owned(),
        Axis::Frame => contract
            .frames
            .map_or("T".to_owned(), |frames| frames.to_string()),
        Axis::Channel => "1".to_owned(),
        Axis::Row => contract.rows.to_string(),
        Axis::Column => contract.columns.to_string(),
    };
    let sizes: Vec<String> = contract.layout.axes().iter().map(size).collect();
    format!("f32 [{}]", sizes.join(", "))
}

/// Whether a shape may be that of the contract, but for the batch.
fn fits(shape: &[Dimension], contract: &Contract) -> bool {
    let axes = contract.layout.axes();
    shape.len() == axes.len()
        && shape.iter().zip(axes).all(|(dimension, axis)| match axis {
            Axis::Batch => true,
            Axis::Frame => contract
                .frames
                .is_none_or(|frames| may_be(dimension, frames)),
            Axis::Channel => may_be(dimension, 1),
            Axis::Row => may_be(dimension, contract.rows),
            Axis::Column => may_be(dimension, contract.columns),
        })
}

/// What to do about an input that does not fit.
fn remedy(input: &Port, contract: &Contract) -> String {
    let shape = input.shape.as_deref().unwrap_or_default();
    // A free number of frames may be one channel: what the contract has in mind comes first.
    let mut layouts = Layout::ALL;
    layouts.sort_by_key(|layout| layout.template() != contract.template);
    let other = layouts.into_iter().find(|&layout| {
        let contract = Contract {
            layout,
            frames: None,
            ..contract.clone()
        };
        input.element == FLOAT && fits(shape, &contract)
    });
    match other {
        Some(layout) if layout == contract.layout => {
            "frames can be given in the .toml beside the model".into()
        }
        Some(layout) => format!(
            "template = {:?} with layout = {:?} in the .toml beside the model would fit",
            layout.template().name(),
            layout.name()
        ),
        None => {
            "rows, columns, template and layout can be given in the .toml beside the model".into()
        }
    }
}

/// Whether an operator quantises by the numbers that it gets: those of ONNX and ONNX Runtime are
/// all called so.
fn quantizes(operator: &str) -> bool {
    let name = operator.rsplit('.').next().unwrap_or(operator);
    name.starts_with("DynamicQuantize")
}

/// `TensorProto.DataType.FLOAT`.
const FLOAT: u64 = 1;

fn may_be(dimension: &Dimension, size: usize) -> bool {
    !matches!(dimension, Dimension::Fixed(fixed) if *fixed != size as u64)
}

fn named<'a>(graph: &'a Graph, name: &str) -> Result<&'a Port, String> {
    graph
        .outputs
        .iter()
        .find(|port| port.name == name)
        .ok_or_else(|| {
            format!(
                "expected an output {name:?} as the contract says, found {}",
                list(&graph.outputs)
            )
        })
}

fn list(ports: &[Port]) -> String {
    if ports.is_empty() {
        return "none".into();
    }
    ports
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::testing::{bytes_with, small_model};
    use crate::score::{Model, Template};

    fn refusal(bytes: Vec<u8>, contract: Contract) -> String {
        Model::from_bytes("m.onnx", bytes, contract)
            .expect_err("does not agree")
            .to_string()
    }

    #[test]
    fn our_own_model_agrees_with_the_default_contract() {
        let model = small_model();
        assert_eq!(model.contract().name, "small");
        let ports = Ports {
            input: "gei".into(),
            embedding: "embedding".into(),
            scores: Some("scores".into()),
            batching: Batching::Any,
        };
        assert_eq!(model.ports(), &ports);
    }

    /// A refusal's text without the file.
    fn of(bytes: Vec<u8>, contract: Contract) -> String {
        refusal(bytes, contract).replace("m.onnx: ", "")
    }

    fn gei(layout: Layout) -> Contract {
        Contract {
            layout,
            ..Contract::default()
        }
    }

    fn silhouettes(layout: Layout, frames: Option<usize>) -> Contract {
        Contract {
            template: Template::Silhouettes,
            layout,
            frames,
            ..Contract::default()
        }
    }

    const IMAGE: [Option<u16>; 4] = [None, Some(1), Some(50), Some(30)];

    #[test]
    fn inputs_that_do_not_fit_are_refused_with_both_shapes() {
        let any = None;
        let (one, h, w) = (Some(1), Some(50), Some(30));
        let by_toml =
            "rows, columns, template and layout can be given in the .toml beside the model";
        let would_fit = |template: &str, layout: &str| {
            format!(
                "template = {template:?} with layout = {layout:?} in the .toml beside the model would fit"
            )
        };
        for (contract, element, found, expected, listed, way_out) in [
            (
                gei(Layout::Nchw),
                1,
                vec![any, one, Some(64), Some(44)],
                "[N, 1, 50, 30]",
                "f32 [N, 1, 64, 44]",
                by_toml.to_owned(),
            ),
            (
                gei(Layout::Nchw),
                1,
                vec![any, Some(1500)],
                "[N, 1, 50, 30]",
                "f32 [N, 1500]",
                by_toml.to_owned(),
            ),
            (
                gei(Layout::Nchw),
                2,
                IMAGE.to_vec(),
                "[N, 1, 50, 30]",
                "u8 [N, 1, 50, 30]",
                by_toml.to_owned(),
            ),
            (
                gei(Layout::Nchw),
                1,
                vec![any, Some(3), h, w],
                "[N, 1, 50, 30]",
                "f32 [N, 3, 50, 30]",
                would_fit("silhouettes", "NTHW"),
            ),
            (
                gei(Layout::Nchw),
                1,
                vec![any, h, w, one],
                "[N, 1, 50, 30]",
                "f32 [N, 50, 30, 1]",
                would_fit("gei", "NHWC"),
            ),
            (
                gei(Layout::Nhwc),
                1,
                IMAGE.to_vec(),
                "[N, 50, 30, 1]",
                "f32 [N, 1, 50, 30]",
                would_fit("gei", "NCHW"),
            ),
            (
                gei(Layout::Nhw),
                1,
                vec![any, w, h],
                "[N, 50, 30]",
                "f32 [N, 30, 50]",
                by_toml.to_owned(),
            ),
            (
                silhouettes(Layout::Nthw, None),
                1,
                vec![any, any, one, h, w],
                "[N, T, 50, 30]",
                "f32 [N, T, 1, 50, 30]",
                would_fit("silhouettes", "NTCHW"),
            ),
            (
                silhouettes(Layout::Ntchw, None),
                1,
                vec![any, any, h, w],
                "[N, T, 1, 50, 30]",
                "f32 [N, T, 50, 30]",
                would_fit("silhouettes", "NTHW"),
            ),
            (
                silhouettes(Layout::Ntchw, Some(30)),
                1,
                vec![any, one, Some(30), h, w],
                "[N, 30, 1, 50, 30]",
                "f32 [N, 1, 30, 50, 30]",
                would_fit("silhouettes", "NCTHW"),
            ),
            (
                silhouettes(Layout::Nthw, Some(30)),
                1,
                vec![any, Some(20), h, w],
                "[N, 30, 50, 30]",
                "f32 [N, 20, 50, 30]",
                "frames can be given in the .toml beside the model".to_owned(),
            ),
        ] {
            let expected =
                format!("expected the input as f32 {expected}, found \"gei\" {listed} ({way_out})");
            assert_eq!(of(bytes_with(element, &found, 1, 2), contract), expected);
        }
        let text = of(
            bytes_with(1, &[Some(8), one, h, w], 1, 2),
            Contract::default(),
        );
        assert!(
            text.contains("expected a free batch axis or one of 1, found 8"),
            "{text}"
        );
    }

    #[test]
    fn two_inputs_are_refused_and_listed() {
        // GraphProto.input { name "mask" } behind those of a whole model.
        let mut bytes = bytes_with(1, &IMAGE, 1, 2);
        bytes.extend(b"\x3A\x08\x5A\x06\x0A\x04mask");
        let text = of(bytes, Contract::default());
        assert_eq!(
            text,
            "expected one input of f32 [N, 1, 50, 30], found \"gei\" f32 [N, 1, 50, 30], \"mask\" unknown of any shape"
        );
    }

    #[test]
    fn every_layout_fits_its_own_shape() {
        let (one, h, w) = (Some(1), Some(50), Some(30));
        for (layout, shape) in [
            (Layout::Nchw, vec![None, one, h, w]),
            (Layout::Nhwc, vec![None, h, w, one]),
            (Layout::Nhw, vec![None, h, w]),
            (Layout::Nthw, vec![None, None, h, w]),
            (Layout::Ntchw, vec![None, None, one, h, w]),
            (Layout::Ncthw, vec![None, one, None, h, w]),
        ] {
            let contract = match layout.template() {
                Template::Gei => gei(layout),
                Template::Silhouettes => silhouettes(layout, None),
            };
            let bytes = bytes_with(1, &shape, 1, 2);
            let model = Model::from_bytes("m.onnx", bytes, contract).expect("its own shape");
            assert_eq!(
                (model.contract().frames, model.batching()),
                (None, Batching::Any)
            );
        }
    }

    #[test]
    fn outputs_that_do_not_fit_are_refused_with_both_shapes() {
        let text = of(bytes_with(1, &IMAGE, 7, 2), Contract::default());
        assert!(text.contains("found \"out\" i64 [N, 4]"), "{text}");
        let text = of(bytes_with(1, &IMAGE, 1, 4), Contract::default());
        let expected = "expected the embedding as f32 [N, numbers] or [N, numbers, parts], found \"out\" f32 [N, 4, 4, 4]";
        assert!(text.starts_with(expected), "{text}");
        assert!(
            Model::from_bytes("m.onnx", bytes_with(1, &IMAGE, 1, 3), Contract::default()).is_ok()
        );

        let mut contract = Contract {
            classes: ["a", "b", "c", "d"].map(String::from).to_vec(),
            ..Contract::default()
        };
        let text = of(bytes_with(1, &IMAGE, 1, 3), contract.clone());
        let expected = "expected an output \"scores\" for the 4 classes in the contract, found \"out\" f32 [N, 4, 4]";
        assert!(text.starts_with(expected), "{text}");
        contract.outputs.scores = Some("out".into());
        let text = of(bytes_with(1, &IMAGE, 1, 3), contract);
        let expected = "expected the scores as f32 [N, classes], found \"out\" f32 [N, 4, 4]";
        assert!(text.starts_with(expected), "{text}");
    }

    #[test]
    fn a_batch_of_one_and_a_single_output_of_any_name_will_do() {
        let bytes = bytes_with(1, &[Some(1), Some(1), Some(50), Some(30)], 1, 2);
        let model = Model::from_bytes("m.onnx", bytes, Contract::default()).expect("usable");
        assert_eq!(model.batching(), Batching::FixedOne);
        assert_eq!(
            (model.ports().embedding.as_str(), &model.ports().scores),
            ("out", &None)
        );
    }

    #[test]
    fn names_and_classes_of_the_contract_are_compared() {
        let classes = ["a", "b", "c"].map(String::from).to_vec();
        let mut contract = Contract {
            classes,
            ..Contract::default()
        };
        let text = refusal(small_model().bytes().to_vec(), contract.clone());
        assert!(
            text.contains("each of the 3 classes in the contract, found \"scores\" f32 [N, 2]"),
            "{text}"
        );
        contract.outputs.embedding = Some("features".into());
        let text = refusal(small_model().bytes().to_vec(), contract);
        assert!(
            text.contains(
                "expected an output \"features\" as the contract says, found \"embedding\""
            ),
            "{text}"
        );
    }
}

//! The inputs and outputs of a graph that are used, and whether they fit a contract.

use super::contract::Contract;
use super::graph::{Dimension, Graph, Port};
use super::input::{InputAxis, InputLayout, InputRange};
use crate::draw::template::Template;
use edgegait_core::silhouette::Size;

/// The name, in our own models, of the output that is compared by distance, f32 `[N, dims]`.
pub const EMBEDDING: &str = "embedding";
/// The name, in our own models, of the output whose highest column decides, f32 `[N, classes]`.
pub const SCORES: &str = "scores";

/// The inputs and outputs of a model that are used, and how many inputs a call may have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Ports {
    pub input: String,
    /// The input of viewpoints, f32 `[N, 2]`, if there is one.
    pub view: Option<String>,
    pub embedding: String,
    pub scores: Option<String>,
    pub batching: Batching,
    pub element: Element,
}

/// The element type of a model's input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    F32,
    F64,
    U8,
}

impl Element {
    /// Returns the element type for a `TensorProto.DataType`, if inputs can be made in it.
    pub(super) const fn from_data_type(kind: u64) -> Option<Self> {
        match kind {
            FLOAT => Some(Self::F32),
            UINT8 => Some(Self::U8),
            DOUBLE => Some(Self::F64),
            _ => None,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
            Self::U8 => "u8",
        }
    }
}

/// Rounds a number of 0 to 255 to a byte.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and contracts with bytes have no other numbers"
)]
pub(super) fn byte_of(number: f32) -> u8 {
    number.round() as u8
}

/// How many inputs one call of a model may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Batching {
    /// Any number: its batch axis is free.
    Any,
    /// One: its batch axis is 1.
    FixedOne,
    /// One, though its batch axis is free: it quantises by the least and the largest number of the
    /// whole batch, so results would depend on the other inputs.
    DynamicQuantization,
}

impl Batching {
    /// Returns whether inputs are run one by one.
    #[must_use]
    pub fn is_one(self) -> bool {
        self != Self::Any
    }
}

impl Ports {
    /// Finds the ports, and the number of frames if the file fixes it.
    pub(super) fn find(
        graph: &Graph,
        contract: &Contract,
    ) -> Result<(Self, Option<usize>), String> {
        let expected = |element: Option<Element>| expected_input(element, contract);
        let (input, view) = inputs(graph, contract)?;
        let axes = contract.layout.axes();
        let element = Element::from_data_type(input.element);
        let (element, shape) = match (&input.shape, element) {
            (Some(shape), Some(element)) if fits(shape, contract) => (element, shape),
            _ => {
                return Err(format!(
                    "expected the input as {}, found {input} ({})",
                    expected(element),
                    remedy(input, contract)
                ));
            }
        };
        let is_plain = contract.mean.is_empty() && contract.std.is_empty();
        if element == Element::U8 && !(is_plain && contract.input_range == InputRange::Byte) {
            return Err(format!(
                "expected bytes of 0 to 255 for {input}, found input_range {:?}{} (in its .toml: input_range = \
                 \"0..255\", without mean and std)",
                contract.input_range.name(),
                if is_plain { "" } else { " with mean or std" },
            ));
        }
        let fixed = |wanted: InputAxis| {
            let at = axes.iter().position(|axis| *axis == wanted)?;
            match shape.get(at)? {
                Dimension::Fixed(size) => usize::try_from(*size).ok(),
                _ => None,
            }
        };
        let batching = match fixed(InputAxis::Batch) {
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
            view: view.map(|port| port.name.clone()),
            embedding: embedding.name.clone(),
            scores: scores.map(|port| port.name.clone()),
            batching,
            element,
        };
        Ok((ports, fixed(InputAxis::Frame)))
    }
}

/// Finds the input of templates or silhouettes, and the input of viewpoints if there is one.
fn inputs<'a>(
    graph: &'a Graph,
    contract: &Contract,
) -> Result<(&'a Port, Option<&'a Port>), String> {
    let expected = expected_input(None, contract);
    let found = list_of(&graph.inputs);
    let is_view = |port: &&Port| Some(&port.name) == contract.view_input.as_ref();
    let view = graph.inputs.iter().find(is_view);
    let others: Vec<&Port> = graph.inputs.iter().filter(|port| !is_view(port)).collect();
    if let (Some(name), None) = (&contract.view_input, view) {
        return Err(format!(
            "expected an input {name:?} of viewpoints as the contract says, found {found}"
        ));
    }
    if let Some(view) = view {
        let fits = view
            .shape
            .as_deref()
            .is_none_or(|shape| shape.len() == 2 && may_be(&shape[1], 2));
        if view.element != FLOAT || !fits {
            return Err(format!(
                "expected the viewpoints as f32 [N, 2], found {view}"
            ));
        }
    }
    match (others.as_slice(), view) {
        ([input], view) => Ok((input, view)),
        (_, Some(view)) => Err(format!(
            "expected one input of {expected} beside {view}, found {found}"
        )),
        (_, None) => {
            let pair = graph.inputs.iter().find(|port| port.is_pair());
            let name = pair.map_or("NAME", |port| &port.name);
            Err(format!(
                "expected one input of {expected}, found {found} (export a graph that takes images only; if it also \
                 takes viewpoints, name their input in its .toml: view_input = {name:?})"
            ))
        }
    }
}

/// Finds the outputs that are used: embedding and scores.
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
        None => {
            let others = || graph.outputs.iter().filter(|port| Some(*port) != scores);
            let fitting = others().find(|port| rank_is(port, &[2, 3]));
            graph
                .outputs
                .iter()
                .find(|port| port.name == EMBEDDING)
                .or(fitting)
                .or(scores)
                .or_else(|| others().next())
                .ok_or("expected an output, found none")?
        }
    };
    if !rank_is(embedding, &[2, 3]) {
        return Err(format!(
            "expected the embedding as f32 [N, numbers] or [N, numbers, parts], found {embedding} ({})",
            remedy_of_outputs(graph, "embedding", &[2, 3])
        ));
    }
    let people = contract.classes.len();
    let Some(port) = scores else {
        if people > 0 {
            return Err(format!(
                "expected an output \"scores\" for the {people} classes in the contract, found {} ({})",
                list_of(&graph.outputs),
                remedy_of_outputs(graph, "scores", &[2])
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

/// Returns whether an output has floats and one of these ranks, as far as the file states it.
fn rank_is(port: &Port, ranks: &[usize]) -> bool {
    let rank = port.shape.as_ref().map(Vec::len);
    [FLOAT, DOUBLE].contains(&port.element) && rank.is_none_or(|rank| ranks.contains(&rank))
}

/// Returns the advice if no output serves as `role`, which needs one of these ranks.
fn remedy_of_outputs(graph: &Graph, role: &str, ranks: &[usize]) -> String {
    if graph.operators.keys().any(|name| name.ends_with("ZipMap")) {
        return "skl2onnx gives probabilities as a list of maps unless it gets options={\"zipmap\": False}".into();
    }
    match graph.outputs.iter().find(|port| rank_is(port, ranks)) {
        Some(port) => format!("in its .toml: outputs.{role} = {:?}", port.name),
        None => format!(
            "end the model with Flatten, or name another output in its .toml: outputs.{role} = \"NAME\""
        ),
    }
}

/// Returns the input that the contract states: `f32 [N, 1, 50, 30]`.
fn expected_input(element: Option<Element>, contract: &Contract) -> String {
    let size = |axis: &InputAxis| match axis {
        InputAxis::Batch => "N".to_owned(),
        InputAxis::Frame => contract
            .frames
            .map_or("T".to_owned(), |frames| frames.to_string()),
        InputAxis::Channel => contract.input_channels().to_string(),
        InputAxis::Row => contract.rows.to_string(),
        InputAxis::Column => contract.columns.to_string(),
        InputAxis::Number => contract.numbers().to_string(),
    };
    let sizes: Vec<String> = contract.layout.axes().iter().map(size).collect();
    let element = element.unwrap_or(Element::F32).name();
    format!("{element} [{}]", sizes.join(", "))
}

/// Returns whether a shape can be the contract's, whatever the batch.
fn fits(shape: &[Dimension], contract: &Contract) -> bool {
    let axes = contract.layout.axes();
    shape.len() == axes.len()
        && shape.iter().zip(axes).all(|(dimension, axis)| match axis {
            InputAxis::Batch => true,
            InputAxis::Frame => contract
                .frames
                .is_none_or(|frames| may_be(dimension, frames)),
            InputAxis::Channel => may_be(dimension, contract.input_channels()),
            InputAxis::Row => may_be(dimension, contract.rows),
            InputAxis::Column => may_be(dimension, contract.columns),
            InputAxis::Number => may_be(dimension, contract.numbers()),
        })
}

/// Returns the advice for an input that does not fit.
fn remedy(input: &Port, contract: &Contract) -> String {
    if Element::from_data_type(input.element).is_none() {
        return "export it with an input of f32; f64 and u8 work too".into();
    }
    let shape = input.shape.as_deref().unwrap_or_default();
    // A free number of frames can also be one channel: the contract's template comes first, then
    // one template of each shape.
    let templates = [
        contract.template,
        Template::Gei,
        Template::Silhouettes,
        Template::Frequency,
        Template::Kfd,
        Template::RowWidth,
    ];
    let sizes = [(contract.rows, contract.columns)].into_iter();
    let sizes = sizes.chain(Size::ALL.map(|size| (size.rows(), size.columns())));
    let all = sizes.flat_map(|size| templates.map(|template| (size, template)));
    let all = all.flat_map(|(size, template)| {
        let layouts = InputLayout::ALL.into_iter();
        let held = layouts.filter(move |layout| layout.holds(template));
        held.flat_map(move |layout| {
            [contract.channels, 1, 3].map(|channels| (size, template, layout, channels))
        })
    });
    let mut all = all.map(|((rows, columns), template, layout, channels)| Contract {
        template,
        layout,
        rows,
        columns,
        channels,
        frames: None,
        ..contract.clone()
    });
    let is_but_frames = |other: &Contract| {
        let without = Contract {
            frames: None,
            ..contract.clone()
        };
        *other == without
    };
    let is_usable = |other: &Contract| other.channels == 1 || other.check_channels().is_ok();
    match all.find(|other| is_usable(other) && fits(shape, other)) {
        Some(other) if is_but_frames(&other) => match frames_of(shape, contract) {
            Some(frames) => format!("in its .toml: frames = {frames}, or no such key"),
            None => "in its .toml: another number of frames".into(),
        },
        Some(other) => {
            let mut keys = vec![
                format!("template = {:?}", other.template.name()),
                format!("layout = {:?}", other.layout.name()),
            ];
            if (other.rows, other.columns) != (contract.rows, contract.columns) {
                keys.push(format!(
                    "rows = {}, columns = {}",
                    other.rows, other.columns
                ));
            }
            if other.channels != contract.channels {
                keys.push(format!("channels = {}", other.channels));
            }
            format!("in its .toml: {}", keys.join(", "))
        }
        None => {
            let sizes = Size::ALL.map(Size::name).join(", ");
            format!("silhouettes are drawn as {sizes}: export the model for one of these")
        }
    }
}

/// Returns the number of frames, if the shape fixes it.
fn frames_of(shape: &[Dimension], contract: &Contract) -> Option<u64> {
    let axes = contract.layout.axes().iter();
    let at = { axes }.position(|axis| *axis == InputAxis::Frame)?;
    match shape.get(at)? {
        Dimension::Fixed(frames) => Some(*frames),
        _ => None,
    }
}

/// Returns whether an operator derives its quantisation from its input: the names of all such
/// operators in ONNX and ONNX Runtime begin like this.
fn quantizes(operator: &str) -> bool {
    let name = operator.rsplit('.').next().unwrap_or(operator);
    name.starts_with("DynamicQuantize")
}

/// `TensorProto.DataType`: `FLOAT`, `UINT8` and `DOUBLE`.
const FLOAT: u64 = 1;
const UINT8: u64 = 2;
const DOUBLE: u64 = 11;

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
                list_of(&graph.outputs)
            )
        })
}

pub(crate) fn list_of(ports: &[Port]) -> String {
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
mod tests;

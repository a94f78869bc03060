//! Which inputs and outputs of a graph are used, and whether they fit a contract.

use super::contract::Contract;
use super::graph::{Dimension, Graph, Port};
use super::input::{Axis, Layout};
use crate::template::Template;

/// How our own models call the output that is compared by distance, f32 `[N, dims]`.
pub const EMBEDDING: &str = "embedding";
/// How they call the output whose highest column is the answer, f32 `[N, classes]`.
pub const SCORES: &str = "scores";

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
    pub(super) fn find(
        graph: &Graph,
        contract: &Contract,
    ) -> Result<(Self, Option<usize>), String> {
        let expected = expected_input(contract);
        let [input] = graph.inputs.as_slice() else {
            return Err(format!(
                "expected one input of {expected}, found {}",
                list_of(&graph.inputs)
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
                list_of(&graph.outputs)
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
        Axis::Channel => contract.channels().to_string(),
        Axis::Row => contract.rows.to_string(),
        Axis::Column => contract.columns.to_string(),
        Axis::Number => contract.numbers().to_string(),
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
            Axis::Channel => may_be(dimension, contract.channels()),
            Axis::Row => may_be(dimension, contract.rows),
            Axis::Column => may_be(dimension, contract.columns),
            Axis::Number => may_be(dimension, contract.numbers()),
        })
}

/// What to do about an input that does not fit.
fn remedy(input: &Port, contract: &Contract) -> String {
    let shape = input.shape.as_deref().unwrap_or_default();
    // A free number of frames may be one channel: what the contract has in mind comes first, then
    // one template of each shape.
    let templates = [
        contract.template,
        Template::Gei,
        Template::Silhouettes,
        Template::Frequency,
        Template::Kfd,
        Template::RowWidth,
    ];
    let all = templates.into_iter().flat_map(|template| {
        let layouts = Layout::ALL.into_iter();
        let held = layouts.filter(move |layout| layout.holds(template));
        held.map(move |layout| (template, layout))
    });
    let mut all = all.map(|(template, layout)| Contract {
        template,
        layout,
        frames: None,
        ..contract.clone()
    });
    match all.find(|other| input.element == FLOAT && fits(shape, other)) {
        Some(other) if (other.template, other.layout) == (contract.template, contract.layout) => {
            "frames can be given in the .toml beside the model".into()
        }
        Some(other) => format!(
            "template = {:?} with layout = {:?} in the .toml beside the model would fit",
            other.template.name(),
            other.layout.name()
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
pub(super) const FLOAT: u64 = 1;

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

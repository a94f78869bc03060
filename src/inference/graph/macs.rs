//! Counts the multiply-accumulates of an inference, from the shapes in the graph.

use super::operands::Operands;
use super::rules;
use super::walk::elements;
use super::{Dimension, Graph, Node, StoredTensor, kernels};
use std::collections::HashMap;

/// The tensors that are known so far.
#[derive(Default)]
pub(super) struct KnownTensors<'a> {
    tensors: HashMap<&'a str, StoredTensor>,
    /// Sizes of named dimensions.
    named: HashMap<&'a str, u64>,
}

impl Graph {
    /// Counts the multiply-accumulates of one inference on an input of this shape, the batch's axis
    /// included. Conv has (numbers in the output x channels of a group x taps, including taps on
    /// padding), Gemm and MatMul have (numbers in the output x length of the summed axis). Biases,
    /// normalisation, pooling and activations count as none, as is usual.
    ///
    /// # Errors
    /// If an operation is of an unknown kind or shape; the error names the first one.
    pub fn macs(&self, input: &[u64]) -> Result<u64, String> {
        let mut known = KnownTensors::from_input(self, input)?;
        let mut macs = 0_u64;
        for node in &self.nodes {
            macs = macs.saturating_add(known.step(self, node)?);
        }
        Ok(macs)
    }
}

impl<'a> KnownTensors<'a> {
    /// Returns the initialisers, and the inputs if the first has this shape.
    ///
    /// # Errors
    /// If the graph has other inputs, or states another shape.
    pub(super) fn from_input(graph: &'a Graph, input: &[u64]) -> Result<Self, String> {
        let mut known = Self::of_initializers(graph);
        let (port, view) = match graph.inputs.as_slice() {
            [port] => (port, None),
            [port, view] | [view, port] if view.is_pair() => (port, Some(view)),
            _ => {
                return Err(format!(
                    "expected one input, or one and an input of viewpoints, found {}",
                    graph.inputs.len()
                ));
            }
        };
        known.bind(port.shape.as_deref(), input, &port.name)?;
        known.learn(&port.name, input.to_vec());
        if let Some(view) = view {
            known.learn(&view.name, vec![input.first().copied().unwrap_or(1), 2]);
        }
        Ok(known)
    }

    pub(super) fn of_initializers(graph: &'a Graph) -> Self {
        let tensors = graph.initializers.iter();
        Self {
            tensors: tensors
                .map(|(name, tensor)| (name.as_str(), tensor.clone()))
                .collect(),
            named: HashMap::new(),
        }
    }

    pub(super) fn learn(&mut self, name: &'a str, shape: Vec<u64>) {
        let integers = None;
        self.tensors.insert(name, StoredTensor { shape, integers });
    }

    pub(super) fn shape(&self, name: &str) -> Option<&[u64]> {
        Some(&self.tensors.get(name)?.shape)
    }

    /// Learns the shapes of a node's outputs, and returns its multiply-accumulates.
    ///
    /// # Errors
    /// If the operator or the shape of its output is unknown.
    pub(super) fn step(&mut self, graph: &'a Graph, node: &'a Node) -> Result<u64, String> {
        let (operator, first) = (&node.operator, node.outputs.first());
        let name = first.map_or("", String::as_str);
        let tensors = &self.tensors;
        let operands = Operands { node, tensors };
        let summed = kernels::summed(&operands);
        let inferred = rules::outputs(&operands)
            .ok_or_else(|| format!("{operator} ({name:?}) is an unknown operator"))?;
        let mut inferred = inferred.into_iter();
        for output in &node.outputs {
            let stated = graph.stated.get(output).map(Vec::as_slice);
            if let Some(tensor) = inferred.next() {
                let bound = self.bind(stated, &tensor.shape, output);
                self.tensors.insert(output, tensor);
                bound?;
            } else if let Some(shape) = stated.and_then(|stated| self.sizes(stated)) {
                self.learn(output, shape);
            } else if Some(output) == first {
                return Err(format!(
                    "the output shape of {operator} ({name:?}) is not known"
                ));
            }
        }
        let summed = summed
            .ok_or_else(|| format!("the sums in {operator} ({name:?}) are of unknown length"))?;
        Ok(self.shape(name).map_or(0, elements).saturating_mul(summed))
    }

    /// Learns the sizes of a stated shape's named dimensions.
    ///
    /// # Errors
    /// If a shape contradicts what the file states.
    fn bind(
        &mut self,
        stated: Option<&'a [Dimension]>,
        shape: &[u64],
        name: &str,
    ) -> Result<(), String> {
        let Some(stated) = stated else {
            return Ok(());
        };
        let agrees = |(dimension, &size): (&Dimension, &u64)| match dimension {
            Dimension::Fixed(fixed) => *fixed == size,
            _ => true,
        };
        if stated.len() != shape.len() || !stated.iter().zip(shape).all(agrees) {
            let stated: Vec<String> = stated.iter().map(ToString::to_string).collect();
            return Err(format!(
                "{name:?} is stated as [{}], but would be {shape:?}",
                stated.join(", ")
            ));
        }
        for (dimension, &size) in stated.iter().zip(shape) {
            if let Dimension::Named(named) = dimension {
                self.named.entry(named).or_insert(size);
            }
        }
        Ok(())
    }

    /// Returns a stated shape's sizes, if all of them are known.
    fn sizes(&self, stated: &[Dimension]) -> Option<Vec<u64>> {
        let sizes = stated.iter().map(|dimension| match dimension {
            Dimension::Fixed(size) => Some(*size),
            Dimension::Named(name) => self.named.get(name.as_str()).copied(),
            Dimension::Unknown => None,
        });
        sizes.collect()
    }
}

#[cfg(test)]
mod tests;

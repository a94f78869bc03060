//! How many multiply-accumulates an inference takes, from the shapes in the graph.

use std::collections::HashMap;

use super::kernels;
use super::rules::{self, Operands};
use super::walk::elements;
use super::{Dimension, Graph, Node};

/// What is known of the tensors so far.
#[derive(Default)]
pub(super) struct Known<'a> {
    pub shapes: HashMap<&'a str, Vec<u64>>,
    /// The numbers of tensors that hold shapes, axes or indices.
    integers: HashMap<&'a str, Vec<i64>>,
    /// Sizes of named dimensions.
    named: HashMap<&'a str, u64>,
}

impl Graph {
    /// Multiply-accumulates of one inference on an input of this shape, the batch's axis
    /// included: those of Conv (numbers in the output x channels of a group x taps, taps on
    /// padding too), and of Gemm and MatMul (numbers in the output x length of the axis that is
    /// summed). Biases, normalisation, pooling and activations count as none, as is usual.
    ///
    /// # Errors
    /// Naming the first operation of an unknown kind or shape: nothing is guessed.
    pub fn macs(&self, input: &[u64]) -> Result<u64, String> {
        let mut known = Known::of_initializers(self);
        let [port] = self.inputs.as_slice() else {
            return Err(format!("expected one input, found {}", self.inputs.len()));
        };
        known.bind(port.shape.as_deref(), input, &port.name)?;
        known.shapes.insert(&port.name, input.to_vec());
        let mut macs = 0_u64;
        for node in &self.nodes {
            macs = macs.saturating_add(known.step(self, node)?);
        }
        Ok(macs)
    }
}

impl<'a> Known<'a> {
    pub fn of_initializers(graph: &'a Graph) -> Self {
        let mut known = Self::default();
        for (name, tensor) in &graph.initializers {
            known.shapes.insert(name, tensor.shape.clone());
            if let Some(integers) = &tensor.integers {
                known.integers.insert(name, integers.clone());
            }
        }
        known
    }

    /// Learns the shapes of a node's outputs; its multiply-accumulates.
    ///
    /// # Errors
    /// If the operator is unknown, or what it gives.
    pub fn step(&mut self, graph: &'a Graph, node: &'a Node) -> Result<u64, String> {
        let name = node.outputs.first().map_or("", String::as_str);
        let (depth, integers, inferred) = {
            let operands = Operands {
                node,
                shapes: &self.shapes,
                integers: &self.integers,
            };
            let inferred = rules::shapes(&operands)
                .ok_or_else(|| format!("{} ({name:?}) is an unknown operator", node.operator))?;
            (
                kernels::summed(&operands),
                rules::integers(&operands),
                inferred,
            )
        };
        for (at, output) in node.outputs.iter().enumerate() {
            let stated = graph.stated.get(output).map(Vec::as_slice).or_else(|| {
                let port = graph.outputs.iter().find(|port| port.name == *output);
                port.and_then(|port| port.shape.as_deref())
            });
            let shape = match inferred.get(at) {
                Some(shape) => {
                    self.bind(stated, shape, output)?;
                    Some(shape.clone())
                }
                None => stated.and_then(|stated| self.sizes(stated)),
            };
            if let Some(shape) = shape {
                self.shapes.insert(output, shape);
            } else if at == 0 {
                return Err(format!(
                    "the shape that {} ({name:?}) gives is not known",
                    node.operator
                ));
            }
        }
        if let Some(integers) = integers {
            self.integers.insert(name, integers);
        }
        if !kernels::is_counted(&node.operator) {
            return Ok(0);
        }
        let depth = depth
            .ok_or_else(|| format!("what {} ({name:?}) sums over is not known", node.operator))?;
        let output = self
            .shapes
            .get(name)
            .ok_or_else(|| format!("{} has no output", node.operator))?;
        Ok(elements(output).saturating_mul(depth))
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

    /// A stated shape's sizes, if all of them are known.
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
#[path = "macs_tests.rs"]
mod tests;

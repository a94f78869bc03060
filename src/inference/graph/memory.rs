//! Bounds each tensor of an inference, from the shapes in the graph.

use super::Graph;
use super::macs::KnownTensors;
use super::walk::elements;

/// The largest elements of a tensor that an operation makes, bytes.
const ELEMENT: u64 = 8;

impl Graph {
    /// Checks that no operation makes a tensor of more than `most` bytes from an input of this
    /// shape, the batch's axis included, as far as the shapes are known beforehand.
    ///
    /// # Errors
    /// The first operation that does.
    pub(in crate::inference) fn check_memory(
        &self,
        input: &[u64],
        most: u64,
    ) -> Result<(), String> {
        let mut known = KnownTensors::from_input(self, input)
            .unwrap_or_else(|_| KnownTensors::of_initializers(self));
        for node in &self.nodes {
            // Unknown operations and shapes: the runtime refuses them, or makes what it makes.
            let _ = known.step(self, node);
            for output in &node.outputs {
                let Some(shape) = known.shape(output) else {
                    continue;
                };
                let bytes = elements(shape).saturating_mul(ELEMENT);
                if bytes > most {
                    return Err(format!(
                        "{} makes a tensor {output:?} of shape {shape:?}: expected at most {most} bytes",
                        node.operator
                    ));
                }
            }
        }
        Ok(())
    }
}

//! The windows that a model slides (convolutions and pooling), and over how many axes.

use super::macs::KnownTensors;
use super::{AttributeValue, Dimension, Graph, Node};

/// An operation that slides a window over an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlidingWindow<'a> {
    /// `Conv`, `ConvTranspose`, `MaxPool` or `AveragePool`.
    pub operator: &'a str,
    /// The name of its output.
    pub output: &'a str,
    /// The number of axes of its input that it slides over, if known: 2 for an image.
    pub axes: Option<usize>,
    /// Whether the file states what the embedded runtime needs: the strides of pooling; the shape
    /// of a convolution's kernel, or else its strides, dilations and padding.
    pub has_strides: bool,
}

impl Graph {
    /// Returns all windows; those of inner graphs and of functions come last.
    pub fn windows(&self) -> Vec<SlidingWindow<'_>> {
        let mut windows = Vec::new();
        let mut known = KnownTensors::of_initializers(self);
        for port in &self.inputs {
            if let Some(shape) = &port.shape {
                known.learn(&port.name, likely(shape));
            }
        }
        for node in &self.nodes {
            windows.extend(SlidingWindow::from_node(node, &known));
            // A shape that cannot be inferred may be stated: only its rank matters.
            if known.step(self, node).is_err() {
                for output in &node.outputs {
                    if let Some(shape) = self.stated.get(output) {
                        known.learn(output, likely(shape));
                    }
                }
            }
        }
        // Names in inner graphs are separate from names in the outermost graph.
        let nothing = KnownTensors::default();
        windows.extend(
            self.inner
                .iter()
                .filter_map(|node| SlidingWindow::from_node(node, &nothing)),
        );
        windows
    }
}

impl<'a> SlidingWindow<'a> {
    fn from_node(node: &'a Node, known: &KnownTensors<'_>) -> Option<Self> {
        let is_pool = match node.operator.as_str() {
            "Conv" | "ConvTranspose" => false,
            "MaxPool" | "AveragePool" => true,
            _ => return None,
        };
        let list = |name: &str| match node.attributes.get(name) {
            Some(AttributeValue::Integers(values)) => Some(values.len()),
            _ => None,
        };
        let axes_of = |input: usize| {
            let shape = known.shape(node.inputs.get(input)?)?;
            // The first two axes are batch and channels; of weights, channels twice.
            shape.len().checked_sub(2)
        };
        let axes = ["kernel_shape", "strides", "dilations"]
            .into_iter()
            .find_map(list)
            .or_else(|| Some(list("pads")? / 2))
            .or_else(|| if is_pool { None } else { axes_of(1) })
            .or_else(|| axes_of(0));
        let is_padded = list("pads").is_some() || node.attributes.contains_key("auto_pad");
        let measures = [
            list("strides").is_some(),
            list("dilations").is_some(),
            is_padded,
        ];
        Some(Self {
            operator: &node.operator,
            output: node.outputs.first().map_or("", String::as_str),
            axes,
            has_strides: if is_pool {
                measures[0]
            } else {
                list("kernel_shape").is_some() || measures == [true; 3]
            },
        })
    }
}

/// Replaces sizes that are not stated by likely ones.
fn likely(shape: &[Dimension]) -> Vec<u64> {
    let sizes = shape.iter().enumerate().map(|(axis, size)| match size {
        Dimension::Fixed(size) => *size,
        _ if axis == 0 => 1,
        _ => 64,
    });
    sizes.collect()
}

#[cfg(test)]
mod tests {
    use super::super::written::{graph, inner, integers, node, stated, weights};

    fn axes(input: &[i64], parts: &[Vec<u8>]) -> Vec<Option<usize>> {
        let graph = graph(input, parts);
        graph.windows().iter().map(|window| window.axes).collect()
    }

    #[test]
    fn attributes_tell_over_how_many_axes_a_window_slides() {
        for (attribute, expected) in [
            ("kernel_shape=[3]", 1),
            ("kernel_shape=[3,3]", 2),
            ("kernel_shape=[3,3,3]", 3),
            ("strides=[1,2,2]", 3),
            ("dilations=[1,1,1]", 3),
            ("pads=[0,1,1,0,1,1]", 3),
        ] {
            for operator in ["Conv", "ConvTranspose", "MaxPool", "AveragePool"] {
                let found = axes(&[], &[node(operator, "unknown w", "y", &[attribute])]);
                assert_eq!(found, [Some(expected)], "{operator} {attribute}");
            }
        }
    }

    #[test]
    fn a_weight_tells_it_wherever_it_comes_from() {
        let conv = node("Conv", "unknown w", "y", &[]);
        let five = [8, 1, 3, 3, 3];
        assert_eq!(
            axes(&[], &[weights("w", 1, &five), conv.clone()]),
            [Some(3)]
        );
        // Computed from an initialiser.
        let product = node("Mul", "v v", "w", &[]);
        let computed = [weights("v", 1, &five), product, conv.clone()];
        assert_eq!(axes(&[], &computed), [Some(3)]);
        // Given by an operator of another domain, and stated.
        let odd = node("Odd", "x", "w", &[]);
        assert_eq!(axes(&[], &[odd.clone(), conv.clone()]), [None]);
        assert_eq!(axes(&[], &[stated(13, "w", &five), odd, conv]), [Some(3)]);
    }

    #[test]
    fn an_input_tells_it_where_nothing_else_does() {
        let conv = node("Conv", "x unknown", "y", &[]);
        let image = [0, 1, 50, 30];
        assert_eq!(axes(&image, std::slice::from_ref(&conv)), [Some(2)]);
        assert_eq!(
            axes(&[0, 1, 0, 50, 30], std::slice::from_ref(&conv)),
            [Some(3)]
        );
        let reshaped = [
            integers("five", &[-1, 1, 1, 50, 30]),
            node("Reshape", "x five", "v", &[]),
            node("Conv", "v unknown", "y", &[]),
        ];
        assert_eq!(axes(&image, &reshaped), [Some(3)]);
    }

    #[test]
    fn windows_of_graphs_in_the_graph_are_found() {
        let conv = node("Conv", "a b", "y", &["kernel_shape=[1,3,3]"]);
        assert_eq!(axes(&[0, 1, 50, 30], &[inner(&[conv])]), [Some(3)]);
    }

    #[test]
    fn strides_may_be_left_out_only_where_the_kernel_has_a_shape() {
        let has_strides = |operator: &str, attributes: &[&str]| {
            let graph = graph(&[], &[node(operator, "x w", "y", attributes)]);
            graph.windows()[0].has_strides
        };
        assert!(!has_strides("Conv", &[]));
        assert!(!has_strides("Conv", &["strides=[1,1]"]));
        let all = ["strides=[1,1]", "dilations=[1,1]", "auto_pad=SAME_UPPER"];
        assert!(has_strides("Conv", &all));
        assert!(has_strides("Conv", &["kernel_shape=[3,3]"]));
        assert!(!has_strides("MaxPool", &["kernel_shape=[3,3]"]));
        assert!(has_strides(
            "MaxPool",
            &["kernel_shape=[3,3]", "strides=[1,1]"]
        ));
    }

    #[test]
    fn an_operation_without_an_output_is_no_reason_to_panic() {
        let mut parts = vec![weights("w", 1, &[8, 1, 3, 3])];
        parts.push(node("Conv", "x w", "", &[]));
        let graph = graph(&[0, 1, 50, 30], &parts);
        assert_eq!(graph.windows().len(), 1);
    }
}

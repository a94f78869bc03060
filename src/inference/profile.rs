//! Reads ONNX Runtime's profile: what ran each operation of a model.
//!
//! A provider silently leaves operations that it does not support to the processor, and ONNX
//! Runtime runs a quantised operation in float where it cannot fuse it with its conversions. The
//! profile that a session writes names the provider and the types of each operation.

use std::collections::{BTreeMap, HashSet};

use serde::{Deserialize, Serialize};

/// Operations of one kind that a session ran in the same way.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProfiledOperations {
    /// The operation, such as `Conv` or `QLinearConv`; a name of the provider's own if it fuses
    /// several.
    pub operator: String,
    /// ONNX Runtime's name for the provider that ran it, such as `CPUExecutionProvider`.
    pub provider: String,
    /// The arithmetic it computes in.
    pub arithmetic: Arithmetic,
    /// The number of these operations.
    pub count: usize,
}

/// The time that operations of one kind take in an inference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OperatorTime {
    /// The operations.
    #[serde(flatten)]
    pub ran: ProfiledOperations,
    /// The time of all of them in one inference, microseconds; the mean over several.
    pub mean_us: f64,
}

/// The arithmetic an operation computes in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Arithmetic {
    /// Floating-point numbers.
    Float,
    /// 8-bit integers.
    Int8,
    /// Conversion from one to the other.
    Conversion,
    /// Shapes and indices, or unknown.
    Other,
}

impl Arithmetic {
    /// Returns the name used in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Float => "float",
            Self::Int8 => "int8",
            Self::Conversion => "conversion",
            Self::Other => "other",
        }
    }
}

impl ProfiledOperations {
    /// Returns whether ONNX Runtime's own kernels ran it, on the processor.
    #[must_use]
    pub fn is_on_cpu(&self) -> bool {
        self.provider == "CPUExecutionProvider"
    }
}

/// Returns whether an operator belongs to a quantised model: it computes in 8-bit integers or
/// converts numbers to or from them. ONNX and ONNX Runtime have `QuantizeLinear`,
/// `DynamicQuantizeMatMul`, `QLinearConv`, `QGemm`, `ConvInteger`.
pub(super) fn is_of_8_bits(operator: &str) -> bool {
    let name = operator.rsplit('.').next().unwrap_or(operator);
    let mut letters = name.chars();
    let is_q = letters.next() == Some('Q') && letters.next().is_some_and(char::is_uppercase);
    is_q || name.contains("Integer") || name.to_lowercase().contains("quantize")
}

/// An event of a profile.
#[derive(Deserialize)]
struct ProfileEvent {
    #[serde(default)]
    cat: String,
    #[serde(default)]
    name: String,
    /// Microseconds.
    #[serde(default)]
    dur: f64,
    #[serde(default)]
    args: Arguments,
}

#[derive(Default, Deserialize)]
struct Arguments {
    #[serde(default)]
    op_name: String,
    #[serde(default)]
    provider: String,
    #[serde(default)]
    input_type_shape: Vec<BTreeMap<String, serde_json::Value>>,
    #[serde(default)]
    output_type_shape: Vec<BTreeMap<String, serde_json::Value>>,
}

/// Reads a profile of `runs` inferences, in the order of operators' names. Each operation counts
/// once, however often it ran. The time of the first inference is left out if there are more.
///
/// # Errors
/// If the text is not a profile.
pub(super) fn read_times(text: &str, runs: usize) -> serde_json::Result<Vec<OperatorTime>> {
    let events: Vec<ProfileEvent> = serde_json::from_str(text)?;
    let events = events.into_iter();
    // Older versions also list the fences around an operation, without a provider.
    let events = events.filter(|event| event.cat == "Node" && !event.args.provider.is_empty());
    let events: Vec<ProfileEvent> = events.collect();
    // Each inference runs the same operations, except inside loops.
    let first = if runs > 1 { events.len() / runs } else { 0 };
    let mut seen = HashSet::new();
    let mut all: BTreeMap<(String, String, Arithmetic), (usize, f64)> = BTreeMap::new();
    for (
        at,
        ProfileEvent {
            name, dur, args, ..
        },
    ) in events.into_iter().enumerate()
    {
        let arithmetic = arithmetic(&args);
        let (count, us) = all
            .entry((args.op_name, args.provider, arithmetic))
            .or_default();
        *count += usize::from(seen.insert(name));
        if at >= first {
            *us += dur;
        }
    }
    let counted = if runs > 1 { runs - 1 } else { 1 };
    let time = |((operator, provider, arithmetic), (count, us))| OperatorTime {
        ran: ProfiledOperations {
            operator,
            provider,
            arithmetic,
            count,
        },
        mean_us: us / counted as f64,
    };
    Ok(all.into_iter().map(time).collect())
}

fn arithmetic(args: &Arguments) -> Arithmetic {
    let first = |types: &[BTreeMap<String, serde_json::Value>]| {
        let first = types.first().and_then(|profiled| profiled.keys().next());
        first.cloned().unwrap_or_default()
    };
    let (input, output) = (
        first(&args.input_type_shape),
        first(&args.output_type_shape),
    );
    let is_int8 = |kind: &str| kind == "uint8" || kind == "int8";
    let is_float = |kind: &str| kind.contains("float") || kind == "double";
    match (is_int8(&input), is_int8(&output)) {
        (true, false) if args.op_name == "DequantizeLinear" => Arithmetic::Conversion,
        (false, true) if args.op_name.ends_with("QuantizeLinear") => Arithmetic::Conversion,
        // The first input of QLinearConcat is a scale, and QGemm may return float.
        (true, _) | (_, true) => Arithmetic::Int8,
        _ if is_float(&input) || is_float(&output) => Arithmetic::Float,
        _ => Arithmetic::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(name: &str, operator: &str, provider: &str, types: [&str; 2]) -> String {
        let [input, output] = types;
        format!(
            r#"{{"cat":"Node","pid":7,"tid":7,"dur":5,"ts":9,"ph":"X","name":"{name}_kernel_time",
            "args":{{"op_name":"{operator}","provider":"{provider}","node_index":"1",
            "input_type_shape":[{{"{input}":[1,8]}},{{"float":[8]}}],
            "output_type_shape":[{{"{output}":[1,8]}}]}}}}"#
        )
    }

    fn read_all(events: &[String]) -> Vec<(String, String, Arithmetic, usize)> {
        let ran = read_times(&format!("[{}]", events.join(",")), 1).expect("a profile");
        ran.into_iter()
            .map(|OperatorTime { ran, .. }| (ran.operator, ran.provider, ran.arithmetic, ran.count))
            .collect()
    }

    #[test]
    fn operations_are_counted_once_by_what_ran_them() {
        let (xnnpack, cpu) = ("XnnpackExecutionProvider", "CPUExecutionProvider");
        let float = ["float", "float"];
        let session = r#"{"cat":"Session","name":"model_run","ts":1,"dur":2,"args":{}}"#;
        let fence = r#"{"cat":"Node","name":"a_fence_before","args":{"op_name":"Conv"}}"#;
        let found = read_all(&[
            session.into(),
            fence.into(),
            event("a", "Conv", xnnpack, float),
            event("b", "Conv", xnnpack, float),
            event("c", "Conv", cpu, float),
            // In a loop.
            event("c", "Conv", cpu, float),
            event("d", "Shape", cpu, ["int64", "int64"]),
        ]);
        let expected = [
            ("Conv", cpu, Arithmetic::Float, 1),
            ("Conv", xnnpack, Arithmetic::Float, 2),
            ("Shape", cpu, Arithmetic::Other, 1),
        ];
        let expected = expected.map(|(a, b, c, d)| (a.to_owned(), b.to_owned(), c, d));
        assert_eq!(found, expected);
    }

    #[test]
    fn times_are_means_over_all_inferences_but_the_first() {
        let event = |name: &str, dur: u64| {
            let event = event(name, "Conv", "P", ["float", "float"]);
            event.replace("\"dur\":5", &format!("\"dur\":{dur}"))
        };
        let all = [
            ("a", 900),
            ("b", 800),
            ("a", 10),
            ("b", 4),
            ("a", 20),
            ("b", 6),
        ];
        let all = all.map(|(name, dur)| event(name, dur)).join(",");
        let found = read_times(&format!("[{all}]"), 3).expect("a profile");
        let said: Vec<_> = found
            .iter()
            .map(|profiled| (profiled.ran.count, profiled.mean_us))
            .collect();
        assert_eq!(said, [(2, 20.0)]);
    }

    #[test]
    fn what_an_operation_computes_in_follows_from_its_types() {
        for (operator, types, expected) in [
            ("Conv", ["float", "float"], Arithmetic::Float),
            ("Conv", ["float16", "float16"], Arithmetic::Float),
            ("QLinearConv", ["uint8", "uint8"], Arithmetic::Int8),
            ("QGemm", ["int8", "float"], Arithmetic::Int8),
            ("QLinearConcat", ["float", "uint8"], Arithmetic::Int8),
            ("MaxPool", ["uint8", "uint8"], Arithmetic::Int8),
            ("QuantizeLinear", ["float", "uint8"], Arithmetic::Conversion),
            (
                "DequantizeLinear",
                ["int8", "float"],
                Arithmetic::Conversion,
            ),
            (
                "DynamicQuantizeLinear",
                ["float", "uint8"],
                Arithmetic::Conversion,
            ),
            ("Gather", ["int64", "int64"], Arithmetic::Other),
        ] {
            let found = read_all(&[event("a", operator, "P", types)]);
            assert_eq!(found[0].2, expected, "{operator}");
        }
    }

    #[test]
    fn operators_of_quantised_models_are_known_by_their_names() {
        for name in [
            "QuantizeLinear",
            "DequantizeLinear",
            "QLinearConv",
            "com.microsoft.QGemm",
            "MatMulInteger",
            "com.microsoft.DynamicQuantizeMatMul",
        ] {
            assert!(is_of_8_bits(name), "{name}");
        }
        for name in ["Conv", "Gemm", "com.microsoft.QuickGelu", "Squeeze"] {
            assert!(!is_of_8_bits(name), "{name}");
        }
    }

    #[test]
    fn what_is_no_profile_is_refused() {
        assert!(read_times("{", 1).is_err());
        assert!(read_times(r#"{"cat":"Node"}"#, 1).is_err());
        assert_eq!(read_times("[]", 2).expect("an empty one"), []);
    }
}

//! A model on a runtime, and details of how it ran.

use crate::inference::{Arithmetic, Model, ProfiledOperations};
use crate::inference::{Provider, RuntimeName};
use serde::Serialize;

/// A model on a runtime, and details of how it ran.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ParitySide {
    /// The model's file.
    pub model: String,
    pub runtime: RuntimeName,
    /// Whether the model computes in 8-bit integers or rounds numbers to them.
    pub quantized: bool,
    /// Count of the numbers in all its answers.
    pub numbers: u64,
    /// Count of these numbers that are NaN or infinite.
    pub non_finite: u64,
    /// Rank-1, 0..1; none if no embedding is finite.
    pub rank1: Option<f64>,
    /// What ran each operation, where the runtime was profiled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operators: Option<Vec<ProfiledOperations>>,
    /// Operations that the processor ran instead of the provider.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fell_back: Vec<ProfiledOperations>,
    /// Operations of a quantised model that were run in float.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub in_float: Vec<ProfiledOperations>,
    /// Notes on how it ran.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

impl ParitySide {
    /// Creates a side without answers.
    pub(crate) fn new(model: &Model, runtime: RuntimeName) -> Self {
        Self {
            model: model.path().display().to_string(),
            quantized: model.graph().is_quantized(),
            runtime,
            numbers: 0,
            non_finite: 0,
            rank1: None,
            operators: None,
            fell_back: Vec::new(),
            in_float: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Returns a label such as `int8.onnx on onnxruntime 1.31.1 (xnnpack)`.
    pub(crate) fn label(&self) -> String {
        format!("{} on {}", self.model, self.runtime)
    }

    fn has_provider(&self) -> bool {
        ![Provider::Cpu.name(), ""].contains(&self.runtime.provider.as_str())
    }

    /// Returns whether a profile of the operations is informative.
    pub(crate) fn is_worth_profiling(&self) -> bool {
        self.quantized || self.has_provider()
    }

    /// Adds what ran each operation; `ran` is none if the runtime does not report it.
    pub(crate) fn with_operators(mut self, ran: Option<Vec<ProfiledOperations>>) -> Self {
        let Some(ran) = ran else {
            if self.quantized {
                self.notes.push(
                    "all is computed in float: QuantizeLinear and DequantizeLinear round, but the \
                     operations between them are not 8-bit arithmetic"
                        .into(),
                );
            }
            return self;
        };
        let chosen = |is_meant: fn(&ProfiledOperations) -> bool| -> Vec<ProfiledOperations> {
            ran.iter().filter(|run| is_meant(run)).cloned().collect()
        };
        if self.has_provider() {
            let provider = &self.runtime.provider;
            self.fell_back = chosen(ProfiledOperations::is_on_cpu);
            self.notes.push(if self.fell_back.len() == ran.len() {
                format!("nothing ran on {provider}: all was left to the processor")
            } else if self.fell_back.is_empty() {
                format!("all ran on {provider}")
            } else {
                format!(
                    "left to the processor by {provider}: {}",
                    listed(&self.fell_back)
                )
            });
        }
        if self.quantized {
            self.in_float = chosen(|operator| operator.arithmetic == Arithmetic::Float);
            let int8 = chosen(|operator| operator.arithmetic == Arithmetic::Int8);
            let all: usize = [&int8, &self.in_float]
                .iter()
                .map(|list| list.iter().map(|operator| operator.count).sum::<usize>())
                .sum();
            self.notes.push(if self.in_float.is_empty() {
                format!("ran in 8 bits: {}", listed(&int8))
            } else {
                let in_float = listed(&self.in_float);
                format!("of {all} operations between conversions, these ran in float: {in_float}")
            });
        }
        self.operators = Some(ran);
        self
    }
}

/// Returns a list such as `Conv 2, Gemm 1`.
fn listed(ran: &[ProfiledOperations]) -> String {
    let each: Vec<String> = ran
        .iter()
        .map(|run| format!("{} {}", run.operator, run.count))
        .collect();
    if each.is_empty() {
        "nothing".into()
    } else {
        each.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(provider: &str, quantized: bool) -> ParitySide {
        let model = crate::inference::testing::small_model();
        let runtime = RuntimeName {
            name: "onnxruntime".into(),
            version: "1.31.1".into(),
            provider: provider.into(),
        };
        ParitySide {
            quantized,
            ..ParitySide::new(&model, runtime)
        }
    }

    fn ran(
        operator: &str,
        provider: &str,
        arithmetic: Arithmetic,
        count: usize,
    ) -> ProfiledOperations {
        ProfiledOperations {
            operator: operator.into(),
            provider: provider.into(),
            arithmetic,
            count,
        }
    }

    const CPU: &str = "CPUExecutionProvider";
    const XNNPACK: &str = "XnnpackExecutionProvider";

    #[test]
    fn operations_that_a_provider_left_to_the_processor_are_named() {
        let note = |ran: &[ProfiledOperations]| {
            side("xnnpack", false)
                .with_operators(Some(ran.to_vec()))
                .notes
        };
        let conv = ran("Conv", XNNPACK, Arithmetic::Float, 2);
        let gemm = ran("Gemm", CPU, Arithmetic::Float, 1);
        assert_eq!(
            note(&[conv.clone(), gemm.clone()]),
            ["left to the processor by xnnpack: Gemm 1"]
        );
        assert_eq!(note(std::slice::from_ref(&conv)), ["all ran on xnnpack"]);
        assert_eq!(
            note(std::slice::from_ref(&gemm)),
            ["nothing ran on xnnpack: all was left to the processor"]
        );
        // The processor was the chosen provider.
        let on_cpu = side("cpu", false).with_operators(Some(vec![gemm]));
        assert_eq!((on_cpu.notes.len(), on_cpu.fell_back.len()), (0, 0));
    }

    #[test]
    fn operations_of_a_quantised_model_that_ran_in_float_are_named() {
        let conv = ran("QLinearConv", CPU, Arithmetic::Int8, 2);
        let quantize = ran("QuantizeLinear", CPU, Arithmetic::Conversion, 1);
        let gemm = ran("Gemm", CPU, Arithmetic::Float, 1);
        let partly = [conv.clone(), quantize.clone(), gemm];
        let partly = side("cpu", true).with_operators(Some(partly.to_vec()));
        assert_eq!(
            partly.notes,
            ["of 3 operations between conversions, these ran in float: Gemm 1"]
        );
        let wholly = side("cpu", true).with_operators(Some(vec![conv, quantize]));
        assert_eq!(wholly.notes, ["ran in 8 bits: QLinearConv 2"]);
        let embedded = side("cpu", true).with_operators(None);
        assert!(embedded.notes[0].starts_with("all is computed in float"));
        assert_eq!(side("cpu", false).with_operators(None).notes, [""; 0]);
    }
}

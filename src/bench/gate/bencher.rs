//! The values in Bencher's metric format, which bencher.dev tracks over commits.
//!
//! The format is "Bencher Metric Format" (BMF) JSON: `{benchmark: {measure: {value, lower_value,
//! upper_value}}}` (bencher.dev/docs/reference/bencher-metric-format). The benchmark is the path of
//! the object around a value, and the measure is the value's key.

use super::report::GateReport;
use serde_json::{Map, Value, json};

impl GateReport {
    /// Returns each value once, however many limits it has.
    pub(crate) fn bencher(&self) -> Value {
        let mut benchmarks = Map::new();
        for line in &self.limits {
            let (benchmark, measure) = match line.figure.rsplit_once('.') {
                Some((around, key)) if !key.contains(['[', ']', '"']) => (around, key),
                _ => ("results", line.figure.as_str()),
            };
            let measure = match &line.per {
                Some(per) => format!("{measure} per {per}"),
                None => measure.to_owned(),
            };
            let found = line.found;
            let mut metric = json!({ "value": found.value });
            for (key, end) in [("lower_value", found.low), ("upper_value", found.high)] {
                if end.is_finite() && end != found.value {
                    metric[key] = json!(end);
                }
            }
            let measures = benchmarks.entry(benchmark).or_insert_with(|| json!({}));
            measures[&measure] = metric;
        }
        Value::Object(benchmarks)
    }
}

//! Results of criterion, as values that limits can name.
//!
//! Criterion 0.8.2 writes `<benchmark>/new/estimates.json`, and `benchmark.json` beside it. Another
//! program may write these files for a size, with the statistic `bytes`.

use crate::error::{Error, Result};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::fs;
use std::path::Path;
use std::time::SystemTime;

/// The content of `estimates.json`.
#[derive(Deserialize)]
struct CriterionEstimates {
    median: Option<CriterionStatistic>,
    mean: Option<CriterionStatistic>,
    bytes: Option<CriterionStatistic>,
}

#[derive(Deserialize)]
struct CriterionStatistic {
    point_estimate: f64,
    confidence_interval: Option<CriterionInterval>,
}

#[derive(Deserialize)]
struct CriterionInterval {
    lower_bound: f64,
    upper_bound: f64,
}

/// The content of `benchmark.json`.
#[derive(Deserialize)]
struct CriterionBenchmark {
    full_id: String,
    throughput: Option<Value>,
}

/// Returns an object with the list `benchmarks`: the values of each benchmark in a folder, in the
/// order of their names.
///
/// # Errors
/// If the folder has no results, or one that is not criterion's JSON.
pub(super) fn benchmarks(folder: &Path) -> Result<Value> {
    let mut found = Vec::new();
    collect(folder, &mut found)?;
    if found.is_empty() {
        let problem = "expected criterion's results (NAME/new/estimates.json), found none";
        return Err(Error::input(folder, problem));
    }
    found.sort_unstable_by_key(|benchmark| benchmark["name"].to_string());
    Ok(json!({ "benchmarks": found }))
}

fn collect(folder: &Path, found: &mut Vec<Value>) -> Result<()> {
    let new = folder.join("new");
    if new.join("estimates.json").exists() {
        found.push(values(&new)?.into());
    }
    let io = |error| Error::io(folder, error);
    for entry in fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        if entry.file_type().map_err(io)?.is_dir() {
            collect(&entry.path(), found)?;
        }
    }
    Ok(())
}

/// Returns the values of one benchmark.
fn values(folder: &Path) -> Result<Map<String, Value>> {
    let path = folder.join("estimates.json");
    let estimates: CriterionEstimates = parsed(&path)?;
    let benchmark: CriterionBenchmark = parsed(&folder.join("benchmark.json"))?;
    let metadata = fs::metadata(&path).and_then(|metadata| metadata.modified());
    let measured = metadata.map_err(|error| Error::io(&path, error))?;
    let mut values = Map::new();
    values.insert("name".into(), benchmark.full_id.into());
    values.insert("measured_s".into(), unix_s(measured).into());
    let mut put = |key: &str, statistic: &CriterionStatistic, count: f64| {
        let mut number = |end: &str, number: f64| {
            values.insert(format!("{key}{end}"), (number / count).into());
        };
        number("", statistic.point_estimate);
        if let Some(interval) = &statistic.confidence_interval {
            number("_low", interval.lower_bound);
            number("_high", interval.upper_bound);
        }
    };
    for (name, time) in [("median", &estimates.median), ("mean", &estimates.mean)] {
        let Some(time) = time else { continue };
        if time.point_estimate <= 0.0 {
            let found = time.point_estimate;
            let problem = format!("expected a {name} above 0 ns, found {found}");
            return Err(Error::input(path, problem));
        }
        put(&format!("{name}_ns"), time, 1.0);
    }
    let elements = benchmark.throughput.as_ref().and_then(|throughput| {
        let both = throughput.pointer("/ElementsAndBytes/elements");
        throughput.get("Elements").or(both)?.as_f64()
    });
    if let (Some(median), Some(elements)) = (&estimates.median, elements.filter(|&n| n > 0.0)) {
        put("per_element_ns", median, elements);
        values.insert("elements".into(), elements.into());
    } else if let Some(bytes) = &estimates.bytes {
        put("bytes", bytes, 1.0);
    }
    Ok(values)
}

/// Returns the time since 1970 in seconds.
pub(super) fn unix_s(time: SystemTime) -> f64 {
    let since = time.duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0.0, |since| since.as_secs_f64())
}

fn parsed<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let bytes = crate::files::read(path)?;
    serde_json::from_slice(&bytes)
        .map_err(|error| Error::input(path, format!("expected criterion's JSON: {error}")))
}

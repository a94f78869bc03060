//! Results as CSV: a row for each model, number of threads and batch size.

use super::results::{BenchResults, ModelResult};
use super::timing::Timing;
use crate::error::Result;
use serde::Serialize;

/// A row of the file; what was not measured is empty.
#[derive(Serialize)]
struct CsvRow<'a> {
    model: &'a str,
    runtime: &'a str,
    runtime_version: &'a str,
    provider: &'a str,
    threads: usize,
    /// The number of inferences in a call.
    batch: usize,
    /// The number of frames in an input, where inputs of several lengths were measured.
    frames: Option<usize>,
    mean_us: f64,
    min_us: f64,
    p50_us: f64,
    p90_us: Option<f64>,
    p95_us: Option<f64>,
    p99_us: Option<f64>,
    max_us: f64,
    throughput: f64,
    spread: f64,
    peak_rss_bytes: Option<u64>,
    load_ms: f64,
    first_ms: f64,
    bytes: u64,
    params: u64,
    macs: Option<u64>,
    single_mj: Option<f64>,
    rank1: Option<f64>,
    rank1_low: Option<f64>,
    rank1_high: Option<f64>,
}

/// Returns the CSV file: a line of column names, then the rows of all models.
///
/// # Errors
/// If a row cannot be serialized.
pub(crate) fn csv(results: &BenchResults) -> Result<Vec<u8>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    for model in &results.models {
        rows.serialize(row(model, &model.single, 1, None, model.peak_rss_bytes))?;
        for batch in model.offline.iter().chain(&model.batches) {
            rows.serialize(row(
                model,
                &batch.timing,
                batch.batch,
                None,
                batch.peak_rss_bytes,
            ))?;
        }
        for length in &model.lengths {
            let frames = Some(length.frames);
            rows.serialize(row(model, &length.timing, 1, frames, length.peak_rss_bytes))?;
        }
    }
    let bytes = rows.into_inner();
    Ok(bytes.map_err(|error| csv::Error::from(error.into_error()))?)
}

fn row<'a>(
    model: &'a ModelResult,
    timing: &Timing,
    batch: usize,
    frames: Option<usize>,
    peak_rss_bytes: Option<u64>,
) -> CsvRow<'a> {
    let times = &timing.times;
    let accuracy = model.accuracy.as_ref();
    let ends = accuracy.map(|accuracy| accuracy.intervals.shown());
    CsvRow {
        model: &model.name,
        runtime: &model.runtime.name,
        runtime_version: &model.runtime.version,
        provider: &model.runtime.provider,
        threads: model.threads,
        batch,
        frames,
        mean_us: times.mean_us,
        min_us: times.min_us,
        p50_us: times.p50_us,
        p90_us: times.p90_us,
        p95_us: times.p95_us,
        p99_us: times.p99_us,
        max_us: times.max_us,
        throughput: timing.throughput,
        spread: timing.spread,
        peak_rss_bytes,
        load_ms: model.load_ms,
        first_ms: model.first_ms,
        bytes: model.bytes,
        params: model.params,
        macs: if frames.is_none() { model.macs } else { None },
        single_mj: model.energy.as_ref().map(|energy| energy.single_mj),
        rank1: accuracy.map(|accuracy| accuracy.rank1),
        rank1_low: ends.map(|ends| ends.0),
        rank1_high: ends.map(|ends| ends.1),
    }
}

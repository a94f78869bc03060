//! Measures what a recognizer costs on this machine (time, memory, energy), and its accuracy.
//!
//! The measurements follow MLPerf Tiny (rules 1.2) and `onnxruntime_perf_test`. The rules are
//! stated where they are applied: [`windows`] for the duration, [`statistics::Times`] for the
//! percentiles, [`mod@measure`] for the content of a timed call. Each model is measured in its own
//! process, which isolates its load time, first inference and peak memory. [`time_budget`] decides
//! what is cut if a measurement would take too long. [`video_pipeline`] measures everything from
//! the frames of a video to an answer.

mod accuracy;
mod affinity;
mod batch;
pub(crate) mod board;
mod cells;
mod compare;
mod conditions;
mod csv;
mod energy;
#[cfg(feature = "plots")]
pub(crate) mod frontier;
pub(crate) mod gate;
mod inputs;
mod measure;
mod memory;
mod process;
mod results;
mod sequence_lengths;
mod statistics;
mod table;
mod task;
mod time_budget;
mod timed_model;
mod timing;
mod video_pipeline;
pub(crate) mod windows;

pub(crate) use affinity::pin;
pub(crate) use compare::{Compared, chart};
pub(crate) use csv::csv;
pub(crate) use inputs::DrawnInputs;
pub(crate) use measure::measure;
pub(crate) use memory::peak_rss_bytes;
pub(crate) use process::{MeasuringProgress, ProcessOutcome, end_with_parent, measured_by};
pub(crate) use results::{BenchResults, ModelResult};
pub(crate) use sequence_lengths::{measure_lengths, require_any_length};
pub(crate) use table::{ResultColumn, TableFormat, render};
pub(crate) use task::Task;
pub(crate) use video_pipeline::{
    CheckedVideo, MADE_FPS, MADE_SIZE, PathResult, PathTask, check, check_model, measure_path,
    write_made,
};

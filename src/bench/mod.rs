//! What a recognizer costs on this machine: time, memory, energy, and what it is worth.
//!
//! The questions are those of MLPerf Tiny (rules 1.2) and of `onnxruntime_perf_test`; the rules
//! are stated where they are applied: [`windows`] for how long, [`Times`] for which percentiles,
//! [`measure`] for what is inside the timed call. Each model is measured in a process of its
//! own, so that its load time, first inference and peak memory are its own. [`cap`] says what is cut
//! where all of it would take too long. [`path`] measures what comes before an inference in the field as
//! well, from a video on.

mod accuracy;
mod affinity;
mod batch;
pub(crate) mod board;
mod cells;
mod compare;
mod conditions;
mod csv;
mod date;
mod energy;
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
pub(crate) use date::utc_now;
pub(crate) use inputs::DrawnInputs;
pub(crate) use measure::measure;
pub(crate) use memory::peak_rss_bytes;
pub(crate) use process::{MeasuringProgress, end_with_parent, measured_by};
pub(crate) use results::{BenchResults, ModelResult};
pub(crate) use sequence_lengths::{measure_lengths, require_any_length};
pub(crate) use table::{ResultColumn, TableFormat, render};
pub(crate) use task::Task;
pub(crate) use video_pipeline::{
    CheckedVideo, MADE_FPS, MADE_SIZE, PathResult, PathTask, check, check_model, measure_path,
    write_made,
};

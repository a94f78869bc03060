//! What a recognizer costs on this machine: time, memory, energy, and what it is worth.
//!
//! The questions are those of MLPerf Tiny (rules 1.2) and of `onnxruntime_perf_test`; the rules
//! are stated where they are applied: [`windows`] for how long, [`Times`] for which percentiles,
//! [`measure`] for what is inside the timed call. Each model is measured in a process of its
//! own, so that its load time, first inference and peak memory are its own.

mod accuracy;
mod affinity;
pub mod board;
mod energy;
mod inputs;
mod measure;
mod memory;
mod process;
mod results;
mod statistics;
mod table;
pub mod windows;

pub use accuracy::Accuracy;
pub use affinity::pin;
pub use energy::Meter;
pub use inputs::Scene;
pub use measure::{Task, measure};
pub use memory::peak_rss_bytes;
pub use process::{end_with_parent, measured_by};
pub use results::{
    Bare, BenchResults, Conditions, Energy, ModelResult, Offline, Parts, Timing, utc_now,
};
pub use statistics::Times;
pub use table::{Column, Format, render};

//! Gait cycles of silhouettes that others made.

#[path = "../helpers/data.rs"]
mod data;

mod errors;
mod truth;
mod walkers;

//! Gait cycles of silhouettes from other software.

#[path = "../helpers/data.rs"]
mod data;

mod errors;
mod truth;
mod walkers;

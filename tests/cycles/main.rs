//! Gait cycles of silhouettes from other software.

#[path = "../helpers/data.rs"]
mod data;

mod errors;
mod methods;
mod truth;
mod walkers;

//! Speed against error: the cost and the error of each choice of rasteriser, frames, hull points
//! and encoding.
//!
//! [`FrontierStudy`] measures a list of configurations and marks those that no other beats
//! ([`pareto`]). Only times differ between two runs.

mod measure;
pub(crate) mod pareto;
pub(crate) mod plot;
mod recognition;
mod timing;

pub(crate) use measure::{FrontierPeople, FrontierPoint, FrontierStudy};

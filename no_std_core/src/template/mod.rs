//! Templates: one image that stands for a gait cycle, built frame by frame.

mod gei;
mod sums;
mod tally;

pub use gei::{Gei, GeiBuilder};
pub use tally::GeiTally;

//! Templates: one image that stands for a gait cycle, built frame by frame.

mod gei;

pub use gei::{Gei, GeiBuilder};

//! EdgeGait host
pub mod error;
pub mod scene;

//! Silhouettes and templates: conditions, sweeps over viewpoints, and templates of gait cycles.

pub mod confounders;
pub(crate) mod grey_threshold;
pub(crate) mod registers;
pub mod sweep;
pub mod template;

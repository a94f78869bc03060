//! Recognizers of the literature beside each other: what each confounder leaves of them.
//!
//! All are trained with some people, and judged on others under each class of confounder.

mod contests;
mod recognizers;

pub(crate) use contests::{COLUMNS, Column, Plan, run};
pub(crate) use recognizers::{Known, Row, steps};

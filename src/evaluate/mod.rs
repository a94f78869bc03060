//! Evaluation of recognizers: hits, ranks and rates, and their intervals.
//!
//! - [`contest`] shows a source's sequences to recognizers as a [`protocol`] specifies. `trial`
//!   compares the probes with the gallery, and `totals` sums the outcomes.
//! - `distance` compares embeddings. `rank1` decides hits and misses by class score,
//!   `identification` computes Rank-k, mAP and mINP from distances, `verification` EER, ROC and
//!   AUC, and `cross_view` the means over pairs of views.
//! - `intervals`, `wilson` and `bootstrap` compute intervals of rates, `median` those of medians.
//!   `paired` tests whether two recognizers differ.
//! - `bands` and `view_angle` sum results over viewpoints.
//! - [`results`] is the JSON that `edgegait score` writes.
//! - `strengths` measures the effect of each confounder, `eight_bit` that of 8-bit weights.
//!   `checkup` checks that a model works, and `parity` whether runtimes and variants of a model
//!   give the same answers.

pub(crate) mod bands;
pub(crate) mod bootstrap;
pub(crate) mod checkup;
pub mod contest;
pub(crate) mod cross_view;
pub(crate) mod distance;
pub(crate) mod eight_bit;
pub(crate) mod identification;
pub(crate) mod intervals;
#[cfg(feature = "train")]
pub(crate) mod literature;
pub(crate) mod median;
pub(crate) mod paired;
pub(crate) mod paired_results;
pub(crate) mod parity;
pub mod protocol;
pub(crate) mod rank1;
pub mod results;
#[cfg(feature = "plots")]
pub(crate) mod strengths;
#[cfg(all(feature = "import", feature = "train", feature = "plots"))]
pub(crate) mod study;
#[cfg(test)]
pub(crate) mod testing;
mod totals;
pub(crate) mod trial;
pub(crate) mod verification;
pub(crate) mod view_angle;
pub(crate) mod wilson;

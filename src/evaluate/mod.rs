//! How good a recognizer is: hits, ranks and rates, their intervals, and where it fails.
//!
//! A [`contest`] shows a source's sequences to recognizers as a [`protocol`] says, and `trial` judges
//! what they answer: `rank` decides hits and misses, `distance` compares embeddings, `ranking`
//! makes Rank-k, mAP and mINP of distances, `verification` EER, ROC and AUC, and `cross_view`
//! the means over pairs of views. `wilson` and `bootstrap` say how far a rate can be trusted,
//! `median` where a median lies, `paired` whether two recognizers differ,
//! `bands` and `angle` sum it over viewpoints, and [`results`] is the JSON that
//! `edgegait score` writes; `strengths` is what each confounder does, `agreement` what 8-bit
//! weights do, `checkup` whether a model works at all, and `parity` whether runtimes and forms of a model answer alike.

pub(crate) mod bands;
pub(crate) mod bootstrap;
pub(crate) mod checkup;
pub mod contest;
pub(crate) mod cross_view;
pub(crate) mod distance;
pub(crate) mod eight_bit;
pub(crate) mod identification;
pub(crate) mod intervals;
pub(crate) mod median;
pub(crate) mod paired;
pub(crate) mod paired_results;
pub(crate) mod parity;
pub mod protocol;
pub(crate) mod rank1;
pub mod results;
#[cfg(feature = "plots")]
pub(crate) mod strengths;
#[cfg(test)]
pub(crate) mod testing;
mod totals;
pub(crate) mod trial;
pub(crate) mod verification;
pub(crate) mod view_angle;
pub(crate) mod wilson;

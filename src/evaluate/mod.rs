//! How good a recognizer is: hits, ranks and rates, their intervals, and where it fails.
//!
//! A [`contest`] shows a source's sequences to recognizers as a [`protocol`] says, and [`trial`] judges
//! what they answer: [`rank`] decides hits and misses, [`distance`] compares embeddings, [`ranking`]
//! makes Rank-k, mAP and mINP of distances, [`verification`] EER, ROC and AUC, and [`cross_view`]
//! the means over pairs of views. [`wilson`] and [`bootstrap`] say how far a rate can be trusted,
//! [`bands`] and [`angle`] sum it over viewpoints, and [`results`] is the JSON that
//! `edgegait score` writes; [`strengths`] is what each confounder does, and [`agreement`] what 8-bit
//! weights do.

pub mod agreement;
pub mod angle;
pub mod bands;
pub mod bootstrap;
pub mod contest;
pub mod cross_view;
pub mod distance;
pub mod intervals;
mod judge;
pub mod protocol;
pub mod rank;
pub mod ranking;
pub mod results;
pub mod strengths;
#[cfg(test)]
pub(crate) mod testing;
pub mod trial;
pub mod verification;
pub mod wilson;

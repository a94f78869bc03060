//! How good a recognizer is: Rank-1, its interval, and where it fails.
//!
//! [`rank`] decides hits and misses, [`wilson`] and [`subjects`] say how far a
//! rate can be trusted, [`bands`] and [`angle`] sum it over viewpoints, and
//! [`results`] is the JSON that `edgegait score` writes.

pub mod angle;
pub mod bands;
pub mod contest;
pub mod rank;
pub mod results;
pub mod subjects;
pub mod wilson;

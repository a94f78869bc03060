//! How good a recognizer is: Rank-1, its interval, and where it fails.
//!
//! [`rank`] and [`leave_out`] decide hits and misses, [`wilson`] and [`subjects`] say how far a
//! rate can be trusted, [`bands`] and [`angle`] sum it over viewpoints, and
//! [`results`] is the JSON that `edgegait score` writes.

pub mod angle;
pub mod bands;
pub mod contest;
pub mod leave_out;
pub mod rank;
pub mod results;
pub mod subjects;
pub mod wilson;

//! From scenes to pack bytes: the only writer of what `edgegait-core` reads.
//!
//! The encoder measures with the decoder: every error that it states was found by
//! decoding its own bytes with the core.

mod avatar;
mod bits;
mod clip;
mod pack;

pub use avatar::{EncodedAvatar, encode_avatar};
pub use clip::{EncodedClip, encode_cycle};
pub use pack::encode_subjects;

/// Greatest encoding error of a walk unless a user says otherwise, mm: a seventh of a GEI's
/// pixel, which is about 35 mm of the body, and less than what closing a recorded loop moves.
pub const MAX_ERROR_MM: f64 = 5.0;

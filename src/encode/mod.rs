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
pub use pack::{NewSubject, NewWalk, PackBuilder};

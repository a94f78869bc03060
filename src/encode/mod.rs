//! The encoder and only writer of packs.
//!
//! The encoder measures every error that it states by decoding its own bytes with the core.

mod avatar;
mod bits;
mod codebook;
mod coefficients;
mod cycle;
mod decoded;
mod entry_table;
mod fourier;
mod frames;
mod hull;
pub(crate) mod inspect;
mod knots;
mod mean_walks;
mod motion_sections;
mod pack;
mod population;
mod rice;
mod spline;
mod symmetry;
mod target;
mod uncut;
mod uncut_fit;
mod uncut_target;
pub(crate) mod within_error;

pub use avatar::{EncodedAvatar, encode_avatar};
pub use pack::{
    BUDGET_TRIES, STEPS_OF_WALK, body_error_mm, check_walks, encode_subjects, encode_within,
};
pub use population::{Effort, encode_population, read_population_code};
pub use uncut::encode_uncut;
pub use uncut_target::EncodedClip;

/// The default greatest encoding error of a walk, mm: a seventh of a GEI's pixel, which is about
/// 35 mm of the body, and less than the shift that closes a recorded loop.
pub const MAX_ERROR_MM: f64 = 5.0;

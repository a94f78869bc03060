//! Confounders: controlled changes that make the same walk look different.
//!
//! A confounder has a name, a class, a strength and a seed. A condition is a set of confounders
//! that act together, with fixed strengths or distributions from which strengths are sampled.
//! Confounders act where their cause does: on the body's hulls (`appearance`), on poses
//! (`motion`), on the camera and the choice of frames (the sweep), or on silhouettes before they
//! are framed (`image`). Strength 0 changes nothing.

pub(crate) mod appearance;
pub(crate) mod catalogue;
mod condition;
mod dose;
mod dose_plan;
pub(crate) mod image;
pub(crate) mod motion;
mod parse;
mod random_strength;

pub use catalogue::{CATALOGUE, Class, Confounder, ConfounderKind, DoseUnit, Stage};
pub use condition::{Condition, Conditions, NAMES, NORMAL};
pub use dose::{Dose, Doses};
pub use dose_plan::DosePlan;
pub use parse::dose;
pub use random_strength::{Per, RandomDose, RandomDoses, StrengthSpread};

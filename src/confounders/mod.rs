//! Confounders: what makes one walk look different, under control.
//!
//! A confounder has a name, a class, a strength and a seed; a condition is confounders that act
//! together, as strongly as it says or as is drawn from distributions that it states. They act where their cause does: on the body's hulls (`appearance`), on poses
//! (`motion`), on the camera and on which frames there are (the sweep), or on silhouettes before
//! they are framed (`image`). At strength 0 nothing is done at all.

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
pub use random_strength::{Draw, Draws, Per, StrengthSpread};

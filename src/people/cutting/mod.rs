//! Gait cycles cut out of recorded motion: when the feet touch the floor, where a cycle begins and
//! ends, and how its last frame is made to meet its first.

pub(crate) mod closing;
pub(crate) mod contacts;
pub mod events;
pub(crate) mod flat_feet;
pub(crate) mod stance;

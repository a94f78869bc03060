//! Cuts gait cycles out of recorded motion: finds foot contacts, chooses where a cycle begins and
//! ends, and makes its last frame meet its first.

pub(crate) mod closing;
pub(crate) mod contacts;
pub mod events;
pub(crate) mod flat_feet;
pub(crate) mod floor;
mod recurrence;
pub(crate) mod stance;

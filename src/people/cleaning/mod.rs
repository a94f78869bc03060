//! Cleaning of recorded motion: what a capture got wrong is repaired, or the part is left out.
//!
//! A file of this folder takes a motion on the canonical skeleton and returns it without one kind
//! of fault: joints that flip, noise above the band of gait, joints that a capture barely sees.

#[cfg(feature = "import")]
pub(crate) mod bridges;
pub(crate) mod flips;
#[cfg(feature = "import")]
pub(crate) mod low_pass;
#[cfg(feature = "import")]
pub(crate) mod usable_part;

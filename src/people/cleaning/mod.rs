//! Cleans recorded motion: repairs faults of the capture, or leaves out the faulty part.
//!
//! Each module removes one kind of fault: impossible steps, joints that flip, noise above the band
//! of gait.

#[cfg(feature = "import")]
pub(crate) mod bridges;
pub(crate) mod flips;
#[cfg(feature = "import")]
pub(crate) mod low_pass;
#[cfg(feature = "import")]
pub(crate) mod usable_part;

//! Finds the gait cycles of a recording from its silhouettes, or the reason why there are none.
//!
//! Silhouettes come from a tree ([`crate::Tree::lower_bodies`]), from arrays ([`lower_bodies`]), or
//! from a camera, frame by frame ([`CycleDetector`], in the core's `cycle`).
//!
//! ```
//! use edgegait::dataset::gait_cycles::{CycleFinder, LowerBody};
//!
//! // The spread of the legs by frame, of a person who takes two steps a second.
//! let spreads = (0..120).map(|frame| 0.1 + 0.05 * (f64::from(frame) * 0.419).cos());
//! let frames = spreads.map(|spread| Some(LowerBody { spread: spread as f32, sway: 0.0 }));
//! let found = CycleFinder::new(30.0)?.find(frames).expect("a walker");
//! assert_eq!(found.period_frames.round(), 30.0);
//! let ranges: Vec<_> = found.cycles.iter().map(edgegait::dataset::gait_cycles::whole_frames).collect();
//! assert_eq!(ranges, [0..30, 30..60, 60..90]);
//! # Ok::<(), edgegait::Error>(())
//! ```

mod finder;
mod found;

pub use edgegait_core::cycle::{
    CycleDetector, DetectedCycle, FrameRateError, LowerBody, NoCycle, Walking,
};
pub use finder::{CycleFinder, lower_bodies, whole_frames};
pub use found::FoundCycles;
pub(super) use found::median;

#[cfg(test)]
mod tests;

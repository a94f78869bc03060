//! Gait cycles from silhouettes, while they are seen.
//!
//! A [`CycleDetector`] takes what is seen of the legs in each frame, a [`LowerBody`], and says where
//! gait cycles begin and end. As Charalambous & Bharath (BMVC 2016) do it, after Sarkar et al. (IEEE
//! TPAMI 27(2), 2005): the legs' outline grows and shrinks once a step, and every second of its
//! largest extents bounds a cycle, since the left and the right step take turns. What differs:
//!
//! * Two things are measured, the pixels of the lowest third and the width of the lowest fifth. The
//!   paper's pixels swing well from the side alone; seen obliquely they swing once a cycle, not once a
//!   step, and the width does better. From in front neither does well, and both together do best.
//! * The peaks are those of the wave that fits four steps best, not of the smoothed signal: one wave has
//!   no side peaks, its phase is a real number, and its share of all that swings tells how sure it is.
//!
//! ```
//! use edgegait_core::cycle::{CycleDetector, LowerBody};
//!
//! // The legs of somebody who makes two steps a second, in 3 seconds at 30 frames a second.
//! let mut detector = CycleDetector::new(30.0)?;
//! let mut found = Vec::new();
//! for frame in 0..90u8 {
//!     let swing = libm::cosf(f32::from(frame) * core::f32::consts::TAU / 15.0);
//!     let legs = LowerBody { pixels: 900.0 + 90.0 * swing, width: 40.0 + 16.0 * swing };
//!     found.extend(detector.push(Some(legs)));
//! }
//! found.extend(detector.finish());
//! let ends: Vec<[f64; 2]> = found.iter().map(|cycle| [cycle.start.round(), cycle.end.round()]).collect();
//! assert_eq!(ends, [[0.0, 30.0], [30.0, 60.0]]);
//! # Ok::<(), edgegait_core::cycle::FrameRateError>(())
//! ```
//!
//! # Guarantees
//!
//! A detector takes at most 1,024 bytes, allocates nothing, and at most once a frame looks twice at a
//! window of [`crate::budget::CYCLE_SAMPLES`] samples, which takes some 30 waves times as many steps of
//! arithmetic and about 2 kB of stack. A boundary is reported two steps after it was seen, and 0.2
//! seconds at most: as soon as the wave before and after it is known. The same frames give the same
//! boundaries on every target. No number of frames and no number in them makes it panic; what is not
//! finite counts as nobody.

mod detector;
mod error;
mod lower_body;
mod wave;

pub use detector::{CycleDetector, DetectedCycle, OpenCycles, Walking};
pub use error::{FrameRateError, NoCycle};
pub use lower_body::LowerBody;

#[cfg(test)]
mod tests;

//! Detection of gait cycles in a stream of silhouettes.
//!
//! A [`CycleDetector`] receives the measurements of the legs in each frame, a [`LowerBody`], and
//! returns where gait cycles begin and end. Charalambous & Bharath (BMVC 2016), after Sarkar et al.
//! (IEEE TPAMI 27(2), 2005), count the pixels of the lower half, which grow and shrink once a step,
//! and take every second maximum. The differences are:
//!
//! * Two numbers are measured: how widely the legs are spread, and how far the trunk sways over the
//!   feet. From the side the spread swings once a step, from nearly in front once a cycle, since the
//!   feet are apart when one leg is ahead and cross when the other one is. From in front the trunk
//!   sways once a cycle.
//! * Power at the cycle's frequency and at the step's, twice as high, counts together, so that the
//!   finder need not know the camera's place. It knows it roughly by the mean spread.
//! * The peaks are those of the wave that fits four steps best, not of the smoothed signal. One
//!   wave has no side peaks, its phase is a real number, and its share of the change shows how
//!   reliable it is.
//!
//! ```
//! use edgegait_core::cycle::{CycleDetector, LowerBody};
//!
//! // The legs of a person who makes two steps a second, in 3 seconds at 30 frames a second.
//! let mut detector = CycleDetector::new(30.0)?;
//! let mut found = Vec::new();
//! for frame in 0..90u8 {
//!     let swing = libm::cosf(f32::from(frame) * core::f32::consts::TAU / 15.0);
//!     let legs = LowerBody { spread: 0.1 + 0.05 * swing, sway: 0.01 * swing };
//!     found.extend(detector.push(Some(legs)));
//! }
//! found.extend(detector.finish());
//! let ends: Vec<[f64; 2]> =
//!     found.iter().map(|cycle| [cycle.start.round(), cycle.end.round()]).collect();
//! assert_eq!(ends, [[0.0, 30.0], [30.0, 60.0]]);
//! # Ok::<(), edgegait_core::cycle::FrameRateError>(())
//! ```
//!
//! # Guarantees
//!
//! A detector takes at most 1,024 bytes and allocates nothing. At most once a frame it reads a
//! window of [`crate::budget::CYCLE_SAMPLES`] samples twice, which takes some 40 waves times that
//! many steps of arithmetic, and about 2 kB of stack. A boundary is reported two steps and at most
//! 0.2 seconds after it was seen, as soon as the wave before and after it is known. The same frames
//! give the same boundaries on every target. It does not panic, whatever the frames and their
//! number; a frame with numbers that are not finite counts as a frame without a person.

mod detector;
mod error;
mod lower_body;
mod wave;

pub use detector::{CycleDetector, DetectedCycle, OpenCycles, Walking};
pub use error::{FrameRateError, NoCycle};
pub use lower_body::LowerBody;

#[cfg(test)]
mod tests;

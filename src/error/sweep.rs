//! Errors about walks that cannot be drawn.

use super::Cause;

/// An error that stops a sweep.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// There is no such walk.
    #[error("there is no walk {number}: expected a number below {walks}")]
    NoWalk {
        /// Its number.
        number: usize,
        /// Number of walks in the pack.
        walks: usize,
    },
    /// An uncut motion has no cycle to make a GEI from.
    #[error("{0} is an uncut motion: a GEI needs a gait cycle")]
    UncutHasNoCycle(String),
    /// An uncut motion has no variations.
    #[error("{0} is an uncut motion: it has no variations")]
    UncutHasNoVariations(String),
    /// A walk has too many frames.
    #[error("{walk}: expected at most {most} frames, found {frames} (use fewer frames a second)")]
    TooManyFrames {
        /// The walk.
        walk: String,
        /// Number of its frames.
        frames: f64,
        /// The maximum number of frames.
        most: u32,
    },
    /// A walk, or a walk under a condition, cannot be drawn.
    #[error("{what}: {cause}")]
    Undrawn {
        /// The walk or the condition.
        what: String,
        /// The cause.
        #[source]
        cause: Cause,
    },
    /// A walk cannot be drawn from a viewpoint.
    #[error(
        "{walk}, variation {variation}, azimuth {azimuth_deg} and elevation {elevation_deg} degrees: {cause}"
    )]
    Unseen {
        /// The walk.
        walk: String,
        /// Number of its variation.
        variation: u32,
        /// Azimuth of the viewpoint.
        azimuth_deg: f32,
        /// Elevation of the viewpoint.
        elevation_deg: f32,
        /// The cause.
        #[source]
        cause: Cause,
    },
    /// A figure has no height to scale it by, metres.
    #[error("a figure {0} m high: expected a height above 0")]
    Flat(f64),
    /// The number of frames does not divide the exact GEI's number.
    #[error("{found} frames a cycle: expected a divisor of {of}")]
    Frames {
        /// Frames a cycle.
        found: u32,
        /// Frames a cycle of the exact GEI.
        of: u32,
    },
    /// No way to draw or encode is exact enough.
    #[error(
        "expected a GEI error of at most {asked}, but the best that can be reached here is {best:.3}"
    )]
    GeiError {
        /// The requested error, root mean square of 255.
        asked: f64,
        /// The smallest error that was found.
        best: f64,
    },
}

//! Why walks are not drawn.

use super::Cause;

/// What stops a sweep on its way.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// There is no such walk.
    #[error("there is no walk {number}: expected a number below {walks}")]
    NoWalk {
        /// Its number.
        number: usize,
        /// Walks of the pack.
        walks: usize,
    },
    /// A take has no cycle to make a GEI of.
    #[error("{0} is a whole take: a GEI needs a gait cycle")]
    TakeHasNoCycle(String),
    /// A take is not varied.
    #[error("{0} is a whole take: it has no variations")]
    TakeHasNoVariations(String),
    /// A walk has more frames than are drawn.
    #[error("{walk}: expected at most {most} frames, found {frames} (ask for fewer a second)")]
    TooManyFrames {
        /// The walk.
        walk: String,
        /// How many it has.
        frames: f64,
        /// How many are drawn.
        most: u32,
    },
    /// A walk, or a walk under a condition, cannot be drawn.
    #[error("{what}: {cause}")]
    Undrawn {
        /// The walk or the condition.
        what: String,
        /// Why not.
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
        /// Which variation of it.
        variation: u32,
        /// From where.
        azimuth_deg: f32,
        /// From how far above.
        elevation_deg: f32,
        /// Why not.
        #[source]
        cause: Cause,
    },
    /// A figure has no height to scale it by, metres.
    #[error("a figure of {0} m height: expected more than 0")]
    Flat(f64),
    /// Frames are not among those of the exact GEI.
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
        /// The error that was asked for, root mean square of 255.
        asked: f64,
        /// The least that was found.
        best: f64,
    },
}

//! Errors about people and walks that cannot be encoded.

use edgegait_core::budget::{MAX_DRAPED_HULLS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use edgegait_core::format::FormatError;
use edgegait_core::skeleton::Joint;
use std::ops::Range;

/// A property of a body, a walk or a pack that the format cannot store.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// A number of a body, a walk or a person is beyond what its field holds.
    #[error("{what} {found} {unit}: expected {expected}")]
    OutOfRange {
        /// The name of the quantity.
        what: &'static str,
        /// Its value.
        found: f64,
        /// Its unit.
        unit: &'static str,
        /// Its range, and what else may be wrong.
        expected: &'static str,
    },
    /// A body, a cycle or a frame has numbers that are not finite, or invalid rotations.
    #[error("{0} with numbers that are not finite, or rotations that are not unit quaternions")]
    NotFinite(String),
    /// A body has more hulls or points than the core can store, or a hull without points.
    #[error(
        "a body of {hulls} hulls, {draped} of them draped, {points} points and at most {largest} in one: expected at most {MAX_HULLS} hulls of 1 to {MAX_HULL_POINTS} points, {MAX_POINTS} in all, and {MAX_DRAPED_HULLS} draped ones of 1 to 8 parts"
    )]
    BodyTooLarge {
        /// Number of hulls, including the parts of draped ones.
        hulls: usize,
        /// Number of draped hulls.
        draped: usize,
        /// Points of all hulls.
        points: usize,
        /// Points of the largest hull.
        largest: usize,
    },
    /// A joint flips over between two frames.
    #[error(
        "joint {joint:?} turns {turned_deg:.0} degrees from frame {before} to {after}: expected at most {most_deg:.0} at {rate_hz:.0} frames a second (a flip of the capture? cut the motion there)"
    )]
    Flip {
        /// The first such joint.
        joint: Joint,
        /// The angle that it turns.
        turned_deg: f64,
        /// The frame before, from 0.
        before: usize,
        /// The frame after.
        after: usize,
        /// The greatest allowed angle.
        most_deg: f64,
        /// Frames a second.
        rate_hz: f64,
    },
    /// A joint turns a full circle in a cycle.
    #[error("joint {0:?} turns a full circle in a gait cycle: expected it to turn back")]
    FullCircle(Joint),
    /// A joint turns too far for the encoding.
    #[error(
        "a joint turns 300 degrees or more from its mean over the pack: expected less (encode such walks as a pack of their own)"
    )]
    TurnsTooFar,
    /// A cycle lasts too long or travels too far.
    #[error("a gait cycle of {period_s} s and {drift_m} m: expected up to 4,000 s and 2,000 m")]
    CycleTooLong {
        /// Its duration.
        period_s: f64,
        /// The distance that it travels.
        drift_m: f64,
    },
    /// An uncut motion has no frames, too many, or unequal numbers of roots and poses.
    #[error(
        "an uncut motion of {roots} root positions and {poses} poses: expected equal numbers, at least one"
    )]
    UncutFrames {
        /// Positions of the root.
        roots: usize,
        /// Poses.
        poses: usize,
    },
    /// An uncut motion travels further than the format can store.
    #[error("an uncut motion that travels further than the format holds")]
    UncutTooFar,
    /// Two people have the same name.
    #[error("two subjects are named {0:?}: expected unique names")]
    SameName(String),
    /// A name is too long.
    #[error("the name {0:?}: expected at most 255 bytes")]
    NameTooLong(String),
    /// There are more people than fit into a pack.
    #[error(
        "people {}..{}: more than fit into a pack's 65,535 walks or 16 MiB (expected a smaller slice, such as {}..{})",
        people.start, people.end, fit.start, fit.end
    )]
    TooManyPeople {
        /// The numbers of the people.
        people: Range<usize>,
        /// The numbers of the people who fit.
        fit: Range<usize>,
    },
    /// A walk of a population is an uncut motion.
    #[error("an uncut motion: expected a gait cycle, since populations have only gait cycles")]
    UncutInPopulation,
    /// There are more entries or bytes than fit into a pack.
    #[error("{0} entries or bytes: more than fit into a pack")]
    PackTooLarge(usize),
    /// A pack exceeds its budget even with the coarsest clips.
    #[error(
        "a budget of {budget} bytes: {people} people with {walks} walks take {found} even at an error of {error_mm} mm (encode fewer of them)"
    )]
    OverBudget {
        /// The budget, bytes.
        budget: usize,
        /// Number of people.
        people: usize,
        /// Number of their walks.
        walks: usize,
        /// Bytes of the smallest pack.
        found: usize,
        /// Its error.
        error_mm: f64,
    },
    /// Encoded data cannot be decoded: a defect of the encoder.
    #[error("{what} does not read back: {source}")]
    ReadBack {
        /// The kind of encoded data.
        what: &'static str,
        /// The error of the decoder.
        source: FormatError,
    },
}

impl EncodeError {
    /// Returns a function that creates the error that `what` cannot be decoded, from its cause.
    pub(crate) fn read_back(what: &'static str) -> impl Fn(FormatError) -> Self {
        move |source| Self::ReadBack { what, source }
    }
}

//! Why people and their walks are not encoded.

use edgegait_core::budget::{MAX_DRAPED_HULLS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use edgegait_core::format::FormatError;
use edgegait_core::skeleton::Joint;
use std::ops::Range;

/// What the format does not hold of a body, a walk or a pack.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// A number of a body, a walk or a person is beyond what its field holds.
    #[error("{what} {found} {unit}: expected {expected}")]
    OutOfRange {
        /// What it is.
        what: &'static str,
        /// How much it is.
        found: f64,
        /// In which unit.
        unit: &'static str,
        /// How much it may be, and what else may be wrong.
        expected: &'static str,
    },
    /// A body, a cycle or a frame of a take has numbers that are not finite, or rotations that are none.
    #[error("{0} with numbers that are not finite, or rotations that are not unit quaternions")]
    NotFinite(String),
    /// A body has more hulls or points than the core holds, or a hull without any.
    #[error(
        "a body of {hulls} hulls, {draped} of them draped, {points} points and at most {largest} in one: expected at most {MAX_HULLS} hulls of 1 to {MAX_HULL_POINTS} points, {MAX_POINTS} in all, and {MAX_DRAPED_HULLS} draped ones of 1 to 8 parts"
    )]
    BodyTooLarge {
        /// Its hulls, and the parts of draped ones.
        hulls: usize,
        /// How many are draped.
        draped: usize,
        /// Points of all of them.
        points: usize,
        /// Points of the largest.
        largest: usize,
    },
    /// A joint flips over between two frames.
    #[error(
        "joint {joint:?} turns {turned_deg:.0} degrees from frame {before} to {after}: expected at most {most_deg:.0} at {rate_hz:.0} frames a second (a flip of the capture? cut the motion there)"
    )]
    Flip {
        /// The first such joint.
        joint: Joint,
        /// By how much it turns.
        turned_deg: f64,
        /// The frame before, from 0.
        before: usize,
        /// The frame after.
        after: usize,
        /// By how much it may.
        most_deg: f64,
        /// Frames a second.
        rate_hz: f64,
    },
    /// A joint turns full circle in a cycle.
    #[error("joint {0:?} turns full circle in a gait cycle: expected it to come back as it went")]
    FullCircle(Joint),
    /// A joint turns too far for any coding.
    #[error(
        "a joint turns 300 degrees or more from its mean over the pack: expected less (encode such walks as a pack of their own)"
    )]
    TurnsTooFar,
    /// A cycle lasts or leads too far.
    #[error("a gait cycle of {period_s} s and {drift_m} m: expected up to 4,000 s and 2,000 m")]
    CycleTooLong {
        /// How long it lasts.
        period_s: f64,
        /// How far it leads.
        drift_m: f64,
    },
    /// A take has no frames, too many, or not as many roots as poses.
    #[error(
        "a take of {roots} root positions and {poses} poses: expected as many, and at least one"
    )]
    TakeFrames {
        /// Positions of the root.
        roots: usize,
        /// Poses.
        poses: usize,
    },
    /// A take leads further than its numbers reach.
    #[error("a take that travels further than the format holds")]
    TakeTooFar,
    /// Two people have one name.
    #[error("two subjects are named {0:?}: expected unique names")]
    SameName(String),
    /// A name is too long.
    #[error("the name {0:?}: expected at most 255 bytes")]
    NameTooLong(String),
    /// There are more people than a pack holds.
    #[error(
        "people {}..{}: more than a pack's 65,535 walks or 16 MiB hold (expected a smaller slice, as {}..{})",
        people.start, people.end, fit.start, fit.end
    )]
    TooManyPeople {
        /// Their numbers.
        people: Range<usize>,
        /// Those of them who fit.
        fit: Range<usize>,
    },
    /// A walk of a population is a whole take.
    #[error("a whole take: expected a gait cycle, since populations have no takes")]
    TakeInPopulation,
    /// There is more of something than a pack counts.
    #[error("{0} entries or bytes: more than a pack holds")]
    PackTooLarge(usize),
    /// A pack is larger than was asked for, however coarse its clips are.
    #[error(
        "a budget of {budget} bytes: {people} people with {walks} walks take {found} even at an error of {error_mm} mm (encode fewer of them)"
    )]
    OverBudget {
        /// Bytes that were asked for.
        budget: usize,
        /// People.
        people: usize,
        /// Their walks.
        walks: usize,
        /// Bytes of the smallest pack.
        found: usize,
        /// Its error.
        error_mm: f64,
    },
    /// What was just encoded cannot be decoded: a defect of the encoder.
    #[error("{what} does not read back: {source}")]
    ReadBack {
        /// What was encoded.
        what: &'static str,
        /// Why it cannot be decoded.
        source: FormatError,
    },
}

impl EncodeError {
    /// `what` cannot be decoded, because of the error that is given then.
    pub(crate) fn read_back(what: &'static str) -> impl Fn(FormatError) -> Self {
        move |source| Self::ReadBack { what, source }
    }
}

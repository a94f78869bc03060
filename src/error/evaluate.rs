//! Errors about comparisons of recognizers.

use super::listed;

/// A missing or excessive input of a protocol.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// No take of a source is in a part of the protocol.
    #[error(
        "protocol {protocol}: no take is in its {part}; found {}",
        listed(takes)
    )]
    NoTake {
        /// The protocol.
        protocol: String,
        /// `gallery` or `probes`.
        part: &'static str,
        /// Names of the first takes of the source.
        takes: Vec<String>,
    },
    /// All people have one take, and the protocol makes no others.
    #[error("protocol {0}: expected several takes of a person, found one of each")]
    NothingMade(String),
    /// A made cycle would be beyond the last variation.
    #[error(
        "protocol {protocol}: made: cycle {cycle} of {cycles} of take {take:?} is variation {variation}, expected at most {most} (begin with a lower one, or make fewer cycles)"
    )]
    VariationTooHigh {
        /// The protocol.
        protocol: String,
        /// The take.
        take: String,
        /// The cycle of the take, from 1.
        cycle: u32,
        /// Cycles of each take.
        cycles: u32,
        /// The cycle's variation.
        variation: u64,
        /// The last variation.
        most: u32,
    },
    /// Two made cycles would be the same.
    #[error(
        "protocol {protocol}: made: cycle {cycle} of {cycles} of take {take:?} is variation {variation}, which take {other:?} has too (give probe takes consecutive variations, others lower ones)"
    )]
    VariationTwice {
        /// The protocol.
        protocol: String,
        /// The second take.
        take: String,
        /// The cycle of the take, from 1.
        cycle: u32,
        /// Cycles of each take.
        cycles: u32,
        /// The variation of both cycles.
        variation: u32,
        /// The first take.
        other: String,
    },
    /// A model that is scored by classes has no class for a person.
    #[error("{model}: no class is called {subject:?}, which scoring by classes needs")]
    NoClass {
        /// The model.
        model: String,
        /// The person.
        subject: String,
    },
    /// The gallery is empty.
    #[error(
        "protocol {0}: nobody is enrolled: expected gallery sequences at the recognizer's training viewpoints"
    )]
    NobodyEnrolled(String),
    /// No embedding of the gallery can be compared.
    #[error("{0}: no embedding of the gallery is finite")]
    NoFiniteGallery(String),
    /// No probe has a gallery to be compared with.
    #[error("protocol {protocol}: no probe has a gallery: expected sequences of both at {at}")]
    NothingCompared {
        /// The protocol.
        protocol: String,
        /// The viewpoints at which both are needed.
        at: &'static str,
    },
    /// There are too many viewpoints to compare in pairs.
    #[error("protocol {protocol}: {found} viewpoints to compare in pairs, expected at most {most}")]
    TooManyViews {
        /// The protocol.
        protocol: String,
        /// Number of viewpoints.
        found: usize,
        /// The maximum number of viewpoints.
        most: usize,
    },
    /// There are more comparisons than can be done in a reasonable time.
    #[error(
        "protocol {protocol}: {found} comparisons, expected at most {most} (choose fewer viewpoints, people or walks)"
    )]
    TooManyComparisons {
        /// The protocol.
        protocol: String,
        /// Number of comparisons.
        found: u64,
        /// The maximum number of comparisons.
        most: u64,
    },
    /// A matrix has no mean over other views.
    #[error("cross-view matrix: expected at least 2 views, found {0}")]
    TooFewViews(usize),
    /// A cell of a matrix is empty.
    #[error(
        "cross-view matrix: no probe of view {probe} was compared with gallery view {gallery}, expected one in every cell (leave the view out)"
    )]
    EmptyCell {
        /// The view of probes.
        probe: usize,
        /// The view of the gallery.
        gallery: usize,
    },
    /// The inputs or answers of two sides cannot be compared.
    #[error(
        "expected one {what} to compare, found {} of {} and {} of {}",
        .values[0], .sides[0], .values[1], .sides[1]
    )]
    SidesDiffer {
        /// A setting of their contracts, or the form of their answers.
        what: &'static str,
        /// The sides.
        sides: [String; 2],
        /// The value of each.
        values: [String; 2],
    },
    /// A recognizer has no probes under a condition.
    #[error("{recognizer}: no probes under {condition}")]
    NotAsked {
        /// The recognizer.
        recognizer: String,
        /// The condition.
        condition: String,
    },
}

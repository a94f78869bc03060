//! Why recognizers are not compared.

use super::listed;

/// What a protocol does not find, or finds too much of.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// No take of a source has a part in the protocol.
    #[error(
        "protocol {protocol}: no take is in its {part}; found {}",
        listed(takes)
    )]
    NoTake {
        /// The protocol.
        protocol: String,
        /// `gallery` or `probes`.
        part: &'static str,
        /// Names of the takes that there are, the first of them.
        takes: Vec<String>,
    },
    /// Everyone has one take, and the protocol makes none.
    #[error(
        "protocol {0}: every person has one take, and it does not say which to make of it (add \"made\")"
    )]
    NothingMade(String),
    /// A cycle that is made would be beyond the last variation.
    #[error(
        "protocol {protocol}: made: cycle {cycle} of {cycles} of take {take:?} is variation {variation}, expected at most {most} (begin with a lower one, or make fewer cycles)"
    )]
    VariationTooHigh {
        /// The protocol.
        protocol: String,
        /// The take.
        take: String,
        /// The cycle of it, from 1.
        cycle: u32,
        /// Cycles of each take.
        cycles: u32,
        /// The cycle's variation.
        variation: u64,
        /// The last.
        most: u32,
    },
    /// Two cycles that are made would be the same.
    #[error(
        "protocol {protocol}: made: cycle {cycle} of {cycles} of take {take:?} is variation {variation}, which take {other:?} has too (give takes that are looked for consecutive variations, others lower ones)"
    )]
    VariationTwice {
        /// The protocol.
        protocol: String,
        /// The second take.
        take: String,
        /// The cycle of it, from 1.
        cycle: u32,
        /// Cycles of each take.
        cycles: u32,
        /// Their variation.
        variation: u32,
        /// The first take.
        other: String,
    },
    /// A model has no class for a person, and is asked for classes.
    #[error("{model}: no class is called {subject:?}, as scoring by classes needs")]
    NoClass {
        /// The model.
        model: String,
        /// The person.
        subject: String,
    },
    /// Nobody is in the gallery.
    #[error(
        "protocol {0}: nobody is enrolled: expected sequences of the gallery at the recognizer's training viewpoints"
    )]
    NobodyEnrolled(String),
    /// No embedding of the gallery can be compared.
    #[error("{0}: no embedding of the gallery is finite")]
    NoFiniteGallery(String),
    /// No probe meets a gallery.
    #[error("protocol {protocol}: no probe meets a gallery: expected sequences of both at {at}")]
    NothingCompared {
        /// The protocol.
        protocol: String,
        /// Where they would meet.
        at: &'static str,
    },
    /// There are more viewpoints than are compared each with each.
    #[error(
        "protocol {protocol}: {found} viewpoints compared each with each, expected at most {most}"
    )]
    TooManyViews {
        /// The protocol.
        protocol: String,
        /// Viewpoints.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// There are more comparisons than would end.
    #[error(
        "protocol {protocol}: {found} comparisons, expected at most {most} (choose fewer viewpoints, people or walks)"
    )]
    TooManyComparisons {
        /// The protocol.
        protocol: String,
        /// Comparisons.
        found: u64,
        /// How many there may be.
        most: u64,
    },
    /// A matrix has no mean over other views.
    #[error("cross-view matrix: expected at least 2 views, found {0}")]
    TooFewViews(usize),
    /// A cell of a matrix is empty.
    #[error(
        "cross-view matrix: no probe of view {probe} met gallery view {gallery}, expected one in every cell (leave the view out)"
    )]
    EmptyCell {
        /// The view of probes.
        probe: usize,
        /// The view of the gallery.
        gallery: usize,
    },
    /// What two sides take or give cannot be compared.
    #[error(
        "expected one {what} to compare, found {} of {} and {} of {}",
        .values[0], .sides[0], .values[1], .sides[1]
    )]
    SidesDiffer {
        /// A setting of their contracts, or the form of their answers.
        what: &'static str,
        /// The sides.
        sides: [String; 2],
        /// What each has.
        values: [String; 2],
    },
    /// A recognizer was not asked under a condition.
    #[error("{recognizer}: no probes under {condition}")]
    NotAsked {
        /// The recognizer.
        recognizer: String,
        /// The condition.
        condition: String,
    },
}

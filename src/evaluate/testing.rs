//! Matrix E1 of the project's reference, whose metrics were worked out by hand.

/// Distances `[probe][gallery]`.
pub(crate) const E1: [[f64; 6]; 3] = [
    [0.10, 0.40, 0.35, 0.60, 0.70, 0.55],
    [0.50, 0.30, 0.20, 0.45, 0.65, 0.80],
    [0.90, 0.75, 0.60, 0.50, 0.25, 0.30],
];
/// The person of each probe.
pub(crate) const E1_PROBES: [usize; 3] = [1, 2, 3];
/// The person of each gallery entry.
pub(crate) const E1_GALLERY: [usize; 6] = [1, 1, 2, 2, 3, 3];

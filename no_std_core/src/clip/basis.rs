//! The Fourier basis at one phase.

use crate::budget::MAX_HARMONICS;
use crate::format::MAX_GROUPS;

/// Values of the Fourier basis at one phase, a pair for each group: 1 and 0, then the cosine and
/// the sine of each harmonic.
pub(super) struct Basis {
    pub(super) pairs: [[f32; 2]; MAX_GROUPS],
}

impl Basis {
    pub(super) fn new(phase: f32) -> Self {
        Self::up_to(phase, MAX_HARMONICS)
    }

    /// Returns the basis up to a harmonic, with zeros after it.
    pub(super) fn up_to(phase: f32, harmonics: usize) -> Self {
        let phase = if phase.is_finite() {
            phase - libm::floorf(phase)
        } else {
            0.0
        };
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * phase);
        let mut pairs = [[0.0; 2]; MAX_GROUPS];
        let [constant, own @ ..] = &mut pairs;
        *constant = [1.0, 0.0];
        let (mut harmonic_cos, mut harmonic_sin) = (cos, sin);
        for pair in own.iter_mut().take(harmonics) {
            *pair = [harmonic_cos, harmonic_sin];
            (harmonic_cos, harmonic_sin) = (
                harmonic_cos * cos - harmonic_sin * sin,
                harmonic_cos * sin + harmonic_sin * cos,
            );
        }
        Self { pairs }
    }
}

//! The Fourier coefficients of a gait cycle, in quantisation steps.

use edgegait_core::format::CHANNELS;

/// The coefficients of all channels in steps: constant, then cosine and sine of each harmonic.
/// A channel ends with the last harmonic that is not 0.
pub(super) type CycleCoefficients = [Vec<i32>; CHANNELS];

/// The coefficients of a mean walk, radians and metres.
pub(super) type Mean = [Vec<f64>; CHANNELS];

/// Returns a coefficient of a mean walk, or 0 where there is none.
pub(super) fn mean_of(mean: Option<&Mean>, channel: usize, index: usize) -> f64 {
    mean.and_then(|mean| mean[channel].get(index).copied())
        .unwrap_or(0.0)
}

/// Removes harmonics of 0 at a channel's end.
pub(super) fn trim(numbers: &mut Vec<i32>) {
    while numbers.last() == Some(&0) {
        numbers.pop();
    }
    if !numbers.is_empty() && numbers.len().is_multiple_of(2) {
        numbers.push(0);
    }
}

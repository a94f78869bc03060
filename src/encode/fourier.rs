//! Fourier series of evenly spaced samples.

use edgegait_core::budget::MAX_HARMONICS;
use std::f64::consts::TAU;

/// The Fourier basis at evenly spaced phases: one row for each coefficient.
#[derive(Clone, Debug)]
pub(super) struct FourierBasis {
    rows: Vec<Vec<f64>>,
    /// The values of the basis by frame.
    columns: Vec<Vec<f64>>,
    /// The sum of the squares of each row.
    squares: Vec<f64>,
}

impl FourierBasis {
    /// Creates a basis of a constant, then cosine and sine of each harmonic up to half the sampling
    /// rate, at most 31. At half the sampling rate, the sine is 0 everywhere.
    pub(super) fn new(frames: usize) -> Self {
        let harmonics = MAX_HARMONICS.min(frames / 2);
        let mut rows = vec![vec![1.0; frames]];
        for harmonic in 1..=harmonics {
            let waves: Vec<(f64, f64)> = (0..frames)
                .map(|frame| {
                    // The product is first reduced in integers.
                    let step = (harmonic * frame) % frames;
                    #[expect(clippy::cast_precision_loss, reason = "frames of a cycle")]
                    let turns = step as f64 / frames as f64;
                    let (sin, cos) = libm::sincos(TAU * turns);
                    // Exactly 0 at half turns, where rounding would leave 1e-16.
                    (
                        if (2 * step).is_multiple_of(frames) {
                            0.0
                        } else {
                            sin
                        },
                        cos,
                    )
                })
                .collect();
            rows.push(waves.iter().map(|(_, cos)| *cos).collect());
            rows.push(waves.iter().map(|(sin, _)| *sin).collect());
        }
        let column = |frame: usize| rows.iter().map(|row| row[frame]).collect();
        Self {
            columns: (0..frames).map(column).collect(),
            squares: rows
                .iter()
                .map(|row| row.iter().map(|a| a * a).sum())
                .collect(),
            rows,
        }
    }

    /// Returns the values of a coefficient's wave, by frame.
    pub(super) fn wave(&self, coefficient: usize) -> &[f64] {
        &self.rows[coefficient]
    }

    /// Returns the coefficients of evenly spaced samples, since the waves are orthogonal.
    pub(super) fn analyse(&self, values: &[f64]) -> Vec<f64> {
        // All sums in one pass, each in the order of the frames.
        let mut sums = vec![-0.0; self.rows.len()];
        for (column, value) in self.columns.iter().zip(values) {
            for (sum, wave) in sums.iter_mut().zip(column) {
                *sum += wave * value;
            }
        }
        for (sum, &square) in sums.iter_mut().zip(&self.squares) {
            *sum = if square > 0.0 { *sum / square } else { 0.0 };
        }
        sums
    }

    /// Returns the values of a series at the same phases.
    pub(super) fn synthesise(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.rows[0].len()];
        for (&coefficient, row) in coefficients.iter().zip(&self.rows) {
            if coefficient != 0.0 {
                for (value, wave) in values.iter_mut().zip(row) {
                    *value += coefficient * wave;
                }
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_return_from_their_coefficients() {
        for count in [7, 8] {
            let values = &[0.5, -1.0, 2.0, 0.25, 0.0, 3.0, -2.0, 1.5][..count];
            let series = FourierBasis::new(values.len());
            let coefficients = series.analyse(values);
            assert_eq!(coefficients.len(), 1 + 2 * (count / 2));
            for (found, value) in series.synthesise(&coefficients).iter().zip(values) {
                assert!((found - value).abs() < 1e-12);
            }
        }
    }
}

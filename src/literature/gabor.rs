//! Gabor features of a GEI: how strongly each place shows waves of each scale and orientation.
//!
//! The kernels are those that Guan & Li 2013 use, "A robust speed-invariant gait recognition system for
//! walker and runner identification", ICB: five scales by eight orientations,
//!
//! `psi(z) = (k^2 / d^2) exp(-k^2 |z|^2 / (2 d^2)) (exp(i k.z) - exp(-d^2 / 2))`
//!
//! with `k = k_s (cos phi, sin phi)`, `k_s = (pi / 2) / sqrt(2)^s`, `phi = pi o / 8` and `d = 2 pi`. The
//! wide ones reach beyond an image of 50 x 30: outside of it there is nothing. Of each response the
//! magnitude is kept, at every fourth row and column; where, the publication leaves open.

use crate::train::algebra::multiply;
use edgegait_core::silhouette::Size;
use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;
use std::f64::consts::{PI, SQRT_2};

/// Scales and orientations of the kernels.
const SCALES: usize = 5;
const ORIENTATIONS: usize = 8;
/// Every so many rows and columns a response is kept. Ours.
const STEP: usize = 4;
/// Images of which responses are computed at once by each thread: 2 MB of them.
const AT_ONCE: usize = 64;

/// The kernels over one size of images, as the matrix that they are.
///
/// A feature is a matrix: a row for each orientation and column of the image, a column for each scale
/// and row of the image. Guan & Li choose random subspaces among combinations of columns: here these are
/// heights of the body, which clothes and loads change one by one. The publication does not say which
/// axis is which.
pub(crate) struct Gabor {
    /// From pixels to the real parts of all responses, and to the imaginary parts.
    parts: [Array2<f32>; 2],
    /// Rows and columns of a feature.
    pub(crate) shape: (usize, usize),
}

impl Gabor {
    /// The kernels over images of this size.
    #[must_use]
    pub(crate) fn new(size: Size) -> Self {
        let (rows, columns) = (kept(size.rows()), kept(size.columns()));
        let shape = (ORIENTATIONS * columns.len(), SCALES * rows.len());
        let mut parts = [(); 2].map(|()| Array2::zeros((size.pixels(), shape.0 * shape.1)));
        for orientation in 0..ORIENTATIONS {
            for (across, &column) in columns.iter().enumerate() {
                for scale in 0..SCALES {
                    for (down, &row) in rows.iter().enumerate() {
                        let feature = (orientation * columns.len() + across) * shape.1
                            + scale * rows.len()
                            + down;
                        for pixel in 0..size.pixels() {
                            let from = (pixel / size.columns(), pixel % size.columns());
                            let z = [column as f64 - from.1 as f64, row as f64 - from.0 as f64];
                            let response = kernel(scale, orientation, z);
                            for (part, number) in parts.iter_mut().zip(response) {
                                part[[pixel, feature]] = number as f32;
                            }
                        }
                    }
                }
            }
        }
        Self { parts, shape }
    }

    /// The features of images, one a row with pixels in 0..1: magnitudes, one feature a row.
    #[must_use]
    pub(crate) fn features(&self, images: ArrayView2<'_, f32>) -> Array2<f32> {
        let mut features = Array2::zeros((images.nrows(), self.shape.0 * self.shape.1));
        let of_some = images.axis_chunks_iter(ndarray::Axis(0), AT_ONCE);
        let chunks = features.axis_chunks_iter_mut(ndarray::Axis(0), AT_ONCE);
        let mut chunks: Vec<_> = of_some.zip(chunks).collect();
        chunks.par_iter_mut().for_each(|(images, features)| {
            let [real, imaginary] = self.parts.each_ref();
            features.assign(&multiply(*images, real.view()));
            let imaginary = multiply(*images, imaginary.view());
            features.zip_mut_with(&imaginary, |a, b| *a = a.hypot(*b));
        });
        features
    }
}

/// Rows or columns at which responses are kept: in the middle of each four.
fn kept(side: usize) -> Vec<usize> {
    (STEP / 2..side).step_by(STEP).collect()
}

/// The kernel at a place, as far right and down of its centre: real and imaginary part.
fn kernel(scale: usize, orientation: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    let delta = 2.0 * PI;
    let k = PI / 2.0 / SQRT_2.powi(scale as i32);
    let phi = PI * orientation as f64 / ORIENTATIONS as f64;
    let wave = k * (x * phi.cos() + y * phi.sin());
    let envelope =
        k * k / (delta * delta) * libm::exp(-k * k * (x * x + y * y) / (2.0 * delta * delta));
    let mean = libm::exp(-delta * delta / 2.0);
    [
        envelope * (libm::cos(wave) - mean),
        envelope * libm::sin(wave),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_have_the_values_of_the_closed_form() {
        // At the centre: (k / d)^2 (1 - exp(-2 pi^2)), with k / d = 1/4 for the finest scale.
        let [real, imaginary] = kernel(0, 0, [0.0, 0.0]);
        assert!((real - 0.0625 * (1.0 - 2.675_287_991e-9)).abs() < 1e-12 && imaginary == 0.0);
        // One pixel right: k = pi/2, a quarter of a wave, so that the cosine is 0.
        let [real, imaginary] = kernel(0, 0, [1.0, 0.0]);
        let envelope = 0.0625 * (-1.0_f64 / 32.0).exp();
        assert!((imaginary - envelope).abs() < 1e-15);
        assert!((real + envelope * 2.675_287_991e-9).abs() < 1e-15);
        // Upright waves do not change downwards: orientation 4 is orientation 0 turned.
        let turned = kernel(2, 4, [3.0, 5.0]);
        let straight = kernel(2, 0, [5.0, -3.0]);
        for (a, b) in turned.iter().zip(straight) {
            assert!((a - b).abs() < 1e-15);
        }
        // Two scales up the waves are twice as long, and a fourth as high.
        let (fine, coarse) = (kernel(0, 3, [1.5, -2.0]), kernel(2, 3, [3.0, -4.0]));
        for (fine, coarse) in fine.iter().zip(coarse) {
            assert!((fine / 4.0 - coarse).abs() < 1e-15);
        }
    }

    #[test]
    fn features_are_magnitudes_of_plain_convolutions() {
        let gabor = Gabor::new(Size::S50x30);
        assert_eq!(gabor.shape, (8 * 7, 5 * 12));
        let image = Array2::from_shape_fn((1, 1500), |(_, at)| ((at * 37 % 101) as f32) / 100.0);
        let features = gabor.features(image.view());
        // Orientation 3, the image's column 10, scale 1, its row 22.
        let (mut real, mut imaginary) = (0.0, 0.0);
        for row in 0..50 {
            for column in 0..30 {
                let [a, b] = kernel(1, 3, [10.0 - column as f64, 22.0 - row as f64]);
                let pixel = f64::from(image[[0, row * 30 + column]]);
                (real, imaginary) = (real + a * pixel, imaginary + b * pixel);
            }
        }
        let expected = f64::hypot(real, imaginary);
        let found = f64::from(features[[0, (3 * 7 + 2) * 60 + 12 + 5]]);
        assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    }

    #[test]
    fn a_wave_is_seen_best_by_the_kernel_of_its_length_and_direction() {
        let gabor = Gabor::new(Size::S50x30);
        let k = PI / 2.0 / SQRT_2;
        // Crests that run down, one every 2 pi / k columns: scale 1, orientation 0.
        let wave = |(_, at): (usize, usize)| (0.5 + 0.5 * (k * (at % 30) as f64).cos()) as f32;
        let image = Array2::from_shape_fn((1, 1500), wave);
        let features = gabor.features(image.view());
        // In the middle of the image.
        let at = |orientation: usize, scale: usize| {
            features[[0, (orientation * 7 + 3) * 60 + scale * 12 + 6]]
        };
        let best = (0..ORIENTATIONS)
            .flat_map(|orientation| (0..SCALES).map(move |scale| (orientation, scale)))
            .max_by(|a, b| at(a.0, a.1).total_cmp(&at(b.0, b.1)));
        assert_eq!(best, Some((0, 1)));
    }

    #[test]
    fn an_even_image_has_no_waves_but_at_its_edges() {
        let gabor = Gabor::new(Size::S64x64);
        let features = gabor.features(Array2::ones((1, 4096)).view());
        // The finest kernels end far from the edges of the middle.
        let columns = 16;
        let middle = features[[0, (columns / 2) * gabor.shape.1 + 8]];
        assert!(middle < 1e-3, "{middle}");
    }
}

//! Gabor features of a GEI: how strong waves of each scale and orientation are at each place.
//!
//! The kernels are from Guan & Li 2013, "A robust speed-invariant gait recognition system for
//! walker and runner identification", ICB: five scales by eight orientations,
//!
//! `psi(z) = (k^2 / d^2) exp(-k^2 |z|^2 / (2 d^2)) (exp(i k.z) - exp(-d^2 / 2))`
//!
//! with `k = k_s (cos phi, sin phi)`, `k_s = (pi / 2) / sqrt(2)^s`, `phi = pi o / 8` and
//! `d = 2 pi`. Wide kernels reach beyond an image of 50 x 30, where pixels count as 0. The
//! magnitude of each response is kept at every fourth row and column; the publication leaves the
//! places open.
//!
//! The last term, 3e-9 of the kernel's peak, is less than f32 resolves, and is left out. The rest
//! is the product of a function of rows and a function of columns, so a response is two matrix
//! products.

use super::linear_algebra::multiply;
use super::onnx_file::{NodeAttribute, OnnxFile};
use edgegait_core::silhouette::Size;
use ndarray::{Array2, ArrayView2, s};
use rayon::prelude::*;
use std::f64::consts::{PI, SQRT_2};

/// Scales and orientations of the kernels.
const SCALES: usize = 5;
const ORIENTATIONS: usize = 8;
const KERNELS: usize = SCALES * ORIENTATIONS;
/// The step in rows and columns between responses that are kept. Our choice.
const STEP: usize = 4;

/// The kernels for one size of images, as matrices.
///
/// A feature is a matrix: a row for each orientation and column of the image, a column for each
/// scale and row of the image. Guan & Li choose random subspaces among combinations of columns.
/// Here columns are heights of the body, which clothes and loads change separately; the publication
/// does not state which axis is which.
pub(crate) struct Gabor {
    size: Size,
    /// The real and the imaginary factors of an image's rows, for each kernel (scale after scale,
    /// in each all orientations) and each row that is kept.
    rows: Array2<f32>,
    /// A block for each kernel: the map from the real, then the imaginary numbers of an image's
    /// columns to the real and the imaginary part of each column that is kept.
    columns: Array2<f32>,
    /// The numbers of rows and columns that are kept.
    kept: (usize, usize),
    /// Rows and columns of a feature.
    pub(crate) shape: (usize, usize),
}

impl Gabor {
    /// Makes the kernels for images of this size.
    #[must_use]
    pub(crate) fn new(size: Size) -> Self {
        let (down, across) = (kept(size.rows()), kept(size.columns()));
        let mut rows = Array2::zeros((KERNELS * down.len() * 2, size.rows()));
        let mut columns = Array2::zeros((KERNELS * size.columns() * 2, across.len() * 2));
        for kernel in 0..KERNELS {
            let (scale, orientation) = (kernel / ORIENTATIONS, kernel % ORIENTATIONS);
            let k = PI / 2.0 / SQRT_2.powi(scale as i32);
            let phi = PI * orientation as f64 / ORIENTATIONS as f64;
            let height = (k / DELTA).powi(2);
            for (at, &middle) in down.iter().enumerate() {
                for row in 0..size.rows() {
                    let y = middle as f64 - row as f64;
                    let first = (kernel * down.len() + at) * 2;
                    for (part, number) in wave(k, k * libm::sin(phi), y).into_iter().enumerate() {
                        rows[[first + part, row]] = (height * number) as f32;
                    }
                }
            }
            for (at, &middle) in across.iter().enumerate() {
                for column in 0..size.columns() {
                    let x = middle as f64 - column as f64;
                    let [real, imaginary] =
                        wave(k, k * libm::cos(phi), x).map(|number| number as f32);
                    let first = kernel * size.columns() * 2 + column;
                    let second = first + size.columns();
                    columns[[first, 2 * at]] = real;
                    columns[[first, 2 * at + 1]] = imaginary;
                    columns[[second, 2 * at]] = -imaginary;
                    columns[[second, 2 * at + 1]] = real;
                }
            }
        }
        Self {
            size,
            rows,
            columns,
            kept: (down.len(), across.len()),
            shape: (ORIENTATIONS * across.len(), SCALES * down.len()),
        }
    }

    /// Computes the features of images, one a row with pixels in 0..1: magnitudes, one feature a
    /// row.
    #[must_use]
    pub(crate) fn features(&self, images: ArrayView2<'_, f32>) -> Array2<f32> {
        let mut features = Array2::zeros((images.nrows(), self.shape.0 * self.shape.1));
        let mut pairs: Vec<_> = images.outer_iter().zip(features.outer_iter_mut()).collect();
        pairs.par_iter_mut().for_each(|(image, feature)| {
            let sides = (self.size.rows(), self.size.columns());
            let image = image.into_shape_with_order(sides).expect("its pixels");
            let responses = self.responses(image);
            let (down, across) = self.kept;
            for response in responses {
                let GaborResponse {
                    kernel,
                    row,
                    column,
                    magnitude,
                } = response;
                let (scale, orientation) = (kernel / ORIENTATIONS, kernel % ORIENTATIONS);
                let at = (orientation * across + column) * self.shape.1 + scale * down + row;
                feature[at] = magnitude;
            }
        });
        features
    }

    /// Computes the responses that are kept of an image.
    fn responses(&self, image: ArrayView2<'_, f32>) -> Vec<GaborResponse> {
        let (down, across) = self.kept;
        let wide = 2 * self.size.columns();
        let of_rows = multiply(self.rows.view(), image);
        let of_rows = of_rows.into_shape_with_order((KERNELS * down, wide));
        let of_rows = of_rows.expect("a real and an imaginary row as one");
        let mut found = Vec::with_capacity(KERNELS * down * across);
        for kernel in 0..KERNELS {
            let own = of_rows.slice(s![kernel * down..(kernel + 1) * down, ..]);
            let columns = self
                .columns
                .slice(s![kernel * wide..(kernel + 1) * wide, ..]);
            let parts = multiply(own, columns);
            for row in 0..down {
                for column in 0..across {
                    let (real, imaginary) =
                        (parts[[row, 2 * column]], parts[[row, 2 * column + 1]]);
                    let magnitude = (real * real + imaginary * imaginary).sqrt();
                    found.push(GaborResponse {
                        kernel,
                        row,
                        column,
                        magnitude,
                    });
                }
            }
        }
        found
    }

    /// Adds the operations that compute features, as matrices, from an input of images.
    pub(super) fn write(&self, file: &mut OnnxFile, input: &str, output: &str) {
        let (down, across) = self.kept;
        let (rows, columns) = (self.size.rows(), self.size.columns());
        file.integers("image_shape", &[0, rows as i64, columns as i64]);
        file.node("Reshape", &[input, "image_shape"], "image");
        file.numbers("gabor_rows", &[self.rows.nrows(), rows], &self.rows);
        file.node("MatMul", &["gabor_rows", "image"], "of_rows");
        let of_kernels = [0, KERNELS as i64, down as i64, 2 * columns as i64];
        file.integers("of_kernels_shape", &of_kernels);
        file.node("Reshape", &["of_rows", "of_kernels_shape"], "of_kernels");
        let sizes = [KERNELS, 2 * columns, 2 * across];
        file.numbers("gabor_columns", &sizes, &self.columns);
        file.node("MatMul", &["of_kernels", "gabor_columns"], "responses");
        file.node("Mul", &["responses", "responses"], "squares");
        let of_parts = [0, KERNELS as i64, down as i64, across as i64, 2];
        file.integers("parts_shape", &of_parts);
        file.node("Reshape", &["squares", "parts_shape"], "parts");
        file.integers("last_axis", &[-1]);
        let keep = [("keepdims", NodeAttribute::Integer(0))];
        file.node_with("ReduceSum", &["parts", "last_axis"], "powers", &keep);
        file.node("Sqrt", &["powers"], "magnitudes");
        let of_scales = [SCALES, ORIENTATIONS, down, across].map(|size| size as i64);
        file.integers("of_scales_shape", &[&[0], &of_scales[..]].concat());
        file.node("Reshape", &["magnitudes", "of_scales_shape"], "of_scales");
        let order = [("perm", NodeAttribute::Integers(&[0, 2, 4, 1, 3]))];
        file.node_with("Transpose", &["of_scales"], "ordered", &order);
        let shape = [0, self.shape.0 as i64, self.shape.1 as i64];
        file.integers("features_shape", &shape);
        file.node("Reshape", &["ordered", "features_shape"], output);
    }
}

/// The response of a kernel at a place of an image.
struct GaborResponse {
    kernel: usize,
    row: usize,
    column: usize,
    magnitude: f32,
}

/// Returns the rows or columns at which responses are kept: the middle of each four.
fn kept(side: usize) -> Vec<usize> {
    (STEP / 2..side).step_by(STEP).collect()
}

/// `d`: the standard deviation of a kernel, in radians of its wave.
const DELTA: f64 = 2.0 * PI;

/// Returns a kernel's factor along one axis, at this distance from its centre: real and imaginary
/// part. `k` is the kernel's wave number, `along` its component on the axis.
fn wave(k: f64, along: f64, at: f64) -> [f64; 2] {
    let envelope = libm::exp(-(k * at / DELTA).powi(2) / 2.0);
    [
        envelope * libm::cos(along * at),
        envelope * libm::sin(along * at),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the kernel `x` to the right of its centre and `y` below it: real and imaginary part.
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
        // Orientation 4 is orientation 0, turned by 90 degrees.
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
        // In the middle, the finest kernels do not reach the edges.
        let columns = 16;
        let middle = features[[0, (columns / 2) * gabor.shape.1 + 8]];
        assert!(middle < 1e-3, "{middle}");
    }
}

//! Principal component analysis: the directions in which samples differ most.
//!
//! A GEI has 1500 pixels, many of which never change (the corners are always
//! background). Such pixels are left out of the eigenproblem, which is solved
//! through the smaller of the covariance and the Gram matrix.

use ndarray::{Array1, Array2, ArrayView2, Axis, s};

use super::Components;
use super::linear_algebra::{Real, add_products_of_columns, eigen, finite, fix_sign, multiply};
use crate::error::{Result, TrainError};

/// Rows that are centred in one pass: this bounds the copy to 6 MB at 1500 pixels.
const ROWS_AT_ONCE: usize = 512;

/// The mean of samples and the directions in which they vary, largest first.
#[derive(Clone, Debug)]
pub(crate) struct Pca<F> {
    /// Mean sample, one number per dimension.
    pub mean: Array1<F>,
    /// Variances along the components (divisor n - 1), falling, never negative: min(samples,
    /// dimensions) numbers, of which only the first `components.nrows()` are above zero.
    pub eigenvalues: Array1<F>,
    /// One unit vector a row; its largest component by magnitude is positive.
    pub components: Array2<F>,
}

impl<F: Real> Pca<F> {
    /// Analyses `samples`, one a row.
    ///
    /// Costs about `samples * dims^2` multiplications and `dims^3`, one thread.
    ///
    /// # Errors
    /// If there are fewer than two samples, no dimension, or a number that is not finite.
    ///
    /// # Guarantees
    /// Equal input gives equal bits on one machine. A dimension that never changes has that
    /// value as its mean exactly, and 0 in every component.
    pub(crate) fn fit<T: Copy + Into<F>>(samples: ArrayView2<'_, T>) -> Result<Self> {
        let (count, dims) = samples.dim();
        if count < 2 || dims == 0 {
            return Err(TrainError::TooFewSamples {
                samples: count,
                dims,
            }
            .into());
        }
        let (mean, varying) = mean_and_varying(samples)?;
        let (values, directions) = if count < varying.len() {
            through_gram(samples, &mean, &varying)?
        } else {
            through_covariance(samples, &mean, &varying)?
        };
        let floor = F::TOLERANCE * values.first().copied().unwrap_or_else(F::zero);
        let rank = values
            .iter()
            .take_while(|value| **value > floor && **value > F::zero())
            .count();
        let mut eigenvalues = Array1::zeros(count.min(dims));
        let mut components = Array2::zeros((rank, dims));
        for (row, mut component) in components.axis_iter_mut(Axis(0)).enumerate() {
            eigenvalues[row] = values[row];
            let direction = directions.row(row);
            let length = direction.dot(&direction).sqrt();
            for (&column, share) in varying.iter().zip(direction) {
                component[column] = *share / length;
            }
            fix_sign(component);
        }
        Ok(Self {
            mean,
            eigenvalues,
            components,
        })
    }

    /// Returns the fewest components that hold `share` (0..1) of the variance; at least 1 if any
    /// varies.
    #[must_use]
    pub(crate) fn components_for(&self, share: f64) -> usize {
        let rank = self.components.nrows();
        let wanted = F::nearest(share) * self.eigenvalues.sum();
        let mut held = F::zero();
        for (index, &value) in self.eigenvalues.iter().take(rank).enumerate() {
            held += value;
            if held >= wanted {
                return index + 1;
            }
        }
        rank
    }

    /// Returns how many components are kept.
    ///
    /// # Errors
    /// If a share is not above 0 and at most 1, or a count is 0.
    pub(crate) fn kept(&self, components: Components) -> Result<usize> {
        let (expected, found) = match components {
            Components::Variance(share) if share > 0.0 && share <= 1.0 => {
                return Ok(self.components_for(share));
            }
            Components::Count(count) if count > 0 => {
                return Ok(count.min(self.components.nrows()));
            }
            Components::Variance(share) => ("a share of variance above 0 and at most 1", share),
            Components::Count(_) => ("at least 1 principal component", 0.0),
        };
        Err(TrainError::OutOfRange { expected, found }.into())
    }

    /// Returns the coordinates of `samples` along the first `count` components, one sample a row.
    #[must_use]
    pub(crate) fn project<T: Copy + Into<F>>(
        &self,
        samples: ArrayView2<'_, T>,
        count: usize,
    ) -> Array2<F> {
        let components = self
            .components
            .slice(s![..count.min(self.components.nrows()), ..]);
        let mut projected = Array2::zeros((samples.nrows(), components.nrows()));
        for (part, mut into) in samples
            .axis_chunks_iter(Axis(0), ROWS_AT_ONCE)
            .zip(projected.axis_chunks_iter_mut(Axis(0), ROWS_AT_ONCE))
        {
            let mut centred = part.mapv(Into::into);
            centred -= &self.mean;
            into.assign(&multiply(centred.view(), components.t()));
        }
        projected
    }
}

/// Checks that all numbers are finite. Returns the mean, and the columns that are not constant.
fn mean_and_varying<T: Copy + Into<F>, F: Real>(
    samples: ArrayView2<'_, T>,
) -> Result<(Array1<F>, Vec<usize>)> {
    let first = samples.row(0).mapv(Into::<F>::into);
    let mut excess: Array1<F> = Array1::zeros(samples.ncols());
    let mut varies = vec![false; samples.ncols()];
    for (row, sample) in samples.outer_iter().enumerate() {
        for (column, &value) in sample.iter().enumerate() {
            let difference = finite(value.into(), row, column)? - first[column];
            varies[column] |= difference != F::zero();
            excess[column] += difference;
        }
    }
    let mean = first + excess / F::nearest(samples.nrows() as f64);
    let varying = (0..varies.len()).filter(|&column| varies[column]).collect();
    Ok((mean, varying))
}

/// Returns the varying columns of `samples`, centred.
fn centred<T: Copy + Into<F>, F: Real>(
    samples: ArrayView2<'_, T>,
    mean: &Array1<F>,
    varying: &[usize],
) -> Array2<F> {
    Array2::from_shape_fn((samples.nrows(), varying.len()), |(row, column)| {
        let column = varying[column];
        samples[[row, column]].into() - mean[column]
    })
}

fn through_covariance<T: Copy + Into<F>, F: Real>(
    samples: ArrayView2<'_, T>,
    mean: &Array1<F>,
    varying: &[usize],
) -> Result<(Vec<F>, Array2<F>)> {
    let mut covariance = Array2::zeros((varying.len(), varying.len()));
    for part in samples.axis_chunks_iter(Axis(0), ROWS_AT_ONCE) {
        add_products_of_columns(centred(part, mean, varying).view(), &mut covariance);
    }
    covariance /= F::nearest((samples.nrows() - 1) as f64);
    let found = eigen(&covariance)?;
    Ok((found.values, found.vectors))
}

/// Finds the components through the Gram matrix: if `X X^T u = s u` then
/// `X^T X (X^T u) = s (X^T u)` (Turk and Pentland, 1991, section 2).
fn through_gram<T: Copy + Into<F>, F: Real>(
    samples: ArrayView2<'_, T>,
    mean: &Array1<F>,
    varying: &[usize],
) -> Result<(Vec<F>, Array2<F>)> {
    let centred = centred(samples, mean, varying);
    let mut gram = Array2::zeros((samples.nrows(), samples.nrows()));
    add_products_of_columns(centred.t(), &mut gram);
    gram /= F::nearest((samples.nrows() - 1) as f64);
    let found = eigen(&gram)?;
    Ok((found.values, multiply(found.vectors.view(), centred.view())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::testing::{jacobi, noise};
    use ndarray::array;

    fn close(a: f64, b: f64, tolerance: f64) -> bool {
        (a - b).abs() <= tolerance * (1.0 + b.abs())
    }

    #[test]
    fn three_points_on_a_line_have_the_eigenvalues_5_and_0() {
        // The covariance is [[1, 2], [2, 4]]; the component is (1, 2) / sqrt(5).
        let pca =
            Pca::<f64>::fit(array![[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]].view()).expect("varies");
        assert_eq!(pca.mean, array![2.0, 4.0]);
        assert!(close(pca.eigenvalues[0], 5.0, 1e-14));
        assert_eq!(pca.eigenvalues[1], 0.0);
        assert_eq!(pca.components.dim(), (1, 2));
        assert!((pca.components[[0, 0]] - 0.447_214).abs() < 1e-6);
        assert!((pca.components[[0, 1]] - 0.894_427).abs() < 1e-6);
    }

    /// Compares with the eigenvalues of the covariance found by Jacobi rotations.
    fn assert_agrees_with_jacobi(samples: &Array2<f64>) {
        let pca = Pca::<f64>::fit(samples.view()).expect("varies");
        let dims = samples.ncols();
        let mut covariance = vec![vec![0.0; dims]; dims];
        for sample in samples.outer_iter() {
            for i in 0..dims {
                for j in 0..dims {
                    covariance[i][j] += (sample[i] - pca.mean[i]) * (sample[j] - pca.mean[j])
                        / (samples.nrows() - 1) as f64;
                }
            }
        }
        let (values, vectors) = jacobi(covariance);
        for (index, component) in pca.components.outer_iter().enumerate() {
            assert!(
                close(pca.eigenvalues[index], values[index], 1e-10),
                "eigenvalue {index}"
            );
            let cosine: f64 = component
                .iter()
                .zip(&vectors[index])
                .map(|(a, b)| a * b)
                .sum();
            assert!(
                (cosine.abs() - 1.0).abs() < 1e-9,
                "component {index}: cosine {cosine}"
            );
            let largest = component
                .iter()
                .copied()
                .max_by(|a, b| a.abs().total_cmp(&b.abs()));
            assert!(largest.is_some_and(|c| c > 0.0));
        }
        let rank = pca.components.nrows();
        assert!(
            values[rank..]
                .iter()
                .all(|value| value.abs() < 1e-9 * values[0])
        );
        for i in 0..rank {
            for j in 0..rank {
                let dot = pca.components.row(i).dot(&pca.components.row(j));
                assert!(
                    (dot - f64::from(u8::from(i == j))).abs() < 1e-6,
                    "{i} {j} {dot}"
                );
            }
        }
    }

    #[test]
    fn many_samples_agree_with_jacobi_rotations() {
        assert_agrees_with_jacobi(&noise(90, 12, 1));
    }

    #[test]
    fn fewer_samples_than_dimensions_agree_with_jacobi_rotations() {
        assert_agrees_with_jacobi(&noise(7, 15, 2));
    }

    #[test]
    fn constant_and_repeated_pixels_leave_no_nan() {
        let mut samples = noise(40, 8, 3);
        samples.column_mut(2).fill(0.1);
        let copy = samples.column(1).to_owned();
        samples.column_mut(5).assign(&copy);
        let pca = Pca::<f64>::fit(samples.view()).expect("varies");
        assert_eq!(pca.components.nrows(), 6);
        assert_eq!(pca.mean[2], 0.1);
        assert!(pca.components.column(2).iter().all(|c| *c == 0.0));
        assert!(
            pca.components
                .iter()
                .chain(&pca.eigenvalues)
                .all(|c| c.is_finite())
        );
        assert_agrees_with_jacobi(&samples);
    }

    #[test]
    fn samples_that_are_all_equal_have_no_component() {
        let pca = Pca::<f64>::fit(Array2::<f32>::from_elem((5, 4), 0.3).view()).expect("finite");
        assert_eq!(pca.components.nrows(), 0);
        assert_eq!(pca.eigenvalues, Array1::<f64>::zeros(4));
        assert_eq!(pca.components_for(0.95), 0);
    }

    #[test]
    fn one_sample_and_a_nan_are_refused() {
        assert!(Pca::<f64>::fit(array![[1.0, 2.0]].view()).is_err());
        let error = Pca::<f64>::fit(array![[1.0, 2.0], [f64::NAN, 1.0]].view()).expect_err("a NaN");
        assert_eq!(
            error.to_string(),
            "sample 1 has a value at 0 that is not a finite number"
        );
    }

    #[test]
    fn projected_samples_have_the_eigenvalues_as_variances() {
        let samples = noise(700, 9, 4);
        let pca = Pca::<f64>::fit(samples.view()).expect("varies");
        let projected = pca.project(samples.view(), 3);
        for (column, value) in projected.axis_iter(Axis(1)).zip(&pca.eigenvalues) {
            let variance = column.dot(&column) / 699.0;
            assert!(close(variance, *value, 1e-11), "{variance} {value}");
        }
    }

    #[test]
    fn half_of_the_variance_needs_one_component_of_three() {
        let pca = Pca {
            mean: Array1::zeros(3),
            eigenvalues: array![6.0, 3.0, 1.0],
            components: Array2::eye(3),
        };
        assert_eq!(
            [0.5, 0.6, 0.7, 0.9, 0.95, 1.0].map(|s| pca.components_for(s)),
            [1, 1, 2, 2, 3, 3]
        );
    }
}

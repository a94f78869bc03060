//! Linear discriminant analysis: the directions that separate classes.
//!
//! Fisher's criterion for several classes (Rao 1948; Han and Bhanu 2006 use it
//! on GEIs after PCA): the ratio of the scatter between class means to the
//! scatter within classes. The within scatter is whitened, so that plain
//! Euclidean distance in the result is the Mahalanobis distance of the input.

use ndarray::{Array1, Array2, ArrayView2, Axis, s};

use super::linear_algebra::{Real, add_products_of_columns, eigen, finite, fix_sign, multiply};
use crate::error::{Result, TrainError};

/// Directions that separate classes, best first.
#[derive(Clone, Debug)]
pub(crate) struct Lda<F> {
    /// One direction a row (at most classes - 1), scaled so that the variance within classes,
    /// ridge included, is 1 along it and 0 across.
    pub directions: Array2<F>,
    /// The variance between class means over the variance within classes along each direction,
    /// descending.
    #[cfg_attr(not(test), expect(dead_code, reason = "read by tests only"))]
    pub ratios: Array1<F>,
}

/// The number of samples of each class, and their mean, one class a row.
pub(crate) struct Classes<F> {
    pub counts: Vec<usize>,
    pub means: Array2<F>,
}

impl<F: Real> Classes<F> {
    /// Checks the labels and averages the samples of each class.
    ///
    /// # Errors
    /// As [`Self::averaged`], and for two classes with the same mean.
    pub(super) fn average<T: Copy + Into<F>>(
        samples: ArrayView2<'_, T>,
        labels: &[usize],
        classes: usize,
    ) -> Result<Self> {
        let classes = Self::averaged(samples, labels, classes)?;
        classes.refuse_equal_means()?;
        Ok(classes)
    }

    /// Checks the labels and averages the samples of each class. Classes may have the same mean, as
    /// they do along the first component of images and their mirror images.
    ///
    /// # Errors
    /// If there are fewer than two classes, a label outside them, a number that is not finite, or a
    /// class without samples.
    pub(crate) fn averaged<T: Copy + Into<F>>(
        samples: ArrayView2<'_, T>,
        labels: &[usize],
        classes: usize,
    ) -> Result<Self> {
        if classes < 2 {
            return Err(TrainError::TooFewClasses(classes).into());
        }
        if labels.len() != samples.nrows() {
            return Err(TrainError::Labels {
                labels: labels.len(),
                samples: samples.nrows(),
            }
            .into());
        }
        let mut counts = vec![0; classes];
        let mut means = Array2::zeros((classes, samples.ncols()));
        for (row, (sample, &label)) in samples.outer_iter().zip(labels).enumerate() {
            let Some(count) = counts.get_mut(label) else {
                return Err(TrainError::Label {
                    row,
                    label,
                    classes,
                }
                .into());
            };
            *count += 1;
            for (column, (sum, &value)) in means.row_mut(label).iter_mut().zip(sample).enumerate() {
                *sum += finite(value.into(), row, column)?;
            }
        }
        for (class, (mut mean, &count)) in means.outer_iter_mut().zip(&counts).enumerate() {
            if count == 0 {
                return Err(TrainError::EmptyClass(class).into());
            }
            mean /= F::nearest(count as f64);
        }
        Ok(Self { counts, means })
    }

    fn refuse_equal_means(&self) -> Result<()> {
        let scale = self.means.iter().fold(F::zero(), |m, v| m.max(v.abs()));
        for (second, b) in self.means.outer_iter().enumerate() {
            for (first, a) in self.means.outer_iter().take(second).enumerate() {
                if a.iter()
                    .zip(b)
                    .all(|(&a, &b)| (a - b).abs() <= F::TOLERANCE * scale)
                {
                    return Err(TrainError::SameMean(first, second).into());
                }
            }
        }
        Ok(())
    }
}

impl<F: Real> Lda<F> {
    /// Finds the directions that separate the classes of `points` (one a row).
    ///
    /// `ridge` times the mean total variance of a dimension is added to the variance within
    /// classes in every direction, so that directions in which the few training samples happen
    /// not to vary cannot dominate.
    ///
    /// # Errors
    /// If there are fewer than two classes, a class has no sample, two classes have the same
    /// mean, or the ridge is not above zero.
    pub(crate) fn fit(
        points: ArrayView2<'_, F>,
        labels: &[usize],
        classes: usize,
        ridge: f64,
    ) -> Result<Self> {
        if !(ridge > 0.0 && ridge.is_finite()) {
            return Err(TrainError::OutOfRange {
                expected: "a ridge above 0",
                found: ridge,
            }
            .into());
        }
        let count = points.nrows();
        let of = Classes::<F>::average(points, labels, classes)?;
        let scatter = Scatter::compute(points, labels, &of);
        discriminants(scatter, count, classes, ridge, classes - 1)
    }
}

/// The scatter of samples within and between classes.
pub(crate) struct Scatter<F> {
    /// Lower triangle of the sum of the products of differences from the class mean.
    pub within: Array2<F>,
    /// Differences of class means from the mean of all, one a row, times the square root of the
    /// number of samples in the class.
    pub offsets: Array2<F>,
}

impl<F: Real> Scatter<F> {
    /// Computes the scatter of samples, one a row, in these classes.
    pub(crate) fn compute(points: ArrayView2<'_, F>, labels: &[usize], of: &Classes<F>) -> Self {
        let (count, dims) = points.dim();
        let mean = points.sum_axis(Axis(0)) / F::nearest(count as f64);
        let mut deviations = points.to_owned();
        for (mut deviation, &label) in deviations.outer_iter_mut().zip(labels) {
            deviation -= &of.means.row(label);
        }
        let mut within = Array2::zeros((dims, dims));
        add_products_of_columns(deviations.view(), &mut within);
        let mut offsets = &of.means - &mean;
        for (mut offset, &count) in offsets.outer_iter_mut().zip(&of.counts) {
            offset *= F::nearest((count as f64).sqrt());
        }
        Self { within, offsets }
    }
}

/// Finds at most `most` directions that separate the `classes`, from the scatter of `count`
/// samples.
///
/// # Errors
/// If the scatter within classes is not positive definite in spite of the ridge.
pub(crate) fn discriminants<F: Real>(
    scatter: Scatter<F>,
    count: usize,
    classes: usize,
    ridge: f64,
    most: usize,
) -> Result<Lda<F>> {
    let Scatter {
        mut within,
        offsets,
    } = scatter;
    let dims = within.nrows();
    let between_trace = offsets.iter().fold(F::zero(), |sum, &v| sum + v * v);
    let total_variance = (within.diag().sum() + between_trace) / F::nearest((count - 1) as f64);

    within /= F::nearest(count.saturating_sub(classes).max(1) as f64);
    within
        .diag_mut()
        .mapv_inplace(|v| v + F::nearest(ridge) * total_variance / F::nearest(dims as f64));
    let whitening = whitening(&within)?;
    let whitened = multiply(offsets.view(), whitening.t());
    let mut between = Array2::zeros((dims, dims));
    add_products_of_columns(whitened.view(), &mut between);
    between /= F::nearest((classes - 1) as f64);
    let found = eigen(&between)?;

    let floor = F::TOLERANCE * found.values[0];
    let rank = found
        .values
        .iter()
        .take(most)
        .take_while(|v| **v > floor)
        .count();
    let mut directions = multiply(found.vectors.slice(s![..rank, ..]), whitening.view());
    directions.outer_iter_mut().for_each(fix_sign);
    Ok(Lda {
        directions,
        ratios: found.values[..rank].iter().copied().collect(),
    })
}

/// Returns a matrix `w` for which `w within w^T` is the identity.
fn whitening<F: Real>(within: &Array2<F>) -> Result<Array2<F>> {
    let mut found = eigen(within)?;
    for (mut vector, &value) in found.vectors.outer_iter_mut().zip(&found.values) {
        if value <= F::zero() {
            return Err(TrainError::NotInvertible.into());
        }
        vector /= value.sqrt();
    }
    Ok(found.vectors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::testing::{noise, solve};
    use ndarray::array;

    /// Draws `classes` clouds of noise around different points, labelled round robin.
    fn clouds(count: usize, dims: usize, classes: usize) -> (Array2<f64>, Vec<usize>) {
        let centres = noise(classes, dims, 77) * 2.0;
        let labels: Vec<usize> = (0..count).map(|i| i % classes).collect();
        let mut points = noise(count, dims, 5);
        for (mut point, &label) in points.outer_iter_mut().zip(&labels) {
            point += &centres.row(label);
        }
        (points, labels)
    }

    /// Computes the scatter within (with ridge) and between classes by plain loops.
    fn scatters(
        points: &Array2<f64>,
        labels: &[usize],
        classes: usize,
        ridge: f64,
    ) -> [Array2<f64>; 2] {
        let (n, d) = points.dim();
        let mean_of = |keep: &dyn Fn(usize) -> bool| -> Vec<f64> {
            let rows: Vec<usize> = (0..n).filter(|&i| keep(labels[i])).collect();
            (0..d)
                .map(|j| rows.iter().map(|&i| points[[i, j]]).sum::<f64>() / rows.len() as f64)
                .collect()
        };
        let overall = mean_of(&|_| true);
        let mut within = Array2::zeros((d, d));
        let mut between = Array2::zeros((d, d));
        let mut total = 0.0;
        for i in 0..n {
            let mean = mean_of(&|label| label == labels[i]);
            for a in 0..d {
                total += (points[[i, a]] - overall[a]).powi(2) / (n - 1) as f64;
                for b in 0..d {
                    within[[a, b]] += (points[[i, a]] - mean[a]) * (points[[i, b]] - mean[b])
                        / (n - classes) as f64;
                    between[[a, b]] +=
                        (mean[a] - overall[a]) * (mean[b] - overall[b]) / (classes - 1) as f64;
                }
            }
        }
        for a in 0..d {
            within[[a, a]] += ridge * total / d as f64;
        }
        [within, between]
    }

    #[test]
    fn two_classes_are_told_apart_along_fishers_direction() {
        // Fisher 1936: the inverse of the within scatter times the difference of the means.
        let (points, labels) = clouds(60, 3, 2);
        let lda = Lda::<f64>::fit(points.view(), &labels, 2, 1e-9).expect("two classes");
        assert_eq!(lda.directions.dim(), (1, 3));
        let [within, _] = scatters(&points, &labels, 2, 1e-9);
        let means = Classes::average(points.view(), &labels, 2)
            .expect("two classes")
            .means;
        let fisher = solve(within, &(&means.row(1) - &means.row(0)));
        let found = lda.directions.row(0);
        let cosine = found.dot(&fisher) / (found.dot(&found) * fisher.dot(&fisher)).sqrt();
        assert!((cosine.abs() - 1.0).abs() < 1e-12, "cosine {cosine}");
    }

    #[test]
    fn directions_solve_the_generalised_eigenproblem() {
        let (points, labels) = clouds(80, 6, 4);
        let ridge = 0.01;
        let lda = Lda::<f64>::fit(points.view(), &labels, 4, ridge).expect("four classes");
        assert_eq!(lda.directions.dim(), (3, 6));
        let [within, between] = scatters(&points, &labels, 4, ridge);
        for (i, (direction, ratio)) in lda.directions.outer_iter().zip(&lda.ratios).enumerate() {
            let residual = between.dot(&direction) - within.dot(&direction) * *ratio;
            assert!(residual.iter().all(|r| r.abs() < 1e-9), "{residual}");
            for (j, other) in lda.directions.outer_iter().enumerate() {
                let expected = f64::from(u8::from(i == j));
                assert!((direction.dot(&within.dot(&other)) - expected).abs() < 1e-10);
            }
        }
        assert!(
            lda.ratios
                .windows(2)
                .into_iter()
                .all(|pair| pair[0] >= pair[1])
        );
    }

    #[test]
    fn classes_on_a_line_need_one_direction() {
        let points = array![
            [0.0, 0.1],
            [0.0, -0.1],
            [1.0, 0.1],
            [1.0, -0.1],
            [2.0, 0.1],
            [2.0, -0.1]
        ];
        let lda =
            Lda::<f64>::fit(points.view(), &[0, 0, 1, 1, 2, 2], 3, 1e-3).expect("three classes");
        assert_eq!(lda.directions.nrows(), 1);
        assert!(lda.directions[[0, 0]] > 0.0 && lda.directions[[0, 1]].abs() < 1e-9);
    }

    #[test]
    fn classes_of_one_sample_each_are_learnt_from_the_ridge_alone() {
        let points = array![[0.0, 1.0], [3.0, 0.0], [1.0, 5.0]];
        let lda = Lda::<f64>::fit(points.view(), &[0, 1, 2], 3, 1e-3).expect("three classes");
        assert!(lda.directions.iter().all(|v| v.is_finite()));
    }

    fn refusal(points: Array2<f64>, labels: &[usize], classes: usize) -> String {
        Lda::<f64>::fit(points.view(), labels, classes, 1e-3)
            .expect_err("nothing to learn")
            .to_string()
    }

    #[test]
    fn one_class_is_refused() {
        let text = refusal(array![[0.0], [1.0]], &[0, 0], 1);
        assert_eq!(text, "training needs at least 2 classes, found 1");
    }

    #[test]
    fn identical_classes_are_refused_by_number() {
        let text = refusal(array![[0.0, 1.0], [9.0, 9.0], [0.0, 1.0]], &[0, 1, 2], 3);
        assert!(
            text.starts_with("classes 0 and 2 have the same mean"),
            "{text}"
        );
        let text = refusal(Array2::zeros((4, 2)), &[0, 1, 0, 1], 2);
        assert!(
            text.starts_with("classes 0 and 1 have the same mean"),
            "{text}"
        );
    }

    #[test]
    fn a_class_without_samples_and_a_label_out_of_range_are_refused() {
        assert_eq!(
            refusal(array![[0.0], [1.0]], &[0, 0], 2),
            "class 1 has no sample to learn from"
        );
        assert_eq!(
            refusal(array![[0.0], [1.0]], &[0, 5], 2),
            "sample 1: expected a label below 2, found 5"
        );
        assert_eq!(
            refusal(array![[0.0], [1.0]], &[0], 2),
            "expected a label per sample, found 1 for 2"
        );
    }
}

//! Linear support vector machines, one for each class against the rest.
//!
//! With y = 1 for the class and -1 for the rest, each minimises
//! `|w|^2 / 2 + C sum max(0, 1 - y w.x)^2` (L2 regularisation, L2 loss; LIBLINEAR's `-s 1 -B 1`),
//! where x ends in a 1 so that the last weight is the bias. The paper (Charalambous and Bharath,
//! BMVC 2016) states neither kernel, C nor scheme: linear, 1 and one against the rest are our
//! choices.

use ndarray::{Array1, Array2, ArrayView2, Axis, s};
use rayon::prelude::*;

use super::lda::Classes;
use super::linear_algebra::{Real, add_products_of_columns, solve_positive};
use crate::error::{Result, TrainError};

/// The maximum number of Newton steps. Our choice: some 10 times what GEIs need.
const MAX_STEPS: usize = 200;

/// Halvings in the search along a step: to 1e-12 of it.
const HALVINGS: usize = 40;

/// One linear function per class; the highest decides.
#[derive(Clone, Debug)]
pub(crate) struct Svm<F> {
    /// One class a row, one weight per dimension.
    pub weights: Array2<F>,
    /// The bias of each class.
    pub bias: Array1<F>,
}

impl<F: Real> Svm<F> {
    /// Learns to separate the classes of `points` (one a row), with errors weighted by `c`.
    ///
    /// Newton's method on the weights (Keerthi and DeCoste, "A modified finite Newton method for
    /// fast solution of large scale linear SVMs", JMLR 6, 2005), since there are never more
    /// principal components than samples: about 10 steps of `samples * dims^2` multiplications a
    /// class, and less for each tenfold of `c`. It ends when the duality gap is at most
    /// [`Real::GAP`] of the objective.
    ///
    /// # Errors
    /// If there are fewer than two classes, a class has no sample, a number or `c` is not finite,
    /// `c` is not above 0, or rounding keeps the gap open.
    ///
    /// # Guarantees
    /// Equal input gives equal bits, with any number of threads.
    pub(crate) fn fit(
        points: ArrayView2<'_, F>,
        labels: &[usize],
        classes: usize,
        c: f64,
    ) -> Result<Self> {
        if !(c > 0.0 && c.is_finite()) {
            return Err(TrainError::OutOfRange {
                expected: "a C above 0",
                found: c,
            }
            .into());
        }
        Classes::<F>::averaged(points, labels, classes)?;
        let dims = points.ncols();
        let mut inputs = Array2::ones((points.nrows(), dims + 1));
        inputs.slice_mut(s![.., ..dims]).assign(&points);
        let functions = (0..classes).into_par_iter().map(|class| {
            let signs = labels
                .iter()
                .map(|&label| if label == class { F::one() } else { -F::one() })
                .collect();
            one_against_the_rest(&inputs, &signs, c).map_err(|gap| TrainError::DualityGap {
                class,
                expected: F::GAP,
                found: gap,
                c,
            })
        });
        let functions: Vec<Array1<F>> = functions.collect::<std::result::Result<_, _>>()?;
        let mut weights = Array2::zeros((classes, dims));
        for (mut row, function) in weights.outer_iter_mut().zip(&functions) {
            row.assign(&function.slice(s![..dims]));
        }
        Ok(Self {
            weights,
            bias: functions.iter().map(|function| function[dims]).collect(),
        })
    }
}

/// Finds the weights for `inputs` (one a row). The error is the relative duality gap that stays
/// open.
///
/// A small C is solved first, and each solution is the start for ten times that C: from zero, a
/// large C takes hundreds of steps.
fn one_against_the_rest<F: Real>(
    inputs: &Array2<F>,
    signs: &Array1<F>,
    c: f64,
) -> std::result::Result<Array1<F>, f64> {
    let squares: f64 = inputs.iter().map(|&v| (v * v).into()).sum();
    // Where one sample at the mean distance pulls about as much as the regulariser.
    let mut stage = c.min(inputs.nrows() as f64 / squares);
    let mut weights = Array1::zeros(inputs.ncols());
    loop {
        weights = descend(inputs, signs, stage, weights)?;
        if stage == c {
            return Ok(weights);
        }
        stage = c.min(10.0 * stage);
    }
}

/// Applies Newton's method from these weights.
fn descend<F: Real>(
    inputs: &Array2<F>,
    signs: &Array1<F>,
    c: f64,
    mut weights: Array1<F>,
) -> std::result::Result<Array1<F>, f64> {
    let twice_c = F::nearest(2.0 * c);
    let slacks = |margins: &Array1<F>| margins.mapv(|margin| (F::one() - margin).max(F::zero()));
    let mut relative_gap = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        let margins = inputs.dot(&weights) * signs;
        let slack = slacks(&margins);
        let violators: Vec<usize> = (0..slack.len()).filter(|&i| slack[i] > F::zero()).collect();
        let violating = inputs.select(Axis(0), &violators);
        let pulls: Array1<F> = violators
            .iter()
            .map(|&i| twice_c * slack[i] * signs[i])
            .collect();
        let gradient = &weights - &violating.t().dot(&pulls);
        // With the dual variables at their best for these weights, 2C times the slacks, the
        // duality gap is exactly half the squared gradient.
        let gap: f64 = (gradient.dot(&gradient)).into() / 2.0;
        let objective =
            weights.dot(&weights).into() / 2.0 + c * Into::<f64>::into(slack.dot(&slack));
        relative_gap = gap / objective;
        if relative_gap <= F::GAP {
            return Ok(weights);
        }
        let mut hessian = Array2::zeros((inputs.ncols(), inputs.ncols()));
        add_products_of_columns(violating.view(), &mut hessian);
        hessian *= twice_c;
        hessian.diag_mut().mapv_inplace(|v| v + F::one());
        let step = solve_positive(&hessian, -gradient).ok_or(relative_gap)?;
        // The objective along the step is convex: go to where its slope is 0, or the whole step.
        let changes = inputs.dot(&step) * signs;
        let slope = |share: F| {
            let slack = slacks(&(&margins + &(&changes * share)));
            (&weights + &(&step * share)).dot(&step) - twice_c * slack.dot(&changes)
        };
        let share = if slope(F::one()) <= F::zero() {
            F::one()
        } else {
            root(slope)
        };
        weights.scaled_add(share, &step);
    }
    Err(relative_gap)
}

/// Finds where in 0..1 a rising function changes its sign.
fn root<F: Real>(rising: impl Fn(F) -> F) -> F {
    let (mut low, mut high) = (F::zero(), F::one());
    for _ in 0..HALVINGS {
        let middle = (low + high) / F::nearest(2.0);
        if rising(middle) <= F::zero() {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::testing::noise;
    use ndarray::{array, concatenate};

    /// Draws `classes` overlapping clouds, labelled round robin.
    fn clouds(count: usize, dims: usize, classes: usize) -> (Array2<f64>, Vec<usize>) {
        let centres = noise(classes, dims, 41);
        let labels: Vec<usize> = (0..count).map(|i| i % classes).collect();
        let mut points = noise(count, dims, 42);
        for (mut point, &label) in points.outer_iter_mut().zip(&labels) {
            point += &centres.row(label);
        }
        (points, labels)
    }

    /// Computes the objective by plain loops.
    fn objective(points: &Array2<f64>, signs: &[f64], c: f64, w: &[f64], bias: f64) -> f64 {
        let mut sum = (w.iter().map(|w| w * w).sum::<f64>() + bias * bias) / 2.0;
        for (point, sign) in points.outer_iter().zip(signs) {
            let value = point.iter().zip(w).map(|(x, w)| x * w).sum::<f64>() + bias;
            sum += c * (1.0 - sign * value).max(0.0).powi(2);
        }
        sum
    }

    /// Solves by an independent method: dual coordinate descent, samples in cyclic order (Hsieh,
    /// Chang, Lin, Keerthi and Sundararajan, "A dual coordinate descent method for large-scale
    /// linear SVM", ICML 2008, algorithm 1 for the L2 loss): another problem, another method, no
    /// linear algebra.
    fn dual_descent(points: &Array2<f64>, signs: &[f64], c: f64) -> (Vec<f64>, f64) {
        let (mut w, mut bias) = (vec![0.0; points.ncols()], 0.0);
        let mut alphas = vec![0.0; signs.len()];
        for _ in 0..20_000 {
            for (i, point) in points.outer_iter().enumerate() {
                let value = point.iter().zip(&w).map(|(x, w)| x * w).sum::<f64>() + bias;
                let gradient = signs[i] * value - 1.0 + alphas[i] / (2.0 * c);
                let curvature = point.iter().map(|x| x * x).sum::<f64>() + 1.0 + 0.5 / c;
                let next = f64::max(alphas[i] - gradient / curvature, 0.0);
                let step = (next - alphas[i]) * signs[i];
                alphas[i] = next;
                bias += step;
                for (w, x) in w.iter_mut().zip(point) {
                    *w += step * x;
                }
            }
        }
        (w, bias)
    }

    fn signs(labels: &[usize], class: usize) -> Vec<f64> {
        let sign = |&label: &usize| if label == class { 1.0 } else { -1.0 };
        labels.iter().map(sign).collect()
    }

    #[test]
    fn dual_coordinate_descent_finds_the_same_solution() {
        for (count, dims, classes, c) in [
            (90, 4, 3, 1.0),
            (60, 7, 2, 0.01),
            (40, 3, 4, 3.0),
            (9, 14, 3, 1.0),
        ] {
            let (points, labels) = clouds(count, dims, classes);
            let svm = Svm::fit(points.view(), &labels, classes, c).expect("clouds");
            for class in 0..classes {
                let signs = signs(&labels, class);
                let (w, bias) = dual_descent(&points, &signs, c);
                let found = svm.weights.row(class).to_vec();
                let ours = objective(&points, &signs, c, &found, svm.bias[class]);
                let theirs = objective(&points, &signs, c, &w, bias);
                assert!((ours - theirs).abs() < 1e-6 * theirs, "{ours} {theirs}");
                assert!(ours <= theirs * (1.0 + 1e-10), "{ours} {theirs}");
                for (a, b) in found.iter().zip(&w) {
                    assert!((a - b).abs() < 1e-4, "{a} {b}");
                }
            }
        }
    }

    /// For points at -1 and 1 the objective is `w^2 / 2 + 2C (1 - w)^2`, least at 4C / (1 + 4C).
    #[test]
    fn two_points_have_the_solution_of_a_parabola() {
        for c in [1e-3, 1.0, 1e6] {
            let svm = Svm::fit(array![[-1.0], [1.0]].view(), &[0, 1], 2, c).expect("two classes");
            let expected = 4.0 * c / (1.0 + 4.0 * c);
            assert!((svm.weights[[1, 0]] - expected).abs() < 1e-6, "{svm:?}");
            assert!((svm.weights[[0, 0]] + expected).abs() < 1e-6);
            assert!(svm.bias.iter().all(|bias| bias.abs() < 1e-6));
        }
    }

    /// The widest street between the sides of a rectangle runs down its middle: w = (1, 0).
    #[test]
    fn separable_points_at_a_large_c_get_the_widest_margin() {
        let points: Array2<f64> = array![
            [1.0, 5.0],
            [1.0, -3.0],
            [-1.0, 2.0],
            [-1.0, -7.0],
            [4.0, 0.0]
        ];
        let svm = Svm::fit(points.view(), &[1, 1, 0, 0, 1], 2, 1e9).expect("separable");
        let margins = points.dot(&svm.weights.row(1)) + svm.bias[1];
        assert!((svm.weights[[1, 0]] - 1.0).abs() < 1e-5, "{svm:?}");
        assert!(svm.weights[[1, 1]].abs() < 1e-5 && svm.bias[1].abs() < 1e-5);
        for (margin, expected) in margins.iter().zip([1.0, 1.0, -1.0, -1.0, 4.0]) {
            assert!((margin - expected).abs() < 1e-4);
        }
    }

    #[test]
    fn every_sample_twice_is_the_solution_for_twice_the_c() {
        let (points, labels) = clouds(50, 5, 3);
        let twice = concatenate![Axis(0), points, points];
        let doubled = Svm::fit(twice.view(), &[&labels[..], &labels].concat(), 3, 0.7);
        let heavier = Svm::fit(points.view(), &labels, 3, 1.4).expect("three clouds");
        for (a, b) in doubled
            .expect("three clouds")
            .weights
            .iter()
            .zip(&heavier.weights)
        {
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }

    #[test]
    fn a_sample_in_two_classes_gets_equal_scores_for_both() {
        let points = array![[-1.0], [0.0], [0.0], [1.0]];
        let svm = Svm::<f64>::fit(points.view(), &[0, 0, 1, 1], 2, 1.0).expect("two classes");
        assert!((svm.bias[0] - svm.bias[1]).abs() < 1e-9, "{svm:?}");
        assert!(svm.weights[[1, 0]] > 0.1);
    }

    fn refusal(points: Array2<f64>, labels: &[usize], classes: usize, c: f64) -> String {
        let refused = Svm::fit(points.view(), labels, classes, c);
        refused.expect_err("nothing to learn").to_string()
    }

    #[test]
    fn what_cannot_be_learnt_from_is_refused() {
        let two = array![[0.0], [1.0]];
        assert_eq!(
            refusal(two.clone(), &[0, 0], 1, 1.0),
            "training needs at least 2 classes, found 1"
        );
        assert_eq!(
            refusal(two.clone(), &[0, 1], 2, 0.0),
            "expected a C above 0, found 0"
        );
        assert!(refusal(two, &[0, 1], 2, f64::NAN).ends_with("found NaN"));
        let text = refusal(array![[0.0], [f64::NAN]], &[0, 1], 2, 1.0);
        assert_eq!(
            text,
            "sample 1 has a value at 0 that is not a finite number"
        );
    }

    #[test]
    fn classes_of_one_mean_are_told_apart_where_they_can_be() {
        // Images and their mirror images along the first component: all means are 0.
        let points = array![[-1.0, 0.1], [1.0, 0.1], [-2.0, -0.1], [2.0, -0.1]];
        let labels = [0, 0, 1, 1];
        let along = points.slice(s![.., ..1]);
        let svm = Svm::<f64>::fit(along, &labels, 2, 1.0).expect("two classes");
        assert!((svm.weights[[0, 0]]).abs() < 1e-9, "{svm:?}");
        let svm = Svm::<f64>::fit(points.view(), &labels, 2, 1.0).expect("two classes");
        assert!(
            svm.weights[[0, 1]] > 0.01 && svm.weights[[1, 1]] < -0.01,
            "{svm:?}"
        );
    }

    #[test]
    fn a_c_beyond_single_precision_is_refused_there() {
        let (points, labels) = clouds(90, 4, 3);
        let text = Svm::fit(points.mapv(|v| v as f32).view(), &labels, 3, 1e12)
            .expect_err("rounding")
            .to_string();
        assert!(
            text.contains("duality gap") && text.contains("smaller C"),
            "{text}"
        );
        assert!(Svm::fit(points.view(), &labels, 3, 1e6).is_ok());
    }
}

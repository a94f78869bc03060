//! A linear classifier that distinguishes two groups of people, judged on people that it was not
//! trained on.

use edgegait::Template;
use edgegait::train::{Analysed, Components, TrainMethod, TrainOptions};
use edgegait_core::silhouette::Size;
use ndarray::{Array2, ArrayView1, s};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// The principal components that the classifier takes, each with variance 1 over the training
/// samples.
const COMPONENTS: usize = 30;
/// The penalty of a squared weight, relative to the evidence of one person. Our choice, not tuned.
const RIDGE: f64 = 1.0;
/// The number of folds of people; each is judged by a classifier trained on the others.
const FOLDS: usize = 10;
/// The number of resamples of people, for intervals.
const RESAMPLES: usize = 1_000;

/// A template of a person of one of two groups.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// The person; nobody is in both groups.
    pub person: usize,
    /// Whether the person is in the first group.
    pub is_first: bool,
    /// The pixels, 0..1.
    pub gei: &'a [f32],
}

/// How often the classifier ranks a cycle of the first group above one of the second.
#[derive(Clone, Debug)]
pub struct Separation {
    first: Vec<usize>,
    second: Vec<usize>,
    /// The share of the pairs of cycles, by person of the first group and of the second.
    won: Array2<f64>,
}

impl Separation {
    /// Judges each person with a classifier trained on other people, on these rows of the image.
    pub fn of(cases: &[Case<'_>], rows: Range<usize>) -> Self {
        Self::by(cases, rows, &folds(cases))
    }

    /// Judges each person with a classifier trained on the other folds.
    pub fn by(cases: &[Case<'_>], rows: Range<usize>, parts: &BTreeMap<usize, usize>) -> Self {
        let pixels = masked(cases, rows);
        let mut scores: BTreeMap<(bool, usize), Vec<f64>> = BTreeMap::new();
        for part in parts.values().collect::<BTreeSet<_>>() {
            let (held, learnt): (Vec<usize>, Vec<usize>) =
                (0..cases.len()).partition(|&at| parts[&cases[at].person] == *part);
            let classifier = Classifier::learn(cases, &pixels, &learnt);
            for at in held {
                let key = (!cases[at].is_first, cases[at].person);
                let score = classifier.score(pixels.row(at));
                scores.entry(key).or_default().push(score);
            }
        }
        let group = |of: bool| scores.iter().filter(move |((second, _), _)| *second == of);
        let names = |of| {
            group(of)
                .map(|((_, person), _)| *person)
                .collect::<Vec<_>>()
        };
        let (first, second) = (names(false), names(true));
        let mut won = Array2::zeros((first.len(), second.len()));
        for (row, (_, ours)) in group(false).enumerate() {
            for (column, (_, theirs)) in group(true).enumerate() {
                let pairs = ours.iter().flat_map(|a| theirs.iter().map(move |b| (a, b)));
                let wins = pairs.map(|(a, b)| {
                    if a == b {
                        0.5
                    } else {
                        f64::from(u8::from(a > b))
                    }
                });
                won[[row, column]] = wins.sum::<f64>() / (ours.len() * theirs.len()) as f64;
            }
        }
        Self { first, second, won }
    }

    /// Returns the area under the ROC curve, in which each person counts `times` times.
    pub fn auc(&self, times: impl Fn(usize) -> f64) -> f64 {
        let (mut won, mut all) = (0.0, 0.0);
        for (row, &first) in self.first.iter().enumerate() {
            for (column, &second) in self.second.iter().enumerate() {
                let weight = times(first) * times(second);
                won += weight * self.won[[row, column]];
                all += weight;
            }
        }
        won / all
    }
}

/// Returns how often each person occurs in each of many resamples, which have the same size and are
/// drawn within the groups.
pub fn resamples(groups: &[usize]) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let members = |group| {
        (0..groups.len())
            .filter(|&at| groups[at] == group)
            .collect()
    };
    let members: Vec<Vec<usize>> = groups.iter().map(|&group| members(group)).collect();
    let draw = |_| {
        let mut times = vec![0.0; groups.len()];
        for of in &members {
            times[of[rng.random_range(0..of.len())]] += 1.0;
        }
        times
    };
    (0..RESAMPLES).map(draw).collect()
}

/// Returns the interval that contains 95 % of these values.
pub fn interval(mut values: Vec<f64>) -> (f64, f64) {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
    (at(0.025), at(0.975))
}

/// Returns the fold of each person, with both groups spread evenly over the folds.
fn folds(cases: &[Case<'_>]) -> BTreeMap<usize, usize> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut folds = BTreeMap::new();
    for group in [true, false] {
        let of = cases.iter().filter(|case| case.is_first == group);
        let mut people: Vec<usize> = of.map(|case| case.person).collect();
        people.sort_unstable();
        people.dedup();
        people.shuffle(&mut rng);
        folds.extend(
            people
                .into_iter()
                .enumerate()
                .map(|(at, person)| (person, at % FOLDS)),
        );
    }
    folds
}

/// Returns the templates, one per row, black outside these rows of the image.
fn masked(cases: &[Case<'_>], rows: Range<usize>) -> Array2<f32> {
    let columns = Size::S50x30.columns();
    let mut pixels = Array2::zeros((cases.len(), Size::S50x30.pixels()));
    let kept = rows.start * columns..rows.end * columns;
    for (case, mut row) in cases.iter().zip(pixels.outer_iter_mut()) {
        let into = row.slice_mut(s![kept.clone()]);
        ArrayView1::from(&case.gei[kept.clone()]).assign_to(into);
    }
    pixels
}

/// A score of templates, above 0 for those similar to the first group's.
struct Classifier {
    /// The map from pixels to principal components.
    components: edgegait::inference::Affine,
    /// A weight for each component, and the constant term.
    weights: Vec<f64>,
    deviations: Vec<f64>,
}

impl Classifier {
    /// Trains on some of the cases. Each person counts once, and so does each group.
    fn learn(cases: &[Case<'_>], pixels: &Array2<f32>, learnt: &[usize]) -> Self {
        let samples = pixels.select(ndarray::Axis(0), learnt);
        let labels: Vec<usize> = learnt
            .iter()
            .map(|&at| usize::from(cases[at].is_first))
            .collect();
        let analysed =
            Analysed::<f64>::analyse(Template::Gei, Size::S50x30, samples.view(), &labels, 2)
                .expect("two groups");
        let options = TrainOptions {
            components: Components::Count(COMPONENTS),
            // The embedding of this method is the principal components.
            method: TrainMethod::Svm { c: 1.0 },
        };
        let components = analysed.fit(options).expect("components").embedding;
        let mut points: Vec<Vec<f64>> = samples
            .outer_iter()
            .map(|row| {
                components
                    .apply(row)
                    .iter()
                    .map(|&x| f64::from(x))
                    .collect()
            })
            .collect();
        let deviation = |at: usize| {
            let squares: f64 = points.iter().map(|point| point[at] * point[at]).sum();
            (squares / points.len() as f64).sqrt()
        };
        let deviations: Vec<f64> = (0..points[0].len()).map(deviation).collect();
        for point in &mut points {
            for (x, deviation) in point.iter_mut().zip(&deviations) {
                *x /= deviation;
            }
            point.push(1.0);
        }
        let mut cycles: BTreeMap<usize, f64> = BTreeMap::new();
        for &at in learnt {
            *cycles.entry(cases[at].person).or_default() += 1.0;
        }
        let mut evidence: Vec<f64> = learnt
            .iter()
            .map(|&at| 1.0 / cycles[&cases[at].person])
            .collect();
        for group in [0, 1] {
            let of = || (0..labels.len()).filter(|&at| labels[at] == group);
            let sum: f64 = of().map(|at| evidence[at]).sum();
            of().for_each(|at| evidence[at] *= 0.5 * cycles.len() as f64 / sum);
        }
        Self {
            components,
            weights: logistic(&points, &labels, &evidence),
            deviations,
        }
    }

    fn score(&self, pixels: ArrayView1<'_, f32>) -> f64 {
        let components = self.components.apply(pixels);
        let terms = components.iter().zip(&self.deviations).zip(&self.weights);
        let sum: f64 = terms
            .map(|((&x, deviation), weight)| f64::from(x) / deviation * weight)
            .sum();
        sum + self.weights[self.weights.len() - 1]
    }
}

/// Returns the weights of a logistic regression with a ridge on all except the last, by Newton's
/// method (iteratively reweighted least squares; Hastie, Tibshirani & Friedman 2009, section
/// 4.4.1).
fn logistic(points: &[Vec<f64>], labels: &[usize], evidence: &[f64]) -> Vec<f64> {
    let dims = points[0].len();
    let mut weights = vec![0.0; dims];
    for _ in 0..50 {
        // The last column, right of the information matrix, is the negative gradient.
        let mut system = Array2::<f64>::zeros((dims, dims + 1));
        for at in 0..dims - 1 {
            system[[at, at]] = RIDGE;
            system[[at, dims]] = -RIDGE * weights[at];
        }
        for ((point, &label), &evidence) in points.iter().zip(labels).zip(evidence) {
            let sum: f64 = point
                .iter()
                .zip(&weights)
                .map(|(x, weight)| x * weight)
                .sum();
            let share = 1.0 / (1.0 + (-sum).exp());
            let information = evidence * share * (1.0 - share);
            for row in 0..dims {
                for column in 0..dims {
                    system[[row, column]] += information * point[row] * point[column];
                }
                system[[row, dims]] += evidence * (label as f64 - share) * point[row];
            }
        }
        let step = solved(system);
        for (weight, step) in weights.iter_mut().zip(&step) {
            *weight += step;
        }
        if step.iter().all(|step| step.abs() < 1e-9) {
            return weights;
        }
    }
    panic!("logistic regression: no convergence in 50 steps");
}

/// Solves a positive definite system whose last column is its right side.
fn solved(mut system: Array2<f64>) -> Vec<f64> {
    let dims = system.nrows();
    for pivot in 0..dims {
        for row in (0..dims).filter(|&row| row != pivot) {
            let factor = system[[row, pivot]] / system[[pivot, pivot]];
            for column in pivot..=dims {
                system[[row, column]] -= factor * system[[pivot, column]];
            }
        }
    }
    (0..dims)
        .map(|row| system[[row, dims]] / system[[row, row]])
        .collect()
}

mod tests {
    use super::*;

    #[test]
    fn a_logistic_regression_of_one_bit_has_the_log_odds_that_its_ridge_leaves() {
        // The numbers -1 and 1 occur 8 times each, with label 1 in a quarter and in three quarters
        // of the cases. By symmetry the last weight is 0, and the optimum of the first satisfies 16
        // (0.75 - 1 / (1 + exp(-w))) = w.
        let points: Vec<Vec<f64>> = (0..16)
            .map(|at| vec![if at < 8 { -1.0 } else { 1.0 }, 1.0])
            .collect();
        let labels: Vec<usize> = (0..16)
            .map(|at| usize::from(at % 4 == 0 || (at >= 8 && at % 4 != 1)))
            .collect();
        let weights = logistic(&points, &labels, &[1.0; 16]);
        let residual = 16.0 * (0.75 - 1.0 / (1.0 + (-weights[0]).exp())) - weights[0];
        assert!(
            residual.abs() < 1e-6 && weights[1].abs() < 1e-9,
            "{weights:?}"
        );
    }

    #[test]
    fn people_count_once_however_many_cycles_they_have() {
        // One person of the first group always wins, the other never.
        let separation = Separation {
            first: vec![0, 1],
            second: vec![2],
            won: ndarray::array![[1.0], [0.0]],
        };
        assert_eq!(separation.auc(|_| 1.0), 0.5);
        assert_eq!(
            separation.auc(|person| if person == 0 { 3.0 } else { 1.0 }),
            0.75
        );
    }
}

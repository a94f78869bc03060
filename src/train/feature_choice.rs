//! Chooses features that identify people whatever they wear, after Nandy et al.: the widths of
//! those rows of the GEnI in which people differ more from each other than from themselves in other
//! clothes.
//!
//! The publication compares the variance within a person's clothes row by row; it leaves open by
//! how much a row has to be better. Here the variance between people's means has to be greater than
//! the variance within people, and each number is measured in units of the latter's square root. A
//! number that does not vary within people counts as much as the steadiest one that does (our choice:
//! in its own unit it would count without limit).
//! The numbers of any template can be chosen from. The chosen numbers are robust to whatever the
//! samples of one person differ in, clothes or something else.

use super::lda::Classes;
use super::{Classifier, LinearModel, Samples};
use crate::error::{Result, TrainError};
use crate::inference::Affine;
use ndarray::{Array1, Array2};

/// The name of the method in contracts.
pub(crate) const METHOD: &str = "choice of features";
/// The maximum number of values that contracts list.
const LISTED: usize = 64;

/// Describes the method with the numbers that it chose (from 0), unless these are many.
pub(crate) fn described(recognizer: &LinearModel) -> String {
    let chosen = chosen(recognizer);
    if chosen.len() > LISTED {
        return format!("{METHOD} ({} of a template)", chosen.len());
    }
    let chosen: Vec<String> = chosen.iter().map(usize::to_string).collect();
    format!("{METHOD} ({})", chosen.join(" "))
}

/// Returns the numbers that it chose, from 0.
pub(crate) fn chosen(recognizer: &LinearModel) -> Vec<usize> {
    let rows = recognizer.embedding.weights.outer_iter();
    rows.filter_map(|row| row.iter().position(|&weight| weight != 0.0))
        .collect()
}

/// The maximum number of weights of the map from a template to the chosen numbers, a dense matrix:
/// 16 MB.
const MAX_WEIGHTS: usize = 1 << 22;

/// The variances of a number of a template.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Variances {
    /// Within people, between their samples.
    within: f64,
    /// Between the means of people.
    between: f64,
}

impl Variances {
    /// Computes the variances of each number of the samples.
    ///
    /// # Errors
    /// As [`Classes::averaged`].
    fn compute(samples: &Samples) -> Result<Vec<Self>> {
        let classes = samples.names.len();
        let Classes { means, .. } =
            Classes::<f64>::averaged(samples.numbers.view(), &samples.labels, classes)?;
        let spare = samples.labels.len().saturating_sub(classes).max(1) as f64;
        let of_number = |number: usize| {
            let column = samples.numbers.column(number);
            let squares = { column.iter().zip(&samples.labels) }
                .map(|(&value, &label)| (f64::from(value) - means[[label, number]]).powi(2));
            let of_people = means.column(number);
            let mean = of_people.mean().unwrap_or_default();
            let of_means = of_people.iter().map(|of_one| (of_one - mean).powi(2));
            Self {
                within: squares.sum::<f64>() / spare,
                between: of_means.sum::<f64>() / (classes - 1) as f64,
            }
        };
        Ok((0..samples.numbers.ncols()).map(of_number).collect())
    }

    /// Returns whether the number varies more between people than within them.
    #[must_use]
    fn is_chosen(self) -> bool {
        self.between > self.within
    }
}

/// Fits a recognizer that uses the chosen numbers.
///
/// # Errors
/// If people have one sample each, no number or too many are chosen, and as [`Classes::averaged`].
pub(crate) fn fit(samples: &Samples) -> Result<LinearModel> {
    let (people, found) = (samples.names.len(), samples.labels.len());
    if found <= people {
        return Err(TrainError::OneSampleEach { people, found }.into());
    }
    let variances = Variances::compute(samples)?;
    let chosen: Vec<usize> = (0..variances.len())
        .filter(|&number| variances[number].is_chosen())
        .collect();
    if chosen.is_empty() {
        return Err(TrainError::NothingChosen.into());
    }
    if chosen.len() * variances.len() > MAX_WEIGHTS {
        return Err(TrainError::TooMuchChosen {
            chosen: chosen.len(),
            numbers: variances.len(),
        }
        .into());
    }
    let varying = chosen.iter().map(|&number| variances[number].within);
    let varying = varying
        .filter(|&within| within > 0.0)
        .min_by(f64::total_cmp);
    let least = varying.unwrap_or(1.0);
    let mut weights = Array2::zeros((chosen.len(), variances.len()));
    for (row, &number) in chosen.iter().enumerate() {
        weights[[row, number]] = (1.0 / variances[number].within.max(least).sqrt()) as f32;
    }
    let classes = samples.names.len();
    let of = Classes::<f32>::averaged(samples.numbers.view(), &samples.labels, classes)?;
    Ok(LinearModel {
        template: samples.template,
        size: samples.size,
        parts: 1,
        classifier: Classifier::Centroids(of.means.dot(&weights.t())),
        embedding: Affine {
            bias: Array1::zeros(chosen.len()),
            weights,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::template::Template;
    use crate::inference::Training;
    use edgegait_core::silhouette::Size;

    /// Returns two people in three garments each, twice: row 0 depends on the person, row 1 on the
    /// garment, row 2 on both but more on the person; all others are empty.
    fn samples() -> Samples {
        let numbers = Array2::from_shape_fn((12, 50), |(at, row)| {
            let (person, garment, again) = ((at / 6) as f32, (at % 3) as f32, (at / 3 % 2) as f32);
            match row {
                0 => 0.5 * person + 0.01 * again,
                1 => 0.3 * garment,
                2 => 0.5 * person + 0.1 * garment,
                _ => 0.0,
            }
        });
        Samples {
            numbers,
            template: Template::RowWidth,
            size: Size::S50x30,
            framing: None,
            labels: (0..12).map(|at| at / 6).collect(),
            views: vec![Some(0); 12],
            names: vec!["ann".into(), "bob".into()],
            found: 12,
            training: Training::default(),
        }
    }

    #[test]
    fn rows_that_tell_more_of_people_than_of_clothes_are_chosen() {
        let samples = samples();
        let fitted = fit(&samples).expect("two people");
        let first = |row: usize| {
            let weights = fitted.embedding.weights.row(row);
            let found = weights.iter().position(|&weight| weight != 0.0);
            found.expect("a number")
        };
        assert_eq!((fitted.dims(), first(0), first(1)), (2, 0, 2));
        // Six values of 0 and 0.01 within a person: 12 squares of 0.005, by 10 degrees of freedom.
        assert_eq!(described(&fitted), "choice of features (0 2)");
        let scale = 1.0 / (12.0_f64 * 0.005 * 0.005 / 10.0).sqrt();
        let found = fitted.embed(&samples.numbers.row(8).to_vec());
        assert!((f64::from(found[0]) - 0.5 * scale).abs() < 1e-3 * scale);
        let scores = fitted.scores(found.view());
        assert!(scores[1] > scores[0]);
    }

    #[test]
    fn numbers_that_do_not_vary_within_people_are_chosen_and_count_the_most() {
        let mut samples = samples();
        for at in 0..12 {
            samples.numbers[[at, 3]] = if at < 6 { 0.25 } else { 0.5 };
        }
        let fitted = fit(&samples).expect("two people");
        assert_eq!(chosen(&fitted), [0, 2, 3]);
        let weights = &fitted.embedding.weights;
        // Row 0 varies the least of those that vary: 12 squares of 0.005, by 10 degrees of freedom.
        let most = 1.0 / (12.0_f64 * 0.005 * 0.005 / 10.0).sqrt();
        assert!((f64::from(weights[[2, 3]]) - most).abs() < 1e-3 * most);
        assert!(weights[[0, 0]] == weights[[2, 3]] && weights[[1, 2]] < weights[[2, 3]]);

        // Where nothing varies within people, numbers keep their own unit.
        let steady = Array2::from_shape_fn((12, 50), |(at, row)| {
            if row == 3 {
                samples.numbers[[at, 3]]
            } else {
                0.0
            }
        });
        let fitted = fit(&Samples {
            numbers: steady,
            ..samples
        });
        let fitted = fitted.expect("two people");
        assert_eq!((chosen(&fitted), fitted.dims()), (vec![3], 1));
        assert_eq!(fitted.embedding.weights[[0, 3]], 1.0);
    }

    #[test]
    fn numbers_that_tell_of_nobody_are_refused() {
        let samples = samples();
        let refused = |samples: Samples| {
            let refused = fit(&samples);
            refused.expect_err("a refusal").to_string()
        };
        let garments = Samples {
            numbers: Array2::from_shape_fn((12, 50), |(at, row)| {
                samples.numbers[[at, 1]] * (row % 2) as f32
            }),
            ..samples.clone()
        };
        assert_eq!(
            refused(garments),
            "no value of the templates varies more between people than within them: there is nothing to choose"
        );
        let once = Samples {
            numbers: samples.numbers.select(ndarray::Axis(0), &[0, 6]),
            labels: vec![0, 1],
            ..samples.clone()
        };
        assert_eq!(
            refused(once),
            "a choice of features needs several samples of each person, to measure the variation within them: found 2 of 2 people"
        );
        let alone = Samples {
            names: vec!["ann".into()],
            labels: vec![0; 12],
            ..samples
        };
        assert!(refused(alone).contains("at least 2"));
    }
}

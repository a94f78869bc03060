//! Finds the affine function from pixels to a recognizer's class scores, by running the recognizer.
//!
//! A graph can compute an affine function in many ways, and an exporter may fold or split it. So
//! nothing is read from the file: the scores of the black image are the biases, the scores of an
//! image with one white pixel add that pixel's weights, and random images show whether that is all.

use super::{Outputs, Recognizer};
use crate::error::{InferenceError, Result};
use edgegait_core::budget::MAX_CLASSES;
use ndarray::{Array1, Array2, ArrayView1};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Images in a batch: 4 MB at 64x64.
const BATCH: usize = 256;
/// Random images on which the function is checked. Our choice.
const CHECKED: usize = 64;
/// The greatest difference between scores and the affine function, as a share of the changes that
/// pixels make. Our choice: above f32 rounding in models of `train` (0.5e-4 to 2.7e-4), below the
/// effect of 8-bit weights (1.7e-3 for `side`, 3.6e-3 for `spread`).
const MOST_DEVIATION: f64 = 1e-3;

/// An affine function `weights x + bias`, in the precision that is exported.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine {
    /// One output a row.
    pub weights: Array2<f32>,
    /// One number per output.
    pub bias: Array1<f32>,
}

impl Affine {
    /// Returns the outputs for one input.
    ///
    /// # Panics
    /// If `input` does not have one number per column of the weights.
    #[must_use]
    pub fn apply(&self, input: ArrayView1<'_, f32>) -> Array1<f32> {
        self.weights.dot(&input) + &self.bias
    }

    /// Computes [`Self::apply`] in double precision, as a reference for the exported graph.
    ///
    /// # Panics
    /// As [`Self::apply`].
    #[must_use]
    pub fn apply_f64(&self, input: ArrayView1<'_, f64>) -> Array1<f64> {
        self.weights.mapv(f64::from).dot(&input) + self.bias.mapv(f64::from)
    }
}

/// The affine function of a recognizer's class scores, and how exact it is.
#[derive(Clone, Debug)]
pub struct AffineScores {
    /// From a template with numbers in 0..1 to its class scores.
    pub map: Affine,
    /// The greatest difference from the recognizer's scores of random images, as a share of the
    /// greatest difference of those from the scores of the black image.
    pub deviation: f64,
}

impl AffineScores {
    /// Runs a recognizer of templates on the black image, on each image with one white pixel, and
    /// on random images.
    ///
    /// # Errors
    /// If it takes viewpoints, has no scores or more than [`MAX_CLASSES`], if scores are not finite
    /// or not an affine function of the pixels, or if it fails.
    pub fn measure(recognizer: &dyn Recognizer, seed: u64) -> Result<Self> {
        let contract = recognizer.contract();
        if let Some(input) = &contract.view_input {
            return Err(InferenceError::TakesViews {
                model: contract.name.clone(),
                input: input.clone(),
            }
            .into());
        }
        let numbers = contract.numbers();
        let black = scores(recognizer, &[vec![0; numbers]])?;
        let classes = black.len();
        let mut weights = Array2::zeros((classes, numbers));
        let pixels: Vec<usize> = (0..numbers).collect();
        for pixels in pixels.chunks(BATCH) {
            let images: Vec<Vec<u8>> = pixels
                .iter()
                .map(|&white| {
                    (0..numbers)
                        .map(|p| if p == white { 255 } else { 0 })
                        .collect()
                })
                .collect();
            let found = scores(recognizer, &images)?;
            for (&pixel, scores) in pixels.iter().zip(found.chunks_exact(classes)) {
                for (class, (score, bias)) in scores.iter().zip(&black).enumerate() {
                    weights[[class, pixel]] = score - bias;
                }
            }
        }
        let map = Affine {
            weights,
            bias: Array1::from_vec(black),
        };
        let deviation = deviation(recognizer, &map, seed)?;
        Ok(Self { map, deviation })
    }
}

/// Measures how far the scores of random images are from `map`.
///
/// # Errors
/// If they are too far from it, or all scores are the same.
fn deviation(recognizer: &dyn Recognizer, map: &Affine, seed: u64) -> Result<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let images: Vec<Vec<u8>> = (0..CHECKED)
        .map(|number| random_image(recognizer.contract().numbers(), number, &mut random))
        .collect();
    let found = scores(recognizer, &images)?;
    let (mut farthest, mut change) = (0.0f64, 0.0f64);
    for (image, found) in images.iter().zip(found.chunks_exact(map.bias.len())) {
        let pixels: Array1<f64> = image.iter().map(|&byte| f64::from(byte) / 255.0).collect();
        let expected = map.apply_f64(pixels.view());
        for ((&found, expected), &black) in found.iter().zip(expected).zip(&map.bias) {
            farthest = farthest.max((f64::from(found) - expected).abs());
            change = change.max((f64::from(found) - f64::from(black)).abs());
        }
    }
    let model = recognizer.name().to_owned();
    if change == 0.0 {
        let images = CHECKED;
        return Err(InferenceError::Constant { model, images }.into());
    }
    if farthest > MOST_DEVIATION * change {
        return Err(InferenceError::NotAffine {
            model,
            images: CHECKED,
            found: farthest,
            change,
        }
        .into());
    }
    Ok(farthest / change)
}

/// Draws an image of random greys, or of runs of one grey each, so that both many small and a few
/// large differences occur.
fn random_image(numbers: usize, number: usize, random: &mut ChaCha8Rng) -> Vec<u8> {
    let longest = if number.is_multiple_of(2) {
        1
    } else {
        numbers / 2
    };
    let mut image = Vec::with_capacity(numbers);
    while image.len() < numbers {
        let run = random.random_range(1..=longest.max(1));
        let grey = random.random();
        image.extend(std::iter::repeat_n::<u8>(
            grey,
            run.min(numbers - image.len()),
        ));
    }
    image
}

/// Returns the class scores of images, one image after another.
fn scores(recognizer: &dyn Recognizer, images: &[Vec<u8>]) -> Result<Vec<f32>> {
    let mut input = Vec::new();
    for image in images {
        recognizer.contract().feed(image, &mut input);
    }
    let Outputs {
        scores, classes, ..
    } = recognizer.run(&input, images.len())?;
    let model = recognizer.name().to_owned();
    let Some(scores) = scores else {
        return Err(InferenceError::NoScores(model).into());
    };
    if classes > MAX_CLASSES {
        return Err(InferenceError::TooManyClasses {
            model,
            found: classes,
            most: MAX_CLASSES,
        }
        .into());
    }
    match scores.iter().find(|score| !score.is_finite()) {
        Some(&score) => Err(InferenceError::NotFinite { model, score }.into()),
        None => Ok(scores),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{MadeUp, small_model};
    use super::super::{Contract, Runtime};
    use super::*;
    use crate::train::testing::small_recognizer;

    fn refusal(function: fn(&[f32]) -> Vec<f32>) -> String {
        let recognizer = MadeUp::new(Contract::default(), function);
        let error = AffineScores::measure(&recognizer, 1).expect_err("not affine");
        error.to_string()
    }

    #[test]
    fn an_affine_function_is_found_exactly() {
        // Sums of powers of two.
        let function = |x: &[f32]| vec![2.0 * x[0] - 4.0 * x[1499] + 8.0, 0.5 * x[31], -1.0];
        let recognizer = MadeUp::new(Contract::default(), function);
        let AffineScores { map, deviation } =
            AffineScores::measure(&recognizer, 1).expect("it is affine");
        assert_eq!(map.bias.to_vec(), [8.0, 0.0, -1.0]);
        let mut weights = Array2::<f32>::zeros((3, 1500));
        (weights[[0, 0]], weights[[0, 1499]], weights[[1, 31]]) = (2.0, -4.0, 0.5);
        assert_eq!(map.weights, weights);
        assert!(deviation < 1e-6, "{deviation:e}");
    }

    #[test]
    fn the_two_products_of_a_trained_model_are_found_as_one() {
        let recognizer = Runtime::rten().load(&small_model()).expect("our own model");
        let found = AffineScores::measure(recognizer.as_ref(), 1).expect("it is affine");
        let trained = small_recognizer();
        let (embedding, scores) = (&trained.embedding, trained.score_map());
        let first = embedding.weights.mapv(f64::from);
        let second = scores.weights.mapv(f64::from);
        let expected = second.dot(&first);
        let largest = expected.iter().fold(0.0f64, |most, w| most.max(w.abs()));
        for (found, expected) in found.map.weights.iter().zip(&expected) {
            let difference = (f64::from(*found) - expected).abs();
            assert!(difference < 1e-4 * largest, "{found} {expected}");
        }
        let bias = second.dot(&embedding.bias.mapv(f64::from)) + scores.bias.mapv(f64::from);
        for (found, expected) in found.map.bias.iter().zip(&bias) {
            let difference = (f64::from(*found) - expected).abs();
            assert!(difference < 1e-5 * expected.abs(), "{found} {expected}");
        }
        assert!(found.deviation < 1e-5, "{:e}", found.deviation);
    }

    #[test]
    fn what_is_not_affine_is_refused_with_how_far_it_is() {
        let softmax = |x: &[f32]| {
            let logits = [x[..750].iter().sum::<f32>(), x[750..].iter().sum()];
            let powers = logits.map(|logit| (0.02 * logit).exp());
            powers
                .map(|power| power / powers.iter().sum::<f32>())
                .to_vec()
        };
        let error = refusal(softmax);
        assert!(
            error.contains("away from it") && error.contains("Softmax"),
            "{error}"
        );
        // Images with one white pixel do not distinguish this one from an affine function.
        let error = refusal(|x| vec![(x.iter().sum::<f32>() - 600.0).max(0.0)]);
        assert!(error.contains("away from it"), "{error}");
        let error = refusal(|_| vec![1.0, 2.0]);
        assert!(error.contains("depend on the pixels"), "{error}");
        let error = refusal(|x| vec![1.0 / x[0]]);
        assert!(error.contains("finite scores, found inf"), "{error}");
        let error = refusal(|_| vec![0.0; 256]);
        assert!(error.contains("at most 255 classes, found 256"), "{error}");
        let error = refusal(|_| Vec::new());
        assert!(error.contains("found an embedding only"), "{error}");
    }
}

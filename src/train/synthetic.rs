//! Real and synthetic templates together: Han & Bhanu 2006, "Individual recognition using gait energy
//! image", IEEE Trans. Pattern Anal. 28:316.
//!
//! Synthetic templates are a template without its lowest rows, enlarged ([`crate::template::augment`]).
//! Principal components and discriminants are learnt of the real ones and of the synthetic ones for
//! themselves; the distance of two templates is the sum of both distances, each divided by the mean
//! distance between the means of two people. A template's synthetic embedding is the mean of those
//! of its synthetic ones, so that all of it is one affine map. (The publication takes the mean of their
//! distances to a person's mean instead: it enrols people by the templates that it learns from.)

use super::{Analysed, Classifier, Components, LinearRecognizer, Method, Options, Real, algebra};
use crate::error::Result;
use crate::score::Affine;
use crate::template::Shape;
use crate::template::augment::{Augmentation, Crops, Variant, crop_weights, varied};
use ndarray::{Array1, Array2, ArrayView2, s};

impl<F: Real> Analysed<'_, F> {
    /// A recognizer of real and of synthetic templates: its embedding has two parts.
    ///
    /// # Errors
    /// For templates that are no images, crops that leave too little, and as [`Self::fit`].
    pub(super) fn real_and_synthetic(
        &self,
        components: Components,
        crops: Crops,
    ) -> Result<LinearRecognizer> {
        let augmentation = Augmentation {
            flip: false,
            crops: Some(crops),
        };
        augmentation.check(self.template, self.size)?;
        let options = Options {
            components,
            method: Method::LDA,
        };
        let real = self.fit(options)?;
        let (samples, labels) = self.synthetic(crops);
        let form = (self.template, self.size);
        let classes = self.class_means.nrows();
        let mut synthetic =
            Analysed::<F>::of(form, samples.view(), &labels, classes)?.fit(options)?;
        let weights = synthetic.embedding.weights.mapv(f64::from);
        let weights = algebra::multiply(weights.view(), self.mean_crop(crops).view());
        synthetic.embedding.weights = weights.mapv(|weight| weight as f32);
        Ok(joined([real, synthetic]))
    }

    /// The synthetic templates of all samples, and whose they are.
    fn synthetic(&self, crops: Crops) -> (Array2<f32>, Vec<usize>) {
        let rows = self.samples.nrows() * crops.steps;
        let (mut numbers, mut labels) =
            (Vec::with_capacity(rows * self.samples.ncols()), Vec::new());
        for (sample, &label) in self.samples.outer_iter().zip(self.labels) {
            let bytes: Vec<u8> = sample
                .iter()
                .map(|number| (number * 255.0).round() as u8)
                .collect();
            for step in 1..=crops.steps {
                let variant = Variant {
                    is_flipped: false,
                    rows_cut: step * crops.rows,
                };
                let made = varied(&bytes, self.size, variant);
                numbers.extend(made.iter().map(|&byte| f32::from(byte) / 255.0));
                labels.push(label);
            }
        }
        let samples = Array2::from_shape_vec((rows, self.samples.ncols()), numbers);
        (samples.expect("whole rows"), labels)
    }

    /// The matrix that makes of a template the mean of its synthetic ones.
    fn mean_crop(&self, crops: Crops) -> Array2<f64> {
        let planes = match self.template.shape(self.size) {
            Shape::Image { planes, .. } => planes,
            Shape::Vector(_) => 0,
        };
        let (pixels, numbers) = (self.size.pixels(), self.samples.ncols());
        let mut mean = Array2::zeros((numbers, numbers));
        for step in 1..=crops.steps {
            for (from, to, weight) in crop_weights(self.size, step * crops.rows) {
                for plane in 0..planes {
                    let first = plane * pixels;
                    mean[[first + to, first + from]] += weight / crops.steps as f64;
                }
            }
        }
        mean
    }
}

/// Two recognizers as one whose embedding has a part of each, scaled so that two people's means are
/// 1 apart on average in each part.
fn joined(parts: [LinearRecognizer; 2]) -> LinearRecognizer {
    let dims = parts.iter().map(LinearRecognizer::dims).max().unwrap_or(0);
    let [first, _] = &parts;
    let (template, size) = (first.template, first.size);
    let mut weights = Array2::zeros((2 * dims, template.shape(size).numbers()));
    let mut bias = Array1::zeros(2 * dims);
    let mut means = Array2::zeros((first.classes(), 2 * dims));
    for (part, recognizer) in parts.iter().enumerate() {
        let Classifier::Centroids(centroids) = &recognizer.classifier else {
            continue;
        };
        let scale = 1.0 / mean_distance(centroids.view());
        // Number i of part j is at 2 i + j.
        let mut of_part = weights.slice_mut(s![part..;2, ..]);
        let own = recognizer.dims();
        of_part
            .slice_mut(s![..own, ..])
            .assign(&(&recognizer.embedding.weights * scale));
        let mut of_part = bias.slice_mut(s![part..;2]);
        of_part
            .slice_mut(s![..own])
            .assign(&(&recognizer.embedding.bias * scale));
        let mut of_part = means.slice_mut(s![.., part..;2]);
        of_part
            .slice_mut(s![.., ..own])
            .assign(&(centroids * scale));
    }
    LinearRecognizer {
        template,
        size,
        parts: 2,
        embedding: Affine { weights, bias },
        classifier: Classifier::Centroids(means),
    }
}

/// The mean distance of two rows.
fn mean_distance(rows: ArrayView2<'_, f32>) -> f32 {
    let (mut sum, mut pairs) = (0.0, 0.0);
    for (at, a) in rows.outer_iter().enumerate() {
        for b in rows.outer_iter().take(at) {
            let square: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            (sum, pairs) = (sum + square.sqrt(), pairs + 1.0);
        }
    }
    (sum / f64::max(pairs, 1.0)) as f32
}

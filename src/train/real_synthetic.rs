//! Recognizers of real and synthetic templates together: Han & Bhanu 2006, "Individual recognition
//! using gait energy image", IEEE Trans. Pattern Anal. 28:316.
//!
//! A synthetic template is a template without its lowest rows, enlarged
//! ([`crate::draw::template::augment`]). Principal components and discriminants are learnt separately
//! from real and from synthetic templates. The distance of two templates is the sum of both
//! distances, each divided by the mean distance between the means of two people. A template's
//! synthetic embedding is the mean of the embeddings of its synthetic templates, so the whole is
//! one affine map. (The publication instead takes the mean of their distances to a person's mean:
//! it enrols people by the templates that it learns from.)

use super::{
    Analysed, Classifier, Components, LinearModel, Real, TrainMethod, TrainOptions, linear_algebra,
};
use crate::draw::template::TemplateShape;
use crate::draw::template::augment::{Augmentation, Crops, Variant, crop_weights, varied};
use crate::error::Result;
use crate::inference::Affine;
use ndarray::{Array1, Array2, ArrayView2, s};

impl<F: Real> Analysed<'_, F> {
    /// Fits a recognizer of real and of synthetic templates; its embedding has two parts.
    ///
    /// # Errors
    /// For templates that are not images, crops that leave too little, and as [`Self::fit`].
    pub(super) fn real_and_synthetic(
        &self,
        components: Components,
        crops: Crops,
    ) -> Result<LinearModel> {
        let augmentation = Augmentation {
            flip: false,
            crops: Some(crops),
        };
        augmentation.check(self.template, self.size)?;
        let options = TrainOptions {
            components,
            method: TrainMethod::LDA,
        };
        let real = self.fit(options)?;
        let (samples, labels) = self.synthetic(crops);
        let classes = self.class_means.nrows();
        let mut synthetic =
            Analysed::<F>::analyse(self.template, self.size, samples.view(), &labels, classes)?
                .fit(options)?;
        let weights = synthetic.embedding.weights.mapv(f64::from);
        let weights = linear_algebra::multiply(weights.view(), self.mean_crop(crops).view());
        synthetic.embedding.weights = weights.mapv(|weight| weight as f32);
        Ok(joined([real, synthetic]))
    }

    /// Returns the synthetic templates of all samples, and their labels.
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

    /// Returns the matrix that maps a template to the mean of its synthetic templates.
    fn mean_crop(&self, crops: Crops) -> Array2<f64> {
        let planes = match self.template.shape(self.size) {
            TemplateShape::Image { planes, .. } => planes,
            TemplateShape::Vector(_) => 0,
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

/// Joins two recognizers into one whose embedding has a part of each, scaled so that two people's
/// means are 1 apart on average in each part.
fn joined(parts: [LinearModel; 2]) -> LinearModel {
    let dims = parts.iter().map(LinearModel::dims).max().unwrap_or(0);
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
    LinearModel {
        template,
        size,
        parts: 2,
        embedding: Affine { weights, bias },
        classifier: Classifier::Centroids(means),
    }
}

/// Returns the mean distance of two rows.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::template::Template;
    use crate::error::Error;
    use crate::train::testing::people;
    use edgegait_core::silhouette::Size;

    const CROPS: Crops = Crops { steps: 3, rows: 2 };
    const METHOD: TrainMethod = TrainMethod::RealSynthetic { crops: CROPS };

    fn fitted(method: TrainMethod) -> LinearModel {
        let (geis, labels) = people(60, 5, 4);
        let analysed = Analysed::<f64>::new(geis.view(), &labels, 5).expect("five people");
        analysed
            .fit(TrainOptions {
                method,
                ..TrainOptions::default()
            })
            .expect("a fit")
    }

    /// Returns the numbers of a part of an embedding.
    fn part(embedding: &Array1<f32>, part: usize) -> Vec<f32> {
        embedding.iter().skip(part).step_by(2).copied().collect()
    }

    #[test]
    fn the_first_part_is_lda_in_units_of_the_mean_distance() {
        let (both, real) = (fitted(METHOD), fitted(TrainMethod::LDA));
        assert_eq!((both.parts, real.parts), (2, 1));
        let (geis, _) = people(6, 5, 77);
        let Classifier::Centroids(centroids) = &real.classifier else {
            panic!("means");
        };
        let unit = mean_distance(centroids.view());
        for gei in geis.outer_iter() {
            let gei = gei.to_vec();
            let expected = real.embed(&gei) / unit;
            for (found, expected) in part(&both.embed(&gei), 0).iter().zip(expected) {
                assert!((found - expected).abs() < 1e-4, "{found} {expected}");
            }
        }
        let Classifier::Centroids(means) = &both.classifier else {
            panic!("means");
        };
        for of_part in 0..2 {
            let own = means.slice(s![.., of_part..;2]).to_owned();
            assert!((mean_distance(own.view()) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn the_second_part_is_the_mean_of_the_synthetic_templates_embeddings() {
        let (geis, labels) = people(60, 5, 4);
        let mut rows = Vec::new();
        let synthetic = |gei: &[f32]| -> Vec<Vec<f32>> {
            let bytes: Vec<u8> = gei.iter().map(|x| (x * 255.0).round() as u8).collect();
            (1..=CROPS.steps)
                .map(|step| {
                    let variant = Variant {
                        is_flipped: false,
                        rows_cut: step * CROPS.rows,
                    };
                    let made = varied(&bytes, Size::S50x30, variant);
                    made.iter().map(|&byte| f32::from(byte) / 255.0).collect()
                })
                .collect()
        };
        for gei in geis.outer_iter() {
            rows.extend(synthetic(&gei.to_vec()).concat());
        }
        let rows = Array2::from_shape_vec((180, 1500), rows).expect("180 templates");
        let labels: Vec<usize> = labels.iter().flat_map(|&label| [label; 3]).collect();
        let analysed = Analysed::<f64>::new(rows.view(), &labels, 5).expect("five people");
        let alone = analysed.fit(TrainOptions::default()).expect("a fit");
        let Classifier::Centroids(centroids) = &alone.classifier else {
            panic!("means");
        };
        let unit = mean_distance(centroids.view());
        let both = fitted(METHOD);
        let gei = geis.row(17).to_vec();
        let mut expected = Array1::<f32>::zeros(alone.dims());
        for made in synthetic(&gei) {
            expected += &(alone.embed(&made) / (3.0 * unit));
        }
        // Crops are rounded to bytes, the map is not.
        let scale = expected.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        for (found, expected) in part(&both.embed(&gei), 1).iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 0.02 * scale,
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn what_has_no_bottom_is_refused() {
        let (samples, labels) = (
            Array2::from_shape_fn((8, 50), |(i, j)| ((i * j) % 7) as f32 / 7.0),
            [0, 1, 0, 1, 0, 1, 0, 1],
        );
        let analysed =
            Analysed::<f64>::analyse(Template::RowWidth, Size::S50x30, samples.view(), &labels, 2)
                .expect("two people");
        let refused = analysed.fit(TrainOptions {
            method: METHOD,
            ..TrainOptions::default()
        });
        assert!(matches!(refused, Err(Error::Choice(_))), "{refused:?}");
    }
}

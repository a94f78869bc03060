//! Fits linear recognizers and exports them as ONNX.
//!
//! PCA and LDA are both affine, so together they are one matrix from pixels to an embedding. The
//! nearest class mean is a second matrix, and so are support vector machines on principal
//! components. A board then computes two matrix products.

mod cycle_share;
pub(crate) mod feature_choice;
pub(crate) mod gabor;
pub(crate) mod lda;
pub(crate) mod linear_algebra;
mod mix;
pub mod onnx;
mod onnx_file;
pub(crate) mod pca;
mod real_synthetic;
mod samples;
pub mod subspaces;
pub(crate) mod svm;
pub mod view_transformation;

pub use cycle_share::CycleShare;
pub use linear_algebra::Real;
pub use mix::{MixPart, SampleForm, joined, require_one_form, strangers};
pub use samples::{Recipe, Samples};

use edgegait_core::silhouette::Size;
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, s};

use crate::draw::template::Template;
use crate::draw::template::augment::Crops;
use crate::error::{Result, TrainError};
use crate::inference::Affine;
use lda::{Classes, Lda};
use pca::Pca;
use std::fmt;
use svm::Svm;

/// The number of principal components that are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Components {
    /// As many as hold this share of the variance, above 0 and at most 1.
    Variance(f64),
    /// This many, or all if there are fewer.
    Count(usize),
}

/// The ridge of [`TrainMethod::LDA`].
pub(crate) const RIDGE: f64 = 1e-3;

/// The method that separates classes along the principal components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrainMethod {
    /// Linear discriminants, and the nearest class mean along them.
    Lda {
        /// Share of the mean total variance added to the variance within classes; above 0.
        ridge: f64,
    },
    /// LDA of real and of synthetic templates, each in its own part of the embedding (Han & Bhanu
    /// 2006).
    RealSynthetic {
        /// The crops that make synthetic templates.
        crops: Crops,
    },
    /// Linear support vector machines, one for each class against the rest.
    Svm {
        /// Weight of the errors; above 0.
        c: f64,
    },
}

impl TrainMethod {
    /// LDA with a ridge of 1e-3 (our choice, not tuned on real people).
    pub const LDA: Self = Self::Lda { ridge: RIDGE };
}

impl fmt::Display for TrainMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lda { .. } => f.write_str("LDA"),
            Self::RealSynthetic { .. } => f.write_str("LDA of real and of synthetic templates"),
            Self::Svm { c } => write!(f, "linear SVM (C {c})"),
        }
    }
}

/// The options of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainOptions {
    /// Principal components kept.
    pub components: Components,
    /// The method applied to them.
    pub method: TrainMethod,
}

impl Default for TrainOptions {
    /// Returns 95 % of the variance and [`TrainMethod::LDA`].
    fn default() -> Self {
        Self {
            components: Components::Variance(0.95),
            method: TrainMethod::LDA,
        }
    }
}

/// The map from an embedding to class scores.
#[derive(Clone, Debug, PartialEq)]
pub enum Classifier {
    /// Mean embedding of each class, one a row: the nearest is the best.
    Centroids(Array2<f32>),
    /// The decision function of each class.
    Svm(Affine),
}

/// A recognizer that consists of an affine map and a linear classifier.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearModel {
    /// The template that it takes.
    pub template: Template,
    /// The size of the silhouettes of its templates.
    pub size: Size,
    /// Parts of an embedding, compared separately: number i of part j is at `i * parts + j`.
    pub parts: usize,
    /// The map from pixels in 0..1 to an embedding. With LDA, the variance within classes is 1 in
    /// every direction; with SVM, an embedding has the coordinates along the principal components.
    pub embedding: Affine,
    /// The map from an embedding to class scores.
    pub classifier: Classifier,
}

impl LinearModel {
    /// Returns the length of an embedding.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.embedding.weights.nrows()
    }

    /// Returns the number of classes.
    #[must_use]
    pub fn classes(&self) -> usize {
        match &self.classifier {
            Classifier::Centroids(centroids) => centroids.nrows(),
            Classifier::Svm(functions) => functions.weights.nrows(),
        }
    }

    /// Returns the map from an embedding to class scores; for centroids `e . mu_c - |mu_c|^2 / 2`.
    ///
    /// The highest score is that of the nearest centroid, since `|e - mu_c|^2 = |e|^2 - 2 score_c`.
    #[must_use]
    pub fn score_map(&self) -> Affine {
        let centroids = match &self.classifier {
            Classifier::Centroids(centroids) => centroids,
            Classifier::Svm(functions) => return functions.clone(),
        };
        let bias = centroids
            .outer_iter()
            .map(|mu| (-0.5 * mu.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>()) as f32)
            .collect();
        Affine {
            weights: centroids.clone(),
            bias,
        }
    }

    /// Returns the embedding of a template with numbers in 0..1.
    ///
    /// # Panics
    /// If `gei` does not have the length of a template.
    #[must_use]
    pub fn embed(&self, gei: &[f32]) -> Array1<f32> {
        self.embedding.apply(ArrayView1::from(gei))
    }

    /// Returns the class scores of an embedding.
    ///
    /// # Panics
    /// If `embedding` does not have [`Self::dims`] numbers.
    #[must_use]
    pub fn scores(&self, embedding: ArrayView1<'_, f32>) -> Array1<f32> {
        self.score_map().apply(embedding)
    }
}

/// Training templates with their principal components, to fit recognizers on any number of these.
pub struct Analysed<'a, F> {
    template: Template,
    size: Size,
    samples: ArrayView2<'a, f32>,
    labels: &'a [usize],
    class_means: Array2<F>,
    pca: Pca<F>,
}

impl<'a, F: Real> Analysed<'a, F> {
    /// Analyses GEIs of `classes` people, one a row with pixels in 0..1.
    ///
    /// # Errors
    /// If the samples are not GEIs of a known size, or as [`Self::analyse`].
    pub fn new(samples: ArrayView2<'a, f32>, labels: &'a [usize], classes: usize) -> Result<Self> {
        let size = Size::ALL
            .into_iter()
            .find(|size| size.pixels() == samples.ncols())
            .ok_or_else(|| TrainError::NoGeis(samples.ncols()))?;
        Self::analyse(Template::Gei, size, samples, labels, classes)
    }

    /// Analyses templates of `classes` people, of silhouettes of this size, one a row with numbers
    /// in 0..1.
    ///
    /// # Errors
    /// If the samples are not such templates with finite numbers, there are fewer than two classes,
    /// a class has no sample, or two classes have the same mean.
    pub fn analyse(
        template: Template,
        size: Size,
        samples: ArrayView2<'a, f32>,
        labels: &'a [usize],
        classes: usize,
    ) -> Result<Self> {
        let (expected, found) = (template.shape(size).numbers(), samples.ncols());
        if found != expected {
            return Err(TrainError::Numbers {
                templates: template.plural(),
                expected,
                found,
            }
            .into());
        }
        Ok(Self {
            template,
            size,
            samples,
            labels,
            class_means: Classes::average(samples, labels, classes)?.means,
            pca: Pca::fit(samples)?,
        })
    }

    /// Fits a recognizer of these people.
    ///
    /// # Errors
    /// If an option is out of range, or the method finds no solution.
    pub fn fit(&self, options: TrainOptions) -> Result<LinearModel> {
        match options.method {
            TrainMethod::Lda { ridge } => self.lda(options.components, ridge),
            TrainMethod::RealSynthetic { crops } => {
                self.real_and_synthetic(options.components, crops)
            }
            TrainMethod::Svm { c } => self.svm(options.components, c),
        }
    }

    /// Returns the first principal components, and the samples along them.
    fn projected(&self, components: Components) -> Result<(ArrayView2<'_, F>, Array2<F>)> {
        let kept = self.pca.kept(components)?;
        let points = self.pca.project(self.samples, kept);
        Ok((self.pca.components.slice(s![..kept, ..]), points))
    }

    fn lda(&self, components: Components, ridge: f64) -> Result<LinearModel> {
        let (components, points) = self.projected(components)?;
        let lda = Lda::fit(points.view(), self.labels, self.class_means.nrows(), ridge)?;
        let weights = linear_algebra::multiply(lda.directions.view(), components);
        let offsets = &self.class_means - &self.pca.mean;
        let centroids = linear_algebra::multiply(offsets.view(), weights.t());
        Ok(self.recognizer(weights, Classifier::Centroids(centroids.mapv(F::exported))))
    }

    fn svm(&self, components: Components, c: f64) -> Result<LinearModel> {
        let (components, points) = self.projected(components)?;
        let svm = Svm::fit(points.view(), self.labels, self.class_means.nrows(), c)?;
        let functions = Affine {
            weights: svm.weights.mapv(F::exported),
            bias: svm.bias.mapv(F::exported),
        };
        Ok(self.recognizer(components.to_owned(), Classifier::Svm(functions)))
    }

    /// Returns the recognizer whose embedding is `weights` times the difference from the mean.
    fn recognizer(&self, weights: Array2<F>, classifier: Classifier) -> LinearModel {
        let bias = -weights.dot(&self.pca.mean);
        LinearModel {
            template: self.template,
            size: self.size,
            parts: 1,
            embedding: Affine {
                weights: weights.mapv(F::exported),
                bias: bias.mapv(F::exported),
            },
            classifier,
        }
    }
}

/// Fits a recognizer of `classes` people to GEIs, one a row with pixels in 0..1.
///
/// PCA, then LDA or SVM, are folded into one map and a classifier. LDA of 8,000 GEIs takes 0.4 s on
/// one core of an AMD EPYC, and 3.5 s if every pixel has noise
/// (`cargo test --lib a_fit_of_8000 -- --ignored --nocapture`).
///
/// # Errors
/// As [`Analysed::new`] and [`Analysed::fit`].
pub fn fit(
    samples: ArrayView2<'_, f32>,
    labels: &[usize],
    classes: usize,
    options: TrainOptions,
) -> Result<LinearModel> {
    Analysed::<f64>::new(samples, labels, classes)?.fit(options)
}

#[cfg(test)]
pub(crate) mod testing;

#[cfg(test)]
mod tests;

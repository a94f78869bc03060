//! Fits linear recognizers and exports them as ONNX.
//!
//! PCA and LDA are both affine, so the two together are one matrix from pixels
//! to an embedding; the nearest class mean in it is a second matrix. A board
//! then runs two products instead of a stack of operators.

mod algebra;
pub mod lda;
pub mod onnx;
pub mod pca;

use edgegait_core::silhouette::Size;
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, s};

use crate::error::{Error, Result};
use lda::{Classes, Lda};
use pca::Pca;

/// How many principal components LDA works on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Components {
    /// As many as hold this share of the variance, above 0 and at most 1.
    Variance(f64),
    /// This many, or all if there are fewer.
    Count(usize),
}

/// What can be chosen about a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Principal components kept before LDA.
    pub components: Components,
    /// Share of the mean total variance added to the variance within classes; above 0.
    pub ridge: f64,
}

impl Default for Options {
    /// 95 % of the variance; a ridge of 1e-3 (ours, not tuned on real people).
    fn default() -> Self {
        Self {
            components: Components::Variance(0.95),
            ridge: 1e-3,
        }
    }
}

/// `weights x + bias`, in the precision that is exported.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine {
    /// One output a row.
    pub weights: Array2<f32>,
    /// One number per output.
    pub bias: Array1<f32>,
}

impl Affine {
    /// The outputs for one input.
    ///
    /// # Panics
    /// If `input` does not have one number per column of the weights.
    #[must_use]
    pub fn apply(&self, input: ArrayView1<'_, f32>) -> Array1<f32> {
        self.weights.dot(&input) + &self.bias
    }

    /// [`Self::apply`] with double precision inside: the oracle of the exported graph.
    ///
    /// # Panics
    /// As [`Self::apply`].
    #[must_use]
    pub fn apply_f64(&self, input: ArrayView1<'_, f64>) -> Array1<f64> {
        self.weights.mapv(f64::from).dot(&input) + self.bias.mapv(f64::from)
    }
}

/// A recognizer that is an affine map and a nearest class mean.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearRecognizer {
    /// Rows and columns of its GEIs.
    pub size: Size,
    /// Pixels in 0..1 to an embedding whose variance within classes is 1 in every direction.
    pub embedding: Affine,
    /// Mean embedding of each class, one a row.
    pub centroids: Array2<f32>,
}

impl LinearRecognizer {
    /// Numbers in an embedding.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.embedding.weights.nrows()
    }

    /// Classes that were learnt.
    #[must_use]
    pub fn classes(&self) -> usize {
        self.centroids.nrows()
    }

    /// The map from an embedding to class scores: `e . mu_c - |mu_c|^2 / 2`.
    ///
    /// The highest score is the nearest centroid, since `|e - mu_c|^2 = |e|^2 - 2 score_c`.
    #[must_use]
    pub fn classifier(&self) -> Affine {
        let bias = self
            .centroids
            .outer_iter()
            .map(|mu| (-0.5 * mu.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>()) as f32)
            .collect();
        Affine {
            weights: self.centroids.clone(),
            bias,
        }
    }

    /// The embedding of a GEI with pixels in 0..1.
    ///
    /// # Panics
    /// If `gei` does not have the pixels of its size.
    #[must_use]
    pub fn embed(&self, gei: &[f32]) -> Array1<f32> {
        self.embedding.apply(ArrayView1::from(gei))
    }

    /// The class scores of an embedding.
    ///
    /// # Panics
    /// If `embedding` does not have [`Self::dims`] numbers.
    #[must_use]
    pub fn scores(&self, embedding: ArrayView1<'_, f32>) -> Array1<f32> {
        self.classifier().apply(embedding)
    }

    /// [`Self::embed`] with double precision inside.
    ///
    /// # Panics
    /// As [`Self::embed`].
    #[must_use]
    pub fn embed_f64(&self, gei: &[f32]) -> Array1<f64> {
        self.embedding
            .apply_f64(ArrayView1::from(gei).mapv(f64::from).view())
    }

    /// [`Self::scores`] with double precision inside.
    ///
    /// # Panics
    /// As [`Self::scores`].
    #[must_use]
    pub fn scores_f64(&self, embedding: ArrayView1<'_, f64>) -> Array1<f64> {
        self.classifier().apply_f64(embedding)
    }
}

/// Learns to tell `classes` people apart from GEIs, one a row with pixels in 0..1.
///
/// PCA, then LDA, folded into one map. 8,000 GEIs took 0.4 s on one core of an AMD EPYC, and 3.5 s
/// where every pixel is grainy (`cargo test --lib a_fit_of_8000 -- --ignored --nocapture`).
///
/// # Errors
/// If the samples are not GEIs of finite numbers, there are fewer than two classes, a class has
/// no sample, two classes are the same, or an option makes no sense.
pub fn fit(
    samples: ArrayView2<'_, f32>,
    labels: &[usize],
    classes: usize,
    options: Options,
) -> Result<LinearRecognizer> {
    let size = Size::ALL
        .into_iter()
        .find(|size| size.pixels() == samples.ncols())
        .ok_or_else(|| {
            Error::Failed(format!(
                "expected GEIs of 50 x 30 = 1500, 64 x 44 = 2816 or 64 x 64 = 4096 pixels, found {}",
                samples.ncols()
            ))
        })?;
    let class_means = Classes::of(samples, labels, classes)?.means;
    let pca = Pca::fit(samples)?;
    let kept = match options.components {
        Components::Variance(share) if share > 0.0 && share <= 1.0 => pca.components_for(share),
        Components::Count(count) if count > 0 => count.min(pca.components.nrows()),
        Components::Variance(share) => {
            return Err(Error::Usage(format!(
                "expected a share of variance above 0 and at most 1, found {share}"
            )));
        }
        Components::Count(_) => {
            return Err(Error::Usage(
                "expected at least 1 principal component, found 0".into(),
            ));
        }
    };
    let points = pca.project(samples, kept);
    let lda = Lda::fit(points.view(), labels, classes, options.ridge)?;
    let weights = algebra::multiply(lda.directions.view(), pca.components.slice(s![..kept, ..]));
    let bias = -weights.dot(&pca.mean);
    let centroids = algebra::multiply((&class_means - &pca.mean).view(), weights.t());
    Ok(LinearRecognizer {
        size,
        embedding: Affine {
            weights: weights.mapv(|v| v as f32),
            bias: bias.mapv(|v| v as f32),
        },
        centroids: centroids.mapv(|v| v as f32),
    })
}

#[cfg(test)]
pub(crate) mod testing;

#[cfg(test)]
mod tests;

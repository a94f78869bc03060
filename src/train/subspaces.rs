//! Many weak classifiers that vote, in random subspaces of Gabor features of GEIs, after Guan & Li
//! 2013, "A robust speed-invariant gait recognition system for walker and runner identification",
//! ICB.
//!
//! The eigenvectors of two-dimensional PCA (Yang, Zhang, Frangi & Yang 2004, IEEE Trans. Pattern
//! Anal. 26:131) of all features are found once. Each classifier draws some of them at random, and
//! learns two-dimensional discriminants (Li & Yuan 2005, Pattern Recognit. Lett. 26:527) along the
//! other axis. The person with the most votes is the answer
//! ([`crate::inference::Distance::Votes`]).

use super::gabor::Gabor;
use super::lda::{Classes, Scatter, discriminants};
use super::linear_algebra::{add_products_of_columns, eigen, fix_sign, multiply};
use super::onnx::add_input;
use super::onnx_file::{NodeAttribute, OnnxFile};
use super::{RIDGE, Samples};
use crate::draw::template::Template;
use crate::error::{Result, TrainError};
use crate::inference::{Contract, Distance, EMBEDDING};
use edgegait_core::silhouette::Size;
use ndarray::{Array2, Array3, ArrayView2, ArrayView3, Axis, s};
use rand::SeedableRng;
use rand::seq::index::sample;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::fmt;

/// The options of random subspaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubspaceOptions {
    /// The number of classifiers.
    pub classifiers: usize,
    /// Eigenvectors that each classifier draws.
    pub eigenvectors: usize,
    /// The maximum number of discriminants that each classifier keeps.
    pub discriminants: usize,
    /// The seed of the random draw.
    pub seed: u64,
}

/// Eigenvectors with less than this share of the first one's variance are left out.
const LEAST_VARIANCE: f64 = 1e-9;

impl Default for SubspaceOptions {
    /// Returns 300 classifiers of 2 eigenvectors and at most 10 discriminants.
    fn default() -> Self {
        Self {
            classifiers: 300,
            eigenvectors: 2,
            discriminants: 10,
            seed: 1,
        }
    }
}

impl fmt::Display for SubspaceOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "Gabor features, {} random subspaces of {} eigenvectors, at most {} discriminants of each (seed {})",
            self.classifiers, self.eigenvectors, self.discriminants, self.seed
        )
    }
}

/// Classifiers in random subspaces of Gabor features, each of which is a part of the embedding.
pub struct RandomSubspaces {
    subspaces: SubspaceOptions,
    size: Size,
    gabor: Gabor,
    learnt: Learnt,
}

/// The classifiers that were learnt from matrices of one shape.
struct Learnt {
    mean: Array2<f32>,
    /// The eigenvectors, one a row, by descending variance.
    eigenvectors: Array2<f32>,
    classifiers: Vec<SubspaceClassifier>,
    /// Discriminants of each classifier; missing ones are filled with zeros.
    discriminants: usize,
}

/// A classifier in a random subspace.
struct SubspaceClassifier {
    /// Numbers of its eigenvectors.
    chosen: Vec<usize>,
    /// Discriminants, one a row.
    directions: Array2<f32>,
}

impl RandomSubspaces {
    /// Learns from GEIs.
    ///
    /// # Errors
    /// For other templates, features that are all the same, fewer than two people, and more
    /// eigenvectors than there are.
    pub fn fit(samples: &Samples, subspaces: SubspaceOptions) -> Result<Self> {
        if samples.template != Template::Gei {
            return Err(TrainError::OtherTemplate {
                method: "gabor-subspaces",
                expected: Template::Gei.plural(),
                found: samples.template.plural(),
            }
            .into());
        }
        let gabor = Gabor::new(samples.size);
        let features = gabor.features(samples.numbers.view());
        let (rows, columns) = gabor.shape;
        let features = features.into_shape_with_order((samples.labels.len(), rows, columns))?;
        let classes = samples.names.len();
        Ok(Self {
            subspaces,
            size: samples.size,
            gabor,
            learnt: Learnt::fit(features.view(), &samples.labels, classes, subspaces)?,
        })
    }

    /// Returns the length of an embedding, all parts together.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.learnt.dims()
    }

    /// Returns the contract of a model called `name` that was learnt from these samples.
    #[must_use]
    pub fn contract(&self, samples: &Samples, name: String) -> Contract {
        Contract {
            distance: Distance::Votes,
            ..samples.contract_of_embeddings(name, &self.subspaces.to_string())
        }
    }

    /// Returns a model file with an embedding `[N, numbers, parts]` that is compared by votes.
    ///
    /// # Guarantees
    /// Equal arguments give equal bytes.
    #[must_use]
    pub fn write(&self, name: &str) -> Vec<u8> {
        let mut file = OnnxFile::default();
        let input = add_input(&mut file, Template::Gei, self.size);
        self.gabor.write(&mut file, input, "features");
        self.learnt.write(&mut file, "features");
        file.bytes(name, &[])
    }
}

impl Learnt {
    fn fit(
        features: ArrayView3<'_, f32>,
        labels: &[usize],
        classes: usize,
        subspaces: SubspaceOptions,
    ) -> Result<Self> {
        let (count, rows, columns) = features.dim();
        let mean = features
            .mean_axis(Axis(0))
            .unwrap_or_else(|| Array2::zeros((rows, columns)));
        let eigenvectors = eigenvectors(features, &mean)?;
        let found = eigenvectors.nrows();
        let SubspaceOptions {
            classifiers,
            eigenvectors: each,
            discriminants: most,
            seed,
        } = subspaces;
        if each == 0 || each > found {
            return Err(TrainError::Subspace { found, each }.into());
        }
        // Each image along all eigenvectors, which classifiers choose from.
        let mut along = Vec::with_capacity(count * rows * found);
        for feature in features.outer_iter() {
            let offset = &feature - &mean;
            along.extend(multiply(eigenvectors.view(), offset.t()));
        }
        let along = Array3::from_shape_vec((count, found, rows), along);
        let along = along.expect("a row for each eigenvector");
        let scatters: Vec<Scatter<f64>> = (0..found)
            .into_par_iter()
            .map(|at| scatter(along.slice(s![.., at, ..]), labels, classes))
            .collect::<Result<_>>()?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draw = |_| {
            let mut chosen = sample(&mut random, found, each).into_vec();
            chosen.sort_unstable();
            chosen
        };
        let drawn: Vec<Vec<usize>> = (0..classifiers).map(draw).collect();
        let learn = |chosen: Vec<usize>| {
            let own = together(chosen.iter().map(|&at| &scatters[at]));
            let found = discriminants(own, count, classes, RIDGE, most)?;
            Ok(SubspaceClassifier {
                chosen,
                directions: found.directions.mapv(|number: f64| number as f32),
            })
        };
        let classifiers = drawn.into_par_iter().map(learn);
        let classifiers: Vec<SubspaceClassifier> = classifiers.collect::<Result<_>>()?;
        let discriminants = classifiers
            .iter()
            .map(|classifier| classifier.directions.nrows())
            .max();
        Ok(Self {
            mean,
            eigenvectors,
            discriminants: discriminants.unwrap_or(0),
            classifiers,
        })
    }

    /// Returns the length of an embedding: each classifier has its discriminants along each of its
    /// eigenvectors.
    fn dims(&self) -> usize {
        let each = self
            .classifiers
            .first()
            .map_or(0, |classifier| classifier.chosen.len());
        self.classifiers.len() * self.discriminants * each
    }

    /// Adds the operations from an input of features to embeddings: number i of classifier j is at
    /// `i * classifiers + j`.
    fn write(&self, file: &mut OnnxFile, input: &str) {
        let (rows, columns) = self.mean.dim();
        let parts = self.classifiers.len();
        let each = self
            .classifiers
            .first()
            .map_or(0, |classifier| classifier.chosen.len());
        file.numbers("mean", &[rows, columns], &self.mean);
        file.node("Sub", &[input, "mean"], "offsets");
        let eigenvectors = self.eigenvectors.t();
        let found = eigenvectors.ncols();
        file.numbers("eigenvectors", &[columns, found], eigenvectors);
        file.node("MatMul", &["offsets", "eigenvectors"], "along_all");
        let chosen = self
            .classifiers
            .iter()
            .flat_map(|classifier| &classifier.chosen);
        let chosen: Vec<i64> = chosen.map(|&at| at as i64).collect();
        file.integers("chosen", &chosen);
        let axis = [("axis", NodeAttribute::Integer(2))];
        file.node_with("Gather", &["along_all", "chosen"], "along", &axis);
        let order = [("perm", NodeAttribute::Integers(&[0, 2, 1]))];
        file.node_with("Transpose", &["along"], "by_eigenvector", &order);
        let shape = [0, parts, each, rows].map(|size| size as i64);
        file.integers("subspaces_shape", &shape);
        file.node(
            "Reshape",
            &["by_eigenvector", "subspaces_shape"],
            "subspaces",
        );
        let mut directions = Array3::zeros((parts, rows, self.discriminants));
        for (mut of_part, one) in directions.outer_iter_mut().zip(&self.classifiers) {
            let own = one.directions.nrows();
            of_part.slice_mut(s![.., ..own]).assign(&one.directions.t());
        }
        let sizes = [parts, rows, self.discriminants];
        file.numbers("discriminants", &sizes, &directions);
        file.node("MatMul", &["subspaces", "discriminants"], "numbers");
        let order = [("perm", NodeAttribute::Integers(&[0, 2, 3, 1]))];
        file.node_with("Transpose", &["numbers"], "by_number", &order);
        let numbers = each * self.discriminants;
        file.integers("embedding_shape", &[0, numbers as i64, parts as i64]);
        file.node("Reshape", &["by_number", "embedding_shape"], EMBEDDING);
        file.output(EMBEDDING, &[numbers, parts]);
    }
}

/// Finds the eigenvectors of two-dimensional PCA, one a row: those of the mean of
/// `(X - mean)^T (X - mean)`.
///
/// # Errors
/// If all features are the same.
fn eigenvectors(features: ArrayView3<'_, f32>, mean: &Array2<f32>) -> Result<Array2<f32>> {
    let columns = mean.ncols();
    let mut sum = Array2::<f64>::zeros((columns, columns));
    for feature in features.outer_iter() {
        let offset = (&feature - mean).mapv(f64::from);
        add_products_of_columns(offset.view(), &mut sum);
    }
    let found = eigen(&sum)?;
    let first = found.values.first().copied().unwrap_or_default();
    let is_direction = |value: &&f64| **value > LEAST_VARIANCE * first && **value > 0.0;
    let kept = found.values.iter().take_while(is_direction).count();
    if kept == 0 {
        return Err(TrainError::Constant.into());
    }
    let mut vectors = found.vectors.slice(s![..kept, ..]).to_owned();
    vectors.outer_iter_mut().for_each(fix_sign);
    Ok(vectors.mapv(|number| number as f32))
}

/// Computes the scatter of vectors, in f64.
///
/// # Errors
/// As [`Classes::averaged`].
fn scatter(points: ArrayView2<'_, f32>, labels: &[usize], classes: usize) -> Result<Scatter<f64>> {
    let points = points.mapv(f64::from);
    let of = Classes::averaged(points.view(), labels, classes)?;
    Ok(Scatter::compute(points.view(), labels, &of))
}

/// Combines the scatters of the columns of matrices (at least one).
fn together<'a>(columns: impl Iterator<Item = &'a Scatter<f64>>) -> Scatter<f64> {
    let mut all: Option<Scatter<f64>> = None;
    for one in columns {
        all = Some(match all {
            None => Scatter {
                within: one.within.clone(),
                offsets: one.offsets.clone(),
            },
            Some(Scatter { within, offsets }) => {
                let offsets = ndarray::concatenate(Axis(0), &[offsets.view(), one.offsets.view()]);
                Scatter {
                    within: within + &one.within,
                    offsets: offsets.expect("as many numbers in a row"),
                }
            }
        });
    }
    all.expect("a column")
}

#[cfg(test)]
mod tests;

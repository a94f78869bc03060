//! Many weak classifiers that vote: Gabor features of GEIs in random subspaces, after Guan & Li 2013,
//! "A robust speed-invariant gait recognition system for walker and runner identification", ICB.
//!
//! The eigenvectors of two-dimensional PCA (Yang, Zhang, Frangi & Yang 2004, IEEE Trans. Pattern Anal.
//! 26:131) of all features are found once. Each classifier draws some of them at random, and learns
//! two-dimensional discriminants (Li & Yuan 2005, Pattern Recognit. Lett. 26:527) along the other axis.
//! A probe is taken for whom most classifiers take it for ([`Distance::Votes`]).

use super::gabor::Gabor;
use crate::error::{Result, TrainError};
use crate::score::{Contract, Distance, Outputs, Recognizer, RuntimeName};
use crate::train::Samples;
use crate::train::algebra::{add_products_of_columns, eigen, multiply};
use crate::train::lda::discriminants;
use ndarray::{Array1, Array2, ArrayView2, ArrayView3, Axis, s};
use rand::SeedableRng;
use rand::seq::index::sample;
use rand_chacha::ChaCha8Rng;

/// How classifiers are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Subspaces {
    /// How many there are.
    pub classifiers: usize,
    /// Eigenvectors that each draws.
    pub eigenvectors: usize,
    /// Discriminants that each keeps, at most.
    pub discriminants: usize,
    /// Of the drawing.
    pub seed: u64,
}

/// Share of the mean variance that is added to the variance within classes. As LDA has it. Ours.
const RIDGE: f64 = 1e-3;

/// Features that vary less than this, as a share of the first eigenvector's, are no directions.
const LEAST_VARIANCE: f64 = 1e-9;

/// The votes of classifiers in random subspaces.
pub(crate) struct Votes {
    contract: Contract,
    runtime: RuntimeName,
    gabor: Gabor,
    learnt: Learnt,
}

/// What was learnt of matrices of one shape.
struct Learnt {
    mean: Array2<f32>,
    /// One a row, by falling variance.
    eigenvectors: Array2<f32>,
    classifiers: Vec<Classifier>,
    /// Discriminants of each; those that are fewer are filled up with nothing.
    discriminants: usize,
}

/// A random subspace.
struct Classifier {
    /// Which eigenvectors.
    chosen: Vec<usize>,
    /// Discriminants, one a row.
    directions: Array2<f32>,
}

impl Votes {
    /// Learns of GEIs.
    ///
    /// # Errors
    /// For features that are all the same, fewer than two people, and more eigenvectors than there are.
    pub(crate) fn fit(samples: &Samples, subspaces: Subspaces, contract: Contract) -> Result<Self> {
        let gabor = Gabor::new(samples.size);
        let features = gabor.features(samples.numbers.view());
        let (rows, columns) = gabor.shape;
        let shape = (features.nrows(), rows, columns);
        let features = features.into_shape_with_order(shape);
        let features = features.expect("a feature has as many numbers");
        let classes = samples.names.len();
        Ok(Self {
            contract: Contract {
                distance: Distance::Votes,
                ..contract
            },
            runtime: RuntimeName {
                name: "rust".into(),
                ..RuntimeName::default()
            },
            gabor,
            learnt: Learnt::fit(features.view(), &samples.labels, classes, subspaces)?,
        })
    }
}

impl Recognizer for Votes {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
        self.contract.frames_in(input.len(), batch)?;
        let images = ArrayView2::from_shape((batch, self.contract.numbers()), input);
        let images = images.expect("the contract's numbers, as checked");
        let (rows, columns) = self.gabor.shape;
        let mut embedding = Vec::new();
        for feature in self.gabor.features(images).outer_iter() {
            let feature = feature.into_shape_with_order((rows, columns));
            self.learnt
                .embed(feature.expect("a feature").view(), &mut embedding);
        }
        let mut outputs = Outputs {
            embedding,
            embedding_dims: self.learnt.dims(),
            embedding_parts: self.learnt.classifiers.len(),
            ..Outputs::default()
        };
        outputs.count_non_finite();
        Ok(outputs)
    }
}

impl Learnt {
    fn fit(
        features: ArrayView3<'_, f32>,
        labels: &[usize],
        classes: usize,
        subspaces: Subspaces,
    ) -> Result<Self> {
        let (count, rows, columns) = features.dim();
        let mean = features
            .mean_axis(Axis(0))
            .unwrap_or_else(|| Array2::zeros((rows, columns)));
        let eigenvectors = eigenvectors(features, &mean)?;
        let found = eigenvectors.nrows();
        let Subspaces {
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
        let along = ndarray::Array3::from_shape_vec((count, found, rows), along);
        let along = along.expect("a row for each eigenvector");
        let scatters: Vec<Scatter> = (0..found)
            .map(|at| Scatter::of(along.slice(s![.., at, ..]), labels, classes))
            .collect::<Result<_>>()?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draw = |_| {
            let mut chosen = sample(&mut random, found, each).into_vec();
            chosen.sort_unstable();
            let within = chosen.iter().map(|&at| &scatters[at].within);
            let within = within.fold(Array2::zeros((rows, rows)), |sum, one| sum + one);
            let offsets: Vec<_> = chosen
                .iter()
                .map(|&at| scatters[at].offsets.view())
                .collect();
            let offsets = ndarray::concatenate(Axis(0), &offsets);
            let offsets = offsets.expect("as many columns each");
            let found = discriminants(within, offsets.view(), (count, classes), RIDGE, most)?;
            Ok(Classifier {
                chosen,
                directions: found.directions.mapv(|number: f64| number as f32),
            })
        };
        let classifiers: Vec<Classifier> = (0..classifiers).map(draw).collect::<Result<_>>()?;
        let discriminants = classifiers.iter().map(|one| one.directions.nrows()).max();
        Ok(Self {
            mean,
            eigenvectors,
            discriminants: discriminants.unwrap_or(0),
            classifiers,
        })
    }

    /// Numbers of an embedding: of each classifier its discriminants along each of its eigenvectors.
    fn dims(&self) -> usize {
        let each = self.classifiers.first().map_or(0, |one| one.chosen.len());
        self.classifiers.len() * self.discriminants * each
    }

    /// Adds the embedding of a feature: number i of classifier j at `i * classifiers + j`.
    fn embed(&self, feature: ArrayView2<'_, f32>, embedding: &mut Vec<f32>) {
        let offset = &feature - &self.mean;
        let along = multiply(self.eigenvectors.view(), offset.t());
        let (first, parts) = (embedding.len(), self.classifiers.len());
        embedding.resize(first + self.dims(), 0.0);
        for (part, one) in self.classifiers.iter().enumerate() {
            for (number, &at) in one.chosen.iter().enumerate() {
                let found: Array1<f32> = one.directions.dot(&along.row(at));
                for (direction, value) in found.into_iter().enumerate() {
                    let number = number * self.discriminants + direction;
                    embedding[first + number * parts + part] = value;
                }
            }
        }
    }
}

/// The eigenvectors of two-dimensional PCA, one a row: of the mean of `(X - mean)^T (X - mean)`.
///
/// # Errors
/// If no number differs.
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
    vectors
        .outer_iter_mut()
        .for_each(crate::train::algebra::fix_sign);
    Ok(vectors.mapv(|number| number as f32))
}

/// How vectors scatter within classes, and where the means of these are.
struct Scatter {
    /// Lower triangle of the sum of the products of differences to the class mean.
    within: Array2<f64>,
    /// Differences of class means to the mean of all, times the root of how many there are.
    offsets: Array2<f64>,
}

impl Scatter {
    fn of(points: ArrayView2<'_, f32>, labels: &[usize], classes: usize) -> Result<Self> {
        let of = crate::train::lda::Classes::<f64>::averaged(points, labels, classes)?;
        let points = points.mapv(f64::from);
        let mean: Array1<f64> = points.mean_axis(Axis(0)).unwrap_or_default();
        let mut deviations = points;
        for (mut deviation, &label) in deviations.outer_iter_mut().zip(labels) {
            deviation -= &of.means.row(label);
        }
        let dims = deviations.ncols();
        let mut within = Array2::zeros((dims, dims));
        add_products_of_columns(deviations.view(), &mut within);
        let mut offsets = &of.means - &mean;
        for (mut offset, &count) in offsets.outer_iter_mut().zip(&of.counts) {
            offset *= (count as f64).sqrt();
        }
        Ok(Self { within, offsets })
    }
}

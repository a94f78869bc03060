//! Many weak classifiers that vote: Gabor features of GEIs in random subspaces, after Guan & Li 2013,
//! "A robust speed-invariant gait recognition system for walker and runner identification", ICB.
//!
//! The eigenvectors of two-dimensional PCA (Yang, Zhang, Frangi & Yang 2004, IEEE Trans. Pattern Anal.
//! 26:131) of all features are found once. Each classifier draws some of them at random, and learns
//! two-dimensional discriminants (Li & Yuan 2005, Pattern Recognit. Lett. 26:527) along the other axis.
//! A probe is taken for whom most classifiers take it for ([`crate::score::Distance::Votes`]).

use super::algebra::{add_products_of_columns, eigen, fix_sign, multiply};
use super::gabor::Gabor;
use super::lda::{Classes, Scatter, discriminants};
use super::onnx::add_input;
use super::onnx_file::{Attribute, OnnxFile};
use super::{RIDGE, Samples};
use crate::error::{Result, TrainError};
use crate::score::{Contract, Distance, EMBEDDING};
use crate::template::Template;
use edgegait_core::silhouette::Size;
use ndarray::{Array2, Array3, ArrayView2, ArrayView3, Axis, s};
use rand::SeedableRng;
use rand::seq::index::sample;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::fmt;

/// How classifiers are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subspaces {
    /// How many there are.
    pub classifiers: usize,
    /// Eigenvectors that each draws.
    pub eigenvectors: usize,
    /// Discriminants that each keeps, at most.
    pub discriminants: usize,
    /// Of the drawing.
    pub seed: u64,
}

/// Features that vary less than this, as a share of the first eigenvector's, are no directions.
const LEAST_VARIANCE: f64 = 1e-9;

impl Default for Subspaces {
    /// 300 classifiers of 2 eigenvectors and at most 10 discriminants.
    fn default() -> Self {
        Self {
            classifiers: 300,
            eigenvectors: 2,
            discriminants: 10,
            seed: 1,
        }
    }
}

impl fmt::Display for Subspaces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "Gabor features, {} random subspaces of {} eigenvectors, at most {} discriminants of each (seed {})",
            self.classifiers, self.eigenvectors, self.discriminants, self.seed
        )
    }
}

/// Classifiers in random subspaces of Gabor features: a part of the embedding each.
pub struct RandomSubspaces {
    subspaces: Subspaces,
    size: Size,
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

impl RandomSubspaces {
    /// Learns of GEIs.
    ///
    /// # Errors
    /// For other templates, features that are all the same, fewer than two people, and more
    /// eigenvectors than there are.
    pub fn fit(samples: &Samples, subspaces: Subspaces) -> Result<Self> {
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

    /// Numbers in an embedding, all parts together.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.learnt.dims()
    }

    /// The contract of a model called `name` that was learnt of these samples.
    #[must_use]
    pub fn contract(&self, samples: &Samples, name: String) -> Contract {
        Contract {
            distance: Distance::Votes,
            ..samples.contract_of_embeddings(name, &self.subspaces.to_string())
        }
    }

    /// A model file: an embedding `[N, numbers, parts]`, compared by votes.
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
            let found = discriminants(own, (count, classes), RIDGE, most)?;
            Ok(Classifier {
                chosen,
                directions: found.directions.mapv(|number: f64| number as f32),
            })
        };
        let classifiers = drawn.into_par_iter().map(learn);
        let classifiers: Vec<Classifier> = classifiers.collect::<Result<_>>()?;
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

    /// Adds what makes embeddings of an input of features: number i of classifier j is at
    /// `i * classifiers + j`.
    fn write(&self, file: &mut OnnxFile, input: &str) {
        let (rows, columns) = self.mean.dim();
        let parts = self.classifiers.len();
        let each = self.classifiers.first().map_or(0, |one| one.chosen.len());
        file.numbers("mean", &[rows, columns], &self.mean);
        file.node("Sub", &[input, "mean"], "offsets");
        let eigenvectors = self.eigenvectors.t();
        let found = eigenvectors.ncols();
        file.numbers("eigenvectors", &[columns, found], eigenvectors);
        file.node("MatMul", &["offsets", "eigenvectors"], "along_all");
        let chosen = self.classifiers.iter().flat_map(|one| &one.chosen);
        let chosen: Vec<i64> = chosen.map(|&at| at as i64).collect();
        file.integers("chosen", &chosen);
        let axis = [("axis", Attribute::Integer(2))];
        file.node_with("Gather", &["along_all", "chosen"], "along", &axis);
        let order = [("perm", Attribute::Integers(&[0, 2, 1]))];
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
        let order = [("perm", Attribute::Integers(&[0, 2, 3, 1]))];
        file.node_with("Transpose", &["numbers"], "by_number", &order);
        let numbers = each * self.discriminants;
        file.integers("embedding_shape", &[0, numbers as i64, parts as i64]);
        file.node("Reshape", &["by_number", "embedding_shape"], EMBEDDING);
        file.output(EMBEDDING, &[numbers, parts]);
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
    vectors.outer_iter_mut().for_each(fix_sign);
    Ok(vectors.mapv(|number| number as f32))
}

/// How vectors scatter, in f64.
///
/// # Errors
/// As [`Classes::averaged`].
fn scatter(points: ArrayView2<'_, f32>, labels: &[usize], classes: usize) -> Result<Scatter<f64>> {
    let points = points.mapv(f64::from);
    let of = Classes::averaged(points.view(), labels, classes)?;
    Ok(Scatter::of(points.view(), labels, &of))
}

/// The scatter of all columns of matrices, of that of each: of one at least.
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
mod tests {
    use super::*;
    use crate::score::{Model, Runtime};
    use crate::train::testing::{noise, people};
    use ndarray::Array1;

    impl Learnt {
        /// The embedding of a feature: number i of classifier j at `i * classifiers + j`.
        fn embed(&self, feature: ArrayView2<'_, f32>) -> Vec<f32> {
            let offset = &feature - &self.mean;
            let along = multiply(self.eigenvectors.view(), offset.t());
            let parts = self.classifiers.len();
            let mut embedding = vec![0.0; self.dims()];
            for (part, one) in self.classifiers.iter().enumerate() {
                for (number, &at) in one.chosen.iter().enumerate() {
                    let found: Array1<f32> = one.directions.dot(&along.row(at));
                    for (direction, value) in found.into_iter().enumerate() {
                        let number = number * self.discriminants + direction;
                        embedding[number * parts + part] = value;
                    }
                }
            }
            embedding
        }
    }

    const ONE: Subspaces = Subspaces {
        classifiers: 1,
        eigenvectors: 4,
        discriminants: 3,
        seed: 5,
    };

    /// Matrices of `rows` by `columns` of four people, told apart by their first row.
    fn features(count: usize, rows: usize, columns: usize) -> (Array3<f32>, Vec<usize>) {
        let labels: Vec<usize> = (0..count).map(|at| at % 4).collect();
        let grain = noise(count, rows * columns, 3);
        let features = Array3::from_shape_fn((count, rows, columns), |(at, row, column)| {
            let own = if row == 0 {
                (labels[at] * (column + 1)) as f64
            } else {
                0.0
            };
            (own + grain[[at, row * columns + column]]) as f32
        });
        (features, labels)
    }

    fn embedded(learnt: &Learnt, features: &Array3<f32>) -> Vec<Vec<f32>> {
        features
            .outer_iter()
            .map(|feature| learnt.embed(feature))
            .collect()
    }

    fn distance(a: &[f32], b: &[f32]) -> f64 {
        let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
        squares.sum::<f64>().sqrt()
    }

    #[test]
    fn a_subspace_of_all_eigenvectors_is_plain_two_dimensional_discriminants() {
        let (features, labels) = features(40, 6, 4);
        let learnt = Learnt::fit(features.view(), &labels, 4, ONE).expect("four people");
        // Without PCA: all eigenvectors only turn the columns, which no distance notices.
        let columns: Vec<Scatter<f64>> = (0..4)
            .map(|column| scatter(features.slice(s![.., .., column]), &labels, 4).expect("vectors"))
            .collect();
        let plain = discriminants(together(columns.iter()), (40, 4), RIDGE, 3).expect("directions");
        let embeddings = embedded(&learnt, &features);
        for (a, b) in [(0, 1), (0, 4), (7, 22), (38, 39)] {
            let between = |at: usize| features.slice(s![at, .., ..]).mapv(f64::from);
            let projected = plain.directions.dot(&(between(a) - between(b)));
            let expected = projected.iter().map(|x| x * x).sum::<f64>().sqrt();
            let found = distance(&embeddings[a], &embeddings[b]);
            assert!(
                (found - expected).abs() < 1e-3 * expected,
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn of_vectors_two_dimensional_discriminants_are_lda() {
        let (features, labels) = features(60, 5, 1);
        let one = Subspaces {
            eigenvectors: 1,
            ..ONE
        };
        let learnt = Learnt::fit(features.view(), &labels, 4, one).expect("four people");
        let points = features.index_axis(Axis(2), 0).mapv(f64::from);
        let lda =
            crate::train::lda::Lda::<f64>::fit(points.view(), &labels, 4, RIDGE).expect("LDA");
        let embeddings = embedded(&learnt, &features);
        for (a, b) in [(0, 1), (3, 30), (14, 59)] {
            let difference = &points.row(a) - &points.row(b);
            let projected = lda.directions.slice(s![..3, ..]).dot(&difference);
            let expected = projected.dot(&projected).sqrt();
            let found = distance(&embeddings[a], &embeddings[b]);
            assert!(
                (found - expected).abs() < 1e-4 * expected,
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn the_seed_draws_and_each_classifier_has_its_own_part() {
        let (features, labels) = features(40, 6, 8);
        let some = Subspaces {
            classifiers: 5,
            eigenvectors: 2,
            discriminants: 2,
            seed: 1,
        };
        let fit = |seed| {
            let drawn = Subspaces { seed, ..some };
            Learnt::fit(features.view(), &labels, 4, drawn).expect("four people")
        };
        let (one, again, other) = (fit(1), fit(1), fit(2));
        assert_eq!(one.dims(), 5 * 2 * 2);
        let chosen = |of: &Learnt| -> Vec<Vec<usize>> {
            of.classifiers
                .iter()
                .map(|one| one.chosen.clone())
                .collect()
        };
        assert_eq!(chosen(&one), chosen(&again));
        assert_ne!(chosen(&one), chosen(&other));
        assert!(
            chosen(&one)
                .iter()
                .all(|chosen| chosen[0] < chosen[1] && chosen[1] < 8)
        );
        // Classifier 3 alone is part 3.
        let alone = Learnt {
            classifiers: one.classifiers.into_iter().skip(3).take(1).collect(),
            ..again
        };
        let all = embedded(&fit(1), &features);
        let part: Vec<f32> = all[9].iter().skip(3).step_by(5).copied().collect();
        assert_eq!(embedded(&alone, &features)[9], part);
    }

    /// Samples of GEI-like images of these people.
    fn samples(count: usize, classes: usize) -> Samples {
        let (numbers, labels) = people(count, classes, 3);
        Samples {
            numbers,
            template: Template::Gei,
            size: Size::S50x30,
            framing: None,
            labels,
            views: vec![Some(0); count],
            names: (0..classes).map(|class| class.to_string()).collect(),
            found: count,
            training: crate::score::Training::default(),
        }
    }

    #[test]
    fn the_model_file_computes_the_votes_that_were_learnt() {
        let samples = samples(60, 6);
        let fitted = RandomSubspaces::fit(&samples, Subspaces::default()).expect("six people");
        let bytes = fitted.write("subspaces");
        // The kernels, and of 300 subspaces 56 by at most 10 discriminants.
        assert!(
            (400_000..2_000_000).contains(&bytes.len()),
            "{}",
            bytes.len()
        );
        assert_eq!(bytes, fitted.write("subspaces"));
        let contract = Contract {
            distance: Distance::Votes,
            ..Contract::default()
        };
        let model = Model::from_bytes("subspaces.onnx", bytes, contract).expect("a model");
        let recognizer = Runtime::rten().load(&model).expect("rten");
        let input: Vec<f32> = samples.numbers.slice(s![..5, ..]).iter().copied().collect();
        let outputs = recognizer.run(&input, 5).expect("an answer");
        assert_eq!(outputs.embedding_parts, 300);
        assert_eq!(outputs.embedding_dims, fitted.dims());
        let features = fitted.gabor.features(samples.numbers.slice(s![..5, ..]));
        for (at, feature) in features.outer_iter().enumerate() {
            let feature = feature.into_shape_with_order(fitted.gabor.shape);
            let expected = fitted.learnt.embed(feature.expect("a matrix"));
            let found = &outputs.embedding[at * fitted.dims()..][..fitted.dims()];
            let scale = expected
                .iter()
                .fold(0.0_f32, |most, one| most.max(one.abs()));
            for (found, expected) in found.iter().zip(&expected) {
                assert!(
                    (found - expected).abs() < 1e-4 * scale,
                    "{found} {expected}"
                );
            }
        }
    }

    #[test]
    fn other_templates_are_refused() {
        let other = Samples {
            template: Template::Mhi,
            ..samples(12, 2)
        };
        let refused = RandomSubspaces::fit(&other, Subspaces::default());
        assert_eq!(
            refused.err().expect("a refusal").to_string(),
            "gabor-subspaces learns of GEIs, found MHIs"
        );
    }

    #[test]
    fn what_cannot_be_learnt_is_refused() {
        let (all, labels) = features(40, 6, 4);
        let refused = |features: ArrayView3<'_, f32>, labels: &[usize], classes, how| {
            let refused = Learnt::fit(features, labels, classes, how);
            refused.err().expect("a refusal").to_string()
        };
        let five = Subspaces {
            eigenvectors: 5,
            ..ONE
        };
        assert_eq!(
            refused(all.view(), &labels, 4, five),
            "expected 1 to 4 eigenvectors of a random subspace, found 5"
        );
        assert_eq!(
            refused(
                Array3::ones((8, 6, 4)).view(),
                &[0, 1, 0, 1, 0, 1, 0, 1],
                2,
                ONE
            ),
            "all samples have the same features: there is nothing to learn from"
        );
        assert!(refused(all.view(), &[0; 40], 1, ONE).contains("at least 2"));
    }
}

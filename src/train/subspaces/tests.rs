use super::*;
use crate::inference::{Model, Runtime};
use crate::train::testing::{noise, people};
use ndarray::Array1;

impl Learnt {
    /// Returns the embedding of a feature: number i of classifier j at `i * classifiers + j`.
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

const ONE: SubspaceOptions = SubspaceOptions {
    classifiers: 1,
    eigenvectors: 4,
    discriminants: 3,
    seed: 5,
};

/// Returns matrices of `rows` by `columns` of four people, who differ in the first row.
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
    // Without PCA: all eigenvectors together only rotate the columns, which changes no distance.
    let columns: Vec<Scatter<f64>> = (0..4)
        .map(|column| scatter(features.slice(s![.., .., column]), &labels, 4).expect("vectors"))
        .collect();
    let plain = discriminants(together(columns.iter()), 40, 4, RIDGE, 3).expect("directions");
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
    let one = SubspaceOptions {
        eigenvectors: 1,
        ..ONE
    };
    let learnt = Learnt::fit(features.view(), &labels, 4, one).expect("four people");
    let points = features.index_axis(Axis(2), 0).mapv(f64::from);
    let lda = crate::train::lda::Lda::<f64>::fit(points.view(), &labels, 4, RIDGE).expect("LDA");
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
    let some = SubspaceOptions {
        classifiers: 5,
        eigenvectors: 2,
        discriminants: 2,
        seed: 1,
    };
    let fit = |seed| {
        let drawn = SubspaceOptions { seed, ..some };
        Learnt::fit(features.view(), &labels, 4, drawn).expect("four people")
    };
    let (one, again, other) = (fit(1), fit(1), fit(2));
    assert_eq!(one.dims(), 5 * 2 * 2);
    let chosen = |of: &Learnt| -> Vec<Vec<usize>> {
        of.classifiers
            .iter()
            .map(|classifier| classifier.chosen.clone())
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

/// Returns samples of GEI-like images of these people.
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
        training: crate::inference::Training::default(),
    }
}

#[test]
fn the_model_file_computes_the_votes_that_were_learnt() {
    let samples = samples(60, 6);
    let fitted = RandomSubspaces::fit(&samples, SubspaceOptions::default()).expect("six people");
    let bytes = fitted.write("subspaces");
    // The kernels, and 56 by at most 10 discriminants for each of 300 subspaces.
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
    let refused = RandomSubspaces::fit(&other, SubspaceOptions::default());
    assert_eq!(
        refused.err().expect("a refusal").to_string(),
        "gabor-subspaces learns from GEIs, found MHIs"
    );
}

#[test]
fn what_cannot_be_learnt_is_refused() {
    let (all, labels) = features(40, 6, 4);
    let refused = |features: ArrayView3<'_, f32>, labels: &[usize], classes, how| {
        let refused = Learnt::fit(features, labels, classes, how);
        refused.err().expect("a refusal").to_string()
    };
    let five = SubspaceOptions {
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

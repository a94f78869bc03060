//! Fits on made-up people, compared with slow arithmetic that is written out here.

use super::testing::{noise, people, small_recognizer};
use super::*;
use ndarray::Axis;

fn best(scores: &Array1<f32>) -> usize {
    (0..scores.len())
        .max_by(|&i, &j| scores[i].total_cmp(&scores[j]))
        .expect("a class")
}

fn centroids(recognizer: &LinearModel) -> &Array2<f32> {
    match &recognizer.classifier {
        Classifier::Centroids(centroids) => centroids,
        Classifier::Svm(_) => panic!("LDA has centroids"),
    }
}

#[test]
fn unseen_walks_of_known_people_are_recognized() {
    let (geis, labels) = people(300, 6, 3);
    let recognizer = fit(geis.view(), &labels, 6, TrainOptions::default()).expect("six people");
    assert_eq!((recognizer.dims(), recognizer.classes()), (5, 6));
    let (probes, truth) = people(120, 6, 4);
    let right = probes
        .outer_iter()
        .zip(&truth)
        .filter(|(gei, person)| {
            let embedding = recognizer.embedding.apply(*gei);
            best(&recognizer.scores(embedding.view())) == **person
        })
        .count();
    assert!(right >= 114, "{right} of 120");
}

#[test]
fn the_highest_score_is_the_nearest_centroid() {
    let (geis, labels) = people(200, 5, 3);
    let recognizer = fit(geis.view(), &labels, 5, TrainOptions::default()).expect("five people");
    for gei in people(40, 5, 8).0.outer_iter() {
        let embedding = recognizer.embedding.apply(gei);
        let distances = centroids(&recognizer).map_axis(Axis(1), |centroid| {
            -centroid
                .iter()
                .zip(&embedding)
                .map(|(a, b)| (a - b).powi(2))
                .sum::<f32>()
        });
        assert_eq!(best(&recognizer.scores(embedding.view())), best(&distances));
    }
}

#[test]
fn centroids_are_the_mean_embeddings_and_scatter_is_one() {
    let (geis, labels) = people(240, 3, 3);
    let recognizer = fit(geis.view(), &labels, 3, TrainOptions::default()).expect("three people");
    let mut sums = Array2::<f64>::zeros((3, 2));
    let embeddings: Vec<Array1<f64>> = geis
        .outer_iter()
        .map(|gei| recognizer.embedding.apply_f64(gei.mapv(f64::from).view()))
        .collect();
    for (embedding, &label) in embeddings.iter().zip(&labels) {
        let mut sum = sums.row_mut(label);
        sum += &(embedding / 80.0);
    }
    for (mean, centroid) in sums.iter().zip(centroids(&recognizer)) {
        assert!(
            (mean - f64::from(*centroid)).abs() < 1e-3,
            "{mean} {centroid}"
        );
    }
    for axis in 0..2 {
        let within: f64 = embeddings
            .iter()
            .zip(&labels)
            .map(|(e, &label)| (e[axis] - sums[[label, axis]]).powi(2))
            .sum::<f64>()
            / 237.0;
        assert!(
            (0.9..=1.0001).contains(&within),
            "the ridge takes a little: {within}"
        );
    }
}

#[test]
fn double_precision_agrees_with_single() {
    let recognizer = small_recognizer();
    for gei in people(10, 2, 5).0.outer_iter() {
        let single = recognizer.embedding.apply(gei);
        let double = recognizer.embedding.apply_f64(gei.mapv(f64::from).view());
        for (a, b) in single.iter().zip(&double) {
            assert!(
                (f64::from(*a) - b).abs() < 1e-4 * b.abs().max(1.0),
                "{a} {b}"
            );
        }
        let scores = recognizer.score_map().apply_f64(double.view());
        for (a, b) in recognizer.scores(single.view()).iter().zip(&scores) {
            assert!(
                (f64::from(*a) - b).abs() < 1e-3 * b.abs().max(1.0),
                "{a} {b}"
            );
        }
    }
}

#[test]
fn a_fit_is_the_same_on_every_thread_and_twice() {
    let (geis, labels) = people(60, 3, 3);
    let here = fit(geis.view(), &labels, 3, TrainOptions::default()).expect("three people");
    let there = std::thread::Builder::new()
        .spawn(move || fit(geis.view(), &labels, 3, TrainOptions::default()))
        .expect("a thread")
        .join()
        .expect("no panic")
        .expect("three people");
    assert_eq!(here, there);
}

#[test]
fn pixels_that_never_change_have_no_weight() {
    let recognizer = small_recognizer();
    assert!(
        recognizer
            .embedding
            .weights
            .column(0)
            .iter()
            .all(|w| *w == 0.0)
    );
    assert!(
        recognizer
            .embedding
            .weights
            .column(15)
            .iter()
            .all(|w| w.is_finite())
    );
}

#[test]
fn more_components_than_there_are_is_all_of_them() {
    let (geis, labels) = people(30, 3, 3);
    let options = TrainOptions {
        components: Components::Count(1500),
        ..TrainOptions::default()
    };
    let recognizer = fit(geis.view(), &labels, 3, options).expect("three people");
    assert!(recognizer.embedding.weights.iter().all(|w| w.is_finite()));
}

const SVM: TrainOptions = TrainOptions {
    components: Components::Count(20),
    method: TrainMethod::Svm { c: 1.0 },
};

#[test]
fn support_vector_machines_recognize_unseen_walks() {
    let (geis, labels) = people(300, 6, 3);
    let recognizer = fit(geis.view(), &labels, 6, SVM).expect("six people");
    assert_eq!((recognizer.dims(), recognizer.classes()), (20, 6));
    let (probes, truth) = people(120, 6, 4);
    let hits = probes.outer_iter().zip(&truth).filter(|(gei, person)| {
        let embedding = recognizer.embedding.apply(*gei);
        best(&recognizer.scores(embedding.view())) == **person
    });
    let right = hits.count();
    assert!(right >= 114, "{right} of 120");
}

#[test]
fn folded_support_vector_machines_score_like_those_on_centred_components() {
    let (geis, labels) = people(80, 4, 3);
    let recognizer = fit(geis.view(), &labels, 4, SVM).expect("four people");
    let pca = Pca::<f64>::fit(geis.view()).expect("varies");
    let points = pca.project(geis.view(), 20);
    let svm = Svm::fit(points.view(), &labels, 4, 1.0).expect("four people");
    let expected = points.dot(&svm.weights.t()) + &svm.bias;
    for (gei, expected) in geis.outer_iter().zip(expected.outer_iter()) {
        let scores = recognizer.scores(recognizer.embedding.apply(gei).view());
        for (a, b) in scores.iter().zip(expected) {
            assert!((f64::from(*a) - b).abs() < 1e-5, "{a} {b}");
        }
    }
}

#[test]
fn one_analysis_serves_any_number_of_components() {
    let (geis, labels) = people(60, 3, 3);
    let analysed = Analysed::<f64>::new(geis.view(), &labels, 3).expect("three people");
    for method in [TrainMethod::LDA, SVM.method] {
        for count in [1, 7, 1500] {
            let options = TrainOptions {
                components: Components::Count(count),
                method,
            };
            let alone = fit(geis.view(), &labels, 3, options).expect("three people");
            assert_eq!(analysed.fit(options).expect("three people"), alone);
        }
    }
}

/// Duplicated cycles change neither mean nor directions, only the divisor n - 1.
#[test]
fn duplicated_cycles_leave_the_directions_as_they_are() {
    let (geis, labels) = people(40, 4, 3);
    let twice = ndarray::concatenate![Axis(0), geis, geis];
    let once = Pca::<f64>::fit(geis.view()).expect("varies");
    let pca = Pca::<f64>::fit(twice.view()).expect("varies");
    for (index, (a, b)) in pca
        .components
        .outer_iter()
        .zip(once.components.outer_iter())
        .take(10)
        .enumerate()
    {
        assert!((a.dot(&b) - 1.0).abs() < 1e-9, "component {index}");
        let ratio = pca.eigenvalues[index] / once.eigenvalues[index];
        assert!((ratio - 2.0 * 39.0 / 79.0).abs() < 1e-9, "{ratio}");
    }
    let with = |c| TrainOptions {
        components: Components::Count(10),
        method: TrainMethod::Svm { c },
    };
    let both = [&labels[..], &labels].concat();
    let doubled = fit(twice.view(), &both, 4, with(1.0)).expect("four people");
    let heavier = fit(geis.view(), &labels, 4, with(2.0)).expect("four people");
    for (a, b) in doubled
        .score_map()
        .weights
        .iter()
        .zip(&heavier.score_map().weights)
    {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}

/// 12 GEIs have at most 11 components, of 1500 pixels whose corners never change.
#[test]
fn fewer_geis_than_pixels_are_learnt_by_heart() {
    let (geis, labels) = people(12, 3, 3);
    for method in [TrainMethod::LDA, SVM.method] {
        let options = TrainOptions {
            components: Components::Count(1500),
            method,
        };
        let recognizer = fit(geis.view(), &labels, 3, options).expect("three people");
        for (gei, &person) in geis.outer_iter().zip(&labels) {
            let embedding = recognizer.embedding.apply(gei);
            assert!(embedding.iter().all(|v| v.is_finite()));
            assert_eq!(best(&recognizer.scores(embedding.view())), person);
        }
        assert!(
            recognizer
                .embedding
                .weights
                .column(0)
                .iter()
                .all(|w| *w == 0.0)
        );
    }
}

/// `cargo test --release --lib single_precision -- --nocapture`
#[test]
fn training_in_single_precision_changes_scores_by_thousandths_and_nobody() {
    let (geis, labels) = people(400, 8, 3);
    let (probes, truth) = people(400, 8, 4);
    let double = Analysed::<f64>::new(geis.view(), &labels, 8).expect("eight people");
    let single = Analysed::<f32>::new(geis.view(), &labels, 8).expect("eight people");
    for (method, bound) in [(TrainMethod::LDA, 1e-3), (SVM.method, 1e-2)] {
        let options = TrainOptions { method, ..SVM };
        let [a, b] = [double.fit(options), single.fit(options)].map(|r| r.expect("eight people"));
        let (mut largest, mut difference, mut hits) = (0.0_f64, 0.0_f64, [0, 0]);
        for (gei, &person) in probes.outer_iter().zip(&truth) {
            let [a, b] = [&a, &b].map(|r| r.scores(r.embedding.apply(gei).view()));
            for (a, b) in a.iter().zip(&b) {
                largest = largest.max(f64::from(a.abs()));
                difference = difference.max(f64::from((a - b).abs()));
            }
            hits[0] += i32::from(best(&a) == person);
            hits[1] += i32::from(best(&b) == person);
        }
        let relative = difference / largest;
        println!(
            "{method} trained in f32: scores differ from those trained in f64 by at most {relative:.1e} of \
             the largest; of 400 unseen {} against {} right",
            hits[1], hits[0]
        );
        assert!(relative < bound, "{relative}");
        assert_eq!(hits[0], hits[1]);
    }
}

fn refusal(geis: Array2<f32>, labels: &[usize], classes: usize, options: TrainOptions) -> String {
    fit(geis.view(), labels, classes, options)
        .expect_err("nothing to learn")
        .to_string()
}

#[test]
fn samples_that_cannot_be_learnt_from_are_refused() {
    let (geis, labels) = people(6, 2, 3);
    let with = |components| TrainOptions {
        components,
        ..TrainOptions::default()
    };
    let text = refusal(
        Array2::zeros((4, 640)),
        &[0, 1, 0, 1],
        2,
        TrainOptions::default(),
    );
    assert_eq!(
        text,
        "expected GEIs of 50 x 30 = 1500, 64 x 44 = 2816 or 64 x 64 = 4096 pixels, found 640"
    );
    let text = refusal(
        Array2::zeros((4, 1500)),
        &[0, 1, 0, 1],
        2,
        TrainOptions::default(),
    );
    assert!(
        text.starts_with("classes 0 and 1 have the same mean"),
        "{text}"
    );
    let text = refusal(geis.clone(), &labels, 2, with(Components::Count(0)));
    assert_eq!(text, "expected at least 1 principal component, found 0");
    let text = refusal(
        geis.clone(),
        &labels,
        2,
        with(Components::Variance(f64::NAN)),
    );
    assert!(text.ends_with("found NaN"), "{text}");
    let text = refusal(
        geis.clone(),
        &labels,
        2,
        TrainOptions {
            method: TrainMethod::Lda { ridge: 0.0 },
            ..TrainOptions::default()
        },
    );
    assert_eq!(text, "expected a ridge above 0, found 0");
    let mut broken = geis;
    broken[[3, 7]] = f32::INFINITY;
    let text = refusal(broken, &labels, 2, TrainOptions::default());
    assert!(text.contains("not a finite number"), "{text}");
}

/// `cargo test --release --lib a_fit_of_8000 -- --ignored --nocapture`
///
/// Runs once with empty backgrounds, and once with grain in every pixel, the worst case: no pixel
/// can be left out, and 95 % of the variance needs more than a thousand components.
#[test]
#[ignore = "measures time: run in release"]
fn a_fit_of_8000_geis_takes_seconds() {
    let (geis, labels) = people(8000, 26, 3);
    let grain = noise(8000, 1500, 6).mapv(|v| v as f32);
    let grainy = (&geis * 0.5 + grain * 0.25 + 0.25).mapv(|v| v.clamp(0.0, 1.0));
    for (name, geis) in [("empty backgrounds", geis), ("grain everywhere", grainy)] {
        let start = std::time::Instant::now();
        let recognizer = fit(geis.view(), &labels, 26, TrainOptions::default()).expect("26 people");
        let (seconds, dims) = (start.elapsed().as_secs_f64(), recognizer.dims());
        println!("fit of 8000 x 1500, {name}: {seconds:.2} s, {dims} dims");
    }
}

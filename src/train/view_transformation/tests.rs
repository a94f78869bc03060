use super::*;
use crate::inference::{Model, Runtime, Training};
use crate::train::testing::noise;
use ndarray::{ArrayView1, array};

/// Returns the distances, at viewpoint `to`, of each person from a template that is transformed
/// there by the blocks' `P_i P_j^+`. (The root gives only lengths, so only differences can be
/// compared.)
fn transformed(people: &[Array2<f64>], (from, to): (usize, usize), x: &Array1<f64>) -> Array1<f64> {
    let blocks = blocks(people).expect("people");
    // The person `v` of the template, by least squares.
    let person = blocks[from].inverse.dot(x);
    let roots: Vec<Array1<f64>> = (0..people[to].ncols())
        .map(|at| {
            let own = blocks[to].inverse.dot(&people[to].column(at));
            blocks[to].root.dot(&(own - &person))
        })
        .collect();
    roots
        .iter()
        .map(|difference| difference.dot(difference).sqrt())
        .collect()
}

#[test]
fn the_worked_example_comes_out() {
    // Two people, (1, 0) and (0, 1) from the first viewpoint, (2, 0) and (1, 1) from the second:
    // (3, 4) becomes 3 (2, 0) + 4 (1, 1) = (10, 4), which is (8, 4) and (9, 3) away from them.
    let people = [
        array![[1.0, 0.0], [0.0, 1.0]],
        array![[2.0, 1.0], [0.0, 1.0]],
    ];
    let found = transformed(&people, (0, 1), &array![3.0, 4.0]);
    for (found, expected) in found.iter().zip([80.0_f64.sqrt(), 90.0_f64.sqrt()]) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

#[test]
fn more_people_than_numbers_are_decomposed_as_numpy_does() {
    // Three numbers of five people from two viewpoints; numpy.linalg.svd and pinv(rcond=1e-5) of
    // the same numbers.
    let both = noise(6, 5, 11);
    let people = [
        both.slice(s![..3, ..]).to_owned(),
        both.slice(s![3.., ..]).to_owned(),
    ];
    let found = transformed(&people, (0, 1), &array![0.5, -0.25, 1.0]);
    for (found, expected) in found.iter().zip(NUMPY) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

const NUMPY: [f64; 5] = [
    2.176571051811704,
    1.5503741816941923,
    1.2769172717247446,
    0.6758277718305609,
    1.5642677344881855,
];

/// Returns three people from two viewpoints, twice each. From the second viewpoint, their
/// differences are mirrored and half as large.
fn samples() -> Samples {
    let (own, grain) = (noise(3, 1500, 5), noise(12, 1500, 6));
    let numbers = Array2::from_shape_fn((12, 1500), |(at, pixel)| {
        let (person, view) = (at / 4, at % 2);
        let seen = match view {
            0 => own[[person, pixel]],
            _ => 0.5 * own[[person, 1499 - pixel]],
        };
        (0.5 + 0.2 * seen + 0.01 * grain[[at, pixel]]) as f32
    });
    Samples {
        numbers,
        template: Template::Gei,
        size: Size::S50x30,
        framing: None,
        labels: (0..12).map(|at| at / 4).collect(),
        views: (0..12).map(|at| Some(at % 2)).collect(),
        names: ["ann", "bob", "cy"].map(str::to_owned).to_vec(),
        found: 12,
        training: Training {
            viewpoints: vec![[90.0, 0.0], [0.0, 10.0]],
            ..Training::default()
        },
    }
}

#[test]
fn the_model_file_brings_people_to_the_probes_viewpoint() {
    let samples = samples();
    let fitted = ViewTransformation::fit(&samples, Components::Count(100)).expect("people");
    let contract = fitted.contract(&samples, "views".into());
    let bytes = fitted.write("views");
    assert_eq!(bytes, fitted.write("views"));
    let model = Model::from_bytes("views.onnx", bytes, contract.clone()).expect("a model");
    let recognizer = Runtime::rten().load(&model).expect("rten");
    let mut input = Vec::new();
    for at in 0..12 {
        input.extend(samples.numbers.row(at));
        let [azimuth, elevation] = samples.training.viewpoints[at % 2];
        contract
            .feed_view(Some((azimuth, elevation)), &mut input)
            .expect("a known one");
    }
    let outputs = recognizer.run(&input, 12).expect("an answer");
    assert_eq!(
        (outputs.embedding_dims, outputs.embedding_parts),
        (fitted.dims(), 2)
    );
    // By the definition: components, the viewpoint's inverse, each viewpoint's root.
    for (at, found) in outputs.embedding.chunks(fitted.dims()).enumerate() {
        let numbers = samples.numbers.row(at).mapv(f64::from);
        let person = fitted.blocks[at % 2]
            .inverse
            .dot(&fitted.components.apply_f64(numbers.view()));
        for (view, block) in fitted.blocks.iter().enumerate() {
            let expected = block.root.dot(&person);
            let part = found.iter().skip(view).step_by(2);
            for (found, expected) in part.zip(&expected) {
                let difference = (f64::from(*found) - expected).abs();
                assert!(difference < 1e-3, "{found} {expected}");
            }
        }
    }
    // From the other viewpoint, each person is nearest to themselves in the probe's part.
    let of =
        |at: usize| ArrayView1::from(&outputs.embedding[at * fitted.dims()..][..fitted.dims()]);
    for probe in [1, 5, 9] {
        let view = contract.view_number(Some((0.0, 10.0)));
        let gallery: Vec<_> = [0, 4, 8].map(|at| of(at).to_vec()).into();
        let gallery: Vec<&[f32]> = gallery.iter().map(Vec::as_slice).collect();
        let probe_embedding = of(probe).to_vec();
        let found =
            contract
                .distance
                .over_gallery(&probe_embedding, view, &gallery, &|entry| entry, 2);
        let nearest = (0..3).min_by(|&a, &b| found[a].total_cmp(&found[b]));
        assert_eq!(nearest, Some(probe / 4), "{found:?}");
    }
    // Without the viewpoint, and from one that it has not been trained on.
    let mut ignored = Vec::new();
    let said = contract.feed_view(None, &mut ignored).expect_err("unknown");
    assert!(
        said.to_string()
            .starts_with("views takes the viewpoint of each input")
    );
    let said = contract
        .feed_view(Some((45.0, 0.0)), &mut ignored)
        .expect_err("untrained");
    assert_eq!(
        said.to_string(),
        "views has not been trained on viewpoint 45,0: expected one of 90,0 0,10 (azimuth,elevation)"
    );
}

#[test]
fn a_contract_and_a_file_have_to_agree_about_the_viewpoint() {
    let samples = samples();
    let fitted = ViewTransformation::fit(&samples, Components::Count(5)).expect("people");
    let refused = |contract: Contract| {
        let refused = Model::from_bytes("m.onnx", fitted.write("m"), contract);
        refused.expect_err("no agreement").to_string()
    };
    let right = fitted.contract(&samples, "m".into());
    let input = "f32 [N, 1, 50, 30]";
    let both = "\"gei\" f32 [N, 1, 50, 30], \"view\" f32 [N, 2]";
    for (view_input, distance, said) in [
        (
            None,
            Distance::Euclidean,
            format!(
                "m.onnx: expected one input of {input}, found {both} (export a graph that takes images only; if it also takes viewpoints, name their input in its .toml: view_input = \"view\")"
            ),
        ),
        (
            Some("seen"),
            Distance::View,
            format!(
                "m.onnx: expected an input \"seen\" of viewpoints as the contract says, found {both}"
            ),
        ),
        (
            Some("gei"),
            Distance::View,
            "m.onnx: expected the viewpoints as f32 [N, 2], found \"gei\" f32 [N, 1, 50, 30]"
                .to_owned(),
        ),
    ] {
        let contract = Contract {
            view_input: view_input.map(str::to_owned),
            distance,
            ..right.clone()
        };
        assert_eq!(refused(contract), said);
    }
    let without = Contract {
        view_input: None,
        ..right.clone()
    };
    let said = without
        .check(std::path::Path::new("m.toml"))
        .expect_err("no input");
    assert_eq!(
        said.to_string(),
        "m.toml: distance: \"view\" compares the part of the probe's viewpoint: expected view_input and training.viewpoints, in the order of the parts"
    );
    // Sums: 5 components, 2 or 3 numbers of a person from these, and those from 2 viewpoints.
    let rank = (fitted.dims() / 2) as u64;
    let model = Model::from_bytes("m.onnx", fitted.write("m"), right).expect("a model");
    let macs = model.graph().macs(&[3, 1, 50, 30]);
    let components = fitted.components.weights.nrows() as u64;
    assert_eq!(
        macs,
        Ok(3 * (1500 * components + components * rank + 2 * rank * rank))
    );
}

#[test]
fn what_cannot_be_learnt_is_refused() {
    let refused = |samples: &Samples| {
        let refused = ViewTransformation::fit(samples, Components::Count(100));
        refused.err().expect("a refusal").to_string()
    };
    let mut missing = samples();
    for view in missing.views.iter_mut().skip(4).take(4) {
        *view = Some(0);
    }
    assert_eq!(
        refused(&missing),
        "view transformation needs each person from each viewpoint, but bob has no sample from azimuth 0, elevation 10"
    );
    let mut nowhere = samples();
    nowhere.views[3] = None;
    assert!(refused(&nowhere).contains("the angles of 1 are unknown"));
    let mut twice = samples();
    twice.training.viewpoints[1] = [450.0, 0.01];
    assert_eq!(
        refused(&twice),
        "view transformation needs different viewpoints, but [90.0, 0.0] and [450.0, 0.01] (azimuth, elevation) are the same"
    );
    let mut one = samples();
    one.training.viewpoints.truncate(1);
    assert_eq!(
        refused(&one),
        "view transformation needs at least 2 viewpoints with known angles, found 1"
    );
    let constant = Samples {
        numbers: Array2::ones((12, 1500)),
        ..samples()
    };
    assert_eq!(
        refused(&constant),
        "all samples have the same features: there is nothing to learn from"
    );
    let alone = Samples {
        labels: vec![0; 12],
        names: vec!["ann".into()],
        ..samples()
    };
    assert!(refused(&alone).contains("at least 2"));
}

//! Compares both runtimes with Rust arithmetic, and gives them broken files.

use super::testing::{
    bytes_of_a_dynamic_quantization, bytes_of_a_logarithm, bytes_of_a_mean_over_frames,
    bytes_with_operator, contract_of_sequences, ort_library, small_model,
};
use super::*;
use crate::train::{self, LinearModel, TrainOptions, testing::people};
use ndarray::Array1;
use std::path::Path;

/// Returns a model of twelve people, and GEIs that the fit has not seen, one after another.
fn twelve_people() -> (LinearModel, Vec<f32>) {
    let (geis, labels) = people(360, 12, 21);
    let recognizer =
        train::fit(geis.view(), &labels, 12, TrainOptions::default()).expect("12 people");
    let probes = people(64, 12, 22).0.into_raw_vec_and_offset().0;
    (recognizer, probes)
}

fn model_of(recognizer: &LinearModel) -> Model {
    let bytes = train::onnx::write(recognizer, "twelve", &[("people", "12")]);
    Model::from_bytes("twelve.onnx", bytes, Contract::default()).expect("our own model")
}

fn embed_f64(recognizer: &LinearModel, gei: &[f32]) -> Array1<f64> {
    let gei: Array1<f64> = gei.iter().map(|&pixel| f64::from(pixel)).collect();
    recognizer.embedding.apply_f64(gei.view())
}

/// Returns the largest difference over the largest magnitude.
fn relative(found: &[f32], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    found
        .iter()
        .zip(expected)
        .map(|(a, b)| (f64::from(*a) - b).abs())
        .fold(0.0, f64::max)
        / scale
}

/// Compares a runtime with the arithmetic of [`LinearModel`] in double precision.
fn assert_agrees_with_rust(runtime: &Runtime) {
    let (recognizer, probes) = twelve_people();
    let loaded = runtime.load(&model_of(&recognizer)).expect("our own model");
    let outputs = loaded.run(&probes, 64).expect("64 GEIs");
    assert_eq!(
        (outputs.embedding_dims, outputs.classes, outputs.non_finite),
        (11, 12, 0)
    );
    let (mut embeddings, mut scores) = (Vec::new(), Vec::new());
    for gei in probes.chunks_exact(1500) {
        let embedding = embed_f64(&recognizer, gei);
        scores.extend(recognizer.score_map().apply_f64(embedding.view()));
        embeddings.extend(embedding);
    }
    let found = outputs.scores.expect("the model has scores");
    let worst = [
        relative(&outputs.embedding, &embeddings),
        relative(&found, &scores),
    ];
    println!(
        "{} and Rust: embedding {:.1e}, scores {:.1e} relative",
        loaded.runtime(),
        worst[0],
        worst[1]
    );
    assert!(worst.iter().all(|worst| *worst <= 1e-4));
}

#[test]
fn the_embedded_runtime_computes_what_rust_computes() {
    assert_agrees_with_rust(&Runtime::rten());
    assert_eq!(Runtime::rten().name().name, "rten");
}

/// Compares the rows of a batch of seven with the same GEIs alone: equal within 1e-6 of the largest
/// number.
fn a_gei_scores_the_same_alone_and_among_seven(runtime: &Runtime) {
    let (recognizer, probes) = twelve_people();
    let loaded = runtime.load(&model_of(&recognizer)).expect("our own model");
    let seven = loaded.run(&probes[..7 * 1500], 7).expect("seven GEIs");
    let alone: Vec<f32> = probes
        .chunks_exact(1500)
        .take(7)
        .flat_map(|gei| loaded.run(gei, 1).expect("one GEI").embedding)
        .collect();
    let worst = relative(
        &alone,
        &seven
            .embedding
            .into_iter()
            .map(f64::from)
            .collect::<Vec<_>>(),
    );
    println!(
        "{}: batch of 1 and of 7: {worst:.1e} relative",
        loaded.runtime().name
    );
    assert!(worst <= 1e-6);
}

/// Loads the real library.
fn ort() -> Runtime {
    Runtime::ort(ort_library()).expect("the real library")
}

fn numbers_that_are_not_finite_are_counted(runtime: &Runtime) {
    let bytes = bytes_of_a_logarithm(None);
    let model = Model::from_bytes("log.onnx", bytes, Contract::default()).expect("a model");
    let mut geis = vec![1.0_f32; 2 * 1500];
    geis[0] = -1.0;
    geis[1500] = 0.0;
    geis[1501] = -2.0;
    let outputs = runtime
        .load(&model)
        .expect("plain operators")
        .run(&geis, 2)
        .expect("two");
    assert_eq!(
        (outputs.non_finite, outputs.embedding_dims),
        (3, 1500),
        "{:?}",
        runtime.name()
    );
    assert_eq!((outputs.scores, outputs.classes), (None, 0));
}

fn a_model_that_takes_one_gei_is_run_one_by_one(runtime: &Runtime) {
    let bytes = bytes_of_a_logarithm(Some(1));
    let model = Model::from_bytes("log.onnx", bytes, Contract::default()).expect("a model");
    let geis: Vec<f32> = (0..3 * 1500).map(|i| 1.0 + i as f32).collect();
    let outputs = runtime
        .load(&model)
        .expect("plain operators")
        .run(&geis, 3)
        .expect("three");
    assert_eq!(outputs.embedding.len(), 4500);
    assert!((outputs.embedding[4499] - 4500_f32.ln()).abs() < 1e-5);
}

/// Steps of 1 / 255 represent these numbers exactly. If they were scaled together with the other
/// input's numbers of up to 100, most would be 0.
fn batch_mates_do_not_change_what_a_dynamically_quantized_model_says(runtime: &Runtime) {
    let bytes = bytes_of_a_dynamic_quantization();
    let model = Model::from_bytes("steps.onnx", bytes, Contract::default()).expect("usable");
    let fine: Vec<f32> = (0..1500).map(|i| (i % 256) as f32 / 255.0).collect();
    let coarse = fine.iter().map(|number| 100.0 * number);
    let both: Vec<f32> = fine.iter().copied().chain(coarse).collect();
    let loaded = runtime.load(&model).expect("plain operators");
    let outputs = loaded.run(&both, 2).expect("two GEIs");
    for (found, expected) in outputs.embedding.iter().zip(&both) {
        assert!(
            (found - expected).abs() <= 1e-5 * expected.max(1.0),
            "{found} {expected}"
        );
    }
}

/// Runs two sequences of three frames with known means.
fn sequences_are_averaged_over_their_frames_into_parts(runtime: &Runtime) {
    let pixels = 64 * 44;
    let frame = |value: f32| (0..pixels).map(move |pixel| value + pixel as f32);
    let input: Vec<f32> = [1.0, 2.0, 6.0, 10.0, 20.0, 60.0]
        .into_iter()
        .flat_map(frame)
        .collect();
    for batch in [None, Some(1)] {
        let bytes = bytes_of_a_mean_over_frames(batch, None);
        let model = Model::from_bytes("mean.onnx", bytes, contract_of_sequences()).expect("usable");
        let loaded = runtime.load(&model).expect("plain operators");
        let outputs = loaded.run(&input, 2).expect("two sequences");
        assert_eq!(
            (outputs.embedding_dims, outputs.embedding_parts),
            (pixels, 44)
        );
        assert_eq!(outputs.embedding.len(), 2 * pixels);
        for (pixel, [first, second]) in [(0, [3.0, 30.0]), (2815, [2818.0, 2845.0])] {
            assert!((outputs.embedding[pixel] - first).abs() < 1e-3);
            assert!((outputs.embedding[pixels + pixel] - second).abs() < 1e-3);
        }
        let error = loaded
            .run(&input[1..], 2)
            .expect_err("a pixel short")
            .to_string();
        assert!(
            error.starts_with("mean: expected 2 equally long sequences of silhouettes of 64 x 44"),
            "{error}"
        );
    }
}

fn a_number_of_frames_that_the_contract_does_not_state_is_refused(runtime: &Runtime) {
    let contract = Contract {
        frames: Some(4),
        ..contract_of_sequences()
    };
    let bytes = bytes_of_a_mean_over_frames(None, None);
    let model = Model::from_bytes("mean.onnx", bytes, contract).expect("usable");
    let loaded = runtime.load(&model).expect("plain operators");
    assert!(loaded.run(&vec![0.0; 4 * 2816], 1).is_ok());
    assert!(loaded.run(&vec![0.0; 5 * 2816], 1).is_err());
}

fn batches_of_the_wrong_length_are_refused(runtime: &Runtime) {
    let loaded = runtime.load(&small_model()).expect("our own model");
    for (length, batch) in [(0, 0), (1499, 1), (1500, 2), (3000, 1), (1500, usize::MAX)] {
        let error = loaded
            .run(&vec![0.0; length], batch)
            .expect_err("wrong length")
            .to_string();
        assert!(
            error.starts_with(&format!("small: expected {batch} GEIs of 50 x 30")),
            "{error}"
        );
    }
    assert!(loaded.run(&[0.5; 1500], 1).is_ok());
}

fn broken_models_are_refused_by_both_runtimes_without_a_panic(runtime: &Runtime) {
    let whole = small_model().bytes().to_vec();
    let noise: Vec<u8> = (0..5000_u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    let mut broken = vec![Vec::new(), noise, b"not a model".to_vec()];
    broken.extend((1..40).map(|i| whole[..whole.len() * i / 40].to_vec()));
    let mut refused = 0;
    for bytes in broken {
        let Ok(model) = Model::from_bytes("m.onnx", bytes, Contract::default()) else {
            refused += 1;
            continue;
        };
        assert!(runtime.load(&model).is_err());
    }
    assert!(refused >= 40, "{refused}");
}

fn changed_bytes_are_an_error_or_a_model_but_never_a_panic(runtime: &Runtime) {
    let whole = small_model().bytes().to_vec();
    let structure = (0..160).chain(whole.len() - 300..whole.len());
    for at in structure {
        for flip in [0x01, 0x10, 0x80] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            let Ok(model) = Model::from_bytes("m.onnx", bytes, Contract::default()) else {
                continue;
            };
            if let Ok(loaded) = runtime.load(&model) {
                let _ = loaded.run(&[0.5; 1500], 1);
            }
        }
    }
}

#[test]
fn libraries_that_cannot_be_used_are_errors() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = folder.path().join("text.so");
    std::fs::write(&text, "not a library").expect("written");
    assert!(Runtime::ort(&text).is_err());
    assert!(Runtime::ort(folder.path().join("missing.so")).is_err());
}

#[test]
fn operators_that_the_embedded_runtime_lacks_are_named() {
    let bytes = bytes_with_operator("LRN", "");
    let model = Model::from_bytes("lrn.onnx", bytes, Contract::default()).expect("a graph");
    let error = Runtime::rten()
        .load(&model)
        .map(|_| ())
        .expect_err("no LRN")
        .to_string();
    assert!(
        error.ends_with("the embedded runtime has no LRN"),
        "{error}"
    );
}

/// Writes a model, GEIs and the scores that Rust computes, for a check in Python.
///
/// `EDGEGAIT_ONNX_OUT=/tmp/x.onnx cargo test --lib writes_a_model -- --ignored`
#[test]
#[ignore = "writes a file for onnx.checker"]
fn writes_a_model_its_probes_and_its_scores() {
    let path = std::env::var_os("EDGEGAIT_ONNX_OUT").expect("EDGEGAIT_ONNX_OUT names a file");
    let path = Path::new(&path);
    let (recognizer, probes) = twelve_people();
    let model = model_of(&recognizer);
    std::fs::write(path, model.bytes()).expect("written");
    let raw = |numbers: &[f32]| {
        numbers
            .iter()
            .flat_map(|n| n.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    std::fs::write(path.with_extension("geis.f32"), raw(&probes)).expect("written");
    let scores: Vec<f32> = probes
        .chunks_exact(1500)
        .flat_map(|gei| {
            let embedding = embed_f64(&recognizer, gei);
            recognizer.score_map().apply_f64(embedding.view())
        })
        .map(|score| score as f32)
        .collect();
    std::fs::write(path.with_extension("scores.f32"), raw(&scores)).expect("written");
}

/// Runs each of these checks with the embedded runtime and with ONNX Runtime.
macro_rules! both_runtimes {
    ($($check:ident)*) => {
        mod both_runtimes {
            mod embedded {
                $(#[test]
                fn $check() {
                    super::super::$check(&crate::inference::Runtime::rten());
                })*
            }

            mod with_ort {
                $(#[test]
                #[ignore = "needs EDGEGAIT_ORT_LIB"]
                fn $check() {
                    super::super::$check(&super::super::ort());
                })*
            }
        }
    };
}

both_runtimes! {
    a_gei_scores_the_same_alone_and_among_seven
    numbers_that_are_not_finite_are_counted
    a_model_that_takes_one_gei_is_run_one_by_one
    batch_mates_do_not_change_what_a_dynamically_quantized_model_says
    sequences_are_averaged_over_their_frames_into_parts
    a_number_of_frames_that_the_contract_does_not_state_is_refused
    batches_of_the_wrong_length_are_refused
    broken_models_are_refused_by_both_runtimes_without_a_panic
    changed_bytes_are_an_error_or_a_model_but_never_a_panic
}

mod with_ort {
    use super::*;

    #[test]
    #[ignore = "needs EDGEGAIT_ORT_LIB"]
    fn onnx_runtime_computes_what_rust_and_the_embedded_runtime_compute() {
        let ort = ort();
        assert_agrees_with_rust(&ort);
        assert!(ort.name().version.starts_with("1."), "{:?}", ort.name());

        let (recognizer, probes) = twelve_people();
        let model = model_of(&recognizer);
        let [a, b] = [Runtime::rten(), ort].map(|runtime| {
            runtime
                .load(&model)
                .expect("our own model")
                .run(&probes, 64)
                .expect("64 GEIs")
        });
        let b_embedding: Vec<f64> = b.embedding.iter().copied().map(f64::from).collect();
        let worst = relative(&a.embedding, &b_embedding);
        println!("rten and ONNX Runtime: embedding {worst:.1e} relative");
        assert!(worst <= 1e-5);
    }

    #[test]
    #[ignore = "needs EDGEGAIT_ORT_LIB"]
    fn a_cut_or_a_second_library_is_an_error_and_the_right_one_still_loads() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = ort_library();
        let bytes = std::fs::read(&path).expect("readable");
        let cut = folder.path().join("cut.so");
        std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).expect("written");
        let error = Runtime::ort(&cut).expect_err("cut short").to_string();
        assert!(error.contains("cut short"), "{error}");
        Runtime::ort(&path).expect("the real library");
        let copy = folder.path().join("copy.so");
        std::fs::copy(&path, &copy).expect("copied");
        let error = Runtime::ort(&copy).expect_err("a second one").to_string();
        assert!(
            error.contains("a process can load only one ONNX Runtime"),
            "{error}"
        );
    }

    #[test]
    #[ignore = "needs EDGEGAIT_ORT_LIB"]
    fn operators_that_the_embedded_runtime_lacks_reach_it() {
        let bytes = bytes_with_operator("LRN", "");
        let model = Model::from_bytes("lrn.onnx", bytes, Contract::default()).expect("a graph");
        // Without its attribute `size`, ONNX Runtime rejects it too, but for that reason.
        let error = ort()
            .load(&model)
            .map(|_| ())
            .expect_err("no size")
            .to_string();
        assert!(error.contains("ONNX Runtime refuses the model"), "{error}");
    }
}

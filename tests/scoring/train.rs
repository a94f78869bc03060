//! Tests of `edgegait train`: methods, numbers of components, precision.

use crate::command::{done, refused};
use serde_json::Value;
use std::path::Path;

/// Returns the JSON results of a command that must succeed.
fn results(dir: &Path, arguments: &[&str]) -> Value {
    let text = done(dir, &[arguments, &["--json", "-"]].concat());
    serde_json::from_str(&text).expect("one JSON document")
}

/// The first six people of the built-in cohort.
const PEOPLE: [&str; 2] = ["--subjects", "F01,M01,F02,M02,F03,M03"];

#[test]
fn support_vector_machines_of_several_sizes_are_trained_at_once_and_scored() {
    let dir = tempfile::tempdir().expect("a folder");
    let recipe = [
        "train",
        "--method",
        "svm",
        "--components",
        "1,12",
        "--out",
        "six.onnx",
    ];
    let trained = results(dir.path(), &[recipe.as_slice(), &PEOPLE].concat());
    assert_eq!(trained["settings"]["method"], "linear SVM (C 1)");
    assert_eq!(trained["settings"]["components"], "1,12");
    let models = trained["models"].as_array().expect("a list");
    let dims: Vec<_> = models.iter().map(|model| model["dims"].as_u64()).collect();
    assert_eq!(dims, [Some(1), Some(12)]);
    assert_eq!(models[1]["training_rank1"], 1.0);
    assert!(!dir.path().join("six.onnx").exists());
    let contract = std::fs::read_to_string(dir.path().join("six-12.toml")).expect("a contract");
    assert!(
        contract.contains("PCA (12) + linear SVM (C 1) on walk-5kmh of"),
        "{contract}"
    );

    let score = ["score", "six-1.onnx", "six-12.onnx", "--views", "side"];
    let scored = results(dir.path(), &[score.as_slice(), &PEOPLE].concat());
    let rank1 = |model: usize| {
        scored["recognizers"][model]["rank1"]
            .as_f64()
            .expect("a rate")
    };
    assert!(
        rank1(1) > 0.9 && rank1(1) > rank1(0),
        "{} {}",
        rank1(0),
        rank1(1)
    );
}

#[test]
fn a_model_trained_in_single_precision_says_so() {
    let dir = tempfile::tempdir().expect("a folder");
    let recipe = ["train", "--precision", "f32", "--out", "single.onnx"];
    let trained = results(dir.path(), &[recipe.as_slice(), &PEOPLE].concat());
    assert_eq!(trained["settings"]["precision"], "f32");
    let contract = std::fs::read_to_string(dir.path().join("single.toml")).expect("a contract");
    assert!(
        contract.contains("PCA (100) + LDA trained in f32 on "),
        "{contract}"
    );
}

#[test]
fn recipes_that_make_no_sense_are_refused_before_anything_is_drawn() {
    let dir = tempfile::tempdir().expect("a folder");
    for (recipe, expected) in [
        (["--svm-c", "2"].as_slice(), "other methods have none"),
        (&["--components", "5,7,5"], "5 appears twice"),
        (&["--components", "0"], "0 is not in 1..=4096"),
        (
            &["--method", "svm", "--svm-c", "0"],
            "expected a C above 0, found 0",
        ),
        (&["--method", "forest"], "lda, real-synthetic, svm"),
    ] {
        refused(dir.path(), &[&["train"], recipe].concat(), 2, &[expected]);
    }
    assert_eq!(std::fs::read_dir(dir.path()).expect("a folder").count(), 0);
}

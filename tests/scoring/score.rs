//! Tests of `edgegait score`, from walks to a scored recognizer.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn edgegait(dir: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_edgegait"))
        .args(arguments)
        .current_dir(dir)
        .env("EDGEGAIT_CACHE", "none")
        .env_remove("EDGEGAIT_ORT_LIB")
        .output()
        .expect("the command starts")
}

/// Returns the JSON results of a command that must succeed.
fn results(dir: &Path, arguments: &[&str]) -> Value {
    let output = edgegait(dir, &[arguments, &["--json", "-"]].concat());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
    serde_json::from_slice(&output.stdout).expect("one JSON document")
}

/// Returns the error of a command that must fail with `code`.
fn refusal(dir: &Path, arguments: &[&str], code: i32) -> String {
    let output = edgegait(dir, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    String::from_utf8(output.stderr).expect("UTF-8")
}

/// Returns results without values that differ between two equal runs.
fn without_timings(value: &Value) -> Value {
    let mut value = value.clone();
    value["seconds"].take();
    for recognizer in value["recognizers"].as_array_mut().expect("a list") {
        for key in ["p50_us", "p90_us", "p99_us"] {
            recognizer[key].take();
        }
    }
    value
}

fn rank1(results: &Value, recognizer: usize) -> f64 {
    results["recognizers"][recognizer]["rank1"]
        .as_f64()
        .expect("a rate")
}

/// Returns a folder with a pack of six people at one speed.
fn six_people() -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("a folder");
    let cohort = [
        "cohort",
        "--people",
        "6",
        "--speeds-kmh",
        "5",
        "--out",
        "six.egp",
    ];
    results(dir.path(), &cohort);
    dir
}

const FEW_VIEWS: [&str; 4] = ["--azimuth-deg", "0,60,90", "--elevation-deg", "0,30"];

#[test]
fn a_recognizer_knows_its_people_where_it_was_trained_and_less_elsewhere() {
    let dir = six_people();
    let trained = results(dir.path(), &["train", "six.egp", "--out", "six.onnx"]);
    assert_eq!(trained["samples"], 48); // 6 people, 8 cycles, 1 viewpoint
    assert_eq!(trained["classes"], 6);
    assert_eq!(trained["models"][0]["dims"], 5); // one fewer than the classes
    let scored = results(
        dir.path(),
        &[
            &["score", "six.onnx", "six.egp", "--cycles", "4"],
            FEW_VIEWS.as_slice(),
        ]
        .concat(),
    );
    let recognizer = &scored["recognizers"][0];
    assert_eq!(recognizer["protocol"], "closed-set");
    assert_eq!(recognizer["probes"], 6 * 4 * 6);
    assert_eq!(recognizer["non_finite"], 0);
    let at = |azimuth: f64, elevation: f64| {
        let views = recognizer["by_viewpoint"].as_array().expect("a list");
        let found = views
            .iter()
            .find(|view| view["azimuth_deg"] == azimuth && view["elevation_deg"] == elevation);
        found.expect("a viewpoint")["rank1"]
            .as_f64()
            .expect("a rate")
    };
    assert!(at(90.0, 0.0) > 0.9, "{}", at(90.0, 0.0));
    assert!(at(0.0, 30.0) < 0.6, "{}", at(0.0, 30.0));
    assert!(dir.path().join("edgegait-report/index.html").is_file());
}

#[test]
fn scores_are_the_same_twice_and_on_any_number_of_threads() {
    let dir = six_people();
    let score = |threads: &str| {
        let arguments = ["score", "six.egp", "--threads", threads];
        without_timings(&results(
            dir.path(),
            &[arguments.as_slice(), FEW_VIEWS.as_slice()].concat(),
        ))
    };
    let one = score("1");
    assert_eq!(one, score("1"));
    assert_eq!(one, score("3"));
}

#[test]
fn another_seed_probes_with_other_cycles() {
    let dir = six_people();
    let geis = |seed: &str| {
        let out = format!("seed{seed}");
        let sweep = [
            "sweep", "six.egp", "--views", "side", "--cycles", "2", "--seed", seed,
        ];
        results(dir.path(), &[sweep.as_slice(), &["--out", &out]].concat());
        std::fs::read(dir.path().join(out).join("geis.npy")).expect("GEIs")
    };
    let (one, two) = (geis("1"), geis("2"));
    assert_eq!(one.len(), two.len());
    assert_ne!(one, two);
}

#[test]
fn a_dataset_is_scored_like_the_walks_that_it_was_made_of() {
    let dir = six_people();
    // New people with two walks each: the first is enrolled, the second is the probe.
    let cohort = [
        "cohort",
        "--people",
        "4",
        "--speeds-kmh",
        "4,5",
        "--seed",
        "9",
    ];
    results(
        dir.path(),
        &[cohort.as_slice(), &["--out", "two.egp"]].concat(),
    );
    let views = [
        "--azimuth-deg",
        "0,30,60,90,120,150,180",
        "--elevation-deg",
        "0,30,60",
    ];
    let walks = results(
        dir.path(),
        &[["score", "two.egp"].as_slice(), views.as_slice()].concat(),
    );
    assert_eq!(walks["recognizers"][1]["protocol"], "first-take");
    assert_eq!(walks["recognizers"][1]["classes"], 4);
    let sweep = ["sweep", "two.egp", "--out", "two"];
    results(dir.path(), &[sweep.as_slice(), views.as_slice()].concat());
    let dataset = results(dir.path(), &["score", "two"]);
    for recognizer in 0..2 {
        assert_eq!(
            walks["recognizers"][recognizer]["by_viewpoint"],
            dataset["recognizers"][recognizer]["by_viewpoint"]
        );
    }
    assert!(rank1(&walks, 1) > 0.5, "{}", rank1(&walks, 1));
}

#[test]
fn people_of_another_seed_are_not_taken_for_those_whom_the_models_know() {
    let dir = tempfile::tempdir().expect("a folder");
    let cohort = [
        "cohort",
        "--people",
        "3",
        "--speeds-kmh",
        "5",
        "--seed",
        "2",
    ];
    results(
        dir.path(),
        &[cohort.as_slice(), &["--out", "other.egp"]].concat(),
    );
    let scored = results(dir.path(), &["score", "other.egp", "--views", "side"]);
    assert_eq!(scored["recognizers"][0]["protocol"], "first-take");
    let warnings = scored["warnings"].as_array().expect("a list");
    assert!(
        warnings[0]
            .as_str()
            .is_some_and(|w| w.contains("variations"))
    );
}

#[test]
fn training_from_a_dataset_equals_training_from_its_walks() {
    let dir = six_people();
    let sweep = [
        "sweep", "six.egp", "--views", "side", "--cycles", "8", "--out", "side",
    ];
    results(dir.path(), &sweep);
    let a = results(dir.path(), &["train", "side", "--out", "a.onnx"]);
    let b = results(dir.path(), &["train", "six.egp", "--out", "b.onnx"]);
    assert_eq!(a["samples"], b["samples"]);
    let score = |model: &str| {
        let scored = results(
            dir.path(),
            &[["score", model, "six.egp"].as_slice(), FEW_VIEWS.as_slice()].concat(),
        );
        scored["recognizers"][0]["by_viewpoint"].clone()
    };
    assert_eq!(score("a.onnx"), score("b.onnx"));
}

#[test]
fn what_cannot_be_scored_is_refused_by_name() {
    let dir = six_people();
    std::fs::write(dir.path().join("empty.onnx"), b"").expect("a file");
    let error = refusal(dir.path(), &["score", "empty.onnx", "six.egp"], 1);
    assert!(error.contains("empty.onnx"), "{error}");
    let error = refusal(dir.path(), &["score", "six.egp", "six.egp"], 2);
    assert!(
        error.contains("expected one pack, dataset or tree"),
        "{error}"
    );
    let library = ["--runtime", "ort", "--ort-lib", "six.egp"];
    let error = refusal(
        dir.path(),
        &[["score", "six.egp"].as_slice(), &library].concat(),
        1,
    );
    assert!(error.contains("six.egp"), "{error}");
    assert!(!dir.path().join("edgegait-report").exists());
    let error = refusal(dir.path(), &["train", "six.egp", "--out", "six.pt"], 2);
    assert!(error.contains(".onnx"), "{error}");
}

#[test]
fn recorded_walks_that_cannot_be_used_are_refused_together_and_nothing_is_written() {
    let dir = tempfile::tempdir().expect("a folder");
    std::fs::write(dir.path().join("a_1.bvh"), "HIERARCHY\nnonsense\n").expect("a file");
    std::fs::write(dir.path().join("b_1.bvh"), "").expect("a file");
    let error = refusal(
        dir.path(),
        &["import", "a_1.bvh", "b_1.bvh", "--out", "x.egp"],
        1,
    );
    assert!(error.contains("a_1.bvh:2"), "{error}");
    assert!(error.contains("b_1.bvh"), "{error}");
    assert!(!dir.path().join("x.egp").exists());
}

#[test]
fn a_dataset_is_used_whole_and_training_on_it_is_noticed() {
    let dir = six_people();
    let sweep = [
        "sweep", "six.egp", "--views", "side", "--cycles", "4", "--out", "seen",
    ];
    results(dir.path(), &sweep);
    results(dir.path(), &["train", "seen", "--out", "a.onnx"]);
    let warnings = |dataset: &str| {
        let scored = results(dir.path(), &["score", "a.onnx", dataset, "--no-baselines"]);
        scored["warnings"].as_array().expect("a list").clone()
    };
    let seen = warnings("seen");
    assert!(
        seen[0]
            .as_str()
            .is_some_and(|w| w.contains("24 of 24 probes")),
        "{seen:?}"
    );
    let unseen = [
        "sweep",
        "six.egp",
        "--views",
        "side",
        "--first-cycle",
        "1000",
    ];
    results(
        dir.path(),
        &[unseen.as_slice(), &["--out", "unseen"]].concat(),
    );
    assert_eq!(
        warnings("unseen"),
        [
            "a: 6 of 6 probes are seeded variations of cycles that it was trained on, not other walks: rank-1 shows only its robustness to noise and viewpoint"
        ]
    );
    for flag in [
        ["--views", "side"],
        ["--cycles", "2"],
        ["--raster", "skia-aa"],
        ["--frames-per-cycle", "8"],
        ["--subjects", "F01"],
    ] {
        let score = [["score", "a.onnx", "seen"].as_slice(), &flag].concat();
        assert!(refusal(dir.path(), &score, 2).contains(flag[0]));
        let train = [["train", "seen", "--out", "b.onnx"].as_slice(), &flag].concat();
        assert!(refusal(dir.path(), &train, 2).contains(flag[0]));
    }
}

#[test]
fn results_that_could_not_be_written_are_refused_before_the_work() {
    let dir = six_people();
    let error = refusal(dir.path(), &["score", "six.egp", "--out", "six.egp"], 2);
    assert!(error.contains("expected a folder"), "{error}");
    let train = [
        "train",
        "six.egp",
        "--out",
        "m.onnx",
        "--json",
        "six.egp/x.json",
    ];
    let error = refusal(dir.path(), &train, 1);
    assert!(error.contains("six.egp/x.json"), "{error}");
    assert!(!dir.path().join("m.onnx").exists());
}

/// Returns the runtimes in the results of the pixel baseline and of a trained model.
fn runtimes_of(dir: &Path, more: &[&str]) -> [Value; 2] {
    let train = [
        "train", "six.egp", "--views", "side", "--cycles", "2", "--out", "m.onnx",
    ];
    results(dir, &train);
    let score = ["score", "pixels", "m.onnx", "six.egp", "--views", "side"];
    let scored = results(dir, &[&score, more].concat());
    [0, 1].map(|index| scored["recognizers"][index]["runtime"].clone())
}

#[test]
fn results_state_runtime_version_and_provider() {
    let dir = six_people();
    let [pixels, model] = runtimes_of(dir.path(), &[]);
    assert_eq!(pixels["name"], "none");
    assert_eq!([&model["name"], &model["provider"]], ["rten", "cpu"]);
}

mod with_ort {
    use super::*;

    #[test]
    #[ignore = "needs EDGEGAIT_ORT_LIB"]
    fn results_state_runtime_version_and_provider() {
        let dir = six_people();
        let library = std::env::var("EDGEGAIT_ORT_LIB").expect("EDGEGAIT_ORT_LIB");
        let ort = ["--runtime", "ort", "--ort-lib", &library];
        let [_, model] = runtimes_of(dir.path(), &ort);
        assert_eq!([&model["name"], &model["provider"]], ["onnxruntime", "cpu"]);
        let version = model["version"].as_str().expect("a version");
        assert!(version.starts_with("1."), "{version}");
        let rknpu = [&["score", "six.egp"], &ort[..], &["--provider", "rknpu"]].concat();
        let error = refusal(dir.path(), &rknpu, 2);
        let expected = "--provider rknpu: expected a library that was built with rknpu, found cpu";
        assert!(error.contains(expected), "{error}");
    }
}

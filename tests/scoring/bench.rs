//! Tests of `edgegait bench`, with windows that are too short for meaningful times.

use crate::command::{done, edgegait, refused, text};
use crate::two::folder;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Short windows, a small batch, one viewpoint.
const SHORT: [&str; 10] = [
    "--window-s",
    "0.01",
    "--windows",
    "2",
    "--warm-up",
    "2",
    "--batch",
    "4",
    "--views",
    "side",
];

/// Returns the results of measuring with [`SHORT`] and these arguments.
fn measured(folder: &Path, arguments: &[&str]) -> Value {
    let json = [["bench"].as_slice(), arguments, &SHORT, &["--json", "-"]].concat();
    serde_json::from_str(&done(folder, &json)).expect("one JSON document")
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("{key}: {of}"))
}

#[test]
fn the_shipped_models_are_measured_each_in_a_process_of_its_own() {
    let folder = folder();
    let results = measured(folder.path(), &["--threads", "1"]);
    assert_eq!(results["command"], "bench");
    assert_eq!(results["settings"]["window_s"], 0.01);
    assert_eq!(results["board"]["architecture"], std::env::consts::ARCH);
    let models = results["models"].as_array().expect("a list");
    let names: Vec<&Value> = models.iter().map(|model| &model["name"]).collect();
    assert_eq!(names, ["side", "spread"]);
    for model in models {
        assert_eq!(model["runtime"]["name"], "rten");
        assert_eq!(model["input"], serde_json::json!([1, 1, 50, 30]));
        assert_eq!(
            (number(model, "params"), number(model, "macs")),
            (38_201.0, 38_150.0)
        );
        let [min, p50, p90, p99, max] =
            ["min_us", "p50_us", "p90_us", "p99_us", "max_us"].map(|key| number(model, key));
        assert!(
            0.0 < min && min <= p50 && p50 <= p90 && p90 <= p99 && p99 <= max,
            "{model}"
        );
        assert!(number(model, "calls") >= 100.0);
        let rate = 1e6 / number(model, "mean_us");
        assert!((number(model, "throughput") - rate).abs() <= 1e-6 * rate);
        assert_eq!(model["window_mean_us"].as_array().map(Vec::len), Some(2));
        assert_eq!(model["offline"]["batch"], 4);
        // Batches of four, with at least a hundred inferences.
        assert!(number(&model["offline"], "calls") >= 25.0);
        let parts = &model["parts"];
        let drawn = number(&parts["preprocessing"], "min_us");
        assert!(number(&parts["end_to_end"], "min_us") > drawn.min(p50));
        assert!(number(model, "load_ms") > 0.0 && number(model, "first_ms") > 0.0);
        if cfg!(target_os = "linux") {
            let over = number(model, "peak_rss_over_baseline_bytes");
            assert!(over > number(model, "bytes") && over < number(model, "peak_rss_bytes"));
        }
        assert_eq!(number(&model["accuracy"], "probes"), 26.0);
    }
    // `side` was trained on the side view: 100 % in the README.
    assert_eq!(number(&models[0]["accuracy"], "rank1"), 1.0);
    let warnings = results["warnings"].to_string();
    assert_eq!(
        warnings.contains("debug build"),
        cfg!(debug_assertions),
        "{warnings}"
    );
}

#[test]
fn results_are_put_side_by_side() {
    let folder = folder();
    let results = measured(folder.path(), &["two.egp", "--walks", "walk-4kmh"]);
    for (file, board) in [("pi4.json", "Board A"), ("pi5.json", "Board B")] {
        let mut results = results.clone();
        results["board"]["model"] = board.into();
        fs::write(folder.path().join(file), results.to_string()).expect("written");
    }
    let compare = ["bench", "--compare", "pi4.json", "pi5.json"];
    let text = done(folder.path(), &compare);
    let line = |start: &str| {
        let found = text.lines().find(|line| line.starts_with(start));
        found
            .unwrap_or_else(|| panic!("{start}: {text}"))
            .to_owned()
    };
    let board = line("board");
    let board: Vec<&str> = board.split_whitespace().collect();
    assert_eq!(board.join(" "), "board Board A Board B");
    assert!(
        text.contains("side pi4") && text.contains("spread pi5"),
        "{text}"
    );
    assert_eq!(line("multiply-accumulates").matches("38,150").count(), 4);
    let markdown = done(
        folder.path(),
        &[compare.as_slice(), &["--format", "markdown"]].concat(),
    );
    assert!(
        markdown.contains("| board | Board A | Board B |"),
        "{markdown}"
    );
    assert!(markdown.contains("|---|--:|--:|--:|--:|"), "{markdown}");

    fs::write(folder.path().join("other.json"), "{\"schema\":1}").expect("written");
    let wrong = ["bench", "--compare", "pi4.json", "other.json"];
    refused(
        folder.path(),
        &wrong,
        1,
        &["other.json: expected the JSON results of edgegait bench"],
    );
    refused(
        folder.path(),
        &["bench", "--compare", "pi4.json"],
        2,
        &["--compare"],
    );
}

#[test]
fn what_cannot_be_measured_is_refused_before_anything_is() {
    let folder = folder();
    let path = folder.path();
    fs::write(path.join("broken.onnx"), "not a model").expect("written");
    refused(
        path,
        &["bench", "broken.onnx"],
        1,
        &["broken.onnx", "not an ONNX model"],
    );
    refused(
        path,
        &["bench", "--bare"],
        2,
        &["--bare compares with ONNX Runtime", "rten"],
    );
    refused(
        path,
        &["bench", "--mlperf", "--windows", "3"],
        2,
        &["--mlperf"],
    );
    refused(
        path,
        &["bench", "--window-s", "3601"],
        2,
        &["0 to 3600 seconds"],
    );
    refused(path, &["bench", "--size", "64x64"], 1, &["side", "50x30"]);
    if cfg!(target_os = "linux") {
        refused(path, &["bench", "--cpus", "1023"], 2, &["--cpus 1023"]);
    }
}

mod with_ort {
    use super::*;

    #[test]
    #[ignore = "needs EDGEGAIT_ORT_LIB"]
    fn a_loop_around_nothing_but_onnx_runtime_is_compared_with() {
        let folder = folder();
        let arguments = [["bench", "--runtime", "ort", "--bare"].as_slice(), &SHORT].concat();
        let output = edgegait(
            folder.path(),
            &[arguments.as_slice(), &["--json", "-"]].concat(),
        );
        assert!(output.status.success(), "{}", text(&output.stderr));
        let results: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let bare = &results["models"][0]["bare"];
        assert!(number(bare, "p50_us") > 0.0);
        // Even on a busy machine, ours takes between half and ten times the time of a loop that
        // also reuses its tensors. A loop that allocates them takes twice as long for a model of
        // this size.
        assert!(
            (-0.5..10.0).contains(&number(bare, "overhead_reusing")),
            "{bare}"
        );
        assert!((-0.9..10.0).contains(&number(bare, "overhead")), "{bare}");
        assert_eq!(results["models"][0]["runtime"]["name"], "onnxruntime");
    }
}

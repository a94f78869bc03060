//! Models without a contract: guesses from their shape, and `edgegait contract`.

use crate::command::{done, names, refused};
use crate::network::write_network;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn scored(at: &Path) -> Value {
    let people = [
        "--views",
        "side",
        "--subjects",
        "F01,F02,M01",
        "--no-baselines",
    ];
    let out = [
        "score",
        "m.onnx",
        "--json",
        "-",
        "--out",
        "report",
        "--overwrite",
    ];
    let text = done(at, &[&out[..], &people].concat());
    serde_json::from_str(&text).expect("one JSON document")
}

fn warnings(results: &Value) -> String {
    results["warnings"].to_string()
}

#[test]
fn a_model_is_scored_by_its_shape_and_by_the_contract_that_is_written_alike() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write_network(at, "m", 1, None);
    fs::remove_file(at.join("m.toml")).expect("the contract");
    let guessed = scored(at);
    let said = warnings(&guessed);
    assert!(said.contains("no .toml lies beside it"), "{said}");
    assert!(said.contains("silhouettes of 64x44 (NTHW)"), "{said}");

    let printed = done(at, &["contract", "m.onnx", "--out", "-"]);
    assert_eq!(names(at), ["m.onnx", "report"]);
    let told = done(at, &["contract", "m.onnx"]);
    assert!(told.contains("wrote m.toml"), "{told}");
    let written = fs::read_to_string(at.join("m.toml")).expect("a contract");
    assert_eq!(written, printed);
    assert!(
        written.starts_with("# m.onnx: takes \"x\" f32 [N, "),
        "{written}"
    );
    for line in [
        "template = \"silhouettes\"",
        "layout = \"NTHW\"",
        "rows = 64",
        "columns = 44",
    ] {
        assert!(written.lines().any(|one| one == line), "{line}: {written}");
    }

    let stated = scored(at);
    assert!(
        !warnings(&stated).contains(".toml"),
        "{}",
        warnings(&stated)
    );
    let of = |results: &Value| results["recognizers"][0]["by_person"].clone();
    assert_eq!(of(&stated), of(&guessed));
    assert_eq!(of(&stated).as_array().map(Vec::len), Some(3));

    // The contract may have been edited since.
    refused(at, &["contract", "m.onnx"], 2, &["m.toml", "--overwrite"]);
    done(at, &["contract", "m.onnx", "--overwrite"]);
}

#[test]
fn what_is_no_model_has_no_contract() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("m.onnx"), "text").expect("written");
    refused(at, &["contract", "m.onnx"], 1, &["m.onnx"]);
    refused(at, &["contract", "none.onnx"], 1, &["none.onnx"]);
    refused(
        at,
        &["contract", "m.onnx", "--out", "m.onnx"],
        2,
        &["m.onnx"],
    );
    assert_eq!(names(at), ["m.onnx"]);
}

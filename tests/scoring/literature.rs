//! Recognizers of the literature: trained, judged by class of confounder, and exported.

use crate::command::{done, refused};
use serde_json::Value;

fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}

#[test]
fn the_table_is_what_score_finds_confounder_by_confounder() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let table =
        "literature --people 4 --training-people 3 --subspaces 5 --discriminants 2 --json -";
    let table: Value = serde_json::from_str(&done(at, &words(table))).expect("JSON");
    let rows = table["recognizers"].as_array().expect("rows");
    let names: Vec<&str> = rows.iter().filter_map(|row| row["name"].as_str()).collect();
    assert_eq!(names.len(), 14);
    assert_eq!(
        names[9..],
        [
            "random",
            "gei-lda",
            "gei-real-synthetic",
            "gabor-subspaces",
            "row-width-chosen"
        ]
    );
    for row in rows {
        let cells = row["cells"].as_array().expect("cells");
        let classes: Vec<&str> = cells
            .iter()
            .filter_map(|cell| cell["class"].as_str())
            .collect();
        assert_eq!(
            classes,
            [
                "normal",
                "view",
                "speed",
                "run",
                "clothes",
                "carrying",
                "occlusion",
                "segmentation"
            ]
        );
        // Two cycles under each condition, a cycle at each speed, 13 viewpoints from 12 others.
        let probes: Vec<u64> = cells
            .iter()
            .filter_map(|cell| cell["probes"].as_u64())
            .collect();
        assert_eq!(probes, [8, 4 * 13 * 12, 16, 20, 48, 24, 16, 56]);
        assert!(cells.iter().all(|cell| cell["people"] == 4));
    }
    // The same people and cycles, as `score` looks for them.
    done(
        at,
        &words("cohort --people 0..4 --quick --speeds-kmh 5 --out four.egp"),
    );
    let score = "score pixels four.egp --views side --conditions each --cycles 2 --raster rows --no-baselines --json -";
    let score: Value = serde_json::from_str(&done(at, &words(score))).expect("JSON");
    let sets = score["recognizers"][0]["probe_sets"]
        .as_array()
        .expect("sets");
    for (class, confounders) in [
        ("normal", &["normal"][..]),
        ("carrying", &["backpack", "shoulder-bag", "suitcase"]),
        ("occlusion", &["static-occluder", "moving-occluder"]),
    ] {
        let of = sets
            .iter()
            .filter(|set| confounders.contains(&set["name"].as_str().unwrap_or("")));
        let people = of.flat_map(|set| set["by_person"].as_array().cloned().unwrap_or_default());
        let (hits, probes) = people.fold((0, 0), |(hits, probes), person| {
            let count = |key: &str| person[key].as_u64().expect("a count");
            (hits + count("hits"), probes + count("probes"))
        });
        let cells = rows[0]["cells"].as_array().expect("cells");
        let cell = cells
            .iter()
            .find(|cell| cell["class"] == class)
            .expect("a cell");
        assert_eq!(cell["probes"], probes, "{class}");
        let rank1 = cell["rank1"].as_f64().expect("a rate");
        assert!(
            (rank1 - hits as f64 / probes as f64).abs() < 1e-12,
            "{class}"
        );
    }
}

#[test]
fn subspaces_larger_than_the_space_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    refused(
        folder.path(),
        &words("literature --people 2 --training-people 2 --eigenvectors 61"),
        2,
        &["61", "1..=60"],
    );
}

#[test]
fn real_and_synthetic_templates_make_one_model_of_two_parts() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let train = "train --method real-synthetic --crop-steps 3 --cycles 2 --raster rows --subjects F01,M02,F05 --components 20 --out both.onnx";
    done(at, &words(train));
    let score = "score both.onnx --subjects F01,M02,F05 --views side --raster rows --protocol first-take --no-baselines --json -";
    let score: Value = serde_json::from_str(&done(at, &words(score))).expect("JSON");
    let result = &score["recognizers"][0];
    assert_eq!(
        (&result["rank1"], &result["probes"]),
        (&1.0.into(), &3.into())
    );
    let contract = std::fs::read_to_string(at.join("both.toml")).expect("a contract");
    assert!(
        contract.contains("LDA of real and of synthetic templates"),
        "{contract}"
    );
    // It makes crops by itself, of images alone.
    for (command, word) in [
        (
            "train --method real-synthetic --augment crop --out x.onnx",
            "crops by itself",
        ),
        ("train --crop-steps 3 --out x.onnx", "--augment crop"),
        (
            "train --method real-synthetic --svm-c 2 --out x.onnx",
            "--svm-c",
        ),
        (
            "train --method real-synthetic --template row-width --raster rows --out x.onnx",
            "row-width",
        ),
    ] {
        refused(at, &words(command), 2, &[word]);
    }
}

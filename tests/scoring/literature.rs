//! Recognizers of the literature: training, evaluation by class of confounder, and export.

use crate::command::{done, refused};
use serde_json::Value;
use std::fs;

fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}

#[test]
fn the_table_is_what_score_finds_confounder_by_confounder() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let table =
        "literature --people 4 --training-people 3 --subspaces 5 --discriminants 2 --json -";
    let table = done(at, &words(table));
    fs::write(at.join("table.json"), &table).expect("written");
    crate::limits::holds(at, "table.json");
    let table: Value = serde_json::from_str(&table).expect("JSON");
    let rows = table["recognizers"].as_array().expect("rows");
    let names: Vec<&str> = rows.iter().filter_map(|row| row["name"].as_str()).collect();
    assert_eq!(names.len(), 15);
    assert_eq!(
        names[9..],
        [
            "random",
            "gei-lda",
            "gei-real-synthetic",
            "gabor-subspaces",
            "view-transformation",
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
        // Two cycles under each condition, one cycle at each speed, and 13 viewpoints from 12
        // others.
        let probes: Vec<u64> = cells
            .iter()
            .filter_map(|cell| cell["probes"].as_u64())
            .collect();
        assert_eq!(probes, [8, 4 * 13 * 12, 16, 20, 72, 48, 16, 72]);
        assert!(cells.iter().all(|cell| cell["people"] == 4));
        let configurations = row["configurations"].as_array().expect("cells");
        let names: Vec<&str> = { configurations.iter() }
            .filter_map(|cell| cell["class"].as_str())
            .collect();
        assert_eq!(
            names,
            [
                "regular",
                "hands-in-pockets",
                "backpack",
                "gown",
                "dynamic-occlusion",
                "static-occlusion"
            ]
        );
        assert!(configurations.iter().all(|cell| cell["probes"] == 8));
    }
    let garments = &table["garments"];
    assert_eq!(garments["names"].as_array().map(Vec::len), Some(10));
    assert_eq!(garments["correlations"][3][3], 1.0);
    // `score` with the same people and cycles.
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
        (
            "carrying",
            &[
                "backpack",
                "shoulder-bag",
                "suitcase",
                "umbrella",
                "carried-box",
                "stroller",
            ],
        ),
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

/// Writes a small tree of three people, two walks each, from two viewpoints.
fn tree(at: &std::path::Path) {
    done(
        at,
        &words(
            "sweep --subjects F01,M02,F05 --walks walk-3kmh,walk-5kmh,walk-7kmh --azimuth-deg 45,90 --elevation-deg 0 --cycles 3 --frames-per-cycle 20 --raster rows --format casia-b --size 64x64 --out tree",
        ),
    );
}

#[test]
fn cycles_of_recorded_people_are_the_probes() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    tree(at);
    let table = "literature tree --training-people 3 --subspaces 5 --discriminants 2 --json -";
    let table: Value = serde_json::from_str(&done(at, &words(table))).expect("JSON");
    for row in table["recognizers"].as_array().expect("rows") {
        let cells = row["cells"].as_array().expect("cells");
        let classes: Vec<&Value> = cells.iter().map(|cell| &cell["class"]).collect();
        assert_eq!(classes, ["normal", "view"]);
        assert!(cells.iter().all(|cell| cell["people"] == 3), "{row}");
        assert!(row.get("configurations").is_none());
        assert_eq!(cells[0]["probes"], cells[1]["probes"]);
    }
    for (command, code, said) in [
        ("literature tree --people 5", 2, "--people and --cycles"),
        ("literature --fps 30", 2, "no tree is given"),
        (
            "literature tree --whole-recordings",
            2,
            "probes are gait cycles",
        ),
        ("literature nothing", 1, "nothing"),
    ] {
        refused(at, &words(command), code, &[said]);
    }
    done(
        at,
        &words("sweep --subjects F01,M02 --views side --raster rows --out geis"),
    );
    refused(
        at,
        &words("literature geis"),
        1,
        &["expected a tree of silhouettes"],
    );
    fs::create_dir_all(at.join("named/ann/nm-01/front")).expect("made");
    let from = at.join("tree");
    let picture = pictures(&from).into_iter().next().expect("a picture");
    fs::copy(picture, at.join("named/ann/nm-01/front/001.png")).expect("copied");
    refused(at, &words("literature named"), 1, &["at least 2 people"]);
}

/// Returns the images below a folder.
fn pictures(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(pictures(&path));
        } else if path.extension().is_some_and(|extension| extension == "png") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Returns the rank-1 of a model and of pixels by `score`.
fn rank1(at: &std::path::Path, command: &str) -> [f64; 2] {
    let score: Value = serde_json::from_str(&done(at, &words(command))).expect("JSON");
    let found = score["recognizers"].as_array().expect("recognizers");
    let is_pixels = |one: &&Value| one["name"] == "pixels";
    let model = found.iter().find(|one| !is_pixels(one));
    let pixels = found.iter().find(is_pixels);
    [model, pixels].map(|one| one.expect("both")["rank1"].as_f64().expect("a rate"))
}

#[test]
fn a_view_transformation_is_given_the_viewpoint_and_knows_its_own_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let people = "--subjects F01,M01,F02,M02,F03,M03,F04,M04 --raster rows --elevation-deg 0";
    done(
        at,
        &words(&format!(
            "train --method view-transformation --template frequency --cycles 2 {people} --azimuth-deg 0,90 --out vtm.onnx"
        )),
    );
    let contract = fs::read_to_string(at.join("vtm.toml")).expect("a contract");
    for line in ["view_input = \"view\"", "distance = \"view\""] {
        assert!(contract.contains(line), "{contract}");
    }
    // People of the training are transformed from one viewpoint to another, where their images are
    // very different.
    let score =
        format!("score vtm.onnx pixels {people} --protocol cross-view --no-baselines --json -");
    let [transformed, pixels] = rank1(at, &format!("{score} --azimuth-deg 0,90"));
    assert!(transformed > 0.9 && pixels < 0.5, "{transformed} {pixels}");
    refused(
        at,
        &words(&format!("{score} --azimuth-deg 0,45,90")),
        1,
        &["vtm has not been trained on viewpoint 45,0: expected one of 0,0 90,0"],
    );
    // A dataset of the same images gives the same model.
    done(
        at,
        &words(&format!(
            "sweep --template frequency --cycles 2 {people} --azimuth-deg 0,90 --out pictures"
        )),
    );
    fs::create_dir(at.join("again")).expect("made");
    done(
        at,
        &words("train pictures --method view-transformation --out again/vtm.onnx"),
    );
    let [one, again] =
        ["vtm.onnx", "again/vtm.onnx"].map(|name| fs::read(at.join(name)).expect("a model"));
    assert!(one == again);
    // Without the line that names the input, the file is an error that states what to do.
    let without = contract.replace("view_input = \"view\"\ndistance = \"view\"\n", "");
    fs::write(at.join("vtm.toml"), without).expect("written");
    let named = "view_input = \"view\"";
    refused(
        at,
        &words("check vtm.onnx"),
        1,
        &[named, "\"view\" f32 [N, 2]"],
    );

    for (command, code, said) in [
        (
            "--template frequency --views side",
            1,
            "at least 2 viewpoints",
        ),
        ("--azimuth-deg 0,90 --augment flip", 2, "mirrored template"),
        ("--azimuth-deg 0,90 --precision f32", 2, "--precision"),
        ("--azimuth-deg 0,90 --subspaces 5", 2, "gabor-subspaces"),
    ] {
        let train =
            format!("train --method view-transformation --raster rows --out x.onnx {command}");
        refused(at, &words(&train), code, &[said]);
        assert!(!at.join("x.onnx").exists());
    }
}

#[test]
fn random_subspaces_vote_in_one_model_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let people = "--subjects F01,M01,F02,M02,F03,M03 --raster rows --views side";
    let train = format!(
        "train --method gabor-subspaces --cycles 4 {people} --subspaces 40 --discriminants 3"
    );
    done(at, &words(&format!("{train} --out votes.onnx")));
    let score =
        format!("score votes.onnx pixels {people} --protocol first-take --no-baselines --json -");
    assert_eq!(rank1(at, &score), [1.0, 1.0]);
    // Another seed samples other subspaces.
    done(at, &words(&format!("{train} --seed 2 --out other.onnx")));
    let [one, other] =
        ["votes.onnx", "other.onnx"].map(|name| fs::read(at.join(name)).expect("a model"));
    assert_ne!(one, other);
    for (command, code, said) in [
        (
            "--template mhi",
            1,
            "gabor-subspaces learns from GEIs, found MHIs",
        ),
        ("--components 20", 2, "no principal components"),
    ] {
        let train = format!("train --method gabor-subspaces {people} --out x.onnx {command}");
        refused(at, &words(&train), code, &[said]);
    }
}

#[test]
fn chosen_row_widths_are_a_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let people = "--subjects F01,M01,F02,M02,F03,M03 --raster rows --views side";
    let worn = ["shoes", "hat", "wide-trousers"]
        .map(|name| format!("[[conditions]]\nname = {name:?}\nconfounders = {{ {name} = 1 }}\n"));
    fs::write(at.join("worn.toml"), worn.concat()).expect("conditions");
    done(
        at,
        &words(&format!(
            "sweep {people} --template row-width --cycles 2 --conditions worn.toml --out dressed"
        )),
    );
    done(
        at,
        &words("train dressed --method feature-choice --out rows.onnx"),
    );
    let contract = fs::read_to_string(at.join("rows.toml")).expect("a contract");
    assert!(contract.contains("choice of features ("), "{contract}");
    let score = format!(
        "score rows.onnx pixels {people} --protocol first-take --conditions worn.toml --no-baselines --json -"
    );
    let [chosen, pixels] = rank1(at, &score);
    assert!(chosen > 0.3 && pixels > 0.3, "{chosen} {pixels}");
    refused(
        at,
        &words("train --method feature-choice --components 5 --out x.onnx"),
        2,
        &["no principal components"],
    );
}

#[test]
fn subspaces_larger_than_the_space_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    refused(
        folder.path(),
        &words("literature --people 2 --training-people 2 --eigenvectors 81"),
        2,
        &["81", "1..=80"],
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
    let contract = fs::read_to_string(at.join("both.toml")).expect("a contract");
    assert!(
        contract.contains("LDA of real and of synthetic templates"),
        "{contract}"
    );
    // The method makes crops itself, and takes only images.
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

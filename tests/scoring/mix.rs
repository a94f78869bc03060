//! Training on several sources together, and on shares of them.

use crate::command::{done, edgegait, refused, text};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}

/// Returns the JSON results of a command that must succeed.
fn results(at: &Path, command: &str) -> Value {
    let command = format!("{command} --json -");
    serde_json::from_str(&done(at, &words(&command))).expect("one JSON document")
}

fn model(at: &Path, name: &str) -> Vec<u8> {
    fs::read(at.join(name)).expect("a model")
}

/// Writes the silhouettes of two people, two recordings each, as a tree.
fn tree(at: &Path) {
    let people = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/people/people");
    for person in ["101", "102"] {
        for take in ["nm-01", "nm-02"] {
            let view = format!("{person}/{take}/090");
            let target = at.join("real").join(&view);
            fs::create_dir_all(&target).expect("made");
            for frame in fs::read_dir(people.join(&view)).expect("frames") {
                let frame = frame.expect("a frame");
                fs::copy(frame.path(), target.join(frame.file_name())).expect("copied");
            }
        }
    }
}

/// Writes a tree of 101 and 102, a pack of F01, M01 and F02, and GEIs of 102 and F01.
fn sources(at: &Path) {
    tree(at);
    done(
        at,
        &words("cohort --people 3 --speeds-kmh 4,5 --out made.egp"),
    );
    fs::create_dir(at.join("own")).expect("made");
    let rows = "subject,walk,azimuth_deg\n102,nm-01,90\nF01,nm-01,90\nF01,nm-02,0\n";
    fs::write(at.join("own/index.csv"), rows).expect("a table");
    let geis = [40, 80, 120].map(|grey| [grey; 1500]).concat();
    edgegait::dataset::write_npy(at.join("own/geis.npy"), &[3, 50, 30], &geis).expect("an array");
}

#[test]
fn a_tree_a_pack_and_a_dataset_train_one_model_of_all_their_people() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    sources(at);
    let train = "train real made.egp own --mix real:0.5,made:0.25 --components 4 --out all.onnx";
    let found = results(at, train);
    let sources = found["sources"].as_array().expect("a list");
    let stated = |key: &str| -> Vec<Value> { sources.iter().map(|one| one[key].clone()).collect() };
    assert_eq!(stated("name"), ["real", "made", "own"]);
    assert_eq!(stated("kind"), ["tree", "pack", "dataset"]);
    assert_eq!(stated("path"), ["real", "made.egp", "own"]);
    assert_eq!(stated("share"), [0.5, 0.25, 1.0]);
    assert_eq!(stated("people"), [2, 3, 2]);
    // Four recordings; then two walks of three people, with eight cycles each.
    assert_eq!(stated("samples_before"), [4, 48, 3]);
    assert_eq!(stated("samples_after"), [2, 12, 3]);
    assert_eq!(
        (&found["samples"], &found["classes"]),
        (&17.into(), &5.into())
    );
    assert_eq!(found["settings"]["mix"], "real:0.5,made:0.25");
    let warnings = found["warnings"].as_array().expect("a list");
    let has = |words: &str| {
        warnings
            .iter()
            .any(|one| one.as_str().is_some_and(|one| one.contains(words)))
    };
    assert!(
        has("real: 4 of 4 recordings have no gait cycle"),
        "{warnings:?}"
    );
    assert!(
        has("real and made have no person of the same name"),
        "{warnings:?}"
    );
    assert!(
        has("own: it does not state how its figures are framed"),
        "{warnings:?}"
    );
    assert_eq!(warnings.len(), 3);

    let contract = fs::read_to_string(at.join("all.toml")).expect("a contract");
    for line in [
        r#"classes = ["101", "102", "F01", "M01", "F02"]"#,
        "real (2 people, a share of 0.5 of each person's cycles, 2 of 4 samples): the 2 GEIs of real; made (3 people, a share of 0.25",
        "viewpoints = [[90.0, 0.0], [0.0, 0.0]]",
        r#"walks = ["nm-01", "nm-02", "walk-4kmh", "walk-5kmh"]"#,
        "seed = 1\n",
    ] {
        assert!(contract.contains(line), "{line}: {contract}");
    }

    // The text output states it too. One thread gives the same model, another seed another one.
    let said = done(at, &words(&format!("{train} --threads 1")));
    let expected = "made (pack): 3 people, 12 of 48 samples\n";
    assert!(
        said.contains(expected) && said.contains("warning: real and made have"),
        "{said}"
    );
    let first = model(at, "all.onnx");
    results(at, train);
    assert_eq!(model(at, "all.onnx"), first);
    results(at, &format!("{train} --seed 2"));
    assert_ne!(model(at, "all.onnx"), first);

    // Scoring warns about probes that were in training, from any source.
    let scored = results(at, "score all.onnx made.egp --views side --no-baselines");
    assert!(
        scored["warnings"]
            .to_string()
            .contains("cycles that it was trained on")
    );
}

#[test]
fn names_and_viewpoints_choose_from_each_source() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    sources(at);
    let counts = |flags: &str| -> Vec<Value> {
        let found = results(at, &format!("train {flags} --components 2 --out x.onnx"));
        let sources = found["sources"].as_array().expect("a list");
        sources
            .iter()
            .map(|one| one["samples_after"].clone())
            .collect()
    };
    assert_eq!(counts("real made.egp own --subjects 102,F01"), [2, 16, 3]);
    assert_eq!(counts("made.egp own --azimuth-deg 0 --cycles 2"), [12, 1]);
    assert_eq!(counts("real own --walks nm-01 --whole-recordings"), [2, 2]);
    for (flags, problem) in [
        (
            "real made.egp --subjects zoe",
            "no subject \"zoe\": expected one of 101, 102, F01",
        ),
        (
            "real made.egp --walks walk",
            "no walk \"walk\": expected one of nm-01, nm-02, walk-4kmh",
        ),
        (
            "real made.egp --subjects 101",
            "made.egp: expected some of the chosen people",
        ),
        (
            "real made.egp --azimuth-deg 45",
            "real: expected some of the chosen people, walks and viewpoints",
        ),
    ] {
        refused(
            at,
            &words(&format!("train {flags} --out y.onnx")),
            2,
            &[problem],
        );
    }
    assert!(!at.join("y.onnx").exists());
}

#[test]
fn what_cannot_be_trained_on_together_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    sources(at);
    fs::create_dir_all(at.join("other")).expect("made");
    fs::copy(at.join("made.egp"), at.join("other/made.egp")).expect("copied");
    for (flags, problem) in [
        (
            "real made.egp --mix reel:0.5",
            "no source \"reel\": expected one of real, made",
        ),
        (
            "real made.egp --mix real:0",
            "above 0 and at most 1 of real, found \"0\"",
        ),
        (
            "real made.egp --mix real:1.01",
            "above 0 and at most 1 of real, found \"1.01\"",
        ),
        (
            "real made.egp --mix real:0.5,real:0.6",
            "--mix: real appears twice",
        ),
        (
            "made.egp other/made.egp --mix made:0.5",
            "made.egp and other/made.egp are both called made",
        ),
        (
            "made.egp ./made.egp",
            "./made.egp: expected each source once",
        ),
        (
            "--mix real:0.5",
            "--mix: expected packs, datasets or trees to name",
        ),
        (
            "real own --size 64x44",
            "expected sources of one size, found 64x44 of real and 50x30 of own (--size applies",
        ),
        (
            "own made.egp --template mei",
            "one template, found gei of own and mei of made.egp",
        ),
        (
            "made.egp own --fps 30",
            "--fps: expected a tree of silhouettes",
        ),
        (
            "made.egp real --framing cycle",
            "framing cycle: it depends on the camera's position",
        ),
        ("real own --raster rows", "--raster: a folder is used whole"),
        ("real own --cycles 3", "all gait cycles of a tree"),
        ("real own --template silhouettes", "one image or vector"),
    ] {
        refused(
            at,
            &words(&format!("train {flags} --out x.onnx")),
            2,
            &[problem],
        );
    }
    // Two sources of one name are fine unless a flag names one.
    done(
        at,
        &words("train made.egp other/made.egp --components 2 --out twice.onnx"),
    );
    // Each flag applies to the sources that can use it.
    done(
        at,
        &words("train real made.egp --fps 30 --raster rows --cycles 1 --components 2 --out x.onnx"),
    );
}

/// The content of recordings that a share leaves out does not change the model.
#[test]
fn what_is_left_out_of_a_source_does_not_change_the_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    tree(at);
    done(
        at,
        &words("cohort --people 2 --speeds-kmh 5 --out made.egp"),
    );
    let train = "train real made.egp --mix real:0.5 --augment flip --components 3 --out m.onnx --whole-recordings --cycles 2";
    let trained = |at: &Path| {
        done(at, &words(train));
        model(at, "m.onnx")
    };
    let before = trained(at);
    for person in ["101", "102"] {
        let changes = ["nm-01", "nm-02"].map(|take| {
            let frames = at.join("real").join(person).join(take).join("090");
            let first = fs::read_dir(&frames).expect("frames").next();
            let first = first.expect("a frame").expect("readable").path();
            let bytes = fs::read(&first).expect("a picture");
            // A bar in place of the figure.
            let bar = image::GrayImage::from_fn(180, 240, |column, _| {
                image::Luma([if column / 20 == 5 { 255 } else { 0 }])
            });
            bar.save(&first).expect("written");
            let is_changed = trained(at) != before;
            fs::write(&first, bytes).expect("as it was");
            is_changed
        });
        assert_ne!(changes[0], changes[1], "{person}");
    }
    assert_eq!(trained(at), before);
}

#[test]
fn augmented_copies_stay_with_their_image() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let sweep = "sweep --subjects F01,M01 --views side --cycles 3 --raster rows --augment flip,crop --crop-steps 1 --out set";
    done(at, &words(sweep));
    // Two of three cycles, each with its three copies; half of twelve images would be six.
    let found = results(at, "train set --mix set:0.5 --components 2 --out set.onnx");
    assert_eq!(found["sources"][0]["samples_before"], 24);
    assert_eq!(found["sources"][0]["samples_after"], 2 * 2 * 4);
    // A share of a source is the same next to another source.
    done(at, &words("cohort --people 1 --speeds-kmh 5 --out one.egp"));
    let output = edgegait(
        at,
        &words("train one.egp set --mix set:0.5 --components 2 --out two.onnx"),
    );
    let said = text(&output.stdout);
    assert!(
        said.contains("set (dataset): 2 people, 16 of 24 samples"),
        "{said}"
    );
}

//! Sweeps of trees of silhouettes: datasets with a template for each gait cycle.

use crate::command::{done, refused};
use crate::trees::{DESIGN, geis, tree, words};
use edgegait::Dataset;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Generates a tree of six people, three takes of two cycles, and three views named by azimuth.
fn angled(at: &Path) {
    fs::write(at.join("d.toml"), DESIGN).expect("a design");
    done(at, &words("generate d.toml --format casia-b --out tree"));
}

fn results(at: &Path, command: &str) -> Value {
    let command = format!("{command} --json -");
    serde_json::from_str(&done(at, &words(&command))).expect("one JSON document")
}

#[test]
fn a_dataset_of_a_tree_trains_and_scores_as_the_tree() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    angled(at);
    let swept = results(at, "sweep tree --out set");
    assert_eq!(swept["geis"], 6 * 3 * 3 * 2);
    assert_eq!(swept["silhouettes"], 6 * 3 * 3 * 2 * 32);
    assert_eq!(
        (&swept["settings"]["tree"], &swept["settings"]["framing"]),
        (&"tree".into(), &"height".into())
    );
    assert!(swept.get("raster").is_none());
    let set = Dataset::open(at.join("set")).expect("a dataset");
    let row = &set.index()[3];
    let take = (row.walk.as_str(), row.cycle, row.frames);
    assert_eq!(take, ("walk-5kmh-01", 1, 32));
    assert_eq!(
        (row.azimuth_deg, row.elevation_deg, row.variation),
        (60.0, 0.0, 0)
    );

    // The same images under the same names give the same models, with all of them and with a share.
    for (number, mix) in ["", " --mix NAME:0.5"].into_iter().enumerate() {
        let trained = |source: &str| {
            let mix = mix.replace("NAME", source);
            let out = format!("{source}{number}/m.onnx");
            done(
                at,
                &words(&format!("train {source}{mix} --components 6 --out {out}")),
            );
            fs::read(at.join(out)).expect("a model")
        };
        assert_eq!(trained("tree"), trained("set"), "{mix}");
    }
    let rank1 = |source: &str| {
        let scored = results(
            at,
            &format!("score pixels {source} --protocol leave-one-take-out"),
        );
        let first = &scored["recognizers"][0];
        (first["probes"].clone(), first["rank1"].clone())
    };
    assert_eq!(rank1("tree"), rank1("set"));
}

#[test]
fn a_dataset_of_whole_recordings_has_their_geis_by_the_definition() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    angled(at);
    done(
        at,
        &words("sweep tree --whole-recordings --out set --azimuth-deg 90 --augment flip"),
    );
    let set = Dataset::open(at.join("set")).expect("a dataset");
    let all = geis(&at.join("tree"));
    let side = all.iter().filter(|(_, name, _)| name.ends_with("-090"));
    let expected: Vec<&Vec<f64>> = side.map(|(_, _, gei)| gei).collect();
    assert_eq!(set.index().len(), 2 * expected.len());
    let pairs = set.templates().zip(set.index()).collect::<Vec<_>>();
    for (pair, expected) in pairs.chunks(2).zip(expected) {
        let ((gei, row), (flipped, of_flipped)) = (pair[0], pair[1]);
        let gei: Vec<f64> = gei.iter().map(|&byte| f64::from(byte)).collect();
        assert_eq!(gei, *expected);
        assert_eq!((row.frames, row.condition.as_str()), (64, ""));
        assert_eq!(of_flipped.condition, "+flip");
        assert_eq!(f64::from(flipped[29]), gei[0]);
        assert_eq!(f64::from(flipped[30 * 20 + 9]), gei[30 * 20 + 20]);
    }
}

#[test]
fn flags_that_a_tree_does_not_support_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    angled(at);
    done(at, &words("sweep --subjects F01 --views side --out drawn"));
    for (flags, code, problem) in [
        ("tree --cycles 1", 2, "--cycles: expected a pack"),
        ("tree --joints", 2, "--joints: expected a pack"),
        (
            "tree --conditions casia-b",
            2,
            "a folder is used as it was drawn",
        ),
        ("tree --raster rows", 2, "--raster: a folder is used whole"),
        ("tree --format opengait", 2, "are in a tree already"),
        ("tree --framing cycle", 2, "framing cycle: it depends"),
        ("tree --azimuth-deg 45", 1, "viewpoints, found none"),
        ("tree --fps 5", 2, "10 to 120"),
        (
            "drawn",
            1,
            "found another folder (a dataset has been swept already)",
        ),
        (
            "--whole-recordings --subjects F01",
            2,
            "--whole-recordings: expected a tree",
        ),
    ] {
        refused(
            at,
            &words(&format!("sweep {flags} --out set")),
            code,
            &[problem],
        );
    }
    fs::remove_dir_all(at.join("tree")).expect("removed");
    tree(at, "casia-b");
    let problem =
        "expected views named by angles, as the index of a dataset needs them, found \"seq0\"";
    refused(at, &words("sweep tree --out set"), 1, &[problem]);
    assert!(!at.join("set").exists());
}

//! Training sets from designs: the same bytes however they are generated, and errors for invalid
//! designs.

use crate::command::*;
use edgegait::Dataset;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A design of eleven lines.
const SMALL: &str = r#"seed = 3
conditions = "domain-random"
[population]
people = "PEOPLE"
age_years = [60, 80]
dressed = "per-take"
[walks]
speeds_kmh = { uniform = [3, 5], walks = 2 }
[views]
azimuth_deg = { uniform = [0, 360] }
count = 3
[images]
raster = "rows"
"#;

fn generated(at: &Path, people: &str, flags: &str) -> Dataset {
    fs::write(at.join("d.toml"), SMALL.replace("PEOPLE", people)).expect("a design");
    let command = format!("generate d.toml --out made {flags}");
    done(at, &command.split_whitespace().collect::<Vec<_>>());
    Dataset::open(at.join("made")).expect("a dataset")
}

#[test]
fn a_design_makes_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let files = |threads: &str| {
        let made = generated(at, "0..6", threads);
        assert_eq!(made.index().len(), 6 * 2 * 3);
        serde_json::to_string(&made.manifest().files).expect("JSON")
    };
    let one = files("--threads 1");
    assert_eq!(one, files("--threads 2"));
    assert!(one.contains("walkers.csv"), "{one}");
    assert_eq!(
        names(&at.join("made")),
        ["geis.npy", "index.csv", "manifest.json", "walkers.csv"]
    );

    let walkers = fs::read_to_string(at.join("made/walkers.csv")).expect("a table");
    let lines: Vec<&str> = walkers.lines().collect();
    assert_eq!(
        lines[0],
        "subject,walk,sex,age_years,stature_m,mass_kg,clothes"
    );
    assert_eq!(lines.len(), 1 + 6 * 2);
    let ages = lines[1..]
        .iter()
        .map(|line| line.split(',').nth(3).expect("an age"));
    assert!(
        ages.clone()
            .all(|age| (60..=80).contains(&age.parse().expect("years")))
    );
    assert!(
        lines[1..].iter().all(|line| line.contains('+')),
        "{walkers}"
    );
}

#[test]
fn people_do_not_depend_on_who_else_is_generated() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    // More people than are generated at the same time.
    let all = generated(at, "0..67", "");
    let some = generated(at, "62..66", "");
    let of_some = some.index()[0].subject.clone();
    let from = all.index().iter().position(|row| row.subject == of_some);
    let from = from.expect("the same person");
    for (at, row) in some.index().iter().enumerate() {
        assert_eq!(*row, all.index()[from + at]);
        assert_eq!(some.bytes(at), all.bytes(from + at));
    }
}

#[test]
fn splits_are_datasets_that_share_no_person() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let said = done(
        at,
        &["generate", "casia-b-like", "--people", "2", "--out", "sets"],
    );
    assert!(said.contains("of 4 walks of 4 people"), "{said}");
    let [train, test] = ["train", "test"].map(|name| {
        let made = Dataset::open(at.join("sets").join(name)).expect("a dataset");
        // Two people, ten takes, eleven viewpoints.
        assert_eq!(made.index().len(), 2 * 10 * 11);
        let mut people: Vec<_> = made.index().iter().map(|row| row.subject.clone()).collect();
        people.dedup();
        people
    });
    assert_eq!(
        (train, test),
        (
            vec!["2-F01".into(), "2-M01".into()],
            vec!["2-F38".into(), "2-M38".into()]
        )
    );
    let manifest = fs::read_to_string(at.join("sets/test/manifest.json")).expect("a manifest");
    let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
    let settings = &manifest["settings"];
    assert_eq!(manifest["command"], "generate");
    assert_eq!(settings["design"], "casia-b-like");
    assert_eq!(settings["people"], "74..76");
    assert_eq!(settings["encoding"], "quick");
    // Scoring and training take such a folder.
    let scored = done(
        at,
        &["score", "pixels", "sets/test", "--protocol", "casia-b"],
    );
    assert!(
        ["NM", "BG", "CL"].iter().all(|name| scored.contains(name)),
        "{scored}"
    );
    // An earlier dataset is replaced, and nothing else.
    done(
        at,
        &["generate", "casia-b-like", "--people", "1", "--out", "sets"],
    );
    fs::write(at.join("sets/train/notes.txt"), "mine").expect("a file");
    refused(
        at,
        &["generate", "casia-b-like", "--people", "1", "--out", "sets"],
        2,
        &["notes.txt", "not part of a dataset"],
    );
}

#[test]
fn a_wrong_design_is_refused_before_anything_is_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let wrong = SMALL.replace("PEOPLE", "0..6").replace("[3, 5]", "[5, 3]");
    fs::write(at.join("d.toml"), wrong).expect("a design");
    refused(
        at,
        &["generate", "d.toml", "--out", "made"],
        1,
        &["d.toml:8", "found 5 and 3"],
    );
    fs::write(at.join("own.toml"), SMALL.replace("PEOPLE", "0..6")).expect("a design");
    refused(at, &["generate", "none.toml"], 1, &["none.toml"]);
    refused(
        at,
        &["generate", "casia"],
        2,
        &["\"casia\"", "casia-b-like, domain-random"],
    );
    refused(
        at,
        &["generate", "own.toml", "--seed", "5"],
        2,
        &["--seed 5", "own.toml states its own seed, 3"],
    );
    assert_eq!(names(at), ["d.toml", "own.toml"]);
}

//! Noise and unusable input cause warnings, but do not end the run.

use crate::command::*;
use crate::recording::walk;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Runs `import` with these arguments and returns its results.
fn import(at: &Path, arguments: &str) -> Value {
    let import = format!("import {arguments} --out out.egp --json out.json");
    done(at, &import.split(' ').collect::<Vec<_>>());
    serde_json::from_slice(&fs::read(at.join("out.json")).expect("results")).expect("JSON")
}

fn refuse(at: &Path, arguments: &str, expected: i32, words: &[&str]) {
    let import = format!("import {arguments} --out out.egp");
    let import: Vec<&str> = import.split(' ').collect();
    refused(at, &import, expected, words);
    assert!(!at.join("out.egp").exists());
}

/// Returns the warnings of the header, and of a file's clip if it was imported.
fn warnings(results: &Value, file: &str) -> (Vec<String>, Option<Vec<String>>) {
    let list = |list: &Value| -> Vec<String> {
        let list = list.as_array().expect("a list").iter();
        list.map(|one| one.as_str().expect("text").to_owned())
            .collect()
    };
    let clips = results["clips"].as_array().expect("clips");
    let clip = clips.iter().find(|clip| clip["file"] == file);
    (
        list(&results["warnings"]),
        clip.map(|clip| list(&clip["warnings"])),
    )
}

/// Writes a file with a normal walk of two cycles, from 0.25 and 1.25 s on, and others in which the
/// left hand is turned over in the second cycle or near the file's end, or in which the head turns
/// once a second, or once in the second cycle.
fn files(at: &Path) {
    let over = |frame: usize, from: usize| if frame < from { 0.0 } else { 178.0 };
    let once = |frame: usize| 9.0 * frame.clamp(190, 230) as f64;
    walk(at, "good_1.bvh", 0.0, |_, _| None);
    let turning = |turned: &str, name: &str, angle_deg: &dyn Fn(usize) -> f64| {
        walk(at, name, 0.0, |joint, frame| {
            (joint == turned).then(|| [angle_deg(frame), 0.0, 0.0])
        });
    };
    turning("LeftHand", "hand_1.bvh", &|frame| over(frame, 180));
    turning("LeftHand", "edge_1.bvh", &|frame| over(frame, 3));
    turning("Head", "spin_1.bvh", &|frame| 3.0 * frame as f64);
    turning("Head", "once_1.bvh", &once);
}

#[test]
fn a_hand_that_flips_over_is_kept_near_with_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    files(at);
    for file in ["hand_1.bvh", "edge_1.bvh"] {
        for more in ["", " --track clip", " --track clip --low-pass-hz 0"] {
            let results = import(at, &format!("good_1.bvh {file}{more}"));
            let (_, hand) = warnings(&results, file);
            let hand = hand.expect("it came in");
            let said: Vec<&String> = hand.iter().filter(|one| one.contains("LeftHand")).collect();
            assert_eq!(said.len(), 1, "{file}{more}: {hand:?}");
            for word in ["more than 75 degrees", "kept within 22", "noise"] {
                assert!(said[0].contains(word), "{file}{more}: {hand:?}");
            }
            let (_, good) = warnings(&results, "good_1.bvh");
            assert_eq!(good, Some(Vec::new()), "{file}{more}");
        }
    }
}

#[test]
fn walks_that_the_encoder_refuses_are_left_out_and_the_others_imported() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    files(at);
    let full = "turns a full circle";
    for (file, more, word) in [
        ("spin_1.bvh", "", full),
        ("spin_1.bvh", " --cycles mean", full),
        ("spin_1.bvh", " --budget-bytes 6000", full),
        ("spin_1.bvh", " --max-gei-rmse 20", full),
    ] {
        let both = format!("good_1.bvh {file}{more}");
        refuse(at, &both, 1, &[file, word, "--keep-going"]);
        refuse(at, &format!("{file} --keep-going{more}"), 1, &[file, word]);
        let results = import(at, &format!("{both} --keep-going"));
        let (all, own) = warnings(&results, file);
        assert_eq!(own, None, "{both}");
        let left_out = format!("left out: {file}: ");
        let is_said = |one: &String| one.starts_with(&left_out) && one.contains(word);
        assert!(all.iter().any(is_said), "{both}: {all:?}");
        let found = fs::read(at.join("out.egp")).expect("a pack");
        // Choosing an encoding takes seconds.
        if !more.contains("rmse") {
            import(at, &format!("good_1.bvh{more}"));
            assert!(
                fs::read(at.join("out.egp")).expect("a pack") == found,
                "{both}"
            );
        }
        fs::remove_file(at.join("out.egp")).expect("the pack");
    }
}

#[test]
fn one_cycle_that_the_encoder_refuses_costs_that_cycle_only() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    files(at);
    refuse(
        at,
        "once_1.bvh",
        1,
        &["1 of 2 walks cannot be encoded", "--keep-going"],
    );
    let results = import(at, "once_1.bvh --keep-going");
    let expected = "left out: once_1.bvh: the cycle at 1.25 s: joint Head turns a full circle";
    assert!(
        results["warnings"][0]
            .as_str()
            .is_some_and(|one| one.starts_with(expected))
    );
    assert_eq!(results["clips"][0]["cycles"], 1);
}

#[test]
fn an_impossible_field_of_the_bodies_costs_that_field_only() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    files(at);
    let people = |foot: &str| {
        format!(
            "subject,mass_kg,hip_breadth_mm,foot_length_mm\nhand,70,350,250\ngood,60,340,{foot}\n"
        )
    };
    fs::write(at.join("wrong.csv"), people("25")).expect("a file");
    fs::write(at.join("empty.csv"), people("")).expect("a file");
    let both = "good_1.bvh hand_1.bvh --bodies wrong.csv";
    let words = [
        "wrong.csv:3: foot_length_mm of 25: expected",
        "--keep-going",
    ];
    refuse(at, both, 1, &words);
    let results = import(at, &format!("{both} --keep-going"));
    let (all, own) = warnings(&results, "good_1.bvh");
    assert!(own.is_some());
    assert!(
        all[0].starts_with(words[0]) && all[0].ends_with("treated as not measured"),
        "{all:?}"
    );
    let found = fs::read(at.join("out.egp")).expect("a pack");
    import(at, "good_1.bvh hand_1.bvh --bodies empty.csv");
    assert!(found == fs::read(at.join("out.egp")).expect("a pack"));

    // An implausible mass for the stature is detected with the skeleton's legs.
    fs::write(at.join("heavy.csv"), "subject,mass_kg\ngood,250\n").expect("a file");
    let both = "good_1.bvh hand_1.bvh --bodies heavy.csv";
    fs::remove_file(at.join("out.egp")).expect("the pack");
    refuse(at, both, 2, &["subject \"good\"", "250 kg"]);
    let results = import(at, &format!("{both} --keep-going"));
    let (all, own) = warnings(&results, "good_1.bvh");
    assert_eq!(own, None);
    let said = all.iter().any(|one| {
        one.starts_with("left out: good_1.bvh: subject \"good\"") && one.contains("250 kg")
    });
    assert!(said, "{all:?}");
}

#[test]
fn a_warning_of_several_files_is_printed_once_with_their_number_and_kept_with_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    files(at);
    let names = ["hand_1.bvh", "hand_2.bvh", "hand_3.bvh", "hand_4.bvh"];
    for name in &names[1..] {
        fs::copy(at.join(names[0]), at.join(name)).expect("a copy");
    }
    let import = format!(
        "import {} good_1.bvh --out out.egp --json out.json",
        names.join(" ")
    );
    let said = done(at, &import.split(' ').collect::<Vec<_>>());
    let lines: Vec<&str> = said
        .lines()
        .filter(|line| line.contains("LeftHand"))
        .collect();
    assert_eq!(lines.len(), 1, "{said}");
    assert!(lines[0].starts_with("warning: "), "{said}");
    assert!(
        lines[0].contains("(4 files: ") && lines[0].ends_with(" and 1 more)"),
        "{said}"
    );
    let results = fs::read(at.join("out.json")).expect("results");
    let results: Value = serde_json::from_slice(&results).expect("JSON");
    for name in names {
        let (all, own) = warnings(&results, name);
        assert_eq!(own.map(|own| own.len()), Some(1));
        assert_eq!(all.len(), 1, "{all:?}");
        assert!(
            all[0].ends_with("(4 files: hand_1.bvh, hand_2.bvh, hand_3.bvh and 1 more)"),
            "{all:?}"
        );
    }
}

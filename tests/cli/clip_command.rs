//! Uncut motions on the command line: importing, rendering, and errors where cycles are needed.

use crate::command::*;
use crate::figure::write_turning_figure;
use crate::npy::npy;
use crate::two::folder;
use serde_json::Value;
use std::fs;

#[test]
fn a_take_without_a_cycle_is_kept_whole_and_drawn_at_any_second() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write_turning_figure(&at.join("anna_turn.bvh"), 150);
    refused(at, &["import", "anna_turn.bvh"], 1, &["gait cycle"]);
    let import = "import anna_turn.bvh --track clip --out turn.egp --json turn.json";
    done(at, &import.split(' ').collect::<Vec<_>>());
    let results = fs::read(at.join("turn.json")).expect("results");
    let results: Value = serde_json::from_slice(&results).expect("JSON");
    let clip = &results["clips"][0];
    assert_eq!(clip["frames"], 150);
    assert_eq!(
        (&clip["cadence_spm"], &clip["speed_mps"]),
        (&Value::Null, &0.0.into())
    );
    assert!(clip["max_error_mm"].as_f64().expect("an error") <= 5.01);
    // A standing figure that turns needs bytes only for the turn.
    assert!(clip["bytes"].as_u64().expect("bytes") < 500, "{clip}");

    // Seen from where it first faces: wide at first, narrow after a quarter turn, 0.75 s later.
    let render = "render turn.egp --azimuth-deg 0 --fps 4 --frames 12 --out turn.npy";
    done(at, &render.split(' ').collect::<Vec<_>>());
    let (shape, pixels) = npy(at.join("turn.npy"));
    assert_eq!(shape, "12, 50, 30");
    let area = |frame: usize| -> usize {
        let frame = &pixels[frame * 1_500..(frame + 1) * 1_500];
        frame.iter().filter(|&&pixel| pixel > 0).count()
    };
    assert!(area(0) > area(3) + 50, "{} {}", area(0), area(3));

    // A later start gives the same moment. Before the first and after the last there are no frames.
    let render = "render turn.egp --azimuth-deg 0 --start-s 0.75 --fps 4 --frames 1 --out b.npy";
    done(at, &render.split(' ').collect::<Vec<_>>());
    assert_eq!(npy(at.join("b.npy")).1, pixels[3 * 1_500..4 * 1_500]);
    for (start, word) in [("-9", "0 to 1,000,000"), ("1e3", "ends at")] {
        let render = format!("render turn.egp --start-s {start} --fps 4 --frames 1 --out c.npy");
        refused(at, &render.split(' ').collect::<Vec<_>>(), 2, &[word]);
    }
}

#[test]
fn one_frame_is_a_take() {
    let folder = tempfile::tempdir().expect("a folder");
    write_turning_figure(&folder.path().join("one.bvh"), 1);
    let import = "import one.bvh --track clip --out one.egp";
    done(folder.path(), &import.split(' ').collect::<Vec<_>>());
    let art = "render one.egp --fps 1 --frames 1";
    let art = done(folder.path(), &art.split(' ').collect::<Vec<_>>());
    assert!(art.contains("0.000 and 0.000 s"), "{art}");
}

#[test]
fn what_needs_a_cycle_refuses_takes_and_names_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write_turning_figure(&at.join("anna_turn.bvh"), 50);
    let import = "import anna_turn.bvh --track clip --out turn.egp";
    done(at, &import.split(' ').collect::<Vec<_>>());
    let needs_cycle: &[&str] = &["\"anna_turn\"", "a GEI needs a gait cycle", "--track clip"];
    for (arguments, code, words) in [
        ("sweep turn.egp --views side", 1, needs_cycle),
        ("train turn.egp", 1, &["\"anna_turn\""]),
        ("score turn.egp", 1, &["\"anna_turn\""]),
        (
            "render turn.egp",
            2,
            &["\"anna_turn\"", "--fps F --frames N", "--start-s"],
        ),
        (
            "render turn.egp --fps 4 --frames 2 --cycle 1",
            1,
            &["no variations"],
        ),
        ("render turn.egp --fps 4", 2, &["--frames"]),
        ("render turn.egp --start-s 1", 2, &["--fps"]),
        ("render turn.egp --fps 0 --frames 2", 2, &["--fps 0"]),
        (
            "render turn.egp --fps 4 --frames 2 --start-s inf",
            2,
            &["--start-s inf"],
        ),
        (
            "render turn.egp --fps 4 --frames 2 --frames-per-cycle 9",
            2,
            &["--frames-per-cycle"],
        ),
        (
            "render turn.egp --fps 4 --frames 2 --template gei --out a.npy",
            2,
            &["--template"],
        ),
    ] {
        refused(at, &arguments.split(' ').collect::<Vec<_>>(), code, words);
    }
    assert_eq!(names(at), ["anna_turn.bvh", "turn.egp"]);
}

#[test]
fn a_cycle_is_drawn_at_any_second_too() {
    let folder = folder();
    let at = folder.path();
    // At 4 km/h, the frames of a cycle by seconds equal those by phase.
    let cycle = "render two.egp --subjects F01 --walks walk-4kmh --frames-per-cycle 8 --out a.npy";
    done(at, &cycle.split(' ').collect::<Vec<_>>());
    let bytes = fs::read(at.join("two.egp")).expect("a pack");
    let pack = edgegait_core::pack::Pack::parse(&bytes).expect("a pack");
    let walk = pack
        .walks()
        .find(|walk| walk.name == "walk-4kmh")
        .expect("a walk");
    let period_s = pack.clip(walk.clip).expect("a clip").duration_s();
    let seconds = format!(
        "render two.egp --subjects F01 --walks walk-4kmh --fps {} --frames 8 --start-s {} --out b.npy",
        8.0 / period_s,
        3.0 * period_s
    );
    done(at, &seconds.split(' ').collect::<Vec<_>>());
    let ((shape, a), (_, b)) = (npy(at.join("a.npy")), npy(at.join("b.npy")));
    assert_eq!(shape, "8, 50, 30");
    let differing = a.iter().zip(&b).filter(|(a, b)| a != b).count();
    assert!(differing < 8, "{differing} pixels");
}

#[test]
fn legs_that_do_not_reach_are_reported_by_frame_and_millimetre() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write_turning_figure(&at.join("anna_turn.bvh"), 150);
    let clip = || -> Value {
        let import = "import anna_turn.bvh --track clip --stature-m 1.75 --out turn.egp --json turn.json --overwrite";
        done(at, &import.split(' ').collect::<Vec<_>>());
        let results = fs::read(at.join("turn.json")).expect("results");
        let results: Value = serde_json::from_slice(&results).expect("JSON");
        results["clips"][0].clone()
    };
    let sentence = "short of where the feet were (frame ";
    let even = clip();
    assert!(!even["warnings"].to_string().contains(sentence), "{even}");

    // One leg is 12 cm longer than the other; the body's legs are equal.
    let text = fs::read_to_string(at.join("anna_turn.bvh")).expect("a figure");
    let (before, foot) = text.split_once("JOINT LeftFoot").expect("a foot");
    let foot = foot.replacen("OFFSET 0 -45 0", "OFFSET 0 -57 0", 1);
    fs::write(
        at.join("anna_turn.bvh"),
        format!("{before}JOINT LeftFoot{foot}"),
    )
    .expect("a file");
    let odd = clip()["warnings"].to_string();
    assert!(odd.contains(sentence) && odd.contains(" mm "), "{odd}");
}

//! Feet of recorded walkers on bodies of other dimensions.

use crate::command::done;
use crate::data::fixtures;
use serde_json::Value;
use std::fs;

/// Leg lengths and hip widths from a small woman's to a tall man's.
const BODIES: [[&str; 4]; 2] = [
    ["--stature-m", "1.52", "--sex", "female"],
    ["--stature-m", "1.92", "--sex", "male"],
];

#[test]
fn feet_slide_by_at_most_5_mm_more_than_in_the_recording_whatever_the_body() {
    let clips = fixtures().join("mocap/clips").display().to_string();
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for body in BODIES {
        let import = ["import", &clips, "--subject-from", "folder", "--overwrite"];
        let to = ["--out", "walks.egp", "--json", "walks.json"];
        done(at, &[&import[..], &body, &to].concat());
        let results = fs::read(at.join("walks.json")).expect("results");
        let results: Value = serde_json::from_slice(&results).expect("JSON");
        let clips = results["clips"].as_array().expect("clips");
        assert!(clips.len() > 3);
        for clip in clips {
            let [slide, own] =
                ["skate_mm", "own_skate_mm"].map(|name| clip[name].as_f64().expect("a stance"));
            println!("{}: {slide:.0} mm, own {own:.0}", clip["file"]);
            assert!((slide - own).abs() < 5.0, "{}: {slide} {own}", clip["file"]);
        }
    }
}

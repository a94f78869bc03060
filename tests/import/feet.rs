//! The feet of recorded walkers on bodies of other dimensions.

use crate::command::done;
use crate::data::fixtures;
use edgegait::people::recorded::{ReadOptions, Recording};
use edgegait_core::skeleton::Joint;
use serde_json::Value;
use std::fs;

/// Bodies of a small woman and a tall man, which differ in leg length and hip width.
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

#[test]
fn feet_of_captured_walkers_are_turned_by_a_constant_to_stand_flat() {
    let file = fixtures().join("mocap/clips/cmu_amc/s07/07_01.amc");
    let read = |mend| {
        let options = ReadOptions {
            mend,
            ..ReadOptions::default()
        };
        Recording::read(&file, &options).expect("a walk").take
    };
    let (flat, filed) = (read(true), read(false));
    for (foot, degrees) in [(Joint::LeftFoot, 5.0), (Joint::RightFoot, 8.7)] {
        let turns = filed
            .rotations
            .iter()
            .zip(&flat.rotations)
            .map(|(filed, flat)| {
                let [filed, flat] = [filed, flat].map(|pose| pose[foot.index()]);
                filed.angle_between(flat).to_degrees()
            });
        let turns: Vec<f64> = turns.collect();
        println!("{foot:?}: {} degrees", turns[0]);
        // In the file, the feet are rolled inwards by 5 and 8 degrees and pitched by 1 and 4, by
        // its own axes.
        assert!((turns[0] - degrees).abs() < 1.0, "{foot:?}: {}", turns[0]);
        assert!(turns.iter().all(|turn| (turn - turns[0]).abs() < 1e-6));
    }
}

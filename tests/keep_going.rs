//! What noise and what cannot be used cost: a warning, not the run.

#[expect(dead_code, reason = "other tests share it")]
mod command;
#[expect(dead_code, reason = "other tests share it")]
#[path = "truth/recording.rs"]
mod recording;

use command::*;
use recording::walk;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Runs `import` with these arguments; the results.
fn import(at: &Path, arguments: &str) -> Value {
    let import = format!("import {arguments} --out out.egp --json out.json");
    done(at, &import.split(' ').collect::<Vec<_>>());
    serde_json::from_slice(&fs::read(at.join("out.json")).expect("results")).expect("JSON")
}

/// Warnings of the header, and of the clip of a file, if it came in.
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

/// Files with a usual walk of two cycles, from 0.25 and 1.25 s on, and with others in which the left
/// hand does something else: it is turned over in the second cycle, or next to the file's end, or
/// it turns once a second, or once in the second cycle.
fn files(at: &Path) {
    let over = |frame: usize, from: usize| if frame < from { 0.0 } else { 178.0 };
    let once = |frame: usize| 9.0 * frame.clamp(190, 230) as f64;
    walk(at, "good_1.bvh", 0.0, |_, _| None);
    let hand = |name: &str, turned: &dyn Fn(usize) -> f64| {
        walk(at, name, 0.0, |joint, frame| {
            (joint == "LeftHand").then(|| [turned(frame), 0.0, 0.0])
        });
    };
    hand("hand_1.bvh", &|frame| over(frame, 180));
    hand("edge_1.bvh", &|frame| over(frame, 3));
    hand("spin_1.bvh", &|frame| 3.0 * frame as f64);
    hand("once_1.bvh", &once);
}

#[test]
fn a_hand_that_flips_over_is_smoothed_with_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    files(at);
    for more in ["", " --track clip", " --track clip --low-pass-hz 0"] {
        let results = import(at, &format!("good_1.bvh hand_1.bvh{more}"));
        let (_, hand) = warnings(&results, "hand_1.bvh");
        let hand = hand.expect("it came in");
        let said: Vec<&String> = hand.iter().filter(|one| one.contains("LeftHand")).collect();
        assert_eq!(said.len(), 1, "{more}: {hand:?}");
        for word in ["degrees from frame", "are interpolated", "noise"] {
            assert!(said[0].contains(word), "{more}: {hand:?}");
        }
        let (_, good) = warnings(&results, "good_1.bvh");
        assert_eq!(good, Some(Vec::new()), "{more}");
    }
}

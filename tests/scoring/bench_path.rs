//! Tests of `edgegait bench --video`, for a time that is too short for meaningful times.

use crate::command::{done, names, refused};
use crate::two::folder;
use image::{Rgb, RgbImage};
use serde_json::Value;
use std::fs;
use std::path::Path;

const SIDE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/models/side.onnx");

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("{key}: {of}"))
}

#[test]
fn the_path_of_a_made_video_is_measured_with_each_model() {
    let folder = folder();
    let at = folder.path();
    let measure = [
        "bench",
        "--video",
        "made",
        "--minutes",
        "0.005",
        "--json",
        "-",
    ];
    let results: Value = serde_json::from_str(&done(at, &measure)).expect("one JSON document");
    assert_eq!(results["models"], serde_json::json!([]));
    assert_eq!(results["settings"]["video"], "made");
    assert_eq!(results["settings"]["path_threads"], 1);
    assert_eq!(results["settings"]["pack"], "built-in cohort");
    let paths = results["paths"].as_array().expect("a list");
    let of: Vec<&Value> = paths.iter().map(|path| &path["name"]).collect();
    assert_eq!(of, ["side", "spread"]);
    for path in paths {
        let video = &path["video"];
        let size = (
            number(video, "columns"),
            number(video, "rows"),
            number(video, "fps"),
        );
        assert_eq!(size, (320.0, 240.0, 25.0));
        assert!(
            number(video, "cycles") >= 2.0 && number(video, "frames") >= 50.0,
            "{video}"
        );
        // At least 0.3 s, and until there is an answer.
        assert!(number(path, "seconds") >= 0.3, "{path}");
        let frames = number(path, "frames");
        let rate = frames / number(path, "seconds");
        assert!((number(path, "frames_per_second") - rate).abs() < 1e-6 * rate);
        assert!((number(path, "times_real_time") - rate / 25.0).abs() < 1e-6 * rate);
        let stages = &path["stages"];
        let total_us = |stage: &str| {
            let stage = &stages[stage];
            number(stage, "mean_us") * number(stage, "calls")
        };
        let per_frame = ["decode", "segment", "framing", "cycle"];
        assert!(
            per_frame
                .iter()
                .all(|stage| number(&stages[*stage], "calls") == frames)
        );
        let answers = number(&path["answers"], "count");
        assert!(answers >= 1.0);
        assert!(
            ["template", "network"]
                .iter()
                .all(|stage| number(&stages[*stage], "calls") == answers)
        );
        let sum: f64 = per_frame
            .iter()
            .chain(&["template", "network"])
            .map(|s| total_us(s))
            .sum();
        let seconds = number(path, "seconds");
        assert!(
            sum <= 1.000_001e6 * seconds && sum > 0.98e6 * seconds,
            "{sum} {seconds}"
        );
        assert!(number(&path["answers"], "waited_frames_most") >= 1.0);
        if cfg!(target_os = "linux") {
            let start = number(path, "peak_rss_start_bytes");
            assert!(start > 1e6 && number(path, "peak_rss_end_bytes") >= start);
        }
    }
    // Two boards, one of which has measured models.
    fs::write(at.join("path.json"), results.to_string()).expect("written");
    let mut other = results.clone();
    other["paths"] = serde_json::json!([paths[0]]);
    fs::write(at.join("one.json"), other.to_string()).expect("written");
    let compare = [
        "bench",
        "--compare",
        "path.json",
        "one.json",
        "--format",
        "markdown",
    ];
    let table = done(at, &compare);
    for words in [
        "|  | side path | spread path | side one |",
        "| times real time |",
        "| segment |",
        "| video | 320x240, ",
    ] {
        assert!(table.contains(words), "{words}: {table}");
    }
    assert!(!table.contains("multiply-accumulates"), "{table}");
}

/// Writes a grey Y4M video of this many frames in which a block crosses, and an image of its wall.
fn block(at: &Path, frames: u32) {
    let frame = |column: Option<u32>| {
        RgbImage::from_fn(96, 64, |x, y| {
            let is_on = column.is_some_and(|from| (from..from + 12).contains(&x));
            Rgb([if is_on && (16..48).contains(&y) {
                40
            } else {
                150
            }; 3])
        })
    };
    let mut bytes = b"YUV4MPEG2 W96 H64 F30:1 Ip Cmono XCOLORRANGE=FULL\n".to_vec();
    for number in 0..frames {
        bytes.extend(b"FRAME\n");
        let grey = image::DynamicImage::from(frame(Some(number))).into_luma8();
        bytes.extend(grey.into_raw());
    }
    fs::write(at.join("walk.y4m"), bytes).expect("written");
    frame(None).save(at.join("wall.png")).expect("written");
    RgbImage::new(90, 64)
        .save(at.join("narrow.png"))
        .expect("written");
}

#[test]
fn a_video_without_a_gait_cycle_is_refused_with_what_was_found() {
    let folder = folder();
    let at = folder.path();
    let bench = |more: &str| -> Vec<String> {
        let all = format!("bench {SIDE} --minutes 600 {more}");
        all.split(' ').map(str::to_owned).collect()
    };
    let refuse = |more: &str, code: i32, words: &[&str]| {
        let all = bench(more);
        refused(
            at,
            &all.iter().map(String::as_str).collect::<Vec<_>>(),
            code,
            words,
        );
    };
    block(at, 20);
    refuse(
        "--video walk.y4m --background wall.png",
        1,
        &[
            "walk.y4m: expected a whole gait cycle",
            "20 of 20 frames show a person, and at 30 frames a second two cycles are 33",
        ],
    );
    // The file's rate is 30, unless a flag gives another.
    refuse(
        "--video walk.y4m --background wall.png --fps 50",
        1,
        &["at 50 frames a second"],
    );
    refuse(
        "--video walk.y4m --background wall.png --fps 5",
        2,
        &["10", "120"],
    );
    block(at, 80);
    refuse(
        "--video walk.y4m --background wall.png",
        1,
        &["walk.y4m: expected swinging legs"],
    );
    refuse(
        "--video walk.y4m --background narrow.png",
        1,
        &["narrow.png", "96x64", "90x64"],
    );
    refuse("--video nowhere", 1, &["nowhere"]);
    refuse("--video -", 2, &["--video -", "standard input"]);
    refuse(
        "--video two.egp",
        1,
        &["two.egp: expected a video, found a pack"],
    );
    refuse("--video walk.y4m two.egp", 2, &["PACK"]);
    refuse("--video made --background wall.png", 2, &["--background"]);
    refuse("--video made --raster rows", 2, &["--raster"]);
    refuse("--video made --walks none", 2, &["none"]);
    refuse("--video made --window-s 1", 2, &["--window-s"]);
    refuse("--background wall.png", 2, &["--video"]);
    refused(
        at,
        &["bench", "--video", "made", "--minutes", "0"],
        2,
        &["more than 0"],
    );
    let model = fs::read(SIDE).expect("a model");
    fs::write(at.join("far.onnx"), model).expect("written");
    for (contract, words) in [
        ("framing = \"camera\"", "framing \"height\" or \"box\""),
        ("rows = 128\ncolumns = 88", "128 rows and 88 columns"),
    ] {
        fs::write(at.join("far.toml"), contract).expect("written");
        refused(
            at,
            &["bench", "far.onnx", "--video", "made"],
            1,
            &["far", words],
        );
    }
    let left = names(at);
    assert!(
        !left.iter().any(|name| name.contains("edgegait")),
        "{left:?}"
    );
}

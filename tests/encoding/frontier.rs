//! Tests of `edgegait frontier` and `--max-gei-rmse`.

use crate::command::{done, names, refused};
use crate::two::folder;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

fn points(results: &Value) -> &Vec<Value> {
    results["points"].as_array().expect("points")
}

fn number(point: &Value, key: &str) -> f64 {
    let found = point[key].as_f64();
    found.unwrap_or_else(|| panic!("{key}: expected a number in {point}"))
}

/// Checks what all points of all scenes must satisfy.
fn check(points: &[Value]) {
    for point in points {
        assert!(number(point, "ns_per_silhouette") > 100.0, "{point}");
        let frames = number(point, "frames_per_cycle");
        let of_gei = number(point, "ns_per_silhouette") * frames;
        assert!((number(point, "ns_per_gei") / of_gei - 1.0).abs() < 1e-9);
        assert!((0.7..1.0).contains(&number(point, "jaccard")), "{point}");
        assert!((0.5..40.0).contains(&number(point, "gei_rmse")), "{point}");
        assert!(number(point, "rank1_delta").abs() <= 1.0);
        assert!(number(point, "pack_bytes") > 500.0);
        assert!(number(point, "stack_bytes") > 1_000.0);
        let has_heap = number(point, "heap_bytes") > 0.0;
        assert_eq!(has_heap, point["raster"] == "skia-aa", "{point}");
    }
    let marked = |key: &str| points.iter().filter(|point| point[key] == true).count();
    assert_eq!(marked("is_default"), 1);
    assert_eq!(points[0]["is_default"], true);
    assert_eq!(number(&points[0], "time_ratio"), 1.0);
    assert!(marked("pareto") > 0);
    // The point with the least error is always in the Pareto set.
    let error = |point: &&Value| number(point, "gei_rmse");
    let closest = points.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
    assert_eq!(closest.expect("a point")["pareto"], true);
}

#[test]
fn a_frontier_has_at_least_12_points_and_comes_as_json_csv_and_a_chart() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let results = json(&done(path, &["frontier", "--quick", "--json", "-"]));
    assert_eq!(results["command"], "frontier");
    assert_eq!(results["settings"]["pack"], "built-in cohort");
    let all = points(&results);
    assert!(all.len() >= 12);
    check(all);
    let distinct: BTreeSet<&str> = all.iter().filter_map(|p| p["name"].as_str()).collect();
    assert_eq!(distinct.len(), all.len());
    // In each single setting, a finer value is larger and has a smaller error.
    let of = |name: &str| {
        let found = all.iter().find(|point| point["name"] == name);
        found.unwrap_or_else(|| panic!("no point {name:?}"))
    };
    for finer_first in [
        [
            "skia, 32 frames, 1 mm, all points",
            "skia, 32 frames, 20 mm, all points",
        ],
        [
            "skia, 32 frames, 5 mm, all points",
            "skia, 32 frames, 5 mm, 240 points",
        ],
    ] {
        let [finer, coarser] = finer_first.map(of);
        assert!(number(finer, "pack_bytes") > number(coarser, "pack_bytes"));
        assert!(number(finer, "gei_rmse") < number(coarser, "gei_rmse"));
        assert!(number(finer, "jaccard") > number(coarser, "jaccard"));
    }

    let written = path.join("edgegait-frontier");
    assert_eq!(
        names(&written),
        ["frontier.csv", "frontier.json", "frontier.svg"]
    );
    let text = |name: &str| fs::read_to_string(written.join(name)).expect("a file");
    assert_eq!(json(&text("frontier.json")), results);
    crate::limits::holds(&written, "frontier.json");
    let csv = text("frontier.csv");
    assert_eq!(csv.lines().count(), 1 + all.len());
    assert!(csv.starts_with("name,raster,jitter,hull_points,frames_per_cycle,track_error_mm,"));
    let svg = text("frontier.svg");
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert!(distinct.iter().all(|name| svg.contains(name)));
    // A dot for each point, one in the list for each of the Pareto set, and the ring of the
    // default.
    let front = all.iter().filter(|point| point["pareto"] == true).count();
    assert_eq!(svg.matches("<circle").count(), all.len() + front + 1);

    // Except for times and values derived from them, results are reproducible.
    let again = json(&done(
        path,
        &["frontier", "--quick", "--json", "-", "--threads", "1"],
    ));
    let timeless = |point: &Value| {
        let mut point = point.as_object().expect("an object").clone();
        for key in ["ns_per_silhouette", "ns_per_gei", "time_ratio", "pareto"] {
            assert!(point.remove(key).is_some());
        }
        point
    };
    let pairs = all.iter().zip(points(&again));
    for (a, b) in pairs {
        assert_eq!(timeless(a), timeless(b));
    }
}

#[test]
fn a_packs_walks_are_measured_as_they_are_stored() {
    let folder = folder();
    let path = folder.path();
    let results = done(path, &["frontier", "two.egp", "--quick", "--json", "-"]);
    let results = json(&results);
    assert_eq!(results["inputs"][0]["path"], "two.egp");
    let all = points(&results);
    assert!(all.len() >= 12);
    check(all);
    let bytes = fs::metadata(path.join("two.egp")).expect("the pack").len();
    for point in all {
        assert_eq!(number(point, "pack_bytes"), bytes as f64);
        assert!((0.1..=5.0).contains(&number(point, "track_error_mm")));
        assert!((300.0..=768.0).contains(&number(point, "hull_points")));
    }
    let warnings = results["warnings"].to_string();
    assert!(warnings.contains("is its own motion"), "{warnings}");
    refused(
        path,
        &["frontier", "--out", "two.egp"],
        2,
        &["expected a folder"],
    );
    refused(path, &["frontier", "three.egp"], 1, &["three.egp"]);
}

fn settings(path: &Path, arguments: &[&str]) -> Value {
    json(&done(path, &[arguments, &["--json", "-"]].concat()))["settings"].clone()
}

#[test]
fn a_sweep_takes_the_cheapest_drawing_that_meets_an_error() {
    let folder = folder();
    let path = folder.path();
    let sweep = |most: &str, out: &str| {
        let angles = ["--azimuth-deg", "0,90", "--elevation-deg", "0,40"];
        let flags = ["sweep", "two.egp", "--max-gei-rmse", most, "--out", out];
        settings(path, &[&flags[..], &angles].concat())
    };
    let (coarse, fine) = (sweep("30", "coarse"), sweep("7", "fine"));
    for (found, most) in [(&coarse, 30.0), (&fine, 7.0)] {
        assert_eq!(found["max_gei_rmse"], most);
        assert!(found["gei_rmse"].as_f64().expect("an error") <= most);
    }
    let why = |found: &Value| found["chosen"].as_str().expect("why").to_owned();
    assert!(why(&coarse).contains("the cheapest there is"), "{coarse}");
    assert!(why(&fine).contains("walks: 4, viewpoints: 4"), "{fine}");
    assert!(why(&fine).contains("the next cheaper"), "{fine}");
    let frames = |found: &Value| found["frames_per_cycle"].as_u64().expect("frames");
    assert_eq!(frames(&coarse), 8);
    assert!(frames(&fine) > 8);
    assert!(why(&fine).starts_with(fine["raster"].as_str().expect("a rasteriser")));

    // The chosen settings, given as flags, produce the same sweep.
    let text = frames(&fine).to_string();
    let flags = [
        "sweep",
        "two.egp",
        "--azimuth-deg",
        "0,90",
        "--elevation-deg",
        "0,40",
        "--out",
        "same",
        "--raster",
        fine["raster"].as_str().expect("a name"),
        "--jitter",
        fine["jitter"].as_str().expect("a name"),
        "--frames-per-cycle",
        &text,
    ];
    done(path, &flags);
    let geis = |name: &str| fs::read(path.join(name).join("geis.npy")).expect("GEIs");
    assert_eq!(geis("same"), geis("fine"));

    let with = |more: &[&str], code, words: &[&str]| {
        let flags = [
            "sweep",
            "two.egp",
            "--views",
            "side",
            "--out",
            "none",
            "--max-gei-rmse",
        ];
        refused(path, &[&flags[..], more].concat(), code, words);
        assert!(!path.join("none").exists());
    };
    with(&["0.01"], 1, &["0.01", "the best that can be reached"]);
    with(
        &["7", "--raster", "skia"],
        2,
        &["--raster", "cannot be used"],
    );
    with(&["7", "--jitter", "r2"], 2, &["--jitter"]);
    with(
        &["7", "--frames-per-cycle", "32"],
        2,
        &["--frames-per-cycle"],
    );
    with(&["7", "--framing", "box"], 2, &["--framing height"]);
    with(&["0"], 2, &["above 0"]);
}

#[test]
fn a_cohort_takes_the_encoding_of_fewest_bytes_that_meets_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let cohort = ["cohort", "--people", "1", "--speeds-kmh", "5"];
    let made = |more: &[&str]| settings(path, &[&cohort[..], more].concat());
    let found = made(&["--max-gei-rmse", "8"]);
    assert!(found["gei_rmse"].as_f64().expect("an error") <= 8.0);
    let why = found["chosen"].as_str().expect("why");
    assert!(why.contains("walks: 1, viewpoints: 12"), "{why}");
    let bytes = || fs::read(path.join("cohort.egp")).expect("a pack");
    let chosen = bytes();
    let [error, points] = ["max_error_mm", "hull_points"].map(|key| found[key].to_string());
    made(&["--max-error-mm", &error, "--hull-points", &points]);
    assert_eq!(bytes(), chosen);
    made(&["--max-error-mm", "1"]);
    assert!(chosen.len() < bytes().len());

    let with = |more: &[&str], code, words: &[&str]| {
        refused(path, &[&cohort[..], more].concat(), code, words);
    };
    with(
        &["--max-gei-rmse", "0.001"],
        1,
        &["the best that can be reached"],
    );
    for flags in [
        ["--max-error-mm", "5"],
        ["--budget-bytes", "9000"],
        ["--hull-points", "160"],
    ] {
        let all = [&["--max-gei-rmse", "8"][..], &flags].concat();
        with(&all, 2, &[flags[0], "cannot be used"]);
    }
    with(&["--hull-points", "63"], 2, &["--hull-points"]);
}

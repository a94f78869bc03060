//! Trees and datasets, looked at with `inspect` and `render`.

use crate::command::*;
use crate::npy::npy;
use crate::two::folder;
use serde_json::{Value, json};
use std::fs;

#[test]
fn trees_and_datasets_are_looked_at_as_packs_are() {
    let folder = folder();
    let at = folder.path();
    let run = |line: &str| done(at, &line.split(' ').collect::<Vec<_>>());
    run("sweep two.egp --walks walk-4kmh --views side --cycles 2 --format opengait --out tree");
    let numbers = |json: String| -> Vec<Value> {
        let summary: Value = serde_json::from_str(&json).expect("JSON");
        let counts = [
            "kind",
            "sequences",
            "people",
            "takes",
            "views",
            "recordings",
        ];
        counts.map(|name| summary[name].clone()).into()
    };
    let found = numbers(run("inspect tree --json -"));
    assert_eq!((&found[0], &found[1]), (&"tree".into(), &2.into()));
    // Known cycles of 32 frames, two in each recording.
    for recording in found[5].as_array().expect("recordings") {
        assert_eq!(recording["frames"], 64);
        let cycles = json!([[0, 31], [32, 63]]);
        assert_eq!(recording["cycles"], cycles);
    }
    let text = run("inspect tree");
    assert!(text.contains("0-31 32-63"), "{text}");
    // A whole recording is no cycle.
    let whole = numbers(run("inspect tree --whole-recordings --json -"));
    assert_eq!(whole[5][0]["cycles"], json!([]));

    run("sweep tree --out geis");
    let index = fs::read_to_string(at.join("geis/index.csv")).expect("an index");
    let ends = index.lines().map(|row| row.rsplitn(3, ',').take(2));
    let ends: Vec<String> = ends.map(|two| two.collect::<Vec<_>>().join(" ")).collect();
    assert_eq!(ends[..3], ["last_frame first_frame", "31 0", "63 32"]);
    assert_eq!(numbers(run("inspect geis --json -"))[1], 4);
    let (shape, stored) = npy(at.join("geis/geis.npy"));
    assert_eq!(shape, "4, 50, 30");

    // Two walks from one side, 64 silhouettes each.
    for source in ["tree", "geis"] {
        let json = run(&format!("render {source} --overwrite --out a.png --json -"));
        let rendered: Value = serde_json::from_str(&json).expect("JSON");
        let counts = ["walks", "viewpoints", "silhouettes"].map(|name| rendered[name].clone());
        assert_eq!(counts, [2, 1, 128].map(Value::from), "{source}");
    }

    // One recording as arrays: two GEIs, which the dataset has, too.
    run("render tree --subjects F01 --template gei --out geis.npy");
    assert_eq!(
        npy(at.join("geis.npy")),
        ("2, 50, 30".to_owned(), stored[..3000].to_vec())
    );
    for line in [
        "tree --overwrite --out a.png",
        "tree --template gei --out b.png",
        "geis --out c.png",
        "tree --out d.gif",
    ] {
        run(&format!("render {line}"));
    }
    let picture = |name: &str| image::open(at.join(name)).expect("a picture").to_luma8();
    for name in ["a.png", "b.png", "c.png"] {
        assert!(picture(name).pixels().any(|of| of.0 == [255]), "{name}");
    }
    assert!(picture("a.png").height() > picture("b.png").height());
    let art = run("render tree");
    let title = "F01, walk-4kmh-01, azimuth 90, frames 0 to 31; phases 0 and 0.25\n";
    assert!(art.starts_with(title), "{art}");

    for (line, code, words) in [
        ("inspect two.egp --fps 25", 2, "--fps: expected a tree"),
        ("inspect geis --whole-recordings", 2, "expected a tree"),
        ("render two.egp --whole-recordings", 2, "expected a tree"),
        ("render tree --cycle 1", 2, "--cycle: expected a pack"),
        ("render tree --raster rows", 2, "--raster"),
        ("render tree --out e.npy", 2, "2 recordings are chosen"),
        ("render tree --subjects F09", 2, "F09"),
        ("render tree --azimuth-deg 45 --out e.png", 1, "found none"),
        ("render geis", 2, ".png"),
    ] {
        refused(at, &line.split(' ').collect::<Vec<_>>(), code, &[words]);
    }
}

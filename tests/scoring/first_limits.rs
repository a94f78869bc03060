//! Limits that `gate --init` derives from the results of each command: the results hold them.

use crate::command::{done, refused};
use crate::data::fixtures;
use crate::limits::holds;
use image::{Rgb, RgbImage};
use std::fs;
use std::path::Path;

/// Subcommands whose own tests check their results, since these take long.
const ELSEWHERE: [&str; 4] = ["confounders", "frontier", "literature", "study"];
/// Subcommands whose results have neither times, sizes nor rates.
const WITHOUT: [&str; 5] = ["completions", "contract", "gate", "merge", "render"];

fn run(at: &Path, command: &str) {
    done(at, &command.split_whitespace().collect::<Vec<_>>());
}

/// Writes a short video of a block before a wall.
fn video(at: &Path) {
    fs::create_dir(at.join("frames")).expect("a folder");
    let frame = |place: u32| {
        RgbImage::from_fn(48, 32, |x, y| {
            let is_on = (place..place + 6).contains(&x) && (8..24).contains(&y);
            Rgb(if is_on {
                [40, 50, 150]
            } else {
                [150, 140, 130]
            })
        })
    };
    for number in 0..6 {
        let path = at.join(format!("frames/{number}.png"));
        frame(6 * number).save(path).expect("a frame");
    }
    frame(99).save(at.join("wall.png")).expect("a picture");
}

/// Copies models, one of them with other bytes and the same weights.
fn models(at: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    for name in ["side.onnx", "side.toml"] {
        fs::copy(root.join(name), at.join(name)).expect("a shipped model");
    }
    let mut bytes = fs::read(fixtures().join("parity/float.onnx")).expect("a network");
    fs::write(at.join("float.onnx"), &bytes).expect("written");
    // ModelProto.doc_string = "x"
    bytes.extend(b"\x32\x01x");
    fs::write(at.join("copy.onnx"), bytes).expect("written");
}

/// Returns a command of each subcommand, apart from [`ELSEWHERE`].
fn commands() -> Vec<(&'static str, String)> {
    let clip = fixtures().join("mocap/clips/cmu_bvh_retargeted/s02/002_01.bvh");
    [
        ("cohort", "--people 2 --speeds-kmh 4,6 --quick --out two.egp"),
        ("inspect", "two.egp"),
        ("completions", "--out share"),
        ("sweep", "two.egp --views side --shard 1/2 --out one"),
        ("merge", "one other --out set"),
        ("score", "side spread two.egp --azimuth-deg 60,90 --protocol first-take"),
        ("render", "two.egp --out picture.png"),
        ("train", "two.egp --components 2 --out m.onnx"),
        ("check", "side.onnx"),
        ("contract", "m.onnx --out c.toml"),
        ("quantize", "side.onnx --cycles 1 --views side --out s.egr"),
        ("bench", "side --no-accuracy --window-s 0.02 --windows 2 --batch 2 --frames-per-cycle 8 --max-seconds 2"),
        ("generate", "casia-b-like --people 1 --out made"),
        ("segment", "frames --background wall.png --out seen"),
        ("gate", "inspect.json.limits.toml inspect.json"),
    ]
    .map(|(name, rest)| (name, rest.to_owned()))
    .into_iter()
    .chain([
        ("import", format!("{} --out walk.egp", clip.display())),
        ("parity", "float.onnx copy.onnx two.egp --views side".to_owned()),
    ])
    .collect()
}

#[test]
fn results_of_each_command_hold_their_first_limits() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    video(at);
    models(at);
    let mut named: Vec<String> = ELSEWHERE.map(str::to_owned).into();
    for (name, rest) in commands() {
        named.push(name.to_owned());
        if name == "merge" {
            run(at, "sweep two.egp --views side --shard 2/2 --out other");
        }
        let results = format!("{name}.json");
        run(at, &format!("{name} {rest} --json {results}"));
        if WITHOUT.contains(&name) {
            let words = ["expected results with a time, a size or a rate", &results];
            refused(at, &["gate", "--init", &results], 1, &words);
        } else {
            holds(at, &results);
        }
    }
    // No subcommand is left out.
    let help = done(at, &["--help"]);
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let lines = lines.take_while(|line| !line.is_empty());
    // The text of a command may go on in a line that is indented further.
    let listed = lines.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let mut listed: Vec<&str> = { listed }
        .filter(|name| !name.is_empty() && *name != "help")
        .collect();
    listed.sort_unstable();
    named.sort_unstable();
    assert_eq!(named, listed);
}

#[test]
fn a_limit_with_a_bound_of_its_own_needs_no_baseline() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    run(at, "score side --views side --json r.json");
    let limits = holds(at, "r.json");
    assert!(limits.contains("not_worse = true"), "{limits}");
    let said = done(at, &["gate", "r.json.limits.toml", "r.json"]);
    assert!(said.contains("relative to a baseline left out"), "{said}");
    // Beside itself nothing is left out.
    let said = done(at, &["gate", "r.json.limits.toml", "r.json", "r.json"]);
    assert!(!said.contains("left out"), "{said}");
    fs::write(
        at.join("only.toml"),
        "[[limit]]\nfigure = \"recognizers[side].rank1\"\nnot_worse = true\n",
    )
    .expect("written");
    let words = ["expected a baseline for this limit, found none"];
    refused(at, &["gate", "only.toml", "r.json"], 1, &words);
}

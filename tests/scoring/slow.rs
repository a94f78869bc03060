//! Slow networks: measuring within a time limit, cached answers, resumed runs.
#![cfg(target_os = "linux")]

use crate::command::{code, done, edgegait, refused, text};
use crate::network::{macs_of_a_frame, write_network};
use crate::signals::heeding_signals;
use crate::two::folder;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("one JSON document")
}

/// A tenth of a second or more of one core: two thousand million multiply-accumulates.
const LAYERS: usize = 250;

#[test]
fn what_measuring_in_the_time_that_there_is_leaves_out_is_stated() {
    let folder = folder();
    let at = folder.path();
    write_network(at, "slow", LAYERS, None);
    let bench = "bench slow.onnx two.egp --threads 1 --batch 1024 --max-seconds 3 --json -";
    let output = edgegait(at, &words(bench));
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let results = json(&text(&output.stdout));
    let model = &results["models"][0];
    let number = |of: &Value, key: &str| of[key].as_f64().unwrap_or_else(|| panic!("{key}: {of}"));
    assert_eq!(results["settings"]["max_seconds"], 3.0);
    assert_eq!(model["macs"], 32 * macs_of_a_frame(LAYERS));
    // On any machine, 500 inferences, 55 batches of 1,024, and 1,408 images of two people would
    // have taken far longer.
    let full = number(&model["cut"], "full_seconds");
    assert!(number(model, "seconds") < full / 10.0, "{model}");
    let said = results["warnings"].to_string();
    assert!(
        said.contains("slow: shortened to fit into 3 s: one at a time: "),
        "{said}"
    );
    assert!(said.contains("in full (--max-seconds "), "{said}");

    let extent = &model["extent"];
    let made = extent["inferences"].as_array().expect("of each window");
    let least = made
        .iter()
        .filter_map(Value::as_u64)
        .min()
        .expect("a window");
    assert_eq!(number(extent, "windows"), made.len() as f64);
    assert_eq!(number(extent, "windows_planned"), 5.0);
    assert_eq!(number(extent, "inferences_planned"), 100.0);
    assert!((1..100).contains(&least), "{extent}");
    let calls = number(model, "calls");
    assert_eq!(model["p90_us"].is_null(), calls < 10.0, "{model}");
    assert!(model["p99_us"].is_null(), "{model}");
    let list = model["cut"]["what"].as_array().expect("a list");
    let what: Vec<&str> = list.iter().filter_map(Value::as_str).collect();
    let is_said = |word: &str| what.iter().any(|one| one.contains(word));
    assert!(is_said("of 100 inferences in"), "{what:?}");
    match model["offline"]["batch"].as_u64() {
        Some(batch) => {
            assert!(
                batch < 1024 && is_said(&format!("batches of {batch}, not 1024")),
                "{what:?}"
            );
        }
        None => assert!(is_said("no batches"), "{what:?}"),
    }
    match model["accuracy"]["viewpoints"].as_u64() {
        Some(some) => {
            assert!(
                some < 703 && is_said(&format!("rank-1 from {some} of 703 view")),
                "{what:?}"
            );
        }
        None => assert!(is_said("no rank-1"), "{what:?}"),
    }

    // The table states it too, also in a comparison with results of a version without a time limit.
    fs::write(at.join("new.json"), results.to_string()).expect("written");
    let mut old = results.clone();
    let before = |value: &mut Value, keys: &[&str]| {
        let fields = value.as_object_mut().expect("fields");
        fields.retain(|key, _| !keys.contains(&key.as_str()));
    };
    let model = &mut old["models"][0];
    before(
        model,
        &["extent", "cut", "seconds", "max_seconds", "accuracy"],
    );
    before(&mut model["parts"]["preprocessing"], &["extent"]);
    before(&mut model["parts"]["end_to_end"], &["extent"]);
    let mut offline = model["parts"]["preprocessing"].clone();
    offline["batch"] = 64.into();
    model["offline"] = offline;
    fs::write(at.join("old.json"), old.to_string()).expect("written");
    let compared = done(at, &words("bench --compare old.json new.json"));
    let line = |start: &str| {
        let found = compared.lines().find(|line| line.starts_with(start));
        found
            .unwrap_or_else(|| panic!("{start}: {compared}"))
            .to_owned()
    };
    let cut = line("cut: one at a time");
    assert!(
        cut.contains(" -  ") && cut.contains("of 100 inferences in"),
        "{cut}"
    );
    assert!(line("in batches of").contains("64"));
}

#[test]
fn inputs_of_several_lengths_are_measured_where_a_model_takes_any() {
    let folder = folder();
    let at = folder.path();
    write_network(at, "any", 1, None);
    let short = "--window-s 0.01 --windows 2 --warm-up 2 --batch 4 --views side --threads 1";
    let bench = format!("bench any.onnx two.egp {short} --frames 20,1,8,20 --json any.json");
    let table = done(at, &words(&bench));
    let results = json(&fs::read_to_string(at.join("any.json")).expect("results"));
    let lengths = results["models"][0]["lengths"].as_array().expect("a list");
    let frames: Vec<u64> = lengths
        .iter()
        .filter_map(|it| it["frames"].as_u64())
        .collect();
    assert_eq!(frames, [1, 8, 20]);
    for (length, frames) in lengths.iter().zip(frames) {
        assert_eq!(length["input"], serde_json::json!([1, frames, 64, 44]));
        assert_eq!(length["macs"], frames * macs_of_a_frame(1));
        let inferences = length["extent"]["inferences"]
            .as_array()
            .expect("two windows");
        assert!(inferences.len() == 2 && inferences.iter().all(|it| it.as_u64() >= Some(100)));
        assert!(length["p50_us"].as_f64() <= length["p90_us"].as_f64());
        let over = length["peak_rss_over_baseline_bytes"]
            .as_u64()
            .expect("Linux tells");
        // At least the 7 MB of the file, and less than the whole process.
        assert!(
            over > 7_000_000 && Some(over) < length["peak_rss_bytes"].as_u64(),
            "{length}"
        );
        let row = format!("frames: {frames} ");
        assert!(table.lines().any(|line| line.starts_with(&row)), "{table}");
    }
    assert!(results["models"][0]["cut"].is_null(), "{results}");

    write_network(at, "thirty", 1, Some(30));
    for (model, found) in [
        (
            "thirty.onnx",
            "thirty.onnx: expected a model of sequences of any number of frames, found one of 30 frames",
        ),
        ("", "found one of GEIs"),
    ] {
        refused(
            at,
            &words(&format!("bench {model} --frames 1,8")),
            1,
            &[found],
        );
    }
    refused(at, &words("bench any.onnx --frames 0"), 2, &["--frames"]);
    refused(
        at,
        &words("bench any.onnx --max-seconds 0.5"),
        2,
        &["1 to 1000000 seconds"],
    );
}

/// Returns the command with answers cached in the folder `cache`.
fn keeping(at: &Path, command: &str) -> Command {
    let mut process = heeding_signals();
    process
        .args(words(command))
        .env("EDGEGAIT_CACHE", "cache")
        .current_dir(at);
    process
}

/// Returns the path of the file of answers.
fn answers(at: &Path) -> Option<PathBuf> {
    let mut entries = fs::read_dir(at.join("cache/answers")).ok()?;
    let path = entries.next()?.expect("an entry").path();
    assert!(entries.next().is_none(), "one model, one file");
    Some(path)
}

fn kept(at: &Path) -> Vec<u8> {
    answers(at).map_or_else(Vec::new, |path| fs::read(path).expect("answers"))
}

/// Returns results without values that differ between two equal runs.
fn without_timings(output: &Output) -> String {
    assert_eq!(code(output), 0, "{}", text(&output.stderr));
    let mut results = json(&text(&output.stdout));
    results["seconds"].take();
    for recognizer in results["recognizers"].as_array_mut().expect("a list") {
        for key in ["p50_us", "p90_us", "p99_us"] {
            recognizer[key].take();
        }
    }
    results.to_string()
}

#[test]
fn a_score_that_is_ended_in_the_middle_asks_a_network_for_the_rest_only() {
    let folder = folder();
    let at = folder.path();
    write_network(at, "slow", LAYERS / 25, None);
    let views = "--azimuth-deg 0,45,90,135";
    let score = format!("score slow.onnx two.egp {views} --no-baselines --threads 1 --json -");
    let whole = without_timings(&edgegait(at, &words(&score)));
    let pictures = json(&whole)["geis"].as_u64().expect("a number") as usize;
    // The first takes of two people from the side, and their other takes from four viewpoints.
    assert_eq!(pictures, 2 + 2 * 4);

    // An answer has 28 bytes, 512 numbers, and 8 bytes.
    let answer = 28 + 4 * 512 + 8;
    let mut before = Vec::new();
    for signal in ["-KILL", "-INT", "-TERM"] {
        let mut child = keeping(at, &score)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command starts");
        while kept(at).len() < before.len() + 2 * answer {
            assert!(
                child.try_wait().expect("a child").is_none(),
                "it ended by itself"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        let id = child.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status();
        assert!(sent.expect("kill").success());
        assert!(!child.wait().expect("it ends").success());
        let after = kept(at);
        // Cached answers are not computed again, or they would occur twice.
        assert!(after.starts_with(&before), "{signal}");
        assert!(
            after.len() < pictures * answer,
            "{signal}: it was not in the middle"
        );
        before = after[..after.len() / answer * answer].to_vec();
    }
    assert!(before.len() >= 6 * answer);
    let output = keeping(at, &score).output().expect("the command starts");
    assert_eq!(without_timings(&output), whole);
    let all = kept(at);
    assert!(
        all.starts_with(&before) && all.len() == pictures * answer,
        "{}",
        all.len()
    );

    // Another protocol, with first takes from all viewpoints, computes only the new answers.
    let other = score.replace("--json", "--protocol verification --json");
    let output = keeping(at, &other).output().expect("the command starts");
    let pictures = json(&without_timings(&output))["geis"]
        .as_u64()
        .expect("a number");
    assert_eq!(pictures, 2 * 4 + 2 * 4);
    let more = kept(at);
    assert!(
        more.starts_with(&all) && more.len() == 16 * answer,
        "{}",
        more.len()
    );
}

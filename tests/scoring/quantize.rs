//! Recognizers with 8-bit weights: the command, and the core's answers.

use crate::command::{done, edgegait, names, refused, text};
use crate::npy::npy;
use crate::two::folder;
use edgegait::inference::{Model, Runtime};
use edgegait_core::linear::LinearRecognizer;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the JSON results of a command that must succeed.
fn results(dir: &Path, arguments: &str) -> Value {
    let arguments: Vec<&str> = arguments.split(' ').chain(["--json", "-"]).collect();
    serde_json::from_str(&done(dir, &arguments)).expect("one JSON document")
}

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models")
        .join(name)
}

/// Returns the first index of the highest score.
fn best(scores: &[f32]) -> usize {
    let highest = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let found = scores.iter().position(|score| *score == highest);
    found.expect("a score")
}

#[test]
fn shipped_models_in_8_bits_answer_as_their_onnx_runs_do() {
    let dir = tempfile::tempdir().expect("a folder");
    let at = dir.path();
    for (name, views, least_equal) in [
        ("side", "--azimuth-deg 90 --elevation-deg 0", 1.0),
        (
            "spread",
            "--azimuth-deg 0,60,150 --elevation-deg 0,30",
            0.98,
        ),
    ] {
        let onnx = shipped(&format!("{name}.onnx"));
        let file = format!("{name}.egr");
        let asked = format!(
            "quantize {} --cycles 2 {views} --out {file}",
            onnx.display()
        );
        let stated = results(at, &asked);

        // Both run on the same cycles, as a dataset.
        let swept = format!("sweep --first-cycle 1000 --cycles 2 {views} --out {name}");
        results(at, &swept);
        let (_, pixels) = npy(at.join(name).join("geis.npy"));
        let geis: Vec<&[u8]> = pixels.chunks_exact(1500).collect();
        let bytes = fs::read(at.join(&file)).expect("the recognizer");
        let quantized = LinearRecognizer::parse(&bytes).expect("a recognizer");
        let model = Model::open(&onnx).expect("a shipped model");
        let input: Vec<f32> = pixels.iter().map(|&byte| f32::from(byte) / 255.0).collect();
        let recognizer = Runtime::rten().load(&model).expect("a shipped model");
        let outputs = recognizer.run(&input, geis.len()).expect("answers");
        let scores = outputs.scores.expect("class scores");

        let people = &model.contract().classes;
        assert_eq!(quantized.classes(), people.len());
        for (class, person) in people.iter().enumerate() {
            assert_eq!(quantized.name(class), Some(person.as_str()));
        }
        let index = fs::read_to_string(at.join(name).join("index.csv")).expect("the index");
        let truths = index
            .lines()
            .skip(1)
            .map(|row| row.split(',').next().expect("a name"));
        let (mut equal, mut hits, mut farthest) = (0, [0, 0], 0.0f32);
        for ((gei, scores), truth) in geis.iter().zip(scores.chunks_exact(26)).zip(truths) {
            let (answer, _) = quantized.classify(gei).expect("of its size");
            equal += u64::from(answer == best(scores));
            hits[0] += u32::from(people[best(scores)] == truth);
            hits[1] += u32::from(people[answer] == truth);
            for (class, score) in scores.iter().enumerate() {
                let found = quantized.score(class, gei).expect("a score");
                farthest = farthest.max((found - score).abs());
            }
        }
        let share = equal as f64 / geis.len() as f64;
        assert!(share >= least_equal, "{name}: {equal} of {}", geis.len());
        assert_eq!(stated["bytes"], bytes.len());
        assert_eq!(
            [&stated["probes"], &stated["equal_answers"]],
            [geis.len() as u64, equal]
        );
        let share = |key: &str| stated[key].as_f64().expect("a rate") * geis.len() as f64;
        for (key, hits) in [("rank1", hits[0]), ("rank1_int8", hits[1])] {
            assert!((share(key) - f64::from(hits)).abs() < 1e-6, "{key}: {hits}");
        }
        let most = stated["greatest_difference"]
            .as_f64()
            .expect("a difference");
        assert!(
            (most - f64::from(farthest)).abs() < 1e-3 * most,
            "{most} {farthest}"
        );
        assert!(most < stated["mean_lead"].as_f64().expect("a lead"));
    }
}

/// Encodes a field of a protobuf message: a length below 2^14, and the bytes.
fn field(number: u8, content: &[u8]) -> Vec<u8> {
    let length = content.len();
    let mut bytes = vec![number << 3 | 2, length as u8 | 0x80, (length >> 7) as u8];
    bytes.extend_from_slice(content);
    bytes
}

fn node(operator: &str, input: &str, output: &str, attributes: &[Vec<u8>]) -> Vec<u8> {
    let names = [(1, input), (2, output), (4, operator)];
    let mut node: Vec<u8> = names
        .iter()
        .flat_map(|(number, name)| field(*number, name.as_bytes()))
        .collect();
    node.extend(attributes.iter().flat_map(|attribute| field(5, attribute)));
    field(1, &node)
}

/// Encodes an f32 input or output of shape `[N, ...]`.
fn port(name: &str, sides: &[u8]) -> Vec<u8> {
    let mut shape = field(1, &field(2, b"N"));
    shape.extend(sides.iter().flat_map(|side| field(1, &[8, *side])));
    let tensor = [vec![8, 1], field(2, &shape)].concat();
    let kind = field(2, &field(1, &tensor));
    [field(1, name.as_bytes()), kind].concat()
}

/// Returns a model whose 50 class scores are the mean of each row, or the softmax of these.
fn row_means(is_softmax: bool) -> Vec<u8> {
    // AttributeProto: name, ints or i, type INTS or INT.
    let axes = [field(1, b"axes"), vec![0x40, 3, 0xA0, 1, 7]].concat();
    let keep = [field(1, b"keepdims"), vec![0x18, 0, 0xA0, 1, 2]].concat();
    let mut graph = node("ReduceMean", "gei", "rows", &[axes, keep]);
    let flat = if is_softmax { "means" } else { "scores" };
    graph.extend(node("Flatten", "rows", flat, &[]));
    if is_softmax {
        graph.extend(node("Softmax", "means", "scores", &[]));
    }
    graph.extend(field(2, b"g"));
    graph.extend(field(11, &port("gei", &[1, 50, 30])));
    graph.extend(field(12, &port("scores", &[50])));
    let opset = field(8, &[0x0A, 0, 0x10, 17]);
    [vec![8, 8], field(7, &graph), opset].concat()
}

#[test]
fn means_of_rows_become_rows_of_127() {
    let dir = folder();
    fs::write(dir.path().join("rows.onnx"), row_means(false)).expect("written");
    let asked = "quantize rows.onnx --pack two.egp --cycles 1 --out rows.egr";
    let stated = results(dir.path(), asked);
    assert_eq!([&stated["rank1"], &stated["rank1_int8"]], [&Value::Null; 2]);
    assert_eq!(stated["equal_answers"], stated["probes"]);
    assert!(stated["affine_deviation"].as_f64().expect("a share") < 1e-5);
    let bytes = fs::read(dir.path().join("rows.egr")).expect("the recognizer");
    // The layout of FORMAT.md: 14 bytes, 50 scales and biases, the weights, 50 names.
    let weights = &bytes[14 + 50 * 8..][..50 * 1500];
    for (class, weights) in weights.chunks_exact(1500).enumerate() {
        for (row, weights) in weights.chunks_exact(30).enumerate() {
            let expected = if row == class { 127 } else { 0 };
            assert!(
                weights.iter().all(|weight| *weight == expected),
                "{class} {row}"
            );
        }
    }
    assert!(bytes.ends_with(b"\x02\x34\x38\x02\x34\x39"));
    let quantized = LinearRecognizer::parse(&bytes).expect("a recognizer");
    assert_eq!(
        [0, 49].map(|class| quantized.name(class)),
        [Some("0"), Some("49")]
    );
    let mut pixels = [0; 1500];
    pixels[30 * 7..30 * 8].fill(255);
    let (answer, score) = quantized.classify(&pixels).expect("of its size");
    assert_eq!(answer, 7);
    assert!((score - 1.0).abs() < 1e-5, "{score}");
}

#[test]
fn what_cannot_be_quantised_is_refused_and_leaves_no_file() {
    let dir = folder();
    let at = dir.path();
    fs::write(at.join("softmax.onnx"), row_means(true)).expect("written");
    fs::write(at.join("text.onnx"), "not a model").expect("written");
    fs::write(at.join("cycle.onnx"), row_means(false)).expect("written");
    fs::write(at.join("cycle.toml"), "framing = \"cycle\"").expect("written");
    fs::create_dir(at.join("folder.egr")).expect("a folder");
    let before = names(at);
    let side = shipped("side.onnx").display().to_string();
    for (arguments, code, words) in [
        (
            ["softmax.onnx", "--out", "a.egr"],
            1,
            ["affine function of the pixels", "Softmax"],
        ),
        (
            ["text.onnx", "--out", "a.egr"],
            1,
            ["text.onnx", "not an ONNX model"],
        ),
        (
            ["cycle.onnx", "--out", "a.egr"],
            1,
            ["framing height or box", "cycle"],
        ),
        (
            ["missing.onnx", "--out", "a.egr"],
            1,
            ["missing.onnx", "No such file"],
        ),
        (
            [&side, "--out", "folder.egr"],
            2,
            ["folder.egr", "found a folder"],
        ),
        (
            [&side, "--out", "a.onnx"],
            2,
            ["--out a.onnx", "ends in .egr"],
        ),
        (
            [&side, "--pack", "two.egp"],
            2,
            ["no walk \"walk-5kmh\"", "walk-4kmh"],
        ),
    ] {
        refused(
            at,
            &[&["quantize"], arguments.as_slice()].concat(),
            code,
            &words,
        );
        assert_eq!(names(at), before);
        assert_eq!(
            fs::read_dir(at.join("folder.egr"))
                .expect("a folder")
                .count(),
            0
        );
    }
}

#[test]
fn a_table_says_what_8_bits_changed() {
    let dir = tempfile::tempdir().expect("a folder");
    let side = shipped("side.onnx").display().to_string();
    let arguments = [
        "quantize",
        &side,
        "--subjects",
        "F01,M01",
        "--out",
        "side.egr",
    ];
    let output = edgegait(dir.path(), &arguments);
    let table = text(&output.stdout);
    assert!(
        table.starts_with("side.egr: 39326 bytes, 26 classes of 1500 weights\n"),
        "{table}"
    );
    assert!(
        table.contains("same answers as the model 8 of 8\n"),
        "{table}"
    );
    assert!(table.contains("100.00 (the model: 100.00)\n"), "{table}");
    assert!(table.ends_with("wrote side.egr\n"), "{table}");
    assert_eq!(names(dir.path()), ["side.egr"]);
}

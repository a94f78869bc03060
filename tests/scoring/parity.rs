//! Planted faults of models and runtimes that `edgegait parity` must find.

use crate::command::{code, done, edgegait, refused, text};
use crate::npy::npy;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn in_repository(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Copies a shipped model and its contract.
fn copy_of(name: &str, dir: &Path) {
    for kind in ["onnx", "toml"] {
        let from = in_repository("models").join(format!("{name}.{kind}"));
        let to = dir.join(format!("{name}.{kind}"));
        fs::copy(from, to).expect("a shipped model");
    }
}

/// Copies the networks of tests/python/parity.py.
fn networks(dir: &Path) {
    for name in ["float", "int8", "wrong_scale"] {
        let file = format!("{name}.onnx");
        let from = in_repository("tests/data/parity").join(&file);
        fs::copy(from, dir.join(file)).expect("a network");
    }
}

/// Changes one weight of the embedding of a model that `train` wrote.
fn change(dir: &Path, (from, to): (&str, &str), number: usize, change: impl Fn(f32) -> f32) {
    let mut bytes = fs::read(dir.join(from)).expect("a model");
    // TensorProto: the name (field 8), then its numbers (field 9) after their length.
    let name = b"\x42\x11embedding_weights\x4A";
    let at = bytes.windows(name.len()).position(|part| part == name);
    let length = at.expect("the weights") + name.len();
    let bytes_of_length = bytes[length..].iter().position(|byte| *byte < 0x80);
    let begin = length + bytes_of_length.expect("a length") + 1 + 4 * number;
    let old = f32::from_le_bytes(bytes[begin..begin + 4].try_into().expect("four"));
    bytes[begin..begin + 4].copy_from_slice(&change(old).to_le_bytes());
    fs::write(dir.join(to), bytes).expect("written");
}

/// Returns the exit code and the JSON results.
fn parity(dir: &Path, arguments: &str) -> (i32, Value) {
    let arguments: Vec<&str> = std::iter::once("parity")
        .chain(arguments.split(' '))
        .chain(["--json", "-"])
        .collect();
    let output = edgegait(dir, &arguments);
    let error = text(&output.stderr);
    let results = serde_json::from_slice(&output.stdout);
    let results = results.unwrap_or_else(|_| panic!("{arguments:?}: {error}"));
    (code(&output), results)
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number: {value}"))
}

fn assert_near(found: &Value, expected: f64, tolerance: f64) {
    let found = number(found);
    let most = tolerance * expected.abs();
    assert!((found - expected).abs() <= most, "{found}, not {expected}");
}

/// A sweep of two people at two viewpoints.
const SWEEP: &str =
    "sweep --subjects F01,M01 --first-cycle 1000 --azimuth-deg 45,90 --raster rows --out geis";

#[test]
fn one_weight_that_changed_is_found_with_the_differences_that_it_makes() {
    let dir = tempfile::tempdir().expect("a folder");
    let at = dir.path();
    copy_of("spread", at);
    done(at, &SWEEP.split(' ').collect::<Vec<_>>());
    let (_, geis) = npy(at.join("geis/geis.npy"));
    let of_pixel = |pixel: usize| -> Vec<f64> {
        let each = geis.chunks_exact(1500);
        each.map(|gei| f64::from(gei[pixel]) / 255.0).collect()
    };
    // The brightest pixel, which selects the weight's row in the matrix.
    let light = |pixel: &usize| of_pixel(*pixel).iter().sum::<f64>();
    let brightest = (0..1500).max_by(|a, b| light(a).total_cmp(&light(b)));
    let pixel = brightest.expect("pixels");
    let dims = 25;
    change(
        at,
        ("spread.onnx", "other.onnx"),
        pixel * dims + 3,
        |weight| weight + 2.0,
    );

    let (code, found) = parity(at, "spread.onnx other.onnx geis");
    assert_eq!((code, found["verdict"].as_str()), (4, Some("differs")));
    assert_eq!(found["sequences"], 4);
    assert!(found["inputs"].is_array());
    let embedding = &found["comparisons"][0]["embedding"];
    assert_eq!(embedding["numbers"], dims);
    // One of the 25 numbers is off by twice the pixel.
    let pixels = of_pixel(pixel);
    let greatest = pixels.iter().copied().fold(0.0, f64::max);
    let mean = pixels.iter().sum::<f64>() / 4.0;
    assert_near(&embedding["greatest"], 2.0 * greatest, 1e-4);
    assert_near(&embedding["mean"], 2.0 * mean / dims as f64, 1e-4);
    let spread = number(&embedding["spread"]);
    assert_near(
        &embedding["greatest_relative"],
        2.0 * greatest / spread,
        1e-4,
    );
    assert_near(&embedding["mean_relative"], 2.0 * mean / spread, 1e-4);
    let reasons = found["comparisons"][0]["reasons"].to_string();
    assert!(
        reasons.contains("relative difference of embeddings"),
        "{reasons}"
    );

    // Differences within the limits count as the same.
    let allowed = "spread.onnx other.onnx geis --max-relative-difference 9 \
                   --max-mean-relative-difference 9 --max-changed-hits 1";
    assert_eq!(parity(at, allowed).0, 0);
    // A copy with other bytes and the same weights is identical.
    let mut bytes = fs::read(at.join("spread.onnx")).expect("a model");
    // ModelProto.doc_string = "x"
    bytes.extend(b"\x32\x01x");
    fs::write(at.join("copy.onnx"), bytes).expect("written");
    let (code, found) = parity(at, "spread.onnx copy.onnx geis");
    let embedding = &found["comparisons"][0]["embedding"];
    assert_eq!((code, number(&embedding["greatest"])), (0, 0.0));
    assert_eq!(found["comparisons"][0]["ranks"]["other_ranks"], 0);
    assert_eq!(found["comparisons"][0]["worst"], serde_json::json!([]));
}

#[test]
fn a_weight_that_is_no_number_is_counted_and_never_the_same() {
    let dir = tempfile::tempdir().expect("a folder");
    let at = dir.path();
    copy_of("spread", at);
    change(at, ("spread.onnx", "nan.onnx"), 0, |_| f32::NAN);
    done(at, &SWEEP.split(' ').collect::<Vec<_>>());
    let (code, found) = parity(at, "spread.onnx nan.onnx geis");
    assert_eq!((code, found["verdict"].as_str()), (4, Some("differs")));
    // One number of each embedding, and all 26 scores that depend on it.
    let sides = [&found["sides"][0], &found["sides"][1]];
    assert_eq!(
        sides.map(|side| side["non_finite"].as_u64()),
        [Some(0), Some(4 * 27)]
    );
    assert_eq!(found["comparisons"][0]["by_view"][0]["non_finite"], 2);
    // Two sides with the same fault are not the same either, in any order.
    let mut bytes = fs::read(at.join("nan.onnx")).expect("a model");
    bytes.extend(b"\x32\x01x");
    fs::write(at.join("again.onnx"), bytes).expect("written");
    let wide = "--max-relative-difference 9 --max-mean-relative-difference 9 --max-changed-hits 1";
    for models in ["nan.onnx again.onnx", "nan.onnx spread.onnx"] {
        // The contract is that of `spread`.
        fs::copy(at.join("spread.toml"), at.join("nan.toml")).expect("a contract");
        assert_eq!(parity(at, &format!("{models} geis {wide}")).0, 4);
    }
}

/// A sweep of two takes of six people; the first, from the side, is the gallery of a model without
/// classes, and the second is the probe.
const TWO_TAKES: &str = "sweep --subjects F01,F02,F03,M01,M02,M03 --walks walk-4kmh,walk-6kmh --azimuth-deg 45,90 --raster rows --out geis";

#[test]
fn rounding_to_8_bits_is_the_same_and_a_scale_that_is_half_as_large_again_differs() {
    let dir = tempfile::tempdir().expect("a folder");
    let at = dir.path();
    networks(at);
    done(at, &TWO_TAKES.split(' ').collect::<Vec<_>>());
    let asked = "float.onnx int8.onnx wrong_scale.onnx geis";
    let (code, found) = parity(at, asked);
    assert_eq!(code, 4);
    let sides = found["sides"].as_array().expect("three sides");
    let quantized: Vec<_> = sides
        .iter()
        .map(|side| side["quantized"].as_bool())
        .collect();
    assert_eq!(quantized, [Some(false), Some(true), Some(true)]);
    let [rounded, wrong] = [0, 1].map(|other| &found["comparisons"][other]);
    assert_eq!(
        [&rounded["verdict"], &wrong["verdict"]],
        ["same", "differs"]
    );
    // Expected values from ONNX Runtime 1.32.0 and NumPy: see EXPECTED below.
    for (comparison, [greatest, mean]) in [rounded, wrong].into_iter().zip(EXPECTED) {
        // ONNX Runtime computes in 8 bits, so values between two steps may be rounded differently.
        assert_near(&comparison["embedding"]["greatest_relative"], greatest, 0.1);
        assert_near(&comparison["embedding"]["mean_relative"], mean, 0.1);
    }
    // With the limits for float models, 8 bits are not the same.
    let strict = format!("{asked} --max-relative-difference 0.001");
    assert_eq!(
        parity(at, &strict).1["comparisons"][0]["verdict"],
        "differs"
    );
    let notes = sides[1]["notes"].to_string();
    assert!(notes.contains("all is computed in float"), "{notes}");
}

/// The greatest and the mean relative difference of `int8` and `wrong_scale` to `float`, over the
/// 18 GEIs of first-take (of the 24 of `TWO_TAKES`, those of walk-4kmh at 45 degrees are neither
/// enrolled nor sought), computed in Python with onnxruntime: `norm(a - b) / sqrt(mean(norm(a -
/// mean(a))**2))`.
const EXPECTED: [[f64; 2]; 2] = [[0.0298, 0.0227], [1.242, 0.9867]];

#[test]
fn text_says_what_differs_and_where() {
    let dir = tempfile::tempdir().expect("a folder");
    let at = dir.path();
    networks(at);
    let asked = "parity float.onnx wrong_scale.onnx --azimuth-deg 90 --raster rows";
    let output = edgegait(at, &asked.split(' ').collect::<Vec<_>>());
    assert_eq!(code(&output), 4);
    let said = text(&output.stdout);
    for words in [
        "reference: float.onnx on rten",
        "wrong_scale.onnx on rten 0.27.0: DIFFERS",
        "farthest viewpoint: 90",
        "why: the mean relative difference of embeddings is",
        "what to do: ",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn sides_that_cannot_be_compared_are_refused_with_what_differs() {
    let dir = tempfile::tempdir().expect("a folder");
    let at = dir.path();
    networks(at);
    copy_of("spread", at);
    let refuse = |asked: &str, code, words: &[&str]| {
        let asked: Vec<&str> = asked.split(' ').collect();
        refused(at, &asked, code, words);
    };
    refuse(
        "parity float.onnx --runtime rten",
        2,
        &["expected two sides to compare, found one"],
    );
    refuse(
        "parity float.onnx --runtime rten --runtime rten",
        2,
        &["float.onnx on rten 0.27.0: appears twice"],
    );
    refuse(
        "parity float.onnx int8.onnx --runtime rten --runtime rten --runtime rten",
        2,
        &["expected one model, one --runtime, or as many of both, found 2 and 3"],
    );
    refuse(
        "parity float.onnx int8.onnx --ort-lib x.so",
        2,
        &["--ort-lib: the embedded runtime needs no library"],
    );
    refuse(
        "parity float.onnx --runtime tensorflow",
        2,
        &["expected rten, ort, or ort:PROVIDER with one of cpu, xnnpack"],
    );
    refuse(
        "parity pixels",
        2,
        &["the baseline, which computes nothing"],
    );
    fs::copy(at.join("float.onnx"), at.join("same.onnx")).expect("copied");
    refuse(
        "parity float.onnx same.onnx",
        2,
        &["float.onnx and same.onnx: are the same file on the same runtime"],
    );
    let mut bytes = fs::read(at.join("float.onnx")).expect("a network");
    // NodeProto.op_type
    let name = bytes.windows(6).position(|part| part == b"\x22\x04Relu");
    bytes[name.expect("a Relu") + 5] = b'x';
    fs::write(at.join("relx.onnx"), bytes).expect("written");
    refuse(
        "parity float.onnx relx.onnx --azimuth-deg 90",
        1,
        &[
            "relx.onnx: the embedded runtime refuses the model: ",
            "Relx",
            "(side 2: rten 0.27.0)",
        ],
    );
    fs::write(at.join("int8.toml"), "input_range = \"0..255\"\n").expect("written");
    refuse(
        "parity float.onnx int8.onnx",
        1,
        &[
            "expected one input_range to compare, found 0..1 of float.onnx (which has no .toml beside it) and 0..255 of int8.onnx",
        ],
    );
    refuse(
        "parity spread.onnx float.onnx",
        1,
        &["float.onnx: expected an output \"scores\" as the contract says, found \"embedding\""],
    );
    fs::write(at.join("float.toml"), "").expect("written");
    fs::write(at.join("other.toml"), "classes = []\n").expect("written");
    fs::copy(at.join("spread.onnx"), at.join("other.onnx")).expect("copied");
    refuse(
        "parity float.onnx other.onnx --azimuth-deg 90",
        1,
        &[
            "expected one form of embeddings to compare, found [8] of float.onnx on rten 0.27.0 and [25] of other.onnx on rten 0.27.0",
        ],
    );
}

mod with_ort {
    use super::*;

    fn library() -> String {
        std::env::var("EDGEGAIT_ORT_LIB").expect("EDGEGAIT_ORT_LIB")
    }

    #[test]
    #[ignore = "needs EDGEGAIT_ORT_LIB"]
    fn shipped_models_answer_the_same_on_both_runtimes() {
        let dir = tempfile::tempdir().expect("a folder");
        copy_of("spread", dir.path());
        let asked = format!("spread.onnx --ort-lib {} --raster rows", library());
        let (code, found) = parity(dir.path(), &asked);
        assert_eq!(code, 0, "{found}");
        let names = [0, 1].map(|side| found["sides"][side]["runtime"]["name"].clone());
        assert_eq!(names, ["rten", "onnxruntime"]);
        let embedding = &found["comparisons"][0]["embedding"];
        let greatest = number(&embedding["greatest_relative"]);
        assert!(greatest < 1e-5, "{greatest}");
        assert_eq!(found["sequences"], 260);
    }

    #[test]
    #[ignore = "needs EDGEGAIT_ORT_LIB"]
    fn operators_that_ran_in_8_bits_are_listed() {
        let dir = tempfile::tempdir().expect("a folder");
        let at = dir.path();
        networks(at);
        let asked = format!(
            "float.onnx int8.onnx int8.onnx --runtime rten --runtime rten --runtime ort --ort-lib {} --raster rows",
            library()
        );
        let (code, found) = parity(at, &asked);
        assert_eq!(code, 0, "{found}");
        let side = &found["sides"][2];
        let notes = side["notes"][0].as_str().expect("a note");
        assert!(notes.starts_with("ran in 8 bits: "), "{notes}");
        for operator in ["QLinearConv 1", "QGemm 1"] {
            assert!(notes.contains(operator), "{notes}");
        }
        let operators = side["operators"].as_array().expect("a list");
        let all_on_cpu = |one: &Value| one["provider"] == "CPUExecutionProvider";
        assert!(operators.iter().all(all_on_cpu));
    }

    #[test]
    #[ignore = "needs EDGEGAIT_ORT_LIB"]
    fn a_provider_that_the_library_lacks_is_refused_as_the_flag_names_it() {
        let dir = tempfile::tempdir().expect("a folder");
        networks(dir.path());
        let library = library();
        let asked = [
            "parity",
            "float.onnx",
            "--runtime",
            "rten",
            "--runtime",
            "ort:rknpu",
            "--ort-lib",
            &library,
        ];
        let words = ["--runtime ort:rknpu: provider rknpu: expected a library that was built with"];
        refused(dir.path(), &asked, 2, &words);
    }
}

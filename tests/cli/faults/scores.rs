//! Results that may not depend on what else is asked for.

use crate::command::*;
use crate::rows::{results, row, rows, warnings, words};
use crate::two;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Returns the results of models with and without `pixels` beside them, which differ by the order
/// of the rows only.
fn is_alike_with_pixels(at: &Path, models: &str, rest: &str) -> Value {
    let plain = results(at, &format!("score {models} {rest}"));
    let count = models.split_whitespace().count();
    for named in [format!("{models} pixels"), format!("pixels {models}")] {
        let named = results(at, &format!("score {named} {rest}"));
        assert_eq!(named["settings"], plain["settings"], "{models}");
        let mut expected = rows(&plain);
        let (pixels, others): (Vec<_>, Vec<_>) =
            { expected.drain(..) }.partition(|(name, _)| name.starts_with("pixels"));
        assert!(!pixels.is_empty() && others.len() >= count);
        assert_eq!(rows(&named), [pixels, others].concat(), "{models}");
    }
    plain
}

#[test]
fn pixels_are_compared_with_the_same_whether_they_are_named_or_not() {
    let folder = two::folder();
    let at = folder.path();
    done(
        at,
        &words("cohort --people 6 --speeds-kmh 4,6 --quick --out six.egp"),
    );
    done(
        at,
        &words(
            "train six.egp --method view-transformation --template frequency --azimuth-deg 60,90,120 \
             --out vtm.onnx",
        ),
    );
    let found = is_alike_with_pixels(at, "vtm.onnx", "two.egp --raster rows");
    // The second take of two people, from each of three viewpoints, against all three.
    let pixels = row(&rows(&found), "pixels");
    assert_eq!(pixels["probes"], 2 * 3);
    let rest = "two.egp --azimuth-deg 60,90 --protocol first-take --raster rows";
    is_alike_with_pixels(at, "spread", rest);
    is_alike_with_pixels(at, "side spread", rest);
    // The protocol is that of the models, not of pixels, which have no classes.
    let closed = is_alike_with_pixels(at, "side", "--azimuth-deg 60,90 --raster rows");
    assert_eq!(closed["settings"]["protocol"], "closed-set");

    // Where others decide about viewpoints or the protocol, the results say so.
    let said = warnings(&results(
        at,
        "score vtm.onnx gei-small two.egp --raster rows",
    ));
    let words = "all probes are seen from viewpoints of vtm, which takes no other viewpoints";
    assert!(said.contains(words), "{said}");
    let both = results(at, "score side gei-small --views side --raster rows");
    let said = warnings(&both);
    let words = "the protocol is first-take, since these have no classes for all people: gei-small; without them it is closed-set for side";
    assert!(said.contains(words), "{said}");
    assert!(!warnings(&closed).contains("the protocol is"));
}

#[test]
fn the_length_of_a_random_embedding_is_that_of_its_recognizer() {
    let folder = two::folder();
    let at = folder.path();
    for (name, components) in [("long", 3), ("short", 2)] {
        let train =
            format!("train two.egp --method svm --components {components} --out {name}.onnx");
        done(at, &words(&train));
    }
    let score = |models: &str| {
        let rest = "two.egp --azimuth-deg 60,90,120 --protocol first-take --raster rows";
        rows(&results(at, &format!("score {models} {rest}")))
    };
    let [long, short] = ["long.onnx", "short.onnx"].map(|model| row(&score(model), "random"));
    for both in [score("long.onnx short.onnx"), score("short.onnx long.onnx")] {
        assert_eq!(row(&both, "random as long"), long);
        assert_eq!(row(&both, "random as short"), short);
        assert!(both.iter().any(|(name, _)| name == "pixels"));
    }
}

#[test]
fn a_seed_replaces_that_of_a_built_in_design() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = |design: &str, flags: &str, out: &str| {
        let command = format!("generate {design} --people 1 --out {out} {flags}");
        done(at, &words(&command));
        let split = at.join(out).join("test");
        let split = if split.is_dir() { split } else { at.join(out) };
        let manifest = fs::read_to_string(split.join("manifest.json")).expect("a manifest");
        let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
        (manifest["seed"].clone(), manifest["files"].clone())
    };
    let built_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/dataset/design/built_in");
    for (design, seed) in [("casia-b-like", 5), ("domain-random", 9)] {
        let usual = made(design, "", &format!("{design}-usual"));
        assert_eq!(usual.0, 2);
        assert_eq!(made(design, "--seed 2", &format!("{design}-2")), usual);
        // A copy of the design with this seed gives the same bytes.
        let text = fs::read_to_string(built_in.join(design).with_extension("toml"));
        let text = text
            .expect("a design")
            .replacen("seed = 2", &format!("seed = {seed}"), 1);
        fs::write(at.join("copy.toml"), text).expect("written");
        let found = made(
            design,
            &format!("--seed {seed}"),
            &format!("{design}-other"),
        );
        let copy = made("copy.toml", "", &format!("{design}-copy"));
        assert_eq!(found, copy, "{design}");
        assert_eq!(found.0, seed);
        assert_ne!(found.1, usual.1);
    }
    // The default of other commands is a seed too: that of the built-in cohort.
    let index = |out: &str| fs::read_to_string(at.join(out).join("train/index.csv"));
    made("casia-b-like", "--seed 1", "first");
    assert!(index("first").expect("a table").contains("\nF01,"));
    assert!(
        index("casia-b-like-usual")
            .expect("a table")
            .contains("\n2-F01,")
    );
    // Finished work of another seed is not taken for this one.
    assert_eq!(made("casia-b-like", "--seed 7", "first").0, 7);
    let refusal = "copy.toml states its own seed, 9";
    refused(
        at,
        &words("generate copy.toml --seed 3"),
        2,
        &["--seed 3", refusal],
    );
    done(
        at,
        &words("generate copy.toml --seed 9 --people 1 --out copy"),
    );
}

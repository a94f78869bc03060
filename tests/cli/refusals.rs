//! Errors of the built command: exit codes, messages, and no files left behind.

use crate::command::*;
use crate::made::{made, sha256};
use crate::npy::npy;
use crate::two::folder;
use edgegait::encode::encode_subjects;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

#[test]
fn what_makes_no_sense_is_exit_code_2_and_leaves_no_file() {
    let folder = folder();
    let at = folder.path();
    for (arguments, words) in [
        (
            "render two.egp --subjects Nobody",
            ["\"Nobody\"", "F01, M01"],
        ),
        (
            "sweep two.egp --walks fly-9kmh",
            ["\"fly-9kmh\"", "walk-4kmh, run-8kmh"],
        ),
        (
            "render two.egp --azimuth-deg nan",
            ["azimuth", "expected degrees"],
        ),
        (
            "render two.egp --azimuth-deg 1e9",
            ["azimuth 1000000000", "expected degrees"],
        ),
        (
            "sweep two.egp --azimuth-deg 400",
            ["azimuth 400", "-360..=360"],
        ),
        (
            "cohort --speeds-kmh 5,4,5 --out new.egp",
            ["5 km/h twice", "once"],
        ),
        (
            "render two.egp --elevation-deg 91",
            ["elevation 91", "-90..=90"],
        ),
        (
            "sweep two.egp --elevation-deg -90.5",
            ["elevation -90.5", "-90..=90"],
        ),
        ("render two.egp --views front", ["\"front\"", "paper"]),
        (
            "render two.egp --views side --azimuth-deg 3",
            ["--views", "--azimuth-deg"],
        ),
        (
            "render two.egp --out walk.bmp",
            ["walk.bmp", ".png, .gif or .npy"],
        ),
        ("render two.egp --template gei", ["--template", "--out"]),
        ("render two.egp --template jpeg", ["jpeg", "gei"]),
        ("render two.egp --raster crayon", ["crayon", "skia"]),
        (
            "render two.egp --raster columns",
            ["--framing height", "--raster rows"],
        ),
        (
            "sweep two.egp --raster columns --framing box",
            ["--framing box", "--raster rows"],
        ),
        (
            "score two.egp --raster columns --framing camera --lens persp",
            ["--lens persp", "--raster rows"],
        ),
        ("render two.egp --framing wide", ["wide", "height, box"]),
        ("render two.egp --lens fisheye", ["fisheye", "ortho, persp"]),
        ("render two.egp --size 40x40", ["40x40", "64x44 or 64x64"]),
        ("render two.egp --jitter some", ["some", "r2"]),
        (
            "render two.egp --distance-m 5",
            ["--distance-m: with --lens ortho", "--framing camera"],
        ),
        (
            "sweep two.egp --framing box --camera static",
            ["--camera: with --lens ortho", "--lens persp"],
        ),
        (
            "score two.egp --framing cycle --fov-deg 30",
            ["--fov-deg: with --lens ortho", "--framing camera"],
        ),
        (
            "train two.egp --lens persp --fov-deg 30",
            ["--fov-deg: --framing height", "--framing camera"],
        ),
        (
            "render two.egp --lens persp --aim-m 0,1,0",
            ["--aim-m: a camera that follows", "--camera static"],
        ),
        (
            "render two.egp --lens persp --camera static --aim-m 0,1",
            ["0,1", "three numbers"],
        ),
        (
            "sweep two.egp --framing cycle --lens persp",
            ["cycle", "--lens ortho"],
        ),
        (
            "render two.egp --lens persp --distance-m 0",
            ["--distance-m 0", "0.1 to 1,000,000"],
        ),
        (
            "render two.egp --framing camera --fov-deg 180",
            ["--fov-deg 180", "0.1 to 170"],
        ),
        ("render two.egp --frames-per-cycle 0", ["0", "1..=4096"]),
        ("inspect two.egp --threads 0", ["--threads", "0"]),
        ("sweep two.egp --seed -1", ["-1", "--"]),
        ("inspect two.egp --verbose", ["--verbose", "unexpected"]),
        ("inspect two.egp three.egp", ["three.egp", "unexpected"]),
        ("cohort --people 0 --out new.egp", ["0", "as 26"]),
        (
            "cohort --speeds-kmh 2.9 --out new.egp",
            ["2.9 km/h", "3 to 12"],
        ),
        (
            "cohort --speeds-kmh nan --out new.egp",
            ["NaN km/h", "3 to 12"],
        ),
        (
            "cohort --max-error-mm nan --out new.egp",
            ["--max-error-mm", "0 to 1,000,000"],
        ),
        ("dance", ["dance", "unrecognized"]),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        refused(at, &arguments, 2, &words);
    }
    assert_eq!(code(&edgegait(at, &[])), 2);
    assert_eq!(names(at), ["two.egp"]);
}

#[test]
fn a_bad_pack_is_exit_code_1_and_the_message_names_file_and_byte() {
    let folder = folder();
    let at = folder.path();
    let whole = fs::read(at.join("two.egp")).expect("the pack");
    let write = |name: &str, bytes: &[u8]| fs::write(at.join(name), bytes).expect("a file");
    write("cut.egp", &whole[..whole.len() - 1]);
    write("head.egp", &whole[..40]);
    let mut damaged = whole.clone();
    damaged[500] ^= 4;
    write("damaged.egp", &damaged);
    let mut future = whole.clone();
    future[4] = 2;
    write("future.egp", &future);
    write("note.egp", b"not a pack");
    write("empty.egp", b"");
    fs::create_dir(at.join("folder.egp")).expect("a folder");
    let large = fs::File::create(at.join("large.egp")).expect("a file");
    large.set_len((16 << 20) + 1).expect("a sparse file");
    for (name, words) in [
        ("cut.egp", " at byte 8: expected the length of the file"),
        ("head.egp", " at byte 40: expected the rest of the header"),
        ("damaged.egp", " at byte 12: expected the CRC-32"),
        ("future.egp", " at byte 4: expected version 1"),
        ("note.egp", " at byte 0: expected \"EGPK\""),
        ("empty.egp", " at byte 0: expected \"EGPK\""),
        ("missing.egp", ": No such file"),
        (
            "large.egp",
            ": 16777217 bytes, expected a pack of at most 16777216",
        ),
    ] {
        for command in ["inspect", "render", "sweep"] {
            refused(at, &[command, name], 1, &[&format!("{name}{words}")]);
        }
    }
    for (command, words) in [
        ("inspect", "folder.egp: expected a dataset"),
        ("render", "folder.egp: expected a dataset"),
        (
            "sweep",
            "folder.egp: expected a pack or a tree of silhouettes",
        ),
    ] {
        refused(at, &[command, "folder.egp"], 1, &[words]);
    }
}

#[test]
fn a_bad_list_of_viewpoints_is_exit_code_1_and_the_message_names_its_line() {
    let folder = folder();
    let at = folder.path();
    let render = ["render", "two.egp", "--views", "views.csv"];
    refused(at, &render, 1, &["views.csv: No such file"]);
    for (rows, words) in [
        (
            "azimuth_deg,elevation_deg\n90,0\n0,91\n",
            "views.csv:3: elevation 91",
        ),
        ("azimuth_deg,elevation_deg\nleft,0\n", "views.csv:2: "),
        ("azimuth_deg,elevation_deg\n", "views.csv: no viewpoints"),
        ("angle\n5\n", "views.csv:2: "),
    ] {
        fs::write(at.join("views.csv"), rows).expect("a file");
        refused(at, &render, 1, &[words]);
    }
}

#[test]
fn an_earlier_dataset_is_replaced_and_another_folder_is_not() {
    let folder = folder();
    let at = folder.path();
    let sweep = [
        "sweep", "two.egp", "--views", "side", "--cycles", "2", "--out", "side",
    ];
    done(at, &sweep);
    assert_eq!(
        names(&at.join("side")),
        ["geis.npy", "index.csv", "manifest.json"]
    );
    let (shape, pixels) = npy(at.join("side/geis.npy"));
    // Two people, two walks, two cycles, one viewpoint.
    assert_eq!((shape.as_str(), pixels.len()), ("8, 50, 30", 12_000));
    let index = fs::read_to_string(at.join("side/index.csv")).expect("the index");
    let rows: Vec<&str> = index.lines().collect();
    assert_eq!(rows.len(), 9);
    assert!(rows[1].starts_with("F01,walk-4kmh,0,0,4"), "{}", rows[1]);
    assert!(rows[4].starts_with("F01,run-8kmh,0,1,8"), "{}", rows[4]);
    let manifest = fs::read_to_string(at.join("side/manifest.json")).expect("the manifest");
    let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
    assert_eq!(manifest["geis"], 8);
    for (file, name) in ["geis.npy", "index.csv"].into_iter().enumerate() {
        assert_eq!(manifest["files"][file]["path"], name);
        assert_eq!(
            manifest["files"][file]["sha256"],
            sha256(at.join("side").join(name)).as_str()
        );
    }

    let other = [&sweep[..], &["--seed", "2"]].concat();
    done(at, &other);
    let replaced = npy(at.join("side/geis.npy")).1;
    // Stored cycles are the same, variations change.
    assert_eq!(replaced[..1_500], pixels[..1_500]);
    assert_ne!(replaced[1_500..3_000], pixels[1_500..3_000]);

    // A folder of another program.
    let at_manifest = at.join("side/manifest.json");
    let foreign = fs::read_to_string(&at_manifest).expect("the manifest");
    let foreign = foreign.replace("\"command\": \"sweep\"", "\"command\": \"camera\"");
    fs::write(&at_manifest, foreign).expect("a file");
    refused(at, &sweep, 2, &["did not make", "--overwrite"]);
    assert_eq!(npy(at.join("side/geis.npy")).1, replaced);
    done(at, &[&other[..], &["--overwrite"]].concat());
    assert_eq!(npy(at.join("side/geis.npy")).1, replaced);

    fs::write(at.join("side/thesis.txt"), "mine").expect("a file");
    for flags in [&[][..], &["--overwrite"]] {
        refused(at, &[&sweep[..], flags].concat(), 2, &["thesis.txt"]);
    }
    assert_eq!(npy(at.join("side/geis.npy")).1, replaced);
    assert_eq!(names(at), ["side", "two.egp"]);
}

#[test]
fn a_sweep_that_fails_on_its_way_leaves_nothing() {
    let folder = folder();
    let at = folder.path();
    // A second person without hulls, who cannot be drawn.
    let mut two = made(2, vec![5.0]);
    two[1].body.hulls.clear();
    two[1].walks[0].name = "ghost-walk".into();
    let bytes = encode_subjects(&two, 5.0, &|| Ok(())).expect("a pack");
    fs::write(at.join("ghost.egp"), bytes).expect("a file");
    let sweep = ["sweep", "ghost.egp", "--views", "side", "--out", "new"];
    refused(at, &sweep, 1, &["\"ghost-walk\"", "no points"]);
    assert_eq!(names(at), ["ghost.egp", "two.egp"]);
    done(at, &[&sweep[..], &["--subjects", "F01"]].concat());
    refused(at, &sweep, 1, &["no points"]);
    assert_eq!(npy(at.join("new/geis.npy")).0, "1, 50, 30");
    assert_eq!(names(at), ["ghost.egp", "new", "two.egp"]);
}

/// Returns a valid library of this system that is not ONNX Runtime: the C library of this test.
#[cfg(target_os = "linux")]
fn foreign_library() -> PathBuf {
    let maps = fs::read_to_string("/proc/self/maps").expect("readable");
    let mapped = maps
        .lines()
        .filter_map(|line| line.split_whitespace().nth(5));
    mapped
        .map(PathBuf::from)
        .find(|path| path.to_string_lossy().contains("libc.so"))
        .expect("a C library")
}

#[test]
fn libraries_that_are_not_onnx_runtime_are_refused_before_they_are_loaded() {
    let folder = folder();
    let at = folder.path();
    let score = |library: &str, words: &[&str]| {
        let ort = ["score", "two.egp", "--runtime", "ort", "--ort-lib", library];
        refused(at, &ort, 1, words);
    };
    score("two.egp", &["two.egp: expected a shared library"]);
    score("missing.so", &["missing.so"]);
    score(
        ".",
        &["found no regular file", "the full path of libonnxruntime"],
    );
    assert!(!at.join("edgegait-report").exists());
}

/// Only Linux has `/proc/self/maps`, which names the C library.
#[cfg(target_os = "linux")]
#[test]
fn a_foreign_or_cut_library_is_refused_before_it_is_loaded() {
    let folder = folder();
    let at = folder.path();
    let foreign = foreign_library();
    let score = |library: &str, words: &[&str]| {
        let ort = ["score", "two.egp", "--runtime", "ort", "--ort-lib", library];
        refused(at, &ort, 1, words);
    };
    let name = foreign.display().to_string();
    score(&name, &[&name, "found a library without OrtGetApiBase"]);
    let bytes = fs::read(&foreign).expect("readable");
    fs::write(at.join("cut.so"), &bytes[..bytes.len() / 2]).expect("written");
    score("cut.so", &["cut.so: the library is cut short"]);
    assert!(!at.join("edgegait-report").exists());
}

#[test]
fn flags_that_the_embedded_runtime_has_no_use_for_are_refused() {
    let folder = folder();
    for (flags, words) in [
        (
            ["--ort-lib", "x.so"],
            "--ort-lib: the embedded runtime needs no library",
        ),
        (
            ["--provider", "xnnpack"],
            "--provider xnnpack: the embedded runtime has cpu only",
        ),
        (["--provider", "abacus"], "cpu, xnnpack, acl"),
    ] {
        let arguments = [&["score", "two.egp"][..], &flags].concat();
        refused(folder.path(), &arguments, 2, &[words]);
    }
}

//! Framings, lenses, sizes and jitter mean the same in all commands.

use crate::command::*;
use crate::npy::npy;
use crate::two::folder;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn run(at: &Path, arguments: &str) -> String {
    done(at, &arguments.split(' ').collect::<Vec<_>>())
}

fn json(at: &Path, arguments: &str) -> Value {
    let output = run(at, &format!("{arguments} --json -"));
    serde_json::from_str(&output).expect("JSON")
}

/// Renders F01's walk at 4 km/h in four frames and returns all pixels.
fn rendered(at: &Path, flags: &str) -> Vec<u8> {
    let walk = "render two.egp --subjects F01 --walks walk-4kmh --frames-per-cycle 4 --overwrite --out x.npy";
    let all: Vec<&str> = walk.split(' ').chain(flags.split_whitespace()).collect();
    done(at, &all);
    npy(at.join("x.npy")).1
}

/// Returns the range of rows, and of columns, that have a pixel on.
fn bounds(frame: &[u8], columns: usize) -> [(usize, usize); 2] {
    let on = |pixel: usize| frame[pixel] > 0;
    let span = |of: &dyn Fn(usize) -> usize| {
        let found = (0..frame.len()).filter(|&p| on(p)).map(of);
        let (least, most) = found.fold((usize::MAX, 0), |(l, m), at| (l.min(at), m.max(at)));
        (least, most + 1)
    };
    [
        span(&|pixel| pixel / columns),
        span(&|pixel| pixel % columns),
    ]
}

fn rows(frame: &[u8]) -> usize {
    let (first, end) = bounds(frame, 30)[0];
    end - first
}

#[test]
fn every_size_is_drawn_natively_and_fills_its_rows() {
    let folder = folder();
    let at = folder.path();
    for (size, shape, columns) in [
        ("50x30", "4, 50, 30", 30),
        ("64x44", "4, 64, 44", 44),
        ("64x64", "4, 64, 64", 64),
    ] {
        let pixels = rendered(at, &format!("--size {size}"));
        assert_eq!(npy(at.join("x.npy")).0, shape);
        for frame in pixels.chunks(pixels.len() / 4) {
            assert_eq!(bounds(frame, columns)[0], (0, frame.len() / columns));
        }
        let art = run(
            at,
            &format!("render two.egp --subjects F01 --walks walk-4kmh --size {size}"),
        );
        let lines = art.trim_end().lines().count() - 1;
        assert_eq!(lines, pixels.len() / 4 / columns / 2, "{size}");
        run(
            at,
            &format!("render two.egp --size {size} --frames-per-cycle 8 --scale 1 --out x.png"),
        );
        // Width and height, big-endian, in the first chunk of a PNG (RFC 2083).
        let png = fs::read(at.join("x.png")).expect("a picture");
        let side = |at: usize| usize::from(png[at + 2]) * 256 + usize::from(png[at + 3]);
        // 18 rows of pixels have the label.
        let expected = (8 * (columns + 1) + 1, pixels.len() / 4 / columns + 20);
        assert_eq!((side(16), side(20)), expected, "{size}");
    }
}

#[test]
fn a_box_reaches_all_four_sides_but_for_a_thin_limb_between_samples() {
    let folder = folder();
    for view in ["", "--azimuth-deg 40 --elevation-deg 70"] {
        for frame in rendered(folder.path(), &format!("--framing box {view}")).chunks(1_500) {
            let [(top, bottom), (left, right)] = bounds(frame, 30);
            assert!(top <= 1 && bottom >= 49, "{top} {bottom}");
            // Where the feet pass each other, a column is 1 cm and a row 3 cm; toes are thin.
            assert!(left <= 2 && right >= 28, "{left} {right}");
        }
    }
}

#[test]
fn a_camera_sees_people_smaller_from_further_away_and_larger_through_a_narrow_lens() {
    let folder = folder();
    let at = folder.path();
    let of = |flags: &str| rows(&rendered(at, &format!("--framing camera {flags}"))[..1_500]);
    // 50 rows for 2 * 4 m * tan(22.5 degrees) = 3.31 m: 15.1 rows a metre, and a woman of the
    // cohort is 1.5 to 1.75 m tall.
    let rows = of("");
    assert!((22..=27).contains(&rows), "{rows}");
    for (flags, factor) in [
        ("--distance-m 8", 0.5),
        // tan(45) over tan(22.5) degrees.
        ("--fov-deg 90", 0.414),
        ("--fov-deg 30", 1.546),
        ("--lens persp --distance-m 8", 0.5),
        // A person seen from the side is thin, so perspective has no effect.
        ("--lens persp", 1.0),
    ] {
        let found = of(flags) as f64;
        let expected = rows as f64 * factor;
        assert!(
            (found - expected).abs() <= 2.0,
            "{flags}: {found}, expected {expected}"
        );
    }
}

#[test]
fn a_static_camera_is_where_its_flags_put_it() {
    let folder = folder();
    let at = folder.path();
    let still = |aim: &str| {
        rendered(
            at,
            &format!("--framing camera --camera static --aim-m {aim} --azimuth-deg 0"),
        )
    };
    let columns = |pixels: &[u8]| bounds(&pixels[..1_500], 30)[1];
    let (left, right) = columns(&still("0,0.9,0"));
    // To the walker's left, the image's right: 5.000 columns.
    let moved = columns(&still("0.3313,0.9,0"));
    assert_eq!(moved, (left - 5, right - 5));
    // With parallel rays, an offset along the line of sight has no effect.
    assert_eq!(still("0,0.9,0"), still("0,0.9,-1"));
    // A following camera keeps the pelvis in place, a static one does not.
    let followed = rendered(at, "--framing camera");
    let mean = rendered(at, "--framing camera --camera static");
    assert_ne!(followed, mean);
}

#[test]
fn framing_by_cycle_keeps_one_scale_and_clips_nothing_from_any_elevation() {
    let folder = folder();
    let at = folder.path();
    let results = json(
        at,
        "sweep two.egp --framing cycle --azimuth-deg 0,50,90,180 --elevation-deg 0,-90,-20,30,60,90 --out set",
    );
    assert_eq!(results["clipped_share"], 0.0);
    let frames: Vec<(usize, usize)> = rendered(at, "--framing cycle")
        .chunks(1_500)
        .map(|frame| bounds(frame, 30)[0])
        .collect();
    // The vertical bounce is kept: the head is higher over one leg, at a quarter and three quarters
    // of the cycle, than over two. Figures fill the space that the circle of height and depth
    // allows.
    for (two, one) in [(0, 1), (2, 3)] {
        assert!(frames[one].0 < frames[two].0, "{frames:?}");
    }
    assert!(frames.iter().all(|(top, end)| end - top > 40), "{frames:?}");
    let level = rendered(at, "--framing cycle --azimuth-deg 0 --elevation-deg 0");
    let both = rendered(at, "--framing cycle --azimuth-deg 0 --elevation-deg 0,80");
    // The framing does not depend on the other viewpoints.
    assert_eq!(level, both[..level.len()]);
}

#[test]
fn jitter_begins_at_the_centre_and_moves_the_later_frames() {
    let folder = folder();
    let at = folder.path();
    let (still, moved) = (rendered(at, ""), rendered(at, "--jitter r2"));
    assert_eq!(still[..1_500], moved[..1_500]);
    for frame in 1..4 {
        let range = 1_500 * frame..1_500 * (frame + 1);
        assert_ne!(still[range.clone()], moved[range]);
    }
}

#[test]
fn viewpoints_that_are_the_same_are_the_same_pictures() {
    let folder = folder();
    for flags in ["", "--lens persp", "--framing cycle"] {
        let views = "--azimuth-deg 0,360,-360,270,-90";
        let pixels = rendered(folder.path(), &format!("{flags} {views}"));
        let seen: Vec<&[u8]> = pixels.chunks(6_000).collect();
        assert!(seen[0] == seen[1] && seen[0] == seen[2] && seen[3] == seen[4]);
        assert_ne!(seen[0], seen[3]);
    }
}

#[test]
fn results_state_how_they_were_drawn() {
    let folder = folder();
    let at = folder.path();
    let plain = &json(at, "render two.egp --overwrite --out x.npy")["settings"];
    for (key, value) in [
        ("raster", "skia"),
        ("framing", "height"),
        ("lens", "ortho"),
        ("size", "50x30"),
        ("jitter", "none"),
    ] {
        assert_eq!(plain[key], value);
    }
    assert!(plain.get("distance_m").is_none() && plain.get("camera").is_none());
    let flags = "--framing camera --lens persp --distance-m 6.3 --fov-deg 40 --camera static \
                 --aim-m -0.5,1,2 --size 64x64 --jitter r2";
    let flags: Vec<&str> = flags.split_whitespace().collect();
    let sensor = json(
        at,
        &format!("sweep two.egp --views side --out set {}", flags.join(" ")),
    );
    let manifest = fs::read(at.join("set/manifest.json")).expect("the manifest");
    let manifest: Value = serde_json::from_slice(&manifest).expect("JSON");
    for settings in [&sensor["settings"], &manifest["settings"]] {
        assert_eq!(settings["distance_m"], 6.3);
        assert_eq!(settings["fov_deg"], 40.0);
        assert_eq!(settings["camera"], "static");
        assert_eq!(settings["aim_m"], "-0.5,1,2");
        assert_eq!(settings["size"], "64x64");
        assert_eq!(settings["jitter"], "r2");
    }
    assert_eq!(
        (&sensor["framing"], &sensor["raster"]),
        (&"camera".into(), &"skia".into())
    );
    let mean = json(
        at,
        "render two.egp --lens persp --camera static --overwrite --out x.npy",
    );
    assert_eq!(mean["settings"]["aim_m"], "mean pelvis");
}

#[test]
fn a_camera_too_close_to_the_figure_is_refused_with_its_walk() {
    let folder = folder();
    let arguments = [
        "render",
        "two.egp",
        "--lens",
        "persp",
        "--distance-m",
        "0.2",
    ];
    let words = [
        "walk 0 (\"walk-4kmh\")",
        "in front of the camera",
        "move the camera away",
    ];
    refused(folder.path(), &arguments, 1, &words);
}

#[test]
fn a_model_is_trained_and_scored_in_its_own_size_and_framing_and_refused_otherwise() {
    let folder = folder();
    let at = folder.path();
    run(
        at,
        "train two.egp --size 64x44 --framing cycle --cycles 2 --out mine.onnx",
    );
    let contract = fs::read_to_string(at.join("mine.toml")).expect("a contract");
    for line in ["rows = 64", "columns = 44", "framing = \"cycle\""] {
        assert!(contract.contains(line), "{contract}");
    }
    let score = |rest: &str| {
        let all = format!("score mine.onnx {rest}");
        all.split(' ').map(str::to_owned).collect::<Vec<_>>()
    };
    let refuse = |rest: &str, words: &[&str]| {
        let arguments = score(rest);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        refused(at, &arguments, 1, words);
    };
    refuse(
        "two.egp --views side --size 50x30",
        &["64x44, found 50x30", "use --size 64x44"],
    );
    refuse(
        "two.egp --views side --framing height",
        &["framing cycle, found height", "use --framing cycle"],
    );
    let drawn = json(at, "score mine.onnx two.egp --views side --cycles 1");
    assert_eq!(drawn["settings"]["size"], "64x44");
    assert_eq!(drawn["settings"]["framing"], "cycle");
    assert_eq!(drawn["recognizers"][0]["probes"], 4);
    assert_eq!(drawn["recognizers"][0]["rank1"], 1.0);

    let sweep = "sweep two.egp --views side --first-cycle 1000";
    run(
        at,
        &format!("{sweep} --size 64x44 --framing cycle --out set"),
    );
    assert_eq!(npy(at.join("set/geis.npy")).0, "4, 64, 44");
    let read = json(at, "score mine.onnx set");
    assert_eq!(read["recognizers"][0]["rank1"], 1.0);
    assert_eq!(read["settings"]["size"], "64x44");
    run(at, "train set --out again.onnx");
    let again = fs::read_to_string(at.join("again.toml")).expect("a contract");
    assert!(
        again.contains("rows = 64") && again.contains("framing = \"cycle\""),
        "{again}"
    );

    run(at, &format!("{sweep} --out small"));
    refuse(
        "small",
        &[
            "64x44, found 50x30",
            "sweep another dataset with --size 64x44",
        ],
    );
    run(
        at,
        &format!("{sweep} --size 64x44 --framing box --out boxes"),
    );
    refuse(
        "boxes",
        &[
            "framing cycle, found box",
            "sweep another dataset with --framing cycle",
        ],
    );
    let arguments = ["score", "mine.onnx", "set", "--size", "64x44"];
    refused(at, &arguments, 2, &["--size: a folder is used whole"]);
}

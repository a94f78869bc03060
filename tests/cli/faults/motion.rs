//! Recordings of motion: units, times, periods, people in one file.

use crate::command::*;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn fault(name: &str) -> PathBuf {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/faults");
    data.join(name)
}

/// Imports a file and returns its row of the results.
fn import(folder: &Path, file: &Path, flags: &[&str]) -> Value {
    let file = file.to_str().expect("UTF-8");
    let mut arguments = vec![
        "import",
        file,
        "--out",
        "x.egp",
        "--overwrite",
        "--json",
        "-",
    ];
    arguments.extend(flags);
    let results: Value = serde_json::from_str(&done(folder, &arguments)).expect("JSON");
    results["clips"][0].clone()
}

fn near(found: &Value, expected: f64, tolerance: f64) {
    let found = found.as_f64().expect("a number");
    assert!(
        (found - expected).abs() <= tolerance,
        "{found}, not {expected}"
    );
}

fn warned(clip: &Value, words: &str) {
    assert!(clip["warnings"].to_string().contains(words), "{clip}");
}

/// Multiplies the lengths of a BVH file with position channels in its root alone.
fn scaled(text: &str, scale: f64) -> String {
    let times = |word: &str| (word.parse::<f64>().expect("a number") * scale).to_string();
    let is_row =
        |line: &str| line.starts_with(|first: char| first == '-' || first.is_ascii_digit());
    let lines = text.lines().map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let scaled: Vec<String> = words
            .iter()
            .enumerate()
            .map(|(at, word)| match (words[0], at) {
                ("OFFSET", 1..) => times(word),
                (first, ..3) if is_row(first) => times(word),
                _ => (*word).to_owned(),
            })
            .collect();
        scaled.join(" ") + "\n"
    });
    lines.collect()
}

#[test]
fn a_walk_has_its_size_in_units_of_8_and_of_10_centimetres() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let text = fs::read_to_string(fault("06_loop_of_one_cycle/93_percent.bvh")).expect("text");
    for (unit_cm, name) in [(8.0, "MikuMikuDance"), (10.0, "decimetre"), (100.0, "")] {
        let file = at.join("walk.bvh");
        fs::write(&file, scaled(&text, 1.0 / unit_cm)).expect("written");
        let clip = import(at, &file, &[]);
        near(&clip["speed_mps"], 1.2, 0.01);
        near(&clip["stride_m"], 1.32, 0.01);
        warned(&clip, name);
        let said = done(at, &["inspect", "x.egp"]);
        assert!(said.contains(" 1.77 "), "{said}");
    }
}

#[test]
fn the_speed_that_is_printed_is_the_stored_one_of_a_body_of_another_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let file = fault("06_loop_of_one_cycle/93_percent.bvh");
    let clip = import(at, &file, &["--stature-m", "1.5"]);
    let pack: Value =
        serde_json::from_str(&done(at, &["inspect", "x.egp", "--json", "-"])).expect("JSON");
    let stored = pack["clips"][0]["speed_mps"].as_f64().expect("a number");
    near(&clip["speed_mps"], stored, 0.0006);
    // Legs of a stature of 1.5 instead of 1.77 m.
    near(&clip["speed_mps"], 1.2 * 1.5 / 1.77, 0.03);
}

#[test]
fn a_recording_of_nearly_a_stride_and_a_loop_without_its_last_pose_keep_their_period() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let clip = import(at, &fault("06_loop_of_one_cycle/loop_30_frames.bvh"), &[]);
    near(&clip["cadence_spm"], 120.0, 0.1);
    warned(&clip, "taken as one cycle");
    for low_pass_hz in ["0", "10"] {
        let file = fault("06_loop_of_one_cycle/93_percent.bvh");
        let clip = import(at, &file, &["--low-pass-hz", low_pass_hz]);
        near(&clip["cadence_spm"], 109.1, 0.5);
        near(&clip["speed_mps"], 1.2, 0.01);
        warned(&clip, "of a stride is recorded");
    }
}

#[test]
fn rows_at_uneven_times_keep_their_cadence() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let file = fault("07_trc_uneven_times/variable_rate.trc");
    let clip = import(at, &file, &[]);
    near(&clip["cadence_spm"], 109.1, 0.2);
    near(&clip["speed_mps"], 1.2, 0.01);
    warned(&clip, "rows are interpolated to 30.00 Hz");
}

#[test]
fn headers_and_columns_of_other_writers_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let file = fault("11_trc_trailing_tabs_stripped/stripped_tabs.trc");
    near(&import(at, &file, &[])["speed_mps"], 1.2, 0.01);
    let text = fs::read_to_string(&file).expect("text");
    // Each row with another frame number and time.
    let rows = |number: fn(usize) -> usize, time: fn(f64) -> String| -> String {
        let lines = text.lines().enumerate().map(|(line, row)| {
            match (
                line >= 5,
                row.splitn(3, '\t').collect::<Vec<_>>().as_slice(),
            ) {
                (true, [frame, seconds, rest]) if !rest.is_empty() => format!(
                    "{}\t{}\t{rest}\n",
                    number(frame.parse().expect("a number")),
                    time(seconds.parse().expect("a number"))
                ),
                _ => row.to_owned() + "\n",
            }
        });
        lines.collect()
    };
    let seconds = |time: f64| format!("{time:.5}");
    let file = at.join("walk.trc");
    for (text, flags, words) in [
        (
            rows(|it| it, |time| format!("{:.3}", 1e3 * time)),
            &[][..],
            "milliseconds",
        ),
        (
            rows(|it| it, |time| format!("{:.8}", time / 60.0)),
            &[],
            "minutes",
        ),
        (rows(|it| it, |_| "0".into()), &["--fps", "60"], ""),
        (rows(|it| 2 * it - 1, seconds), &[], ""),
        (rows(|it| 5 * it, seconds), &[], ""),
        (text.replace("\tmm\t", "\t\t"), &[], "states no unit"),
        (
            text.replacen("60.00\t60.00", "0.00\t60.00", 1),
            &["--fps", "60"],
            "",
        ),
    ] {
        fs::write(&file, text).expect("written");
        let clip = import(at, &file, flags);
        near(&clip["cadence_spm"], 109.1, 0.2);
        near(&clip["speed_mps"], 1.2, 0.01);
        warned(&clip, words);
    }
}

#[test]
fn one_of_several_people_is_chosen_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let markers = fault("02_c3d_two_subjects/two_subjects.c3d");
    let skeletons = fault("13_gltf_two_walkers/two_under_one_node.glb");
    for (file, people, speeds_mps) in [
        (&markers, ["A", "B"], [1.2, 1.2]),
        (&skeletons, ["Armature", "Armature.001"], [1.2, 0.9]),
    ] {
        let path = file.to_str().expect("UTF-8");
        let both = people.join(", ");
        refused(
            at,
            &["import", path],
            1,
            &["several people", &both, "--person"],
        );
        refused(
            at,
            &["import", path, "--person", "C"],
            1,
            &["no person C", &both],
        );
        for (person, speed_mps) in people.into_iter().zip(speeds_mps) {
            let clip = import(at, file, &["--person", person]);
            near(&clip["speed_mps"], speed_mps, 0.01);
        }
    }
    done(
        at,
        &[
            "import",
            markers.to_str().expect("UTF-8"),
            "--person",
            "A",
            "--out",
            "a.egp",
        ],
    );
    let said = done(at, &["inspect", "a.egp"]);
    assert!(said.contains(" 1.75 "), "{said}");
    let bvh = fault("06_loop_of_one_cycle/loop_30_frames.bvh");
    let bvh = bvh.to_str().expect("UTF-8");
    refused(at, &["import", bvh, "--person", "A"], 1, &["no person A"]);
}

#[test]
fn what_does_not_matter_to_motion_is_no_reason_to_refuse_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let file = fault("08_gltf_required_extensions/texture_transform.glb");
    near(&import(at, &file, &[])["speed_mps"], 1.2, 0.01);
    let bytes = fs::read(&file).expect("bytes");
    // Names of the same length keep the file's lengths.
    let renamed = |name: &[u8]| -> Vec<u8> {
        let mut other = bytes.clone();
        let old = b"KHR_texture_transform";
        for at in 0..other.len() - old.len() {
            if other[at..].starts_with(old) {
                other[at..at + old.len()].copy_from_slice(name);
            }
        }
        other
    };
    let copy = at.join("walk.glb");
    fs::write(&copy, renamed(b"KHR_materials_unlitXX")).expect("written");
    near(&import(at, &copy, &[])["speed_mps"], 1.2, 0.01);
    fs::write(&copy, renamed(b"EXT_something_unknown")).expect("written");
    let words = ["requires the extension EXT_something_unknown"];
    refused(at, &["import", "walk.glb"], 1, &words);
    let file = fault("15_c3d_scale_sign/header_scale_positive.c3d");
    let clip = import(at, &file, &[]);
    near(&clip["speed_mps"], 1.2, 0.01);
    warned(&clip, "fits floats");
}

#[test]
fn joints_that_no_table_knows_are_named_by_a_file() {
    let work = tempfile::tempdir().expect("a folder");
    let at = work.path();
    let text = fs::read_to_string(fault("06_loop_of_one_cycle/loop_30_frames.bvh"));
    let text = text.expect("a motion");
    let german = [
        ("UpLeg", "Huefte"),
        ("Leg", "Knie"),
        ("Foot", "Knoechel"),
        ("ToeBase", "Ballen"),
        ("Shoulder", "Schluesselbein"),
        ("Arm", "Schulter"),
        ("ForeArm", "Ellbogen"),
        ("Hand", "Handgelenk"),
    ];
    let (mut renamed, mut rows) = (text.replace("Head", "x_Kopf"), "name,known\n".to_owned());
    for (side, abroad) in [("Left", "links"), ("Right", "rechts")] {
        for (known, name) in german {
            let (old, new) = (format!("{side}{known}\n"), format!("x_{name}_{abroad}\n"));
            assert!(renamed.contains(&old), "{old}");
            renamed = renamed.replace(&old, &new);
            rows += &format!("x_{name}_{abroad},{side}{known}\n");
        }
    }
    rows += "x_Kopf,Head\n";
    for folder in ["known", "abroad", "prefixed"] {
        fs::create_dir(at.join(folder)).expect("a folder");
    }
    fs::write(at.join("known/walk.bvh"), &text).expect("written");
    fs::write(at.join("abroad/walk.bvh"), &renamed).expect("written");
    // All names share a prefix, and so do those that no row is about.
    let shared = ["Hips", "Spine1", "Spine\n", "Neck"];
    let prefixed = shared.iter().fold(renamed, |text, name| {
        text.replace(&format!(" {name}"), &format!(" x_{name}"))
    });
    fs::write(at.join("prefixed/walk.bvh"), prefixed).expect("written");
    fs::write(at.join("joints.csv"), &rows).expect("written");

    refused(
        at,
        &["import", "abroad/walk.bvh", "--out", "x.egp"],
        1,
        &["no leg joints", "--joints FILE.csv: the line name,known"],
    );
    let packed = |file: &str, flags: &[&str]| {
        import(at, &at.join(file), &[&["--subject", "x"], flags].concat());
        fs::read(at.join("x.egp")).expect("a pack")
    };
    let named = ["--joints", "joints.csv"];
    let known = packed("known/walk.bvh", &[]);
    assert_eq!(packed("abroad/walk.bvh", &named), known);
    assert_eq!(packed("prefixed/walk.bvh", &named), known);
    let clip = import(at, &at.join("abroad/walk.bvh"), &named);
    near(&clip["cadence_spm"], 120.0, 0.05);

    let bad = |rows: &str, words: &str| {
        fs::write(at.join("bad.csv"), rows).expect("written");
        let arguments = [
            "import",
            "abroad/walk.bvh",
            "--joints",
            "bad.csv",
            "--out",
            "y.egp",
        ];
        refused(at, &arguments, 1, &[words]);
    };
    bad(
        "joint,name\n",
        "bad.csv:1: expected the header name,known, found \"joint,name\"",
    );
    bad(
        "name,known\na,LeftThing\n",
        "bad.csv:2: expected Head, or Left or Right",
    );
    bad(
        "name,known\na,Head\nb,Head,c\n",
        "bad.csv:3: expected 2 fields, found 3",
    );
    bad(
        "name,known\na,Head\na,Head\n",
        "bad.csv:3: \"a\" is in an earlier line",
    );
    bad("name,known\n", "no rows");
    bad(
        "name,known\nnobody,Head\n",
        "has none of the names in bad.csv: nobody",
    );
    bad(
        "name,known\nx_Kopf,Head\nNeck,Head\n",
        "two are called Head",
    );
    let some = format!("{rows}nobody,LASI\n");
    fs::write(at.join("some.csv"), some).expect("written");
    let clip = import(at, &at.join("abroad/walk.bvh"), &["--joints", "some.csv"]);
    warned(&clip, "nothing here is called nobody");
}

//! Files that break importers: each is an error of one line that names the cause, or is accepted
//! with a warning about the repair. The README of the folder `hard` states what is expected; where
//! it leaves a choice, the table states ours. Files with the same faults are made here.

use super::hard_files::{Case, End, MARKERS, NO_MARKERS, REFERENCE, SKELETONS, USUAL};
use crate::command::{self, code, text};
use crate::data::given;
use edgegait::import::{FileContents, ImportOptions, Markers, Motion};
use edgegait::people::retarget::RetargetedMotion;
use edgegait_core::skeleton::Joint;
use glam::DVec3;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use End::{Accepted, Refused, SameMotion, SameTake, Smooth, Warned};

/// The output of `edgegait import` for a file: standard output, or the only line of the error.
#[derive(Debug)]
pub struct Said(pub Result<String, String>);

/// Imports a file in a new folder, within ten seconds and 512 MB of address space, which bounds the
/// memory.
pub fn import(file: &Path, asf: Option<&Path>) -> Said {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = if cfg!(target_os = "linux") {
        let mut shell = Command::new("sh");
        shell.args(["-c", "ulimit -v 524288; exec \"$@\"", "sh"]);
        shell.arg(env!("CARGO_BIN_EXE_edgegait"));
        shell
    } else {
        Command::new(env!("CARGO_BIN_EXE_edgegait"))
    };
    command.arg("import").arg(file).args(["--out", "hard.egp"]);
    if let Some(asf) = asf {
        command.arg("--asf").arg(asf);
    }
    let started = Instant::now();
    let output = command.current_dir(&folder).output().expect("it starts");
    let name = file.display();
    let took = started.elapsed();
    assert!(took < Duration::from_secs(10), "{name}: {took:?}");
    let left = command::names(folder.path());
    let error = text(&output.stderr);
    if code(&output) == 0 {
        assert_eq!(left, ["hard.egp"], "{name}");
        return Said(Ok(text(&output.stdout)));
    }
    assert_eq!(code(&output), 1, "{name}: {error}");
    assert!(left.is_empty(), "{name} left {left:?}");
    assert!(output.stdout.is_empty(), "{name}");
    assert_eq!(error.lines().count(), 1, "{name}: {error}");
    let stem = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let is_named = error.contains(&stem(file)) || asf.is_some_and(|asf| error.contains(&stem(asf)));
    assert!(error.starts_with("error: ") && is_named, "{name}: {error}");
    Said(Err(error))
}

/// Checks the command's output against the outcomes of the table.
fn check_command(name: &str, said: &Said, ends: &[End]) {
    for end in ends {
        match (end, &said.0) {
            (Refused(part), Err(error)) => assert!(error.contains(part), "{name}: {error}"),
            (Refused(_), Ok(output)) => panic!("{name} was accepted: {output}"),
            (Warned(_) | Accepted, Err(error)) => panic!("{name}: {error}"),
            (Warned(part), Ok(output)) => {
                let is_warned = warnings(output).any(|warning| warning.contains(part));
                assert!(is_warned, "{name}: {output}");
            }
            (Accepted, Ok(output)) => {
                let unusual =
                    warnings(output).find(|warning| !USUAL.iter().any(|w| warning.contains(w)));
                assert_eq!(unusual, None, "{name}");
            }
            (SameMotion | SameTake(..) | Smooth(_), _) => {}
        }
    }
}

pub fn warnings(output: &str) -> impl Iterator<Item = &str> {
    output
        .lines()
        .filter_map(|line| line.trim().strip_prefix("warning: "))
}

fn motion(folder: &Path, name: &str, asf: Option<&str>) -> Motion {
    let options = ImportOptions {
        asf: asf.map(|asf| folder.join(asf)),
        ..ImportOptions::default()
    };
    Motion::read_with(folder.join(name), &options).unwrap()
}

/// Checks the motion against the outcomes of the table.
fn check_motion(folder: &Path, (name, asf, ends): Case) {
    for end in ends {
        match *end {
            SameMotion => {
                let (ours, reference) =
                    (motion(folder, name, asf), motion(folder, REFERENCE, None));
                assert_eq!(ours.frames.len(), reference.frames.len(), "{name}");
                for frame in 0..ours.frames.len() {
                    let (a, b) = (ours.globals(frame).0, reference.globals(frame).0);
                    let apart = a.iter().zip(&b).map(|(a, b)| a.distance(*b));
                    assert!(apart.fold(0.0, f64::max) < 1e-3, "{name} frame {frame}");
                }
            }
            SameTake(other, other_asf) => {
                let take = |name, asf| {
                    RetargetedMotion::from_motion(&motion(folder, name, asf), None).unwrap()
                };
                let (ours, reference) = (take(name, asf), take(other, other_asf));
                assert_eq!(ours.len(), reference.len(), "{name}");
                for joint in Joint::ALL.map(Joint::index) {
                    let apart_m = ours.offsets[joint].distance(reference.offsets[joint]);
                    assert!(apart_m < 1e-3, "{name} {joint}: {apart_m}");
                    for (a, b) in ours.rotations.iter().zip(&reference.rotations) {
                        let turn = a[joint].angle_between(b[joint]);
                        assert!(turn < 1e-3, "{name} {joint}: {turn}");
                    }
                }
            }
            Smooth(most_m) => {
                let take = RetargetedMotion::from_motion(&motion(folder, name, asf), None).unwrap();
                let mut farthest_m = 0f64;
                for frame in 1..take.len() {
                    let (a, b) = (take.joint_positions(frame - 1), take.joint_positions(frame));
                    let steps = a.iter().zip(&b).map(|(a, b)| a.distance(*b));
                    farthest_m = steps.fold(farthest_m, f64::max);
                }
                assert!(farthest_m < most_m, "{name}: {farthest_m}");
            }
            Refused(_) | Warned(_) | Accepted => {}
        }
    }
}

pub fn read_markers(path: &Path) -> Markers {
    match FileContents::read(path).unwrap() {
        FileContents::Markers(markers) => markers,
        FileContents::Motion(_) => panic!("{} holds a skeleton", path.display()),
    }
}

/// Returns legs that walk at 1.3 m/s for two strides, at 60 frames a second, in centimetres.
fn walking_legs() -> String {
    let leg = |side: &str, x: f64| {
        format!(
            "JOINT {side}UpLeg\n{{\nOFFSET {x} -4 0\nCHANNELS 1 Xrotation\n\
             JOINT {side}Leg\n{{\nOFFSET 0 -42 0\nCHANNELS 1 Xrotation\n\
             JOINT {side}Foot\n{{\nOFFSET 0 -41 0\nCHANNELS 0\n\
             End Site\n{{\nOFFSET 0 -6 14\n}}\n}}\n}}\n}}\n"
        )
    };
    let mut bvh = format!(
        "HIERARCHY\nROOT Hips\n{{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n{}{}}}\n\
         MOTION\nFrames: 132\nFrame Time: 0.016667\n",
        leg("Left", 9.0),
        leg("Right", -9.0)
    );
    for frame in 0..132 {
        let time_s = f64::from(frame) / 60.0;
        let phase = std::f64::consts::TAU * time_s / 1.1;
        let (thigh, shank) = (25.0 * phase.sin(), 28.0 * (phase + 0.9).cos());
        bvh += &format!(
            "0 {:.4} {:.4} {:.4} {:.4} {:.4} {:.4}\n",
            88.0 + 2.0 * (2.0 * phase).cos(),
            130.0 * time_s,
            -thigh,
            30.0 - shank,
            thigh,
            30.0 + shank
        );
    }
    bvh
}

#[test]
fn made_files_with_the_same_faults_end_the_same_way() {
    let walk = walking_legs();
    let rows: Vec<&str> = walk.lines().collect();
    let row = rows.len() - 132 + 40;
    let with_row = |text: &str| {
        let mut rows = rows.clone();
        rows[row] = text;
        rows.join("\n")
    };
    let line = format!(":{}: frame 40", row + 1);
    let bare = "the skeleton has no arms, forearms, hands, head";
    let standing: String = rows
        .iter()
        .enumerate()
        .map(|(i, text)| {
            if i < row - 40 {
                format!("{text}\n")
            } else {
                "0 88 0 0 0 0 0\n".into()
            }
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    for (name, text, end, part) in [
        ("whole", walk.clone(), true, bare),
        ("crlf", walk.replace('\n', "\r\n"), true, bare),
        (
            "rates",
            walk.replace("0.016667", "0.00833"),
            true,
            "is the frame rate",
        ),
        (
            "more",
            walk.replace(": 132", ": 20"),
            true,
            "20 frames declared, 132 present",
        ),
        (
            "fewer",
            walk.replace(": 132", ": 4000000000"),
            false,
            "expected 4000000000 frames, found 132",
        ),
        (
            "cut",
            rows[..=row].join("\n") + "\n0 88",
            false,
            "expected 7 values in the row, found 2",
        ),
        ("extra", with_row("0 88 0 0 0 0 0 0"), false, &line),
        ("nan", with_row("0 88 0 0 nan 0 0"), false, &line),
        (
            "comma",
            with_row("0 88,0 0 0 0 0 0"),
            false,
            "decimal commas",
        ),
        ("standing", standing, false, "no gait cycle"),
        (
            "one",
            rows[..=row - 40].join("\n").replace(": 132", ": 1"),
            false,
            "no gait cycle",
        ),
        (
            "legless",
            walk.replace("UpLeg", "Arm").replace("Leg", "ForeArm"),
            false,
            "no leg joints",
        ),
        (
            "twice",
            walk.replace("RightUpLeg", "LeftUpLeg"),
            false,
            "share a name",
        ),
        ("utf16", "\u{feff}H".into(), false, "expected HIERARCHY"),
        ("empty", String::new(), false, "the file is empty"),
        (
            "long",
            "HIERARCHY\n".to_owned() + &"7 ".repeat(1 << 20),
            false,
            "longer than 1048576",
        ),
    ] {
        let file = folder.path().join(format!("{name}.bvh"));
        fs::write(&file, text).unwrap();
        let said = import(&file, None).0;
        assert_eq!(said.is_ok(), end, "{name}: {said:?}");
        let said = said.unwrap_or_else(|error| error);
        assert!(said.contains(part), "{name}: {said}");
    }
}

mod with_data {
    use super::*;

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn every_hard_skeleton_is_refused_or_accepted_as_the_table_says() {
        let folder = given().join("hard");
        for &(name, asf, ends) in SKELETONS {
            let unpacked = tempfile::tempdir().unwrap();
            let mut file = folder.join(name);
            if let Some(stem) = name.strip_suffix(".xz") {
                let output = Command::new("xz").arg("-dc").arg(&file).output();
                let output = output.expect("the command xz");
                file = unpacked.path().join(stem);
                fs::write(&file, output.stdout).unwrap();
            }
            let asf_path = asf.map(|asf| folder.join(asf));
            check_command(name, &import(&file, asf_path.as_deref()), ends);
            check_motion(&folder, (name, asf, ends));
        }
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn every_hard_recording_of_markers_is_read_as_the_table_says() {
        let folder = given().join("hard");
        for &(name, count, frames, rate_hz, missing, warnings, end) in MARKERS {
            let markers = read_markers(&folder.join(name));
            let unseen = markers.frames.iter().flatten().filter(|p| p.is_none());
            assert_eq!(
                (markers.names.len(), markers.frames.len(), unseen.count()),
                (count, frames, missing),
                "{name}"
            );
            assert!((markers.sample_rate_hz - rate_hz).abs() < 1e-3, "{name}");
            assert_eq!(
                markers.warnings.len(),
                warnings.len(),
                "{name}: {:?}",
                markers.warnings
            );
            for (found, part) in markers.warnings.iter().zip(warnings) {
                assert!(found.contains(part), "{name}: {found}");
            }
            check_command(name, &import(&folder.join(name), None), &[end]);
        }
        for &(name, part) in NO_MARKERS {
            check_command(name, &import(&folder.join(name), None), &[Refused(part)]);
        }
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn blank_nan_zero_and_9999999_hide_the_same_frames_of_the_left_ankle() {
        let folder = given().join("hard");
        let whole = read_markers(&folder.join("80_trc_ok.trc"));
        let ankle = whole.names.iter().position(|name| name == "LANK").unwrap();
        let gap = |frame: usize| (30..55).contains(&frame);
        let first_missing =
            |markers: &Markers| markers.frames.iter().position(|f| f[ankle].is_none());
        let masked = [
            "81_trc_blank_gap",
            "82_trc_nan_gap",
            "83_trc_zero_gap",
            "84_trc_9999999_gap",
        ]
        .map(|name| read_markers(&folder.join(format!("{name}.trc"))));
        let start = first_missing(&masked[0]).unwrap();
        for markers in &masked {
            for (frame, (ours, all)) in markers.frames.iter().zip(&whole.frames).enumerate() {
                for (marker, (ours, all)) in ours.iter().zip(all).enumerate() {
                    let is_hidden = marker == ankle && gap(frame + 30 - start);
                    assert_eq!(*ours, all.filter(|_| !is_hidden), "{frame}");
                }
            }
        }
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn the_six_encodings_of_a_trial_agree_within_a_count() {
        let folder = given().join("hard");
        for (names, count_mm) in [
            (
                [
                    "Eb015pr", "Eb015pi", "Eb015vr", "Eb015vi", "Eb015sr", "Eb015si",
                ]
                .map(|n| format!("enc_{n}")),
                0.0834,
            ),
            (
                [
                    "pc_real", "pc_int", "dec_real", "dec_int", "sgi_real", "sgi_int",
                ]
                .map(|n| format!("enc2_{n}")),
                0.2812,
            ),
        ] {
            let all = names.map(|name| read_markers(&folder.join(format!("real/c3d_{name}.c3d"))));
            for other in &all[1..] {
                assert_eq!(other.names, all[0].names);
                for (a, b) in other
                    .frames
                    .iter()
                    .flatten()
                    .zip(all[0].frames.iter().flatten())
                {
                    match (a, b) {
                        (None, None) => {}
                        (Some(a), Some(b)) => assert!((*a - *b).abs().max_element() <= count_mm),
                        _ => panic!("seen in one encoding only"),
                    }
                }
            }
        }
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn rotations_before_positions_in_a_root_are_read_as_the_file_says() {
        let folder = given().join("hard");
        let motion = motion(&folder, "real/bvh_rotation_first_root.bvh", None);
        assert_eq!(motion.frames[0].root, DVec3::new(10.0, 50.0, -20.0));
        assert_eq!(motion.frames.len(), 4);
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn no_hard_file_is_left_out_of_the_tables() {
        let folder = given().join("hard");
        let mut known: BTreeSet<String> = ["README.md", "make_hard.py"].map(str::to_owned).into();
        for (name, asf, _) in SKELETONS {
            known.extend([name.to_string(), asf.unwrap_or(name).to_string()]);
        }
        known.extend(MARKERS.iter().map(|case| case.0.to_owned()));
        known.extend(NO_MARKERS.iter().map(|case| case.0.to_owned()));
        for (prefix, folder) in [("", folder.clone()), ("real/", folder.join("real"))] {
            for name in command::names(&folder)
                .iter()
                .filter(|name| *name != "real")
            {
                assert!(known.contains(&format!("{prefix}{name}")), "{prefix}{name}");
            }
        }
    }
}

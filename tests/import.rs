//! Real recordings and broken ones, from file to gait cycles.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use edgegait::import::{Motion, Options};
use edgegait::scene::events::{self, Cut};
use edgegait::scene::retarget::{DEFAULT_CUT_OFF_HZ, Take};
use edgegait_core::skeleton::Joint;
use glam::{DMat4, DVec3};

/// A folder of real data, if it is there.
fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared")
        .join(folder);
    if path.is_dir() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there", path.display());
    None
}

type Row = HashMap<String, String>;

/// The rows of the manifest whose BVH or AMC is there, as column name to value.
fn manifest() -> Vec<Row> {
    let Some(folder) = shared("mocap") else {
        return Vec::new();
    };
    let mut reader = csv::Reader::from_path(folder.join("manifest.csv")).unwrap();
    reader
        .deserialize()
        .map(|row| row.unwrap())
        .filter(|row: &Row| row["file"].ends_with(".bvh") || row["file"].ends_with(".amc"))
        .filter(|row| folder.join(&row["file"]).is_file())
        .collect()
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap()
}

fn take_of(row: &Row) -> Take {
    let path = shared("mocap").unwrap().join(&row["file"]);
    let options = Options {
        sample_rate_hz: row["file"].ends_with(".amc").then(|| number(row, "fps")),
        asf: None,
    };
    let motion = Motion::read_with(path, &options).unwrap();
    Take::from_motion(&motion, Some(DEFAULT_CUT_OFF_HZ)).unwrap()
}

#[test]
fn every_clip_of_the_manifest_gives_a_gait_cycle() {
    let rows = manifest();
    for row in &rows {
        let cut = events::cut(&take_of(row)).unwrap_or_else(|e| panic!("{}: {e}", row["file"]));
        for one in &cut.cycles {
            // Walking and running people; the shuffle of CMU 131 is one real stride.
            assert!(
                (40.0..200.0).contains(&one.cadence_spm),
                "{}: {}",
                row["file"],
                one.cadence_spm
            );
        }
    }
    eprintln!("{} clips", rows.len());
}

/// Mean distance over a take of the canonical joint from the source's, metres.
fn misses(take: &Take) -> Vec<(Joint, f64)> {
    Joint::ALL
        .into_iter()
        .map(|joint| {
            let sum: f64 = (0..take.len())
                .map(|frame| {
                    let reached = take.joint_positions(frame)[joint.index()];
                    reached.distance(take.positions[frame][joint.index()])
                })
                .sum();
            (joint, sum / take.len() as f64)
        })
        .collect()
}

#[test]
fn canonical_joints_lie_within_25_mm_of_the_sources_in_every_clip() {
    let mut worst = (0.0, String::new());
    for row in manifest() {
        for (joint, miss) in misses(&take_of(&row)) {
            assert!(miss < 0.025, "{} {joint:?}: {miss}", row["file"]);
            if miss > worst.0 {
                worst = (miss, format!("{} {joint:?}", row["file"]));
            }
        }
    }
    eprintln!("worst: {worst:?}");
}

#[test]
fn cadence_and_speed_agree_with_the_manifest_within_5_percent() {
    let rows: Vec<Row> = manifest()
        .into_iter()
        .filter(|row| row["dataset"] == "cmu_amc")
        .filter(|row| ["s02", "s07", "s08", "s09", "s35"].contains(&row["subject"].as_str()))
        .collect();
    for row in &rows {
        let cut: Cut = events::cut(&take_of(row)).unwrap();
        let off = |ours: f64, column| ours / number(row, column) - 1.0;
        let (cadence, speed) = (
            off(cut.cadence_spm, "cadence_spm"),
            off(cut.speed_mps, "speed_mps"),
        );
        eprintln!(
            "{}: {:.1} steps/min ({:+.1} %), {:.2} m/s ({:+.1} %)",
            row["trial"],
            cut.cadence_spm,
            100.0 * cadence,
            cut.speed_mps,
            100.0 * speed
        );
        assert!(
            cadence.abs() < 0.05 && speed.abs() < 0.05,
            "{}",
            row["trial"]
        );
    }
}

/// CMU 02's left leg by matrices, from the numbers of `02.asf` typed here: bone vector
/// (direction, length) and the angle of its axes about z. `f` is one frame's text.
fn left_ankle_by_matrices(f: &HashMap<&str, Vec<f64>>) -> DVec3 {
    let turn = |x: f64, y: f64, z: f64| {
        DMat4::from_rotation_z(z.to_radians())
            * DMat4::from_rotation_y(y.to_radians())
            * DMat4::from_rotation_x(x.to_radians())
    };
    let bone = |x: f64, y: f64, z: f64, length: f64| {
        DMat4::from_translation(DVec3::new(x, y, z).normalize() * length)
    };
    let (root, femur, tibia) = (&f["root"], &f["lfemur"], &f["ltibia"]);
    let axes = turn(0.0, 0.0, 20.0);
    let ankle = DMat4::from_translation(DVec3::new(root[0], root[1], root[2]))
        * turn(root[3], root[4], root[5])
        * bone(0.655637, -0.713449, 0.247245, 2.52691)
        * (axes * turn(femur[0], femur[1], femur[2]) * axes.inverse())
        * bone(0.34202, -0.939693, 0.0, 7.59371)
        * (axes * turn(tibia[0], 0.0, 0.0) * axes.inverse())
        * bone(0.34202, -0.939693, 0.0, 7.28717);
    ankle.transform_point3(DVec3::ZERO)
}

#[test]
fn the_left_ankle_of_cmu_02_01_is_where_matrices_put_it() {
    let Some(folder) = shared("mocap/clips/cmu_amc/s02") else {
        return;
    };
    let motion = Motion::read(folder.join("02_01.amc")).unwrap();
    let joint = motion
        .joints
        .iter()
        .position(|j| j.name == "lfoot")
        .unwrap();
    let text = std::fs::read_to_string(folder.join("02_01.amc")).unwrap();
    let mut frame = HashMap::new();
    let mut checked = 0;
    for line in text.lines().filter(|l| !l.starts_with(['#', ':'])) {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap();
        frame.insert(name, words.map(|w| w.parse().unwrap()).collect());
        // The last line of each frame.
        if name == "ltoes" {
            let ankle = motion.globals(checked).0[joint];
            assert!(ankle.distance(left_ankle_by_matrices(&frame)) < 1e-9);
            checked += 1;
        }
    }
    assert_eq!(checked, motion.frames.len());
}

/// Reads an odd file up to its cycles: the warnings on the way and where it ended.
fn outcome(name: &str, asf: Option<&str>) -> (Vec<String>, Option<String>) {
    let folder = shared("hard").unwrap();
    let options = Options {
        sample_rate_hz: None,
        asf: asf.map(|name| folder.join(name)),
    };
    let motion = match Motion::read_with(folder.join(name), &options) {
        Ok(motion) => motion,
        Err(e) => return (Vec::new(), Some(e.to_string())),
    };
    match Take::from_motion(&motion, Some(DEFAULT_CUT_OFF_HZ)) {
        Ok(take) => match events::cut(&take) {
            Ok(cut) => ([take.warnings, cut.warnings].concat(), None),
            Err(end) => (take.warnings, Some(end)),
        },
        Err(e) => (motion.warnings, Some(e.to_string())),
    }
}

#[test]
fn broken_files_are_refused_in_a_sentence_that_names_the_place() {
    if shared("hard").is_none() {
        return;
    }
    for (name, asf, expected) in [
        (
            "01_truncated_motion.bvh",
            None,
            ":172: frame 52: expected 60 values in the row, found 11",
        ),
        (
            "02_frames_declared_too_many.bvh",
            None,
            "expected 500 frames, found 60",
        ),
        (
            "04_nan_inf_values.bvh",
            None,
            ":130: frame 10, Yrotation of RightUpLeg",
        ),
        (
            "15_frame_time_zero.bvh",
            None,
            ":119: expected a frame time",
        ),
        (
            "15b_frame_time_negative.bvh",
            None,
            ":119: expected a frame time",
        ),
        (
            "15c_frame_time_nan.bvh",
            None,
            ":119: expected a frame time",
        ),
        ("16_deep_hierarchy_500.bvh", None, "no thigh joints"),
        ("17_duplicate_joint_names.bvh", None, "no right thigh joint"),
        ("18_empty.bvh", None, "the file is empty"),
        ("23_utf16.bvh", None, "UTF-16"),
        ("24_no_motion_section.bvh", None, "expected MOTION"),
        (
            "29_missing_closing_brace.bvh",
            None,
            ":116: MOTION inside of 1 open braces",
        ),
        ("30_two_roots.bvh", None, ":117: a second ROOT"),
        ("31_one_frame.bvh", None, "no gait cycle"),
        ("32_zero_frames.bvh", None, "no frames"),
        (
            "33_frame_count_4e9.bvh",
            None,
            "expected 4000000000 frames, found 5",
        ),
        ("34_frame_count_negative.bvh", None, "found `-5`"),
        (
            "35_channels_count_mismatch.bvh",
            None,
            ":9: expected 3 channel names, found 2",
        ),
        ("36_decimal_comma.bvh", None, "decimal commas"),
        (
            "38_frames_wrapped_over_lines.bvh",
            None,
            ":120: frame 0: expected 60 values",
        ),
        ("39_overflow_1e400.bvh", None, ":127: frame 7"),
        (
            "40_extra_column.bvh",
            None,
            ":120: frame 0: expected 60 values in the row, found 61",
        ),
        (
            "41_short_row_in_middle.bvh",
            None,
            ":150: frame 30: expected 60",
        ),
        ("42_non_numeric_token.bvh", None, "found `abc`"),
        ("45_standing_still_no_gait.bvh", None, "no gait cycle"),
        ("46_binary_garbage.bvh", None, ":1: expected HIERARCHY"),
        ("47_nul_bytes.bvh", None, ":58: a NUL byte"),
        (
            "48_unknown_channel.bvh",
            None,
            ":9: unknown channel `Wscale`",
        ),
        ("51_no_legs.bvh", None, "no thigh joints"),
        (
            "63_amc_frame_numbers_skip.amc",
            Some("60_ok.asf"),
            "expected frame 50, found 53",
        ),
        (
            "64_amc_bone_missing_in_one_frame.amc",
            Some("60_ok.asf"),
            "lacks the bone",
        ),
        (
            "65_amc_bone_not_in_asf.amc",
            Some("60_ok.asf"),
            "no bone `tail`",
        ),
        (
            "68_amc_truncated.amc",
            Some("60_ok.asf"),
            "frame 120 lacks the bone",
        ),
        (
            "70_amc_duplicate_frame_number.amc",
            Some("60_ok.asf"),
            "expected frame",
        ),
        (
            "60_ok.amc",
            Some("67_asf_hierarchy_cycle.asf"),
            "a second parent (a cycle?)",
        ),
        (
            "60_ok.amc",
            Some("69_asf_direction_zero.asf"),
            "direction is zero",
        ),
    ] {
        let (_, end) = outcome(name, asf);
        let end = end.unwrap_or_else(|| panic!("{name} was accepted"));
        assert!(end.contains(expected), "{name}: {end}");
        assert_eq!(end.lines().count(), 1, "{name}: {end}");
    }
}

#[test]
fn odd_spellings_of_one_motion_give_one_motion() {
    let Some(folder) = shared("hard") else { return };
    let read = |name: &str| Motion::read(folder.join(name)).unwrap();
    let reference = read("00_reference_ok.bvh");
    for name in [
        "06_rotation_order_YXZ.bvh",
        "07_rotation_order_mixed_per_joint.bvh",
        "10_crlf.bvh",
        "11_tabs.bvh",
        "12_exponent_notation.bvh",
        "20_non_utf8_names_latin1.bvh",
        "20b_shift_jis_names.bvh",
        "21_cr_only_line_endings.bvh",
        "22_utf8_bom.bvh",
        "25_lowercase_keywords.bvh",
        "26_positions_on_all_joints.bvh",
        "27_rotation_channels_before_position.bvh",
        "28_spaces_and_namespace_in_names.bvh",
    ] {
        let motion = read(name);
        assert_eq!(motion.frames.len(), reference.frames.len(), "{name}");
        for frame in 0..motion.frames.len() {
            let (a, b) = (motion.globals(frame).0, reference.globals(frame).0);
            for (a, b) in a.iter().zip(&b) {
                assert!(a.distance(*b) < 1e-3, "{name} frame {frame}: {a} {b}");
            }
        }
    }
}

#[test]
fn odd_worlds_of_one_motion_give_one_take() {
    let Some(folder) = shared("hard") else { return };
    let take =
        |name: &str| Take::from_motion(&Motion::read(folder.join(name)).unwrap(), None).unwrap();
    let reference = take("00_reference_ok.bvh");
    for name in [
        "13_no_end_sites.bvh",
        "14_huge_coordinates_1e6.bvh",
        "28_spaces_and_namespace_in_names.bvh",
        "37_metres.bvh",
        "44_tpose_first_frame.bvh",
        "50_left_right_swapped_names.bvh",
        "52_orientation_z_up.bvh",
    ] {
        let other = take(name);
        assert_eq!(other.len(), reference.len(), "{name}");
        for (a, b) in other.rotations.iter().zip(&reference.rotations) {
            for joint in Joint::ALL {
                let turn = a[joint.index()].angle_between(b[joint.index()]);
                assert!(turn < 1e-3, "{name} {joint:?}: {turn}");
            }
        }
    }
}

#[test]
fn repairs_are_announced() {
    if shared("hard").is_none() {
        return;
    }
    for (name, asf, expected) in [
        (
            "03_frames_declared_too_few.bvh",
            None,
            "20 frames declared, 60 present",
        ),
        ("05_zero_length_bones.bvh", None, "a segment has no length"),
        (
            "17_duplicate_joint_names.bvh",
            None,
            "several joints share a name",
        ),
        (
            "43_root_teleport_frame.bvh",
            None,
            "the root jumps 3.00 m at frame 30",
        ),
        ("44_tpose_first_frame.bvh", None, "frame 0 is a T-pose"),
        (
            "49_fps_halved_walks_double_speed.bvh",
            None,
            "implausible: is the frame rate of 120.0 Hz right?",
        ),
        (
            "50_left_right_swapped_names.bvh",
            None,
            "legs were named the wrong way round",
        ),
        (
            "60_ok.amc",
            Some("61_asf_no_units.asf"),
            "no unit of length",
        ),
        (
            "66_amc_no_degrees_keyword.amc",
            Some("60_ok.asf"),
            "no unit of angle",
        ),
        ("real/cmu_03_02_root_glitch.amc", None, "are used"),
        ("real/cmu_09_10_root_teleport.amc", None, "the root jumps"),
    ] {
        let (warnings, end) = outcome(name, asf);
        assert!(
            warnings.iter().any(|w| w.contains(expected)),
            "{name}: {warnings:?} {end:?}"
        );
    }
}

#[test]
fn subjects_and_takes_do_not_depend_on_the_order_of_the_files() {
    use edgegait::scene::recorded::{BodyOptions, ReadOptions, Recording, SubjectName, subjects};
    let Some(folder) = shared("mocap/clips/cmu_amc") else {
        return;
    };
    let read = |file: &str, subject: SubjectName| {
        let options = ReadOptions {
            subject,
            ..ReadOptions::default()
        };
        Recording::read(&folder.join(file), &options).unwrap()
    };
    let mut recordings: Vec<Recording> = ["s08/08_01.amc", "s07/07_02.amc", "s07/07_01.amc"]
        .map(|file| read(file, SubjectName::File))
        .to_vec();
    let names = |recordings: &[Recording]| -> Vec<(String, Vec<String>)> {
        let people = subjects(recordings, &BodyOptions::default()).unwrap();
        let takes =
            |walks: &[edgegait::scene::Walk]| walks.iter().map(|w| w.name.clone()).collect();
        people
            .iter()
            .map(|p| (p.name.clone(), takes(&p.walks)))
            .collect()
    };
    let expected = vec![
        (
            "07".to_owned(),
            vec!["07_01".to_owned(), "07_02".to_owned()],
        ),
        ("08".to_owned(), vec!["08_01".to_owned()]),
    ];
    assert_eq!(names(&recordings), expected);
    recordings.reverse();
    assert_eq!(names(&recordings), expected);

    // The same take twice is two people who share a name, or a mistake.
    recordings.push(recordings[0].clone());
    let error = subjects(&recordings, &BodyOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("--subject-from folder"),
        "{error}"
    );

    let by_folder = read("s08/08_01.amc", SubjectName::Folder);
    assert_eq!(by_folder.subject, "s08");
}

//! Gait cycles of real recordings of skeletons.

use std::collections::HashMap;
use std::path::Path;

use super::clips::{Row, manifest, number};
use crate::data::{fixtures, given};
use edgegait::import::{ImportOptions, Motion};
use edgegait::people::cutting::events::{self, CutTake};
use edgegait::people::retarget::{DEFAULT_CUT_OFF_HZ, RetargetedMotion};
use edgegait_core::skeleton::Joint;
use glam::{DMat4, DVec3};

fn take_of(data: &Path, row: &Row) -> RetargetedMotion {
    let path = data.join("mocap").join(&row["file"]);
    let options = ImportOptions {
        sample_rate_hz: row["file"].ends_with(".amc").then(|| number(row, "fps")),
        ..ImportOptions::default()
    };
    let motion = Motion::read_with(path, &options).unwrap();
    RetargetedMotion::from_motion(&motion, Some(DEFAULT_CUT_OFF_HZ)).unwrap()
}

fn check_cycles(data: &Path) {
    let rows = manifest(data, &[".bvh", ".amc"]);
    for row in &rows {
        let cut =
            events::cut(&take_of(data, row)).unwrap_or_else(|e| panic!("{}: {e}", row["file"]));
        for one in &cut.cycles {
            // The range of walking and running people; the shuffle of CMU 131 is one real stride.
            assert!(
                (40.0..200.0).contains(&(120.0 / one.cycle.period_s)),
                "{}: {}",
                row["file"],
                120.0 / one.cycle.period_s
            );
        }
    }
    eprintln!("{} clips", rows.len());
}

/// Returns the mean distance over a take of each canonical joint from the source's, metres.
fn misses(take: &RetargetedMotion) -> Vec<(Joint, f64)> {
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

fn check_joints(data: &Path) {
    let mut worst = (0.0, String::new());
    for row in manifest(data, &[".bvh", ".amc"]) {
        for (joint, miss) in misses(&take_of(data, &row)) {
            assert!(miss < 0.025, "{} {joint:?}: {miss}", row["file"]);
            if miss > worst.0 {
                worst = (miss, format!("{} {joint:?}", row["file"]));
            }
        }
    }
    eprintln!("worst: {worst:?}");
}

fn check_cadence_and_speed(data: &Path) {
    let rows: Vec<Row> = manifest(data, &[".bvh", ".amc"])
        .into_iter()
        .filter(|row| row["dataset"] == "cmu_amc")
        .filter(|row| ["s02", "s07", "s08", "s09", "s35"].contains(&row["subject"].as_str()))
        .collect();
    assert!(!rows.is_empty());
    for row in &rows {
        let cut: CutTake = events::cut(&take_of(data, row)).unwrap();
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

/// Computes the left leg of CMU 02 with matrices, from numbers copied from `02.asf`: the bone
/// vector (direction, length) and the angle of its axes about z. `f` is one frame's text.
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
    let folder = fixtures().join("mocap/clips/cmu_amc/s02");
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
        // This is the last line of each frame.
        if name == "ltoes" {
            let ankle = motion.globals(checked).0[joint];
            assert!(ankle.distance(left_ankle_by_matrices(&frame)) < 1e-9);
            checked += 1;
        }
    }
    assert_eq!(checked, motion.frames.len());
}

#[test]
fn subjects_and_takes_do_not_depend_on_the_order_of_the_files() {
    use edgegait::people::recorded::{BodyOptions, ReadOptions, Recording, SubjectName, subjects};
    let folder = fixtures().join("mocap/clips/cmu_amc");
    let read = |file: &str, subject: SubjectName| {
        let options = ReadOptions {
            subject,
            ..ReadOptions::default()
        };
        Recording::read(&folder.join(file), &options).unwrap()
    };
    let mut recordings: Vec<Recording> = ["s08/08_01.amc", "s07/07_10.amc", "s07/07_01.amc"]
        .map(|file| read(file, SubjectName::File))
        .to_vec();
    let names = |recordings: &[Recording]| -> Vec<(String, Vec<String>)> {
        let people = subjects(recordings, &BodyOptions::default()).unwrap();
        let takes =
            |walks: &[edgegait::people::Walk]| walks.iter().map(|w| w.name.clone()).collect();
        people
            .iter()
            .map(|p| (p.name.clone(), takes(&p.walks)))
            .collect()
    };
    let expected = vec![
        (
            "07".to_owned(),
            ["07_01", "07_10", "07_10"].map(str::to_owned).to_vec(),
        ),
        ("08".to_owned(), vec!["08_01".to_owned()]),
    ];
    assert_eq!(names(&recordings), expected);
    recordings.reverse();
    assert_eq!(names(&recordings), expected);

    // The same take twice is an error: two people who share a name, or a mistake.
    recordings.push(recordings[0].clone());
    let error = subjects(&recordings, &BodyOptions::default()).unwrap_err();
    assert!(
        error.to_string().ends_with("expected one file for each"),
        "{error}"
    );

    let by_folder = read("s08/08_01.amc", SubjectName::Folder);
    assert_eq!(by_folder.subject, "s08");
}

#[test]
fn every_clip_gives_a_gait_cycle() {
    check_cycles(&fixtures());
}

#[test]
fn canonical_joints_lie_within_25_mm_of_the_sources() {
    check_joints(&fixtures());
}

#[test]
fn cadence_and_speed_agree_with_the_manifest_within_5_percent() {
    check_cadence_and_speed(&fixtures());
}

mod with_data {
    use super::*;

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn every_clip_gives_a_gait_cycle() {
        check_cycles(&given());
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn canonical_joints_lie_within_25_mm_of_the_sources() {
        check_joints(&given());
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn cadence_and_speed_agree_with_the_manifest_within_5_percent() {
        check_cadence_and_speed(&given());
    }
}

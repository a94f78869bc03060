//! Bounds the widths of the bodies of src/people/cohort/body.rs, which no page publishes: breadth and
//! depth at each height beside skinned ones of the same dimensions in the same recordings.

use crate::command::done;
use crate::data::given;
use crate::means::{mean, mean_row};
use crate::parts::Parts;
use crate::people::{Row, rows, spans};
use crate::walker::{recording, takes};
use edgegait::people::Cycle;
use edgegait::people::cohort::anthropometry::{DIMENSIONS, Dimensions, NAMES};
use edgegait::people::cohort::body;
use edgegait::people::recorded::{Keep, ReadOptions, Recording};
use edgegait_core::pack::{Pack, Sex};
use edgegait_core::skeleton::Joint;
use glam::{DQuat, DVec2, DVec3};
use std::fs;
use std::path::Path;

/// The people for choosing settings whose motion is CMU's.
const PEOPLE: [&str; 9] = [
    "101", "102", "104", "105", "106", "107", "108", "109", "110",
];
const VIEWS: [(&str, f64); 2] = [("000", 0.0), ("090", 90.0)];
/// The number of heights at which widths are measured, from the soles to the crown.
const HEIGHTS: usize = 100;
/// A region's range of heights, and the largest error of the mean over people from the front and
/// from the side, cm: the measured error plus 4 mm.
const REGIONS: [(&str, usize, usize, [f64; 2]); 8] = [
    ("calves", 14, 24, [0.6, 1.2]),
    ("thighs", 30, 42, [2.8, 0.5]),
    ("crotch", 42, 48, [3.7, 3.7]),
    ("hips", 48, 54, [1.6, 2.2]),
    ("waist", 56, 64, [2.0, 1.5]),
    ("chest", 66, 74, [1.1, 0.4]),
    ("shoulders", 78, 82, [1.3, 1.8]),
    ("head", 92, 98, [1.1, 1.6]),
];

/// Returns the width at each height, in statures, of an image's set pixels.
fn profile(set: &[bool], columns: usize) -> Vec<f64> {
    let widths: Vec<f64> = set
        .chunks_exact(columns)
        .map(|row| row.iter().filter(|set| **set).count() as f64)
        .collect();
    let top = widths.iter().position(|&width| width > 0.0);
    let bottom = widths.iter().rposition(|&width| width > 0.0);
    let (top, bottom) = (top.expect("a figure"), bottom.expect("a figure") + 1);
    let tall = (bottom - top) as f64;
    (0..HEIGHTS)
        .map(|at| {
            let up = (at as f64 + 0.5) / HEIGHTS as f64 * tall;
            widths[(bottom as f64 - up) as usize] / tall
        })
        .collect()
}

/// Returns the dimensions of a dressed body. Its arms hang, while those of ANSUR II are flexed.
fn dimensions(row: &Row) -> (Dimensions, f64) {
    let number = |name: &str| row.get(name).and_then(|text| text.parse::<f64>().ok());
    let stature_m = number("stature_m").expect("a stature");
    let mut measured = [None; DIMENSIONS];
    for (value, name) in measured.iter_mut().zip(NAMES) {
        *value = number(&format!("{name}_m"));
        match name {
            "biceps_circumference" => *value = value.map(|m| m / 0.92),
            "forearm_circumference" => *value = value.map(|m| m / 0.95),
            // That of the skinned bodies is their neck joint's, below the vertebra's. The depth of
            // shoulders and nape is taken from that height (`body::offsets`).
            "cervicale_height" => *value = None,
            // The navel is 1 cm below the iliac crests.
            "iliocristale_height" => *value = number("waist_height_m").map(|m| m + 0.01),
            _ => {}
        }
    }
    let sex = if row["sex"] == "M" {
        Sex::Male
    } else {
        Sex::Female
    };
    let mass_kg = number("mass_kg").expect("a mass");
    let expected = Dimensions::expected(stature_m, mass_kg, Some(sex), &[0.0; DIMENSIONS]);
    (expected.expect("a person").with(&measured), stature_m)
}

/// Returns the mean profile of the silhouettes of whole cycles.
fn theirs(data: &Path, row: &Row) -> Vec<f64> {
    let cycles = spans(&row["phase_cycles"]);
    let folder = ["id", "take", "view"]
        .iter()
        .fold(data.join("people/people"), |at, name| at.join(&row[*name]));
    let frames = cycles[0].0.ceil() as usize..cycles[cycles.len() - 1].1.ceil() as usize;
    let images: Vec<_> = frames
        .map(|frame| {
            let image = image::open(folder.join(format!("{:03}.png", frame + 1)));
            let image = image.expect("a silhouette").into_luma8();
            let set: Vec<bool> = image.pixels().map(|pixel| pixel[0] > 0).collect();
            profile(&set, image.width() as usize)
        })
        .collect();
    mean_row(images.iter().map(Vec::as_slice))
}

/// Returns the mean profile of the synthetic body in the mean cycle of the recording, at 6 m, with
/// hands as in the file's own mean cycle.
fn ours(pack: &[u8], own: &Cycle, d: &Dimensions, azimuth_deg: f64) -> Vec<f64> {
    const SIZE: (usize, usize) = (500, 360);
    let pack = Pack::parse(pack).expect("a pack");
    let walk = pack.clip(0).and_then(|clip| clip.as_loop());
    let walk = walk.expect("a cycle");
    let made = body::body(d, body::offsets(d));
    let turn = DQuat::from_rotation_y(-azimuth_deg.to_radians());
    let images: Vec<_> = (0..24u8)
        .map(|phase| {
            let pose = walk.pose(f32::from(phase) / 24.0);
            let root = pose.root.as_dvec3();
            let place = |point: DVec3| {
                let seen = turn * (point - DVec3::new(root.x, 0.92, root.z));
                let scale = 2.0 * 686.0 / (6.0 - seen.z);
                DVec2::new(180.0 + scale * seen.x, 250.0 - scale * seen.y)
            };
            let mut rotations = pose.rotations.map(glam::Quat::as_dquat);
            let frame = usize::from(phase) * own.rotations.len() / 24;
            for hand in [Joint::LeftHand, Joint::RightHand] {
                rotations[hand.index()] = own.rotations[frame][hand.index()];
            }
            let picture = Parts::draw(&made, (root, &rotations), place, SIZE);
            let set: Vec<bool> = picture.pixels.iter().map(|&parts| parts != 0).collect();
            profile(&set, picture.columns)
        })
        .collect();
    mean_row(images.iter().map(Vec::as_slice))
}

mod with_data {
    use super::*;

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn made_bodies_are_as_wide_as_skinned_ones_of_the_same_dimensions() {
        let data = given();
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        let bodies = rows(&data.join("people/bodies_dressed.csv"));
        let takes = takes(&data);
        let mut off = [[0.0; HEIGHTS]; 2];
        for id in PEOPLE {
            let row = bodies.iter().find(|row| row["id"] == id);
            let (d, stature_m) = dimensions(row.expect("a body"));
            let of = |view: &str| {
                let mut seen = takes.iter().filter(|row| row["view"] == view);
                seen.find(|row| row["id"] == id).expect("a take")
            };
            let take = of("000");
            let source = recording(&data, take);
            // The people of the other software hold their hands as in the files.
            let options = ReadOptions {
                keep: Keep::MeanCycle,
                mend: false,
                ..ReadOptions::default()
            };
            let own = Recording::read(&source, &options).expect("a recording");
            let own = &own.cut.expect("cycles").cycles[0].cycle;
            let source = source.display().to_string();
            let stature = stature_m.to_string();
            let import = ["import", &source, "--cycles", "mean", "--overwrite"];
            let body = ["--stature-m", &stature, "--out", "walk.egp"];
            done(at, &[&import[..], &body].concat());
            let pack = fs::read(at.join("walk.egp")).expect("a pack");
            for (off, (view, azimuth_deg)) in off.iter_mut().zip(VIEWS) {
                let (theirs, ours) = (theirs(&data, of(view)), ours(&pack, own, &d, azimuth_deg));
                for (off, (ours, theirs)) in off.iter_mut().zip(ours.iter().zip(&theirs)) {
                    *off += 100.0 * stature_m * (ours - theirs) / PEOPLE.len() as f64;
                }
            }
        }
        println!("made less skinned, cm: from the front, from the side");
        let mut missed = Vec::new();
        for (region, from, to, most) in REGIONS {
            let mean = off.map(|off| mean(off[from..to].iter().copied()));
            println!("{region:<10} {:>+5.2} {:>+5.2}", mean[0], mean[1]);
            if mean[0].abs() > most[0] || mean[1].abs() > most[1] {
                missed.push((region, mean));
            }
        }
        assert!(missed.is_empty(), "{missed:?}");
    }
}

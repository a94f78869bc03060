//! Tests of `import --bodies`: measured people.

use crate::command::*;
use crate::figure::write_turning_figure;
use edgegait_core::pack::{Pack, Sex};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::Vec3;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The largest error of an extent in a pack: 2 mm on either side.
const ROUNDING_M: f32 = 0.004;

/// Imports `people.csv` with the take of anna, who stands and turns, and returns the results.
fn import(at: &Path, people: &str, more: &str) -> Value {
    write_turning_figure(&at.join("anna_turn.bvh"), 20);
    fs::write(at.join("people.csv"), people).expect("a file");
    let import = format!(
        "import anna_turn.bvh --track clip --bodies people.csv --out anna.egp --json anna.json{more}"
    );
    done(at, &import.split(' ').collect::<Vec<_>>());
    let results = fs::read(at.join("anna.json")).expect("results");
    serde_json::from_slice(&results).expect("JSON")
}

/// Returns the extent of a joint's hulls along each axis, metres.
fn extents(pack: &Pack<'_>, joint: Joint) -> Vec3 {
    let avatar = pack.avatar(0).expect("a body");
    let hulls = avatar.hulls().filter(|hull| hull.joint() == joint);
    let points: Vec<Vec3> = hulls
        .flat_map(|hull| hull.points().collect::<Vec<_>>())
        .collect();
    let most = points.iter().copied().fold(Vec3::MIN, Vec3::max);
    most - points.into_iter().fold(Vec3::MAX, Vec3::min)
}

/// Returns the depth of the abdomen where it is broadest, metres.
fn navel_depth(pack: &Pack<'_>) -> f32 {
    let avatar = pack.avatar(0).expect("a body");
    let hulls = avatar.hulls().filter(|hull| hull.joint() == Joint::Spine);
    let points: Vec<Vec3> = hulls
        .flat_map(|hull| hull.points().collect::<Vec<_>>())
        .collect();
    let broadest = points.iter().max_by(|a, b| a.x.total_cmp(&b.x));
    let height = broadest.expect("a hull").y;
    let level = points.iter().filter(|p| (p.y - height).abs() < 0.005);
    let (least, most) = level.fold((f32::MAX, f32::MIN), |(least, most), p| {
        (least.min(p.z), most.max(p.z))
    });
    most - least
}

fn offsets(pack: &Pack<'_>) -> [Vec3; JOINTS] {
    pack.avatar(0).expect("a body").skeleton().offsets
}

#[track_caller]
fn near(found: f32, expected: f32) {
    assert!((found - expected).abs() <= ROUNDING_M, "{found} {expected}");
}

#[test]
fn hulls_in_the_pack_are_as_broad_as_the_row_says_and_joints_stay_the_skeletons() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let people = "subject,sex,hip_breadth_mm,waist_breadth_mm,waist_depth_mm,head_breadth_mm,foot_length_m,hand_breadth_mm\n\
                  anna,female,401,333,285,141,0.231,71\n";
    let results = import(at, people, "");
    assert_eq!(results["warnings"], Value::Array(Vec::new()), "{results}");
    assert_eq!(results["inputs"][1]["path"], "people.csv");
    let bytes = fs::read(at.join("anna.egp")).expect("the pack");
    let pack = Pack::parse(&bytes).expect("a pack");
    near(extents(&pack, Joint::Pelvis).x, 0.401);
    near(extents(&pack, Joint::Spine).x, 0.333);
    // The abdomen leans, so that only its section at the navel is as deep.
    near(navel_depth(&pack), 0.285);
    near(extents(&pack, Joint::Head).x, 0.141);
    near(extents(&pack, Joint::LeftFoot).z, 0.231);
    near(extents(&pack, Joint::RightHand).z, 0.071);
    assert_eq!(
        pack.subjects().next().and_then(|anna| anna.sex),
        Some(Sex::Female)
    );
    // The thighs and upper arms of the file: 45 and 28 cm.
    near(offsets(&pack)[Joint::LeftShank.index()].y, -0.45);
    near(offsets(&pack)[Joint::LeftForearm.index()].y, -0.28);
}

#[test]
fn with_a_stature_joints_lie_where_the_measured_dimensions_put_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let people = "subject,stature_m,mass_kg,trochanterion_height_mm,knee_height_mm,radiale_stylion_length_mm\n\
                  anna,1.62,58,840,470,244\n";
    // The row takes precedence over the options.
    import(at, people, " --stature-m 1.9 --mass-kg 90 --sex female");
    let bytes = fs::read(at.join("anna.egp")).expect("the pack");
    let pack = Pack::parse(&bytes).expect("a pack");
    near(offsets(&pack)[Joint::LeftShank.index()].y, -0.37);
    near(offsets(&pack)[Joint::RightHand.index()].y, -0.244);
    let anna = pack.subjects().next().expect("a subject");
    assert_eq!(anna.sex, Some(Sex::Female));
    assert_eq!((anna.stature_mm, anna.mass_hg), (1620, 580));
}

#[test]
fn rows_and_walkers_without_each_other_are_warned_of_and_bad_files_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let results = import(at, "subject,knee_height_mm\nAnna,470\n", "");
    let warnings: Vec<&str> = results["warnings"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|warning| warning.as_str().expect("text"))
        .collect();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings[0].contains("\"Anna\"") && warnings[0].contains("anna"),
        "{warnings:?}"
    );
    assert!(
        warnings[1].contains("\"anna\" was not measured"),
        "{warnings:?}"
    );

    fs::write(at.join("bad.csv"), "subject,knee_height_mm\nanna,47\n").expect("a file");
    let import = "import anna_turn.bvh --track clip --bodies bad.csv --out bad.egp";
    refused(
        at,
        &import.split(' ').collect::<Vec<_>>(),
        1,
        &["bad.csv:2", "knee_height_mm of 47"],
    );
    assert!(!at.join("bad.egp").exists());
}

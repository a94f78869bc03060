//! `FORMAT.md`'s pack by hand means what is written there.

use edgegait_core::avatar::PosedHulls;
use edgegait_core::pack::{Gait, Pack, Sex};
use edgegait_core::pose::ModelPose;
use edgegait_core::skeleton::Joint;
use glam::Vec3;

/// The bytes of the dump in `FORMAT.md`: lines of a four-digit offset and the bytes there.
fn documented_pack() -> Vec<u8> {
    let mut bytes = Vec::new();
    let lines = include_str!("../FORMAT.md").lines();
    for (offset, row) in lines.filter_map(|line| line.split_once("  ")) {
        if offset.len() == 4 && usize::from_str_radix(offset, 16) == Ok(bytes.len()) {
            let byte = |hex| u8::from_str_radix(hex, 16).expect("two digits");
            bytes.extend(row.split(' ').map(byte));
        }
    }
    bytes
}

#[test]
fn the_documented_pack_holds_what_its_table_says() {
    let bytes = documented_pack();
    assert_eq!(bytes.len(), 442);
    let pack = Pack::parse(&bytes).expect("the documented pack");
    let subject = pack.subject(0).expect("a subject");
    assert_eq!((subject.name, subject.sex), ("F01", Some(Sex::Female)));
    assert_eq!((subject.stature_mm, subject.mass_hg), (1_650, 600));
    let walk = pack.walks().next().expect("a walk");
    assert_eq!((walk.name, walk.gait), ("walk", Gait::Walk));
    assert_eq!(walk.speed_mm_per_s, 1_364);
    let clip = pack.clip(walk.clip).expect("a clip");
    assert!((clip.period_s() - 1.1).abs() < 1e-6);
    assert!((clip.drift_m() - 1.5).abs() < 1e-6);
    assert!((clip.max_error_mm() - 5.0).abs() < 1e-4);
    assert!((clip.mean_error_mm() - 1.0).abs() < 1e-4);
}

#[test]
fn the_documented_pack_decodes_as_by_hand() {
    let bytes = documented_pack();
    let pack = Pack::parse(&bytes).expect("the documented pack");
    let avatar = pack.avatar(0).expect("an avatar");
    let clip = pack.clip(0).expect("a clip");
    let forearm = clip.pose(0.0).rotations[Joint::LeftForearm.index()];
    assert!((forearm.x + 0.258_837).abs() < 1e-6);
    assert!((forearm.w - 0.965_921).abs() < 1e-6);
    for (phase, angle, knee) in [
        (0.0, -0.375f32, Vec3::new(0.09, 0.54669, 0.15383)),
        (0.25, 0.125, Vec3::new(0.09, 0.52078, -0.05236)),
        (0.5, 0.625, Vec3::new(0.09, 0.59690, -0.24574)),
    ] {
        let pose = clip.pose(phase);
        assert_eq!(pose.root, Vec3::new(0.0, 0.9375, 0.0));
        let thigh = pose.rotations[Joint::LeftThigh.index()];
        assert!((thigh.x - (0.5 * angle).sin()).abs() < 1e-6, "{phase}");
        let model = ModelPose::new(&avatar.skeleton(), &pose);
        let found = model.positions[Joint::LeftShank.index()];
        assert!((found - knee).length() < 2e-5, "{phase}: {found}");
    }
    // The hull's points in the rest pose of its joint, 9 cm to the left of the pelvis.
    let rest = ModelPose::new(&avatar.skeleton(), &edgegait_core::pose::Pose::REST);
    let expected = [[0.04, 0.005, 0.0], [0.14, 0.005, 0.0], [0.09, -0.42, 0.06]];
    let figure = PosedHulls::new(&avatar, &rest);
    assert_eq!(figure.points().len(), expected.len());
    for (found, expected) in figure.points().iter().zip(expected) {
        assert!((*found - Vec3::from(expected)).length() < 1e-6, "{found}");
    }
}

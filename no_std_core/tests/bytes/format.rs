//! Tests of the pack and the recognizer that `FORMAT.md` writes out by hand.

use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::Framing;
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::pack::{Gait, Pack, Sex};
use edgegait_core::pose::ModelPose;
use edgegait_core::silhouette::Size;
use edgegait_core::skeleton::Joint;
use glam::Vec3;

const COHORT: &[u8] = include_bytes!("../golden/cohort.egp");

/// Returns the bytes of the dump after this heading of `FORMAT.md`: lines of a four-digit offset
/// and the bytes there, with zeros where lines are left out.
fn documented(heading: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let text = include_str!("../../FORMAT.md").split_once(heading);
    let (_, text) = text.expect("the heading");
    let lines = text.lines().take_while(|line| !line.starts_with("# "));
    for (offset, row) in lines.filter_map(|line| line.split_once("  ")) {
        let at = usize::from_str_radix(offset, 16);
        if let (4, Ok(at)) = (offset.len(), at) {
            bytes.resize(at, 0);
            let byte = |hex| u8::from_str_radix(hex, 16).expect("two digits");
            bytes.extend(row.split(' ').map(byte));
        }
    }
    bytes
}

#[test]
fn the_documented_pack_holds_what_its_table_says() {
    let bytes = documented("## A pack by hand");
    assert_eq!(bytes.len(), 623);
    let pack = Pack::parse(&bytes).expect("the documented pack");
    let subject = pack.subject(0).expect("a subject");
    assert_eq!((subject.name, subject.sex), ("F01", Some(Sex::Female)));
    assert_eq!(subject.age_years, Some(30));
    assert_eq!((subject.stature_mm, subject.mass_hg), (1_650, 600));
    let walk = pack.walks().next().expect("a walk");
    assert_eq!((walk.name, walk.gait), ("walk", Gait::Walk));
    assert_eq!(walk.speed_mm_per_s, 1_364);
    let clip = pack.clip(walk.clip).expect("a clip");
    let clip = clip.as_loop().expect("a loop");
    assert_eq!((clip.template_number(), clip.frames()), (1, 96));
    assert!((clip.closure_mm() - 12.0).abs() < 1e-4);
    let (most, mean) = pack.codebook().joint_error_mm(Joint::LeftThigh);
    assert!((most - 5.0).abs() < 1e-4 && (mean - 1.0).abs() < 1e-4);
    assert!((clip.period_s() - 1.1).abs() < 1e-6);
    assert!((clip.drift_m() - 1.5).abs() < 1e-6);
    assert!((clip.max_error_mm() - 5.0).abs() < 1e-4);
    assert!((clip.mean_error_mm() - 1.0).abs() < 1e-4);
    let avatar = pack.avatar(0).expect("an avatar");
    assert!((avatar.max_error_mm() - 2.0).abs() < 1e-4);
    let mut offsets = [Vec3::ZERO; 19];
    offsets[Joint::LeftThigh.index()] = Vec3::new(0.09, 0.0, 0.0);
    offsets[Joint::LeftShank.index()] = Vec3::new(0.0, -0.42, 0.0);
    for (found, expected) in avatar.skeleton().offsets.iter().zip(offsets) {
        assert!((*found - expected).length() < 1e-6, "{found}");
    }
}

#[test]
fn subjects_and_walks_are_found_by_their_numbers() {
    let pack = Pack::parse(COHORT).expect("a pack");
    let (subjects, walks) = (pack.subjects(), pack.walks());
    let counts = (subjects.len(), walks.len());
    assert_eq!(counts, (26, 260));
    for (index, subject) in subjects.enumerate() {
        assert_eq!(pack.subject(index), Some(subject));
    }
    for (index, walk) in walks.enumerate() {
        assert_eq!(pack.walk(index), Some(walk));
    }
    for behind in [260, usize::MAX] {
        assert_eq!((pack.subject(behind), pack.walk(behind)), (None, None));
    }
}

#[test]
fn the_documented_pack_decodes_as_by_hand() {
    let bytes = documented("## A pack by hand");
    let pack = Pack::parse(&bytes).expect("the documented pack");
    let avatar = pack.avatar(0).expect("an avatar");
    let clip = pack
        .clip(0)
        .and_then(|clip| clip.as_loop())
        .expect("a loop");
    let forearm = clip.pose(0.0).rotations[Joint::LeftForearm.index()];
    // By 30.000980 degrees: the reference is rounded.
    assert!((forearm.x + 0.258_827).abs() < 1e-6);
    assert!((forearm.w - 0.965_924).abs() < 1e-6);
    for (phase, angle, knee) in [
        (0.0, -0.249_675f32, Vec3::new(0.09, 0.46802, 0.10378)),
        (0.25, 0.249_675, Vec3::new(0.09, 0.46802, -0.10378)),
        (0.5, 0.741_392, Vec3::new(0.09, 0.56524, -0.28363)),
    ] {
        let pose = clip.pose(phase);
        assert_eq!(pose.root, Vec3::new(0.0, 0.875, 0.0));
        let thigh = pose.rotations[Joint::LeftThigh.index()];
        assert!((thigh.x - (0.5 * angle).sin()).abs() < 1e-6, "{phase}");
        let model = ModelPose::new(&avatar.skeleton(), &pose);
        let found = model.positions[Joint::LeftShank.index()];
        assert!((found - knee).length() < 2e-5, "{phase}: {found}");
    }
    // The hull's points in the rest pose of its joint, 9 cm to the left of the pelvis.
    let rest = ModelPose::new(&avatar.skeleton(), &edgegait_core::pose::Pose::REST);
    let expected = [[0.09, -0.42, 0.06], [0.14, 0.005, 0.0], [0.04, 0.005, 0.0]];
    let body = UnpackedBody::new(&avatar);
    let figure = Figure::new(&body, &rest);
    assert_eq!(figure.len(), expected.len());
    for (found, expected) in figure.points().zip(expected) {
        assert!((found - Vec3::from(expected)).length() < 1e-6, "{found}");
    }
}

#[test]
fn the_documented_recognizer_scores_as_by_hand() {
    let bytes = documented("## A recognizer by hand");
    assert_eq!(bytes.len(), 3_035);
    let recognizer = LinearRecognizer::parse(&bytes).expect("the documented recognizer");
    assert_eq!(recognizer.classes(), 2);
    assert_eq!(recognizer.size(), Size::S50x30);
    assert_eq!(recognizer.framing(), Framing::Height);
    let names = [0, 1, 2].map(|class| recognizer.name(class));
    assert_eq!(names, [Some("A"), Some("BC"), None]);
    let mut pixels = [0; 1_500];
    (pixels[0], pixels[1], pixels[1_499]) = (10, 20, 4);
    let scores = [0, 1, 2].map(|class| recognizer.score(class, &pixels));
    assert_eq!(scores, [Some(-21.0), Some(137.0), None]);
    assert_eq!(recognizer.classify(&pixels), Some((1, 137.0)));
}

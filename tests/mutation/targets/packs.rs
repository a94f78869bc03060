//! Packs and recognizers for firmware, with the core.

use super::target;
use crate::data::fixtures;
use crate::mutators::checksums;
use crate::run::{Outcome, Target};
use edgegait::Pack;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::pose::{ModelPose, Pose};
use glam::Vec3;
use std::fs;

const SHARES: [f64; 5] = [0.0, 0.37, 1.0, -2.5, 1e12];

pub fn targets() -> Vec<Target> {
    let golden = ["v1-loops.egp", "v1-take.egp"].map(|name| fixtures().join("golden").join(name));
    let packs = golden.map(|path| fs::read(path).expect("a pack")).to_vec();
    let recognizer = fs::read("no_std_core/tests/golden/spread.egr").expect("a recognizer");
    let any = checksums::pack_bytes;
    vec![
        target(
            "pack",
            120,
            packs,
            &[any, any, checksums::pack_section],
            &[],
            |bytes, _| read_pack(bytes),
        ),
        target(
            "recognizer",
            10,
            vec![recognizer],
            &[checksums::recognizer],
            &[],
            |bytes, _| read_recognizer(bytes),
        ),
    ]
}

/// Decodes all bodies and walks of a pack.
pub fn read_pack(bytes: &[u8]) -> Outcome {
    let pack = Pack::parse(bytes)?;
    for subject in pack.subjects() {
        let _ = format!("{} {:?}", subject.name, subject.sex);
    }
    let own = pack.subjects().map(|subject| subject.avatar);
    for number in own.chain(pack.walks().map(|walk| walk.avatar)) {
        let avatar = pack.avatar(number).expect("a checked avatar");
        let rest = ModelPose::new(&avatar.skeleton(), &Pose::REST);
        let body = UnpackedBody::new(&avatar);
        let figure = Figure::new(&body, &rest);
        assert!(figure.points().all(Vec3::is_finite), "a point of a body");
    }
    let mut buffer = vec![0.0; 63 * 60];
    for walk in pack.walks() {
        let clip = pack.clip(walk.clip).expect("a checked clip");
        for share in SHARES {
            is_pose(&clip.sample(share * clip.duration_s()));
        }
        if let Some(cycle) = clip.as_loop() {
            let expanded = cycle.expand(&mut buffer).expect("63 coefficients");
            is_pose(&expanded.pose(0.37));
        }
    }
    Ok(())
}

fn is_pose(pose: &Pose) {
    assert!(pose.root.is_finite(), "a root at {}", pose.root);
    for rotation in pose.rotations {
        assert!(
            (rotation.length() - 1.0).abs() < 1e-4,
            "a rotation of {rotation}"
        );
    }
}

fn read_recognizer(bytes: &[u8]) -> Outcome {
    let linear = LinearRecognizer::parse(bytes).map_err(|error| error.to_string())?;
    let pixels = vec![137; linear.size().rows() * linear.size().columns()];
    for class in 0..linear.classes() {
        let _ = linear.name(class);
        let score = linear.score(class, &pixels).expect("a checked class");
        // Huge scales give infinite scores.
        assert!(!score.is_nan(), "a score");
    }
    Ok(())
}

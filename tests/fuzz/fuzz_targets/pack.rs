//! Fuzzing packs: any bytes are an error, or a pack whose poses are all valid.
//!
//! Length and checksum are corrected first, as hardly any input would pass them otherwise.

#![no_main]

use edgegait_core::body::{UnpackedBody, Figure};
use edgegait_core::format::{CRC_AT, HEADER_BYTES, LENGTH_AT, MAGIC, crc32};
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use libfuzzer_sys::fuzz_target;

const SHARES: [f64; 5] = [0.0, 0.37, 1.0, -2.5, 1e12];

fuzz_target!(|data: &[u8]| {
    let mut bytes = data.to_vec();
    if bytes.len() >= HEADER_BYTES {
        bytes[..MAGIC.len()].copy_from_slice(&MAGIC);
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[LENGTH_AT..LENGTH_AT + 4].copy_from_slice(&length);
        let crc = crc32(&bytes[HEADER_BYTES..]).to_le_bytes();
        bytes[CRC_AT..CRC_AT + 4].copy_from_slice(&crc);
    }
    let Ok(pack) = Pack::parse(&bytes) else {
        return;
    };
    let own = pack.subjects().map(|subject| subject.avatar);
    for number in own.chain(pack.walks().map(|walk| walk.avatar)) {
        let avatar = pack.avatar(number).expect("a checked avatar");
        let rest = ModelPose::new(&avatar.skeleton(), &Pose::REST);
        let body = UnpackedBody::new(&avatar);
        let figure = Figure::new(&body, &rest);
        assert!(figure.points().all(|point| point.is_finite()));
    }
    let mut buffer = vec![0.0; 63 * 60];
    for walk in pack.walks() {
        let clip = pack.clip(walk.clip).expect("a checked clip");
        for share in SHARES {
            is_pose(&clip.sample(share * clip.duration_s()));
        }
        if let Some(cycle) = clip.as_loop() {
            let expanded = cycle.expand(&mut buffer).expect("63 coefficients");
            assert_eq!(expanded.pose(0.37), cycle.pose(0.37));
        }
    }
});

fn is_pose(pose: &Pose) {
    assert!(pose.root.is_finite(), "{}", pose.root);
    for rotation in pose.rotations {
        assert!((rotation.length() - 1.0).abs() < 1e-4, "{rotation}");
    }
}

//! Packs of released versions decode to the same poses, bit for bit, forever; with changed bytes,
//! they are rejected or decode to some pose.
//!
//! `UPDATE_GOLDEN=1 cargo test --test encoding golden` regenerates the packs of the current version
//! and their poses, which is allowed only until that version is released.

use edgegait::encode::encode_subjects;
use edgegait::people::cohort::{self, CohortOptions};
use edgegait::people::{Cycle, Subject, Track, UncutMotion};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::clip::Clip;
use edgegait_core::format::crc32;
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::skeleton::JOINTS;
use glam::{DQuat, DVec3, Vec3};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Five people with a walk and a run each, as closed cycles with mean walks; and one of them who
/// starts to walk and turns, as an uncut motion.
const PACKS: [&str; 2] = ["v1-loops", "v1-take"];
/// The times at which poses are stored, as shares of a clip's duration.
const MOMENTS: [f64; 5] = [0.0, 0.125, 0.5, 0.71, 1.0];

fn path(name: &str, extension: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden");
    folder.join(format!("{name}.{extension}"))
}

fn people() -> Vec<Subject> {
    let options = CohortOptions {
        people: 5,
        speeds_kmh: vec![5.0, 10.0],
        ..CohortOptions::default()
    };
    cohort::subjects(&options).expect("five people")
}

/// Returns four seconds of a cycle that starts from standing and turns by 200 degrees.
fn set_off(cycle: &Cycle) -> UncutMotion {
    const RATE_HZ: f64 = 60.0;
    let frames = cycle.root.len();
    let (mut phase, mut heading, mut at) = (0.0f64, 0.0f64, DVec3::ZERO);
    let mut span = UncutMotion {
        sample_rate_hz: RATE_HZ,
        roots: Vec::new(),
        rotations: Vec::new(),
    };
    for frame in 0..240 {
        let along = f64::from(frame) / 240.0;
        let speed = (2.0 * along).min(1.0);
        let from = phase.rem_euclid(1.0) * frames as f64;
        let (low, part) = (from as usize % frames, from.fract());
        let high = (low + 1) % frames;
        let look = DQuat::from_rotation_y(heading);
        let sway = cycle.root[low].lerp(cycle.root[high], part);
        span.roots.push(at + look * sway);
        let mut pose: [DQuat; JOINTS] = std::array::from_fn(|joint| {
            cycle.rotations[low][joint].slerp(cycle.rotations[high][joint], part)
        });
        pose[0] = look * pose[0];
        span.rotations.push(pose);
        phase += speed / (cycle.period_s * RATE_HZ);
        at += look * DVec3::Z * (speed * cycle.drift_m / (cycle.period_s * RATE_HZ));
        heading += (200f64.to_radians() / 240.0) * 2.0 * along;
    }
    span
}

fn make(name: &str) -> Vec<u8> {
    let mut people = people();
    if name == "v1-take" {
        people.truncate(1);
        people[0].walks.truncate(1);
        let walk = &mut people[0].walks[0];
        walk.name = "set-off".into();
        if let Track::Loop(cycle) = &walk.motion {
            walk.motion = Track::Uncut(set_off(cycle));
        }
    }
    encode_subjects(&people, 5.0, &|| Ok(())).expect("a pack")
}

/// Formats a line for each body (joint offsets, and the corners of the box around its hulls at
/// rest), then one for each clip and moment (root and rotations), with digits that reproduce the
/// floats.
fn poses(pack: &Pack<'_>) -> String {
    let mut text = String::from("body,19 offsets (x, y, z) and two corners\n");
    for index in 0..pack.avatar_count() {
        let avatar = pack.avatar(index).expect("an avatar");
        let skeleton = avatar.skeleton();
        let body = UnpackedBody::new(&avatar);
        let figure = Figure::new(&body, &ModelPose::new(&skeleton, &Pose::REST));
        let corners = [
            figure.points().fold(Vec3::MAX, Vec3::min),
            figure.points().fold(Vec3::MIN, Vec3::max),
        ];
        let _ = write!(text, "{index}");
        for number in skeleton
            .offsets
            .iter()
            .chain(&corners)
            .flat_map(Vec3::to_array)
        {
            let _ = write!(text, ",{number:?}");
        }
        text.push('\n');
    }
    text.push_str("clip,share,root and 19 rotations (x, y, z, w)\n");
    for index in 0..pack.clip_count() {
        let clip = pack.clip(index).expect("a clip");
        for share in MOMENTS {
            let pose: Pose = clip.sample(share * clip.duration_s());
            let _ = write!(text, "{index},{share}");
            let rotations = pose.rotations.iter().flat_map(glam::Quat::to_array);
            for number in pose.root.to_array().into_iter().chain(rotations) {
                let _ = write!(text, ",{number:?}");
            }
            text.push('\n');
        }
    }
    text
}

#[test]
fn golden_packs_decode_to_the_same_poses() {
    for name in PACKS {
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            let bytes = make(name);
            let text = poses(&Pack::parse(&bytes).expect("our own pack"));
            fs::create_dir_all(path(name, "egp").parent().expect("a folder")).expect("a folder");
            fs::write(path(name, "egp"), &bytes).expect("the pack");
            fs::write(path(name, "csv"), text).expect("its poses");
        }
        let bytes = fs::read(path(name, "egp")).expect("the golden pack");
        let expected = fs::read_to_string(path(name, "csv")).expect("its poses");
        let pack = Pack::parse(&bytes).expect("a pack of a released version");
        let found = poses(&pack);
        assert!(name == "v1-take" || pack.codebook().template_count() > 0);
        for (found, expected) in found.lines().zip(expected.lines()) {
            assert_eq!(found, expected, "{name}");
        }
        assert_eq!(found.lines().count(), expected.lines().count());
    }
}

/// Corrects length and checksum after a change.
fn fix(bytes: &mut [u8]) {
    if bytes.len() >= 16 {
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        let crc = crc32(&bytes[16..]).to_le_bytes();
        bytes[12..16].copy_from_slice(&crc);
    }
}

/// Reads everything in a pack, and returns whether it is valid.
fn reads(bytes: &[u8]) -> bool {
    let Ok(pack) = Pack::parse(bytes) else {
        return false;
    };
    for subject in pack.subjects() {
        let avatar = pack.avatar(subject.avatar).expect("a checked avatar");
        assert!(avatar.hulls().count() <= 32);
    }
    for walk in pack.walks() {
        let clip: Clip<'_> = pack.clip(walk.clip).expect("a checked clip");
        for share in [0.3, 1.7] {
            let pose = clip.sample(share * clip.duration_s());
            assert!(pose.root.is_finite());
            for rotation in pose.rotations {
                assert!((rotation.length() - 1.0).abs() < 1e-4, "{rotation}");
            }
        }
    }
    true
}

#[test]
fn every_truncation_of_a_golden_pack_is_refused() {
    for name in PACKS {
        let bytes = fs::read(path(name, "egp")).expect("the golden pack");
        for length in 0..bytes.len() {
            assert!(!reads(&bytes[..length]), "{name}: {length} bytes");
            let mut cut = bytes[..length].to_vec();
            fix(&mut cut);
            assert!(!reads(&cut), "{name}: {length} bytes with a true checksum");
        }
    }
}

#[test]
fn ten_thousand_flipped_bits_of_each_golden_pack_are_noticed_or_decode() {
    let mut random = ChaCha8Rng::seed_from_u64(20);
    for name in PACKS {
        let bytes = fs::read(path(name, "egp")).expect("the golden pack");
        let mut decoded = 0;
        for _ in 0..10_000 {
            let bit = random.random_range(0..8 * bytes.len());
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(Pack::parse(&flipped).is_err(), "{name}: bit {bit}");
            fix(&mut flipped);
            decoded += usize::from(reads(&flipped));
        }
        // Most of the bytes are numbers, which may have any value.
        println!("{name}: {decoded} of 10,000 decode");
        assert!((2_000..10_000).contains(&decoded), "{name}: {decoded}");
    }
}

//! Encoding and decoding of uncut motions.

use super::uncut_oracle::Oracle;
use crate::data::{fixtures, given};
use edgegait::encode::{EncodedClip, encode_uncut};
use edgegait::people::cohort::Person;
use edgegait::people::recorded::{BodyOptions, Keep, ReadOptions, Recording, subjects};
use edgegait::people::{Cycle, Track, UncutMotion};
use edgegait_core::clip::Clip;
use edgegait_core::codebook::Codebook;
use edgegait_core::format::{CODEBOOK_BYTES, STEPS_AT};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{DQuat, DVec3};
use std::f64::consts::PI;
use std::path::Path;

/// Returns a codebook without references, bases and groups; steps get coarser from the hips to the
/// hands and feet.
fn codebook() -> Vec<u8> {
    let mut bytes = vec![0; CODEBOOK_BYTES + 45];
    for joint in Joint::ALL {
        let offset = match joint {
            Joint::Pelvis | Joint::LeftThigh | Joint::RightThigh => 0,
            Joint::LeftShank | Joint::RightShank => 0,
            Joint::LeftHand | Joint::RightHand | Joint::Head => 24,
            Joint::LeftFoot | Joint::RightFoot => 24,
            _ => 5,
        };
        bytes[STEPS_AT + 3 * joint.index()..][..3].fill(offset);
    }
    bytes
}

fn walker() -> (Cycle, Skeleton) {
    let person = Person::average(Sex::Female);
    let skeleton = Skeleton {
        offsets: person.body.offsets.map(DVec3::as_vec3),
    };
    (person.cycle(5.0), skeleton)
}

/// Returns a walk of some seconds whose heading (radians) and share of full stride depend on time.
fn walk(
    cycle: &Cycle,
    seconds: f64,
    rate: f64,
    heading: impl Fn(f64) -> f64,
    share: impl Fn(f64) -> f64,
) -> UncutMotion {
    let (mut at, mut phase) = (DVec3::ZERO, 0.0);
    let (mut roots, mut rotations) = (Vec::new(), Vec::new());
    for frame in 0..(seconds * rate) as usize {
        let time = frame as f64 / rate;
        let (look, share) = (DQuat::from_rotation_y(heading(time)), share(time));
        let count = cycle.root.len();
        let place = phase * count as f64;
        let (before, part) = (place as usize % count, place.fract());
        let after = (before + 1) % count;
        let mut pose: [DQuat; JOINTS] = std::array::from_fn(|joint| {
            let (a, b) = (
                cycle.rotations[before][joint],
                cycle.rotations[after][joint],
            );
            DQuat::IDENTITY.slerp(a.slerp(b, part), share).normalize()
        });
        pose[0] = (look * pose[0]).normalize();
        let sway = cycle.root[before].lerp(cycle.root[after], part);
        roots.push(at + look * DVec3::new(sway.x * share, sway.y, sway.z * share));
        rotations.push(pose);
        at += look * DVec3::Z * (share * cycle.drift_m / cycle.period_s / rate);
        phase = (phase + share / (cycle.period_s * rate)).fract();
    }
    UncutMotion {
        sample_rate_hz: rate,
        roots,
        rotations,
    }
}

/// Encodes a motion, and checks the stated error with the second decoder.
fn encoded(span: &UncutMotion, skeleton: &Skeleton, asked_mm: f64) -> EncodedClip {
    let codebook = codebook();
    let parsed = Codebook::parse(&codebook).unwrap();
    let encoded = encode_uncut(span, skeleton, &parsed, asked_mm).unwrap();
    assert!(encoded.max_error_mm <= asked_mm, "{}", encoded.max_error_mm);
    let oracle = Oracle::new(&encoded.bytes, &codebook);
    let found = oracle.max_error_mm(span, skeleton);
    // The core decodes in f32, which is within 0.01 mm for some hundred metres.
    assert!((found - encoded.max_error_mm).abs() < 0.01, "{found}");
    let clip = Clip::parse(&encoded.bytes, &parsed).unwrap();
    assert!(f64::from(clip.max_error_mm()) >= encoded.max_error_mm - 1e-4);
    assert_eq!(clip.frames() as usize, span.roots.len());
    let last_s = (span.roots.len() - 1) as f64 / span.sample_rate_hz;
    assert!((clip.duration_s() - last_s).abs() < 1e-6);
    encoded
}

#[test]
fn a_walk_that_turns_by_400_degrees_keeps_every_error() {
    let (cycle, skeleton) = walker();
    // Straight for a second, 400 degrees in three, straight again.
    let turn = |time: f64| (400.0 / 180.0 * PI) * ((time - 1.0) / 3.0).clamp(0.0, 1.0);
    let span = walk(&cycle, 5.0, 100.0, turn, |_| 1.0);
    let bytes = [1.0, 5.0, 10.0].map(|asked| encoded(&span, &skeleton, asked).bytes.len());
    // At most 600 bytes a second at 5 mm; a smaller error takes more.
    assert!(bytes[0] > bytes[1] && bytes[1] > bytes[2], "{bytes:?}");
    assert!(bytes[1] < 5 * 600, "{bytes:?}");
}

#[test]
fn a_walk_begins() {
    let (cycle, skeleton) = walker();
    let start = |time: f64| ((time - 0.5) / 1.5).clamp(0.0, 1.0);
    let span = walk(&cycle, 3.0, 120.0, |_| 0.0, start);
    for asked in [1.0, 5.0, 10.0] {
        encoded(&span, &skeleton, asked);
    }
}

#[test]
fn a_standing_person_takes_a_few_bytes_a_channel() {
    let (cycle, skeleton) = walker();
    let still = walk(&cycle, 60.0, 100.0, |_| 0.3, |_| 0.0);
    let bytes = encoded(&still, &skeleton, 1.0).bytes.len();
    assert!(bytes < 3 * 61, "{bytes}");
    let frame = walk(&cycle, 0.01, 100.0, |_| 0.3, |_| 1.0);
    assert_eq!(frame.roots.len(), 1);
    let bytes = encoded(&frame, &skeleton, 1.0).bytes.len();
    assert!(bytes < 3 * 61, "{bytes}");
}

#[test]
fn ten_minutes_of_circles_are_a_minute_ten_times() {
    let (cycle, skeleton) = walker();
    let minutes = |count: f64| {
        let span = walk(&cycle, 60.0 * count, 30.0, |time| 0.5 * time, |_| 1.0);
        encoded(&span, &skeleton, 5.0).bytes.len()
    };
    let (one, ten) = (minutes(1.0), minutes(10.0));
    // The search uses all of one minute, but only the liveliest part of ten: measured 17 % more
    // bytes.
    assert!(ten < 12 * one, "{one} {ten}");
}

#[test]
fn an_error_that_cannot_be_met_is_stated() {
    let (cycle, skeleton) = walker();
    let span = walk(&cycle, 0.5, 100.0, |_| 0.0, |_| 1.0);
    let codebook = codebook();
    let parsed = Codebook::parse(&codebook).unwrap();
    let finest = encode_uncut(&span, &skeleton, &parsed, 0.0).unwrap();
    assert!(finest.max_error_mm > 0.0 && finest.max_error_mm < 0.02);
    let found = Oracle::new(&finest.bytes, &codebook).max_error_mm(&span, &skeleton);
    assert!((found - finest.max_error_mm).abs() < 0.01, "{found}");
}

#[test]
fn quaternions_of_either_sign_are_the_same_motion() {
    let (cycle, skeleton) = walker();
    let span = walk(&cycle, 1.0, 100.0, |time| 3.0 + time, |_| 1.0);
    let mut flipped = span.clone();
    for (frame, pose) in flipped.rotations.iter_mut().enumerate() {
        for (joint, rotation) in pose.iter_mut().enumerate() {
            if (frame + joint) % 3 == 0 {
                *rotation = -*rotation;
            }
        }
    }
    let (a, b) = (
        encoded(&span, &skeleton, 5.0),
        encoded(&flipped, &skeleton, 5.0),
    );
    assert_eq!(a.bytes, b.bytes);
}

#[test]
fn invalid_motions_are_refused_with_a_reason() {
    let (cycle, skeleton) = walker();
    let span = walk(&cycle, 0.1, 100.0, |_| 0.0, |_| 1.0);
    let codebook = codebook();
    let parsed = Codebook::parse(&codebook).unwrap();
    let refusal = |change: &dyn Fn(&mut UncutMotion)| {
        let mut span = span.clone();
        change(&mut span);
        let error = encode_uncut(&span, &skeleton, &parsed, 5.0).unwrap_err();
        error.to_string()
    };
    let empty = refusal(&|span| (span.roots, span.rotations) = (Vec::new(), Vec::new()));
    assert!(empty.contains("at least one"), "{empty}");
    let uneven = refusal(&|span| span.roots.truncate(9));
    assert!(uneven.contains("9 root positions and 10 poses"), "{uneven}");
    for rate in [0.5, 10_001.0, f64::NAN] {
        let wrong = refusal(&|span| span.sample_rate_hz = rate);
        assert!(wrong.contains("expected 1 to 10,000"), "{wrong}");
    }
    let lost = refusal(&|span| span.roots[3].x = f64::NAN);
    assert!(lost.contains("frame 3"), "{lost}");
    let stretched = refusal(&|span| span.rotations[4][7] = DQuat::from_xyzw(1.0, 1.0, 0.0, 0.0));
    assert!(stretched.contains("frame 4"), "{stretched}");
    let far = refusal(&|span| span.roots[3].x = 1e300);
    assert!(far.contains("further than the format holds"), "{far}");
}

/// Encodes each of these clips uncut and checks its error.
fn check_recorded_takes(data: &Path, files: &[&str]) {
    let folder = data.join("mocap/clips");
    let options = ReadOptions {
        keep: Keep::Uncut,
        ..ReadOptions::default()
    };
    for file in files {
        let recording = Recording::read(&folder.join(file), &options).unwrap();
        let people = subjects(&[recording], &BodyOptions::default()).unwrap();
        let Track::Uncut(span) = &people[0].walks[0].motion else {
            panic!("{file} is not kept as a take");
        };
        let skeleton = Skeleton {
            offsets: people[0].body.offsets.map(DVec3::as_vec3),
        };
        for asked in [1.0, 5.0, 10.0] {
            let encoded = encoded(span, &skeleton, asked);
            let seconds = span.roots.len() as f64 / span.sample_rate_hz;
            let rate = encoded.bytes.len() as f64 / seconds;
            eprintln!(
                "{file}: {asked} mm: {} bytes, {rate:.0} B/s",
                encoded.bytes.len()
            );
        }
    }
}

#[test]
fn recorded_takes_keep_every_error() {
    let files = ["cmu_amc/s02/02_01.amc", "cmu_amc/s07/07_01.amc"];
    check_recorded_takes(&fixtures(), &files);
}

mod with_data {
    use super::*;

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn recorded_takes_keep_every_error() {
        let files = [
            "cmu_amc/s02/02_01.amc",
            "cmu_amc/s07/07_01.amc",
            "cmu_bvh/s131/131_01.bvh",
            "pymo/AV_Meredith/8Walk_HVHA.bvh",
        ];
        check_recorded_takes(&given(), &files);
    }
}

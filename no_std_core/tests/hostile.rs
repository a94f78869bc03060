//! Damaged and forged packs: an error or a decode, never a panic.
#![cfg(feature = "skia")]

mod random;
mod small_pack;

use edgegait_core::avatar::{Avatar, PosedHulls};
use edgegait_core::camera::{Camera, Viewpoint};
use edgegait_core::clip::Clip;
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{Rasterizer, Renderer};
use random::Random;
use small_pack::{fix_header, small_pack};

const SKIA: [Rasterizer; 2] = [Rasterizer::Skia, Rasterizer::SkiaAa];

const PHASES: [f32; 10] = [
    0.0,
    0.37,
    1.0,
    -0.2,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN_POSITIVE,
    -1e30,
];

/// Draws with both rasterisers, from one of four viewpoints in turn.
struct Viewer {
    renderers: [Renderer; 2],
    cameras: [Camera; 4],
    turn: usize,
}

impl Viewer {
    fn new() -> Self {
        let angles = [(90.0, 0.0), (0.0, 90.0), (33.3, 47.7), (-720.5, -90.0)];
        Self {
            renderers: SKIA.map(Renderer::new),
            cameras: angles.map(|(azimuth, elevation)| {
                let viewpoint = Viewpoint::from_degrees(azimuth, elevation);
                Camera::orthographic(viewpoint.expect("a viewpoint"))
            }),
            turn: 0,
        }
    }

    /// Draws the figure once; whether it has an image.
    fn look(&mut self, figure: &PosedHulls) -> bool {
        self.turn += 1;
        let renderer = &mut self.renderers[self.turn % 2];
        let drawn = renderer.draw(figure, &self.cameras[self.turn / 2 % 4]);
        drawn.is_ok_and(|drawing| {
            assert!((0.0..=1.0).contains(&drawing.clipped_share));
            true
        })
    }

    /// Reads everything that the bytes hold, if they are a pack; whether they are.
    fn read(&mut self, bytes: &[u8]) -> bool {
        let Ok(pack) = Pack::parse(bytes) else {
            return false;
        };
        assert_eq!(pack.len_bytes(), bytes.len());
        for subject in pack.subjects() {
            assert!(pack.avatar(subject.avatar).is_some());
        }
        for walk in pack.walks() {
            let subject = pack.subject(walk.subject).expect("a checked subject");
            let avatar = pack.avatar(subject.avatar).expect("a checked avatar");
            let clip = pack.clip(walk.clip).expect("a checked clip");
            self.walk(&avatar, &clip);
        }
        true
    }

    fn walk(&mut self, avatar: &Avatar<'_>, clip: &Clip<'_>) {
        assert!(clip.period_s() > 0.0);
        for phase in PHASES {
            let pose = clip.pose(phase);
            assert_is_pose(&pose);
            if phase == 0.37 {
                let model = ModelPose::new(&avatar.skeleton(), &pose);
                self.look(&PosedHulls::new(avatar, &model));
            }
        }
    }
}

fn assert_is_pose(pose: &Pose) {
    assert!(pose.root.is_finite(), "{}", pose.root);
    for rotation in pose.rotations {
        assert!((rotation.length() - 1.0).abs() < 1e-4, "{rotation}");
    }
}

#[test]
fn the_pack_made_by_hand_is_read_and_drawn() {
    let bytes = small_pack();
    let pack = Pack::parse(&bytes).expect("a whole pack");
    assert_eq!(
        pack.subjects().map(|s| s.name).collect::<Vec<_>>(),
        ["Ann", "Bob"]
    );
    let walks: Vec<_> = pack.walks().map(|w| (w.name, w.subject, w.cycle)).collect();
    assert_eq!(walks, [("slow", 0, 0), ("fast", 0, 0), ("slow", 1, 3)]);
    let mut viewer = Viewer::new();
    assert!(viewer.read(&bytes));
    for walk in pack.walks() {
        let avatar = pack.avatar(walk.subject).expect("a body");
        let pose = pack.clip(walk.clip).expect("a clip").pose(0.1);
        let model = ModelPose::new(&avatar.skeleton(), &pose);
        for _ in 0..8 {
            assert!(viewer.look(&PosedHulls::new(&avatar, &model)));
        }
    }
}

#[test]
fn every_truncation_is_refused_with_a_byte_within_the_file() {
    let bytes = small_pack();
    for length in 0..bytes.len() {
        let error = Pack::parse(&bytes[..length]).expect_err("a truncated pack");
        assert!(error.byte <= length, "{length}: {error}");
        // With a true length and checksum, the sections themselves fall short.
        let mut cut = bytes[..length].to_vec();
        fix_header(&mut cut);
        let error = Pack::parse(&cut).expect_err("a truncated pack");
        assert!(error.byte <= length, "{length}: {error}");
    }
}

#[test]
fn a_flipped_bit_is_noticed() {
    // A CRC-32 notices every single flip, and the fields before it are all checked.
    let bytes = small_pack();
    for bit in 0..8 * bytes.len() {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(Pack::parse(&flipped).is_err(), "bit {bit}");
    }
}

#[test]
fn forged_packs_with_true_checksums_are_refused_or_decoded() {
    let bytes = small_pack();
    let mut viewer = Viewer::new();
    let mut random = Random(11);
    let mut accepted = 0;
    const FORGERIES: usize = 12_000;
    for _ in 0..FORGERIES {
        let mut forged = bytes.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(forged.len());
            match random.below(6) {
                0..=3 => forged[at] ^= 1 << random.below(8),
                4 => forged[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5)],
                _ => {
                    let from = random.below(forged.len());
                    let length = random.below(16).min(forged.len() - at.max(from));
                    forged.copy_within(from..from + length, at);
                }
            }
        }
        fix_header(&mut forged);
        accepted += usize::from(viewer.read(&forged));
    }
    // Most of a pack is coefficients and points, which may be anything.
    assert!((FORGERIES / 4..FORGERIES).contains(&accepted), "{accepted}");
}

#[test]
fn random_bytes_are_no_clips_or_decode() {
    let mut random = Random(12);
    let body = small_pack();
    let avatar = Pack::parse(&body)
        .expect("a pack")
        .avatar(0)
        .expect("a body");
    let mut viewer = Viewer::new();
    let mut accepted = 0;
    for _ in 0..2_000 {
        // The header is right, so that all of the stream is walked; it is then cut
        // where the walk ended, so that it is accepted.
        let mut bytes = vec![0; 16 + 6_000];
        for byte in &mut bytes[16..] {
            *byte = random.bits() as u8;
        }
        bytes[..6].copy_from_slice(&[1, 0, 0xff, 0xff, 0xff, 0xff]);
        bytes[14..16].copy_from_slice(&6_000u16.to_le_bytes());
        assert!(
            Clip::parse(&bytes).is_err(),
            "a stream with bytes behind it"
        );
        let Some(bits) = stream_bits(&bytes[16..]) else {
            continue;
        };
        let used = bits.div_ceil(8);
        bytes.truncate(16 + used);
        if !bits.is_multiple_of(8) {
            bytes[14..16].copy_from_slice(&(used as u16).to_le_bytes());
            bytes[15 + used] |= 1 << (bits % 8);
            assert!(
                Clip::parse(&bytes).is_err(),
                "a stream with bits behind its last channel"
            );
            bytes[15 + used] &= (1 << (bits % 8)) - 1;
        }
        bytes[14..16].copy_from_slice(&(used as u16).to_le_bytes());
        let clip = Clip::parse(&bytes).expect("a clip of random coefficients");
        viewer.walk(&avatar, &clip);
        accepted += 1;
    }
    assert!(accepted > 1_500, "{accepted}");
}

/// Bits of the 60 channels at the start of `stream`, if they are all there.
fn stream_bits(stream: &[u8]) -> Option<usize> {
    let mut at = 0;
    let mut read = |width: usize| {
        let value = (0..width).map(|bit| {
            let bit_at = at + bit;
            let byte = stream.get(bit_at / 8).copied().unwrap_or(0);
            usize::from(byte >> (bit_at % 8) & 1) << bit
        });
        let value = value.sum::<usize>();
        at += width;
        value
    };
    for vector in 0..20 {
        if vector < 19 {
            // Two bits and three components.
            for width in [2, 15, 15, 15] {
                read(width);
            }
        }
        for _ in 0..3 {
            let mut left = read(6);
            if left > 0 {
                read(6);
            }
            for band in [1, 2, 4, 8, 16, 32] {
                let length = left.min(band);
                if length > 0 {
                    let width = read(4);
                    for _ in 0..length {
                        read(width);
                    }
                }
                left -= length;
            }
        }
    }
    (at <= 8 * stream.len()).then_some(at)
}

#[test]
fn random_bytes_are_no_avatars_or_are_drawn() {
    let mut random = Random(13);
    let mut viewer = Viewer::new();
    let mut accepted = 0;
    for _ in 0..4_000 {
        let mut bytes = vec![0; 114 + random.below(200)];
        for byte in &mut bytes {
            *byte = random.bits() as u8;
        }
        // Mostly whole hulls of known joints, whatever their points are.
        let mut at = 114;
        while random.below(20) > 0 && at + 14 < bytes.len() {
            let points = (1 + random.below(6)).min((bytes.len() - at - 14) / 3);
            bytes[at] = random.below(19) as u8;
            bytes[at + 1] = points as u8;
            at += 14 + 3 * points;
        }
        bytes.truncate(at);
        let Ok(avatar) = Avatar::parse(&bytes) else {
            continue;
        };
        accepted += 1;
        let mut pose = Pose::REST;
        pose.root.y = random.between(-1e6, 1e6) as f32;
        let model = ModelPose::new(&avatar.skeleton(), &pose);
        viewer.look(&PosedHulls::new(&avatar, &model));
    }
    assert!((1_000..4_000).contains(&accepted), "{accepted}");
}

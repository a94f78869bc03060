//! Tests of damaged and forged packs: they are rejected or decoded, without a panic.

use crate::random::Random;
use crate::small_pack::{avatar, fix_header, small_pack, wild_clip};
use edgegait_core::avatar::Avatar;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::clip::{Clip, Loop};
use edgegait_core::codebook::Codebook;
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use glam::{Vec2, Vec3};

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

/// Draws with all rasterisers, each in another size, with one of five cameras and one of three
/// framings in turn.
struct Viewer {
    renderers: Vec<Renderer>,
    cameras: Vec<Camera>,
    turn: usize,
}

impl Viewer {
    fn new() -> Self {
        let viewpoint = |(azimuth, elevation)| {
            Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint")
        };
        let angles = [(90.0, 0.0), (0.0, 90.0), (33.3, 47.7), (-720.5, -90.0)];
        let mut cameras: Vec<Camera> = angles.map(viewpoint).map(Camera::orthographic).into();
        let near = Camera::perspective(viewpoint((200.0, 10.0)), Vec3::Y, 2.0);
        cameras.push(near.expect("a camera"));
        Self {
            renderers: Rasterizer::ALL
                .iter()
                .zip(Size::ALL.into_iter().cycle())
                .map(|(&rasterizer, size)| Renderer::new(rasterizer, size))
                .collect(),
            cameras,
            turn: 0,
        }
    }

    /// Draws the figure once, and returns whether it has an image.
    fn look(&mut self, figure: &Figure<'_>) -> bool {
        self.turn += 1;

        let camera = &self.cameras[self.turn % self.cameras.len()];
        let framing = match self.turn % 3 {
            0 => Framing::Height,
            1 => Framing::Box,
            _ => Framing::Fixed {
                centre: Vec3::Y,
                pixels_per_metre: 20.0,
            },
        };
        let drawn = self.renderers.iter_mut().map(|renderer| {
            let drawn = renderer.draw(figure, camera, framing, Vec2::splat(0.25));
            drawn.is_ok_and(|drawing| {
                assert!((0.0..=1.0).contains(&drawing.clipped_share));
                true
            })
        });
        // Every rasteriser draws, even if the first one fails.
        drawn.fold(true, |all, drawn| all & drawn)
    }

    /// Reads everything that the bytes hold if they are a pack, and returns whether they are.
    fn read(&mut self, bytes: &[u8]) -> bool {
        let Ok(pack) = Pack::parse(bytes) else {
            return false;
        };
        assert_eq!(pack.len_bytes(), bytes.len());
        for subject in pack.subjects() {
            assert!(pack.avatar(subject.avatar).is_some());
        }
        for walk in pack.walks() {
            assert!(pack.subject(walk.subject).is_some());
            let avatar = pack.avatar(walk.avatar).expect("a checked avatar");
            let clip = pack.clip(walk.clip).expect("a checked clip");
            self.walk(&avatar, &clip);
        }
        true
    }

    fn walk(&mut self, avatar: &Avatar<'_>, clip: &Clip<'_>) {
        assert!(clip.duration_s() >= 0.0);
        if let Some(cycle) = clip.as_loop() {
            assert_unpacked_poses_are_the_same(&cycle);
        }
        for phase in PHASES {
            let pose = clip.sample(f64::from(phase) * clip.duration_s());
            assert_is_pose(&pose);
            if phase == 0.37 {
                let model = ModelPose::new(&avatar.skeleton(), &pose);
                self.look(&Figure::new(&UnpackedBody::new(avatar), &model));
            }
        }
    }
}

fn assert_unpacked_poses_are_the_same(cycle: &Loop<'_>) {
    let mut buffer = vec![f32::NAN; cycle.expanded_len() + 7];
    let short = cycle.expanded_len().saturating_sub(1);
    assert_eq!(
        cycle.expand(&mut buffer[..short]).is_some(),
        short == cycle.expanded_len()
    );
    let expanded = cycle
        .expand(&mut buffer)
        .expect("a buffer that is long enough");
    for phase in PHASES {
        assert_eq!(expanded.pose(phase), cycle.pose(phase), "{phase}");
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
    let worn: Vec<_> = pack.walks().map(|walk| walk.avatar).collect();
    assert_eq!(worn, [0, 0, 0]);
    let mut viewer = Viewer::new();
    assert!(viewer.read(&bytes));
    for walk in pack.walks() {
        let avatar = pack.avatar(walk.avatar).expect("a body");
        let pose = pack.clip(walk.clip).expect("a clip").sample(0.1);
        let model = ModelPose::new(&avatar.skeleton(), &pose);
        let body = UnpackedBody::new(&avatar);
        for _ in 0..15 {
            assert!(viewer.look(&Figure::new(&body, &model)));
        }
    }
}

#[test]
fn every_truncation_is_refused_with_a_byte_within_the_file() {
    let bytes = small_pack();
    for length in 0..bytes.len() {
        let error = Pack::parse(&bytes[..length]).expect_err("a truncated pack");
        assert!(error.byte <= length, "{length}: {error}");
        // With a correct length and checksum, the sections themselves are too short.
        let mut cut = bytes[..length].to_vec();
        fix_header(&mut cut);
        let error = Pack::parse(&cut).expect_err("a truncated pack");
        assert!(error.byte <= length, "{length}: {error}");
    }
}

#[test]
fn a_damaged_byte_is_noticed() {
    // A CRC-32 detects any damage within 32 bits, and the fields before it are all checked.
    let mut bytes = small_pack();
    for at in 0..bytes.len() {
        let whole = bytes[at];
        for damage in 1..=u8::MAX {
            bytes[at] = whole ^ damage;
            assert!(Pack::parse(&bytes).is_err(), "byte {at}, {damage:#x}");
        }
        bytes[at] = whole;
    }
    assert!(Pack::parse(&bytes).is_ok());
}

#[test]
fn a_pack_that_is_opened_again_is_the_same_and_is_not_read_again() {
    let mut bytes = small_pack();
    let parsed = format!("{:?}", Pack::parse(&bytes).expect("a pack"));
    let again = Pack::reopen(&bytes).expect("the same pack");
    assert_eq!(format!("{again:?}"), parsed);
    // The last byte is one of a clip.
    *bytes.last_mut().expect("a byte") ^= 1;
    assert!(Pack::parse(&bytes).is_err());
    assert!(Pack::reopen(&bytes).is_ok());
    // Without all of its sections it cannot be opened.
    for length in 0..bytes.len() {
        assert!(Pack::reopen(&bytes[..length]).is_err(), "{length}");
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
fn the_wildest_numbers_decode_to_poses() {
    let mut random = Random(12);
    let body = small_pack();
    let avatar = Pack::parse(&body)
        .expect("a pack")
        .avatar(0)
        .expect("a body");
    let mut viewer = Viewer::new();
    for _ in 0..500 {
        let [code, templates, clip] = wild_clip(&mut random);
        let codebook = Codebook::parse(&code).expect("a codebook");
        let codebook = codebook.with_templates(&templates).expect("a template");
        let clip = Clip::parse(&clip, &codebook).expect("a clip");
        viewer.walk(&avatar, &clip);
    }
}

#[test]
fn random_streams_are_refused_without_harm() {
    let mut random = Random(14);
    let [code, templates, _] = wild_clip(&mut random);
    let codebook = Codebook::parse(&code).expect("a codebook");
    let codebook = codebook.with_templates(&templates).expect("a template");
    for _ in 0..2_000 {
        let mut bytes = vec![0; 19 + random.below(6_000)];
        for byte in &mut bytes[19..] {
            *byte = random.bits() as u8;
        }
        bytes[..7].copy_from_slice(&[1, 1, 0xff, 0xff, 0xff, 0xff, 0xff]);
        let error = Clip::parse(&bytes, &codebook).expect_err("a random stream");
        assert!(error.byte <= bytes.len(), "{error}");
    }
}

#[test]
fn random_bytes_are_no_avatars_or_are_drawn() {
    let mut random = Random(13);
    let mut viewer = Viewer::new();
    let mut look = |random: &mut Random, bytes: &[u8]| {
        let Ok(avatar) = Avatar::parse(bytes) else {
            return false;
        };
        let points: usize = avatar.hulls().map(|hull| hull.points().count()).sum();
        assert_eq!(points, avatar.hulls().map(|hull| hull.len()).sum());
        let mut pose = Pose::REST;
        pose.root.y = random.between(-1e6, 1e6) as f32;
        let model = ModelPose::new(&avatar.skeleton(), &pose);
        let body = UnpackedBody::new(&avatar);
        let figure = Figure::new(&body, &model);
        assert_eq!(figure.len(), points);
        viewer.look(&figure);
        true
    };
    // Whole avatars with a few bits flipped: most are points and offsets.
    const DAMAGED: usize = 4_000;
    let mut accepted = 0;
    for _ in 0..DAMAGED {
        let hulls = random.below(14);
        let mut bytes = avatar(&mut random, hulls);
        assert!(look(&mut random, &bytes));
        for _ in 0..=random.below(2) {
            let at = random.below(bytes.len());
            bytes[at] ^= 1 << random.below(8);
        }
        accepted += usize::from(look(&mut random, &bytes));
    }
    assert!((DAMAGED / 4..DAMAGED).contains(&accepted), "{accepted}");
    // Only random bits after a header with up to two hulls, cut everywhere and with 0 to 7 bits
    // left over.
    let mut accepted = 0;
    for _ in 0..1_000 {
        let mut bytes: Vec<u8> = (0..150).map(|_| random.bits() as u8).collect();
        bytes[4] = 0x40 * random.below(2) as u8 + random.below(3) as u8;
        for end in 5..bytes.len() {
            for padding in 0..8 {
                let mut cut = bytes[..=end].to_vec();
                cut[end] &= 0xff >> padding;
                accepted += usize::from(look(&mut random, &cut));
            }
        }
    }
    assert!(accepted > 500, "{accepted}");
}

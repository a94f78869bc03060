//! Tests that compact bodies, drawn hull by hull, give the same bytes as unpacked bodies: silhouettes,
//! shares, GEIs and errors.

use crate::plain_avatar;
use crate::random::Random;
use crate::small_pack;
use edgegait_core::avatar::Avatar;
use edgegait_core::body::{self, Figure, OverBudget};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::clip::Expanded;
use edgegait_core::compact::{self, Budget, CompactFigure, CompactRows, Room};
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
#[cfg(feature = "tiny-skia")]
use edgegait_core::raster::TinySkia;
use edgegait_core::raster::{DrawError, Rasterizer, Renderer, Skia, Window};
use edgegait_core::silhouette::{AnySilhouette, Silhouette, Size};
use edgegait_core::template::{BufferTooSmall, FrameError, GeiBuilder, GeiInPlace};
use glam::{Quat, Vec2, Vec3};

/// Room for every avatar.
type CompactBody = compact::CompactBody<768, 1536>;

fn loaded(avatar: &Avatar<'_>) -> CompactBody {
    let mut body = CompactBody::EMPTY;
    body.load(avatar).expect("within the budget");
    body
}

/// Straight ahead, sideways and above, where facets are seen edge-on and points coincide; slightly
/// off; and in between.
const VIEWS: [[f32; 2]; 9] = [
    [0.0, 0.0],
    [90.0, 0.0],
    [90.0, 90.0],
    [45.0, 90.0],
    [180.0, -90.0],
    [90.0001, 0.0],
    [0.0, 89.999],
    [37.0, 41.0],
    [301.0, -23.0],
];

fn random_pose(random: &mut Random) -> Pose {
    let mut pose = Pose::REST;
    let mut single = |low, high| random.between(low, high) as f32;
    pose.root = Vec3::new(single(-0.5, 0.5), single(0.7, 1.1), single(-0.5, 0.5));
    for rotation in &mut pose.rotations {
        let axis = Vec3::new(single(-1.0, 1.0), single(-1.0, 1.0), single(-1.0, 1.0));
        *rotation = Quat::from_scaled_axis(axis);
    }
    pose
}

fn cameras(random: &mut Random) -> Vec<Camera> {
    let viewpoint = |[azimuth, elevation]: [f32; 2]| {
        Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint")
    };
    let mut cameras: Vec<Camera> = VIEWS
        .iter()
        .map(|&view| Camera::orthographic(viewpoint(view)))
        .collect();
    for view in VIEWS {
        let aim = Vec3::new(0.0, random.between(0.5, 1.0) as f32, 0.1);
        let distance_m = random.between(0.5, 9.0) as f32;
        let camera = Camera::perspective(viewpoint(view).rolled(3.0), aim, distance_m);
        cameras.push(camera.expect("a camera"));
    }
    cameras
}

fn framings(random: &mut Random) -> [Framing; 4] {
    let fixed = |pixels_per_metre| Framing::Fixed {
        centre: Vec3::new(0.0, 0.8, 0.0),
        pixels_per_metre,
    };
    let near = fixed(random.between(20.0, 90.0) as f32);
    [Framing::Height, Framing::Box, near, fixed(2_000.0)]
}

/// Returns frame and share, or the error, as text, which compares NaN too.
fn told(drawn: Result<(AnySilhouette, f32), DrawError>) -> String {
    match drawn {
        Ok((AnySilhouette::Binary(silhouette), share)) => {
            format!("{:08x}\n{silhouette}", share.to_bits())
        }
        Ok((grey, share)) => format!("{:08x}\n{grey:?}", share.to_bits()),
        Err(error) => format!("{error:?}"),
    }
}

/// Draws random bodies in random poses both ways, and returns how many images were drawn and how
/// many rejected.
fn compare<W, I: Copy>(
    rasterizer: Rasterizer,
    window: impl Fn(Size) -> W,
    frame: impl Fn(I) -> AnySilhouette,
) -> [usize; 2]
where
    W: for<'a> Window<CompactFigure<'a>, Image = I>,
{
    let mut random = Random(11);
    let (mut drawn, mut refused) = (0, 0);
    for round in 0..12 {
        let bytes = small_pack::avatar(&mut random, 4 + round);
        let avatar = Avatar::parse(&bytes).expect("an avatar");
        let (whole, small) = (body::UnpackedBody::new(&avatar), loaded(&avatar));
        let pose = ModelPose::new(&avatar.skeleton(), &random_pose(&mut random));
        let figure = Figure::new(&whole, &pose);
        let size = Size::ALL[round % 3];
        let mut renderer = Renderer::new(rasterizer, size);
        let mut compact = Renderer::with_window(window(size));
        for camera in cameras(&mut random) {
            for framing in framings(&mut random) {
                let jitter = Vec2::new(random.between(-0.5, 0.5) as f32, 0.25);
                let jitter = if round % 2 == 0 { Vec2::ZERO } else { jitter };
                let expected = renderer.draw(&figure, &camera, framing, jitter);
                let expected = expected.map(|d| (*d.frame, d.clipped_share));
                let found = compact.draw(&small.posed(&pose), &camera, framing, jitter);
                let found = found.map(|d| (frame(*d.frame), d.clipped_share));
                let count = if found.is_ok() {
                    &mut drawn
                } else {
                    &mut refused
                };
                *count += 1;
                assert_eq!(
                    told(found),
                    told(expected),
                    "{round} {camera:?} {framing:?}"
                );
            }
        }
    }
    [drawn, refused]
}

fn assert_many([drawn, refused]: [usize; 2]) {
    assert!(
        drawn > 500 && refused > 4,
        "{drawn} drawn, {refused} refused"
    );
}

#[test]
fn rows_are_the_same_bits() {
    assert_many(compare(
        Rasterizer::Rows,
        CompactRows::new,
        AnySilhouette::Binary,
    ));
}

#[test]
fn skia_draws_the_same_bits() {
    assert_many(compare(Rasterizer::Skia, Skia::new, AnySilhouette::Binary));
}

#[cfg(feature = "tiny-skia")]
#[test]
fn tiny_skia_draws_the_same_bits() {
    let binary = AnySilhouette::Binary;
    assert_many(compare(Rasterizer::Skia, TinySkia::new, binary));
    assert_many(compare(
        Rasterizer::SkiaAa,
        TinySkia::anti_aliased,
        AnySilhouette::Grey,
    ));
}

#[test]
fn a_gei_in_a_buffer_is_the_gei() {
    let bytes = small_pack::small_pack();
    let pack = Pack::parse(&bytes).expect("a pack");
    let camera = Camera::orthographic(Viewpoint::from_degrees(72.0, 15.0).expect("a viewpoint"));
    for walk in pack.walks() {
        let avatar = pack.avatar(walk.avatar).expect("an avatar");
        let cycle = pack.clip(walk.clip).and_then(|clip| clip.as_loop());
        let cycle = cycle.expect("a loop");
        let skeleton = avatar.skeleton();
        let (whole, small) = (body::UnpackedBody::new(&avatar), loaded(&avatar));
        let mut renderer = Renderer::new(Rasterizer::Rows, Size::S64x44);
        let mut compact = Renderer::with_window(CompactRows::new(Size::S64x44));
        let mut expected = GeiBuilder::new(Size::S64x44);
        let mut buffer = [7; 3_000];
        let mut gei = GeiInPlace::new(Size::S64x44, &mut buffer).expect("room");
        for frame in 0..23u8 {
            let pose = ModelPose::new(&skeleton, &cycle.pose(f32::from(frame) / 23.0));
            let figure = Figure::new(&whole, &pose);
            let drawing = renderer.draw(&figure, &camera, Framing::Height, Vec2::ZERO);
            let frame = drawing.expect("a figure").frame;
            expected.add(frame).expect("room");
            let posed = small.posed(&pose);
            let drawing = compact.draw(&posed, &camera, Framing::Height, Vec2::ZERO);
            let silhouette = drawing.expect("a figure").frame;
            gei.add(silhouette).expect("room");
        }
        assert_eq!(gei.frames(), 23);
        assert_eq!(gei.finish(), expected.gei().pixels());
        assert_eq!(buffer[64 * 44..], [7; 3_000 - 64 * 44]);
    }
}

#[test]
fn a_gei_in_a_buffer_counts_255_frames_of_its_size_and_refuses_others() {
    let error = GeiInPlace::new(Size::S50x30, &mut [0; 1_499]).expect_err("no room");
    let (expected, found) = (1_500, 1_499);
    assert_eq!(error, BufferTooSmall { expected, found });
    let mut buffer = [9; 1_500];
    let mut gei = GeiInPlace::new(Size::S50x30, &mut buffer).expect("room");
    let refused = gei.add(&Silhouette::from_rows(Size::S64x44, &[1]));
    let (expected, found) = (Size::S50x30, Size::S64x44);
    assert_eq!(refused, Err(FrameError::Size { expected, found }));
    assert_eq!(gei.frames(), 0);
    assert_eq!(gei.finish(), [0; 1_500]);
    let mut gei = GeiInPlace::new(Size::S50x30, &mut buffer).expect("room");
    // On in 1, 2 and 255 frames.
    for frame in 0..255 {
        let bits = 0b100 | u64::from(frame < 2) << 1 | u64::from(frame < 1);
        let silhouette = Silhouette::from_rows(Size::S50x30, &[0, bits]);
        gei.add(&silhouette).expect("room");
    }
    let refused = gei.add(&Silhouette::from_rows(Size::S50x30, &[0, 0b1000]));
    let refused = refused.expect_err("a 256th frame");
    assert_eq!(refused, FrameError::Full { frames: 255 });
    assert_eq!(
        refused.to_string(),
        "expected at most 255 frames in this template, found one more (begin another)"
    );
    assert_eq!(gei.frames(), 255);
    assert_eq!(gei.finish()[30..34], [1, 2, 255, 0]);
}

#[test]
fn room_is_the_points_and_the_facets_of_all_hulls() {
    let both = [-1, 1];
    let cube: Vec<_> = both
        .iter()
        .flat_map(|&x| both.map(|y| both.map(|z| [x, y, z])))
        .flatten()
        .collect();
    let wedge = vec![[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]];
    let square = vec![[0, 0, 5], [9, 0, 5], [9, 9, 5], [0, 9, 5]];
    let line = vec![[0, 0, 0], [1, 1, 1]];
    // By hand: two triangles for each of 6 squares; 4 triangles; 4 sides; none for a line and a
    // point.
    for (hulls, expected) in [
        (vec![cube.clone()], [1, 8, 12]),
        (vec![wedge.clone()], [1, 4, 4]),
        (vec![square.clone()], [1, 4, 4]),
        (vec![line.clone(), vec![[7, 7, 7]]], [2, 3, 0]),
        (vec![cube, wedge, square, line], [4, 18, 20]),
    ] {
        let bytes = plain_avatar::avatar(1_000, &hulls);
        let room = Room::for_avatar(&Avatar::parse(&bytes).expect("an avatar"));
        let [hulls, points, facets] = expected;
        let expected = Room {
            hulls,
            points,
            facets,
        };
        assert_eq!(room, expected);
    }
}

#[test]
fn a_budget_is_enough_for_every_walk_of_a_pack() {
    let bytes = small_pack::small_pack();
    let pack = Pack::parse(&bytes).expect("a pack");
    let budget = Budget::from_pack(&pack);
    assert_eq!(budget.pack_bytes, bytes.len());
    let rooms = [0, 1].map(|number| Room::for_avatar(&pack.avatar(number).expect("an avatar")));
    let most = |of: fn(&Room) -> usize| rooms.iter().map(of).max().expect("two");
    let (hulls, points) = (most(|room| room.hulls), most(|room| room.points));
    let facets = most(|room| room.facets);
    let room = Room {
        hulls,
        points,
        facets,
    };
    assert_eq!(budget.room, room);
    // The buffer is long enough for the longest loop, and one number fewer is not.
    let mut buffer = vec![0.0; (budget.expanded_bytes - size_of::<Expanded<'_>>()) / 4];
    let expands = |buffer: &mut [f32]| {
        let clips = (0..pack.clip_count()).map(|number| pack.clip(number).expect("a clip"));
        clips.into_iter().all(|clip| {
            let cycle = clip.as_loop().expect("a loop");
            cycle.expand(buffer).is_some()
        })
    };
    assert!(expands(&mut buffer));
    assert!(!expands(&mut buffer[1..]));
    // A larger image takes its pixels; larger bit images take nothing more.
    let [small, large] =
        [Size::S50x30, Size::S64x64].map(|size| budget.ram_bytes::<CompactRows>(size));
    assert_eq!(large - small, 64 * 64 - 50 * 30);
    assert!(small > room.bytes() + 1_500);
}

#[test]
fn a_body_that_there_is_no_room_for_is_refused() {
    let bytes = small_pack::avatar(&mut Random(3), 12);
    let avatar = Avatar::parse(&bytes).expect("an avatar");
    let Room { points, facets, .. } = Room::for_avatar(&avatar);
    assert!(
        points > 60 && facets > 60,
        "{points} points, {facets} facets"
    );
    let (mut few_points, mut few_facets) = (
        compact::CompactBody::<60, 1000>::EMPTY,
        compact::CompactBody::<500, 60>::EMPTY,
    );
    assert_eq!(few_points.load(&avatar), Err(OverBudget));
    assert_eq!(few_facets.load(&avatar), Err(OverBudget));
    let mut enough = CompactBody::EMPTY;
    assert_eq!(enough.load(&avatar), Ok(()));
}

#[test]
fn without_facets_rows_have_nothing_to_draw_and_skia_draws_the_same() {
    let bytes = small_pack::avatar(&mut Random(5), 10);
    let avatar = Avatar::parse(&bytes).expect("an avatar");
    let mut bare = compact::CompactBody::<768, 0>::EMPTY;
    bare.load(&avatar).expect("points alone");
    let pose = ModelPose::new(&avatar.skeleton(), &Pose::REST);
    let camera = Camera::orthographic(Viewpoint::from_degrees(30.0, 10.0).expect("a viewpoint"));
    let mut rows = Renderer::with_window(CompactRows::new(Size::S50x30));
    let drawn = rows.draw(&bare.posed(&pose), &camera, Framing::Height, Vec2::ZERO);
    assert_eq!(drawn.expect_err("no outline"), DrawError::Vanished);
    let whole = loaded(&avatar);
    let silhouette = |posed: &CompactFigure<'_>| {
        let mut skia = Renderer::with_window(Skia::new(Size::S50x30));
        let drawn = skia.draw(posed, &camera, Framing::Height, Vec2::ZERO);
        *drawn.expect("a figure").frame
    };
    assert_eq!(
        silhouette(&bare.posed(&pose)),
        silhouette(&whole.posed(&pose))
    );
}

//! Tests of the core's heap use, byte by byte.
#![expect(
    unsafe_code,
    reason = "a global allocator that counts cannot be written without it"
)]

mod plain_avatar;
mod random;
mod small_pack;

use edgegait_core::avatar::Avatar;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::budget::{MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::clip::Clip;
use edgegait_core::codebook::Codebook;
use edgegait_core::compact::{self, CompactRows};
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
#[cfg(feature = "tiny-skia")]
use edgegait_core::raster::TinySkia;
use edgegait_core::raster::{DrawError, Drawing, Rasterizer, Renderer, Skia, Window};
use edgegait_core::silhouette::{Silhouette, Size};
use edgegait_core::skeleton::Joint;
use edgegait_core::template::{GeiBuilder, GeiInPlace};
use glam::{Vec2, Vec3};
use random::Random;
use small_pack::{small_pack, wild_clip};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// An allocator that counts by thread, so that tests do not affect each other. A growing buffer
/// counts as the old and the new one together (`GlobalAlloc::realloc` is not overridden), as in a
/// simple allocator.
struct Counting;

thread_local! {
    static LIVE: Cell<usize> = const { Cell::new(0) };
    static PEAK: Cell<usize> = const { Cell::new(0) };
    static CALLS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes unchanged to the system's allocator, which keeps the contract. The
// counters are initialised by constants and have no destructor, so counting itself neither
// allocates nor runs after them.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LIVE.set(LIVE.get().wrapping_add(layout.size()));
        PEAK.set(PEAK.get().max(LIVE.get()));
        CALLS.set(CALLS.get() + 1);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        LIVE.set(LIVE.get().wrapping_sub(layout.size()));
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The size whose window is the largest.
const LARGEST: Size = Size::S64x64;

/// The heap use of some work.
#[derive(Debug, PartialEq, Eq)]
struct Taken {
    /// The bytes that it still holds.
    kept: isize,
    /// The maximum number of bytes that it held together.
    peak: usize,
    /// The number of allocations.
    calls: usize,
}

fn taken<R>(work: impl FnOnce() -> R) -> (R, Taken) {
    let (before, calls) = (LIVE.get(), CALLS.get());
    PEAK.set(before);
    let result = work();
    let taken = Taken {
        kept: LIVE.get().cast_signed() - before.cast_signed(),
        peak: PEAK.get() - before,
        calls: CALLS.get() - calls,
    };
    (result, taken)
}

const NOTHING: Taken = Taken {
    kept: 0,
    peak: 0,
    calls: 0,
};

/// Returns as many hulls of as many points as the budget allows, or fewer. Every point of a hull is
/// a corner of its outline from some viewpoint: points lie on an ellipsoid.
fn body(random: &mut Random) -> UnpackedBody {
    let mut body = UnpackedBody::default();
    let spread = 10f64.powf(random.between(-2.0, 1.6));
    let size = 10f64.powf(random.between(-2.0, 0.5));
    let most = 1 + random.below(MAX_HULL_POINTS);
    for _ in 0..=random.below(MAX_HULLS) {
        let centre = [spread, 0.5, spread].map(|reach| random.between(-reach, reach));
        let radii = [0; 3].map(|_| random.between(0.1, 1.0) * size);
        let points = if random.below(2) == 0 {
            MAX_HULL_POINTS
        } else {
            most
        };
        let hull: Vec<Vec3> = (0..points)
            .map(|_| {
                let direction = Vec3::from([0; 3].map(|_| random.between(-1.0, 1.0) as f32));
                let radii = Vec3::from(radii.map(|radius| radius as f32));
                Vec3::from(centre.map(|c| c as f32)) + radii * direction.normalize_or(Vec3::X)
            })
            .collect();
        if body.push(Joint::Pelvis, hull).is_err() {
            break;
        }
    }
    body
}

/// Returns rings of 32 points in the plane of the front view, with 32 corners.
///
/// They take `columns` columns if they fill the rows of `size`.
fn ring(columns: f32, size: Size) -> UnpackedBody {
    let mut body = UnpackedBody::default();
    let width = columns / size.rows() as f32;
    for _ in 0..MAX_POINTS / MAX_HULL_POINTS {
        let ring = (0..32u8).map(|i| {
            let turn = f32::from(i) / 32.0 * std::f32::consts::TAU;
            Vec3::new(0.5 * width * turn.cos(), 0.5 * turn.sin(), 0.0)
        });
        body.push(Joint::Pelvis, ring).expect("within the budget");
    }
    body
}

fn camera(azimuth_deg: f64, elevation_deg: f64) -> Camera {
    let viewpoint = Viewpoint::from_degrees(azimuth_deg as f32, elevation_deg as f32);
    Camera::orthographic(viewpoint.expect("a viewpoint"))
}

fn draw<'r, 'f, W: Window<Figure<'f>>>(
    renderer: &'r mut Renderer<W>,
    figure: &Figure<'f>,
    camera: &Camera,
) -> Result<Drawing<'r, W::Image>, DrawError> {
    renderer.draw(figure, camera, Framing::Height, Vec2::ZERO)
}

#[cfg(feature = "tiny-skia")]
#[test]
fn tiny_skia_holds_its_window_and_from_the_first_hull_on_one_path() {
    // One edge list for each of 24 hulls and, for anti-aliasing, two buffers of a row.
    holds_its_window(TinySkia::new, 24);
    holds_its_window(TinySkia::anti_aliased, 3 * 24);
}

#[cfg(feature = "tiny-skia")]
fn holds_its_window<W>(window: impl Fn(Size) -> W, calls: usize)
where
    W: for<'a> Window<Figure<'a>>,
{
    let body = ring(30.0, LARGEST);
    let figure = Figure::at_rest(&body);
    // 64 columns of 50 rows, a byte each.
    let (_, made) = taken(|| Renderer::with_window(window(Size::S50x30)));
    assert_eq!((made.peak, made.calls), (3_200, 1));
    // 64 rows.
    let (mut renderer, made) = taken(|| Renderer::with_window(window(LARGEST)));
    assert_eq!((made.kept, made.peak), (4_096, 4_096));
    let (drawn, first) = taken(|| draw(&mut renderer, &figure, &camera(0.0, 0.0)).is_ok());
    assert!(drawn);
    // 37 points of 8 bytes and 38 verbs of 1.
    assert_eq!(first.kept, 334);
    assert_eq!(
        made.kept + first.kept,
        edgegait_core::budget::SKIA_RESIDENT_BYTES.cast_signed()
    );
    let (drawn, later) = taken(|| draw(&mut renderer, &figure, &camera(0.0, 0.0)).is_ok());
    assert!(drawn);
    assert_eq!((later.kept, later.calls), (0, calls));
}

/// Returns the bytes that a rasteriser may take from the heap.
fn heap_bytes(rasterizer: Rasterizer) -> usize {
    match rasterizer {
        #[cfg(feature = "tiny-skia")]
        Rasterizer::SkiaAa => edgegait_core::budget::SKIA_HEAP_BYTES,
        _ => 0,
    }
}

#[test]
fn drawing_any_figure_from_anywhere_stays_within_the_stated_heap() {
    for &rasterizer in Rasterizer::ALL {
        let most = heap_bytes(rasterizer);
        for size in Size::ALL {
            let mut random = Random(3);
            let (mut renderer, made) = taken(|| Renderer::new(rasterizer, size));
            let (first, upright) = (ring(30.0, size), camera(0.0, 0.0));
            let figure = Figure::at_rest(&first);
            let (drawn, path) = taken(|| draw(&mut renderer, &figure, &upright));
            drawn.expect("a ring");
            let resident = usize::try_from(made.kept + path.kept).expect("more than nothing");
            assert!(made.peak.max(resident) <= most, "{resident} bytes");
            let (mut drawn, mut wide) = (0, 0);
            for frame in 0..500 {
                let body = body(&mut random);
                let figure = Figure::at_rest(&body);
                let camera = match frame % 4 {
                    0 => camera(5.0 * random.below(37) as f64, 5.0 * random.below(19) as f64),
                    1 => camera(random.between(-720.0, 720.0), random.between(-90.0, 90.0)),
                    2 => camera(random.between(0.0, 360.0), 90.0),
                    _ => camera(90.0 * random.below(9) as f64, -90.0),
                };
                let framing = match frame % 5 {
                    0 => Framing::Box,
                    1 => Framing::Fixed {
                        centre: Vec3::Y,
                        pixels_per_metre: 30.0,
                    },
                    _ => Framing::Height,
                };
                let (drawing, used) =
                    taken(|| renderer.draw(&figure, &camera, framing, Vec2::ZERO));
                if let Ok(drawing) = drawing {
                    drawn += 1;
                    wide += usize::from(drawing.clipped_share > 0.8);
                }
                assert_eq!(used.kept, 0, "frame {frame}");
                assert!(resident + used.peak <= most, "{used:?}");
                assert!(most > 0 || used == NOTHING, "{used:?}");
            }
            assert!(
                drawn > 250 && wide > 10,
                "{drawn} drawn, {wide} of them wide"
            );
        }
    }
}

#[cfg(feature = "tiny-skia")]
#[test]
fn the_stated_heap_is_reached_by_a_figure_as_wide_as_the_window() {
    // Window, path, 64 edges of 80 bytes; 65 runs of 2 bytes and 65 bytes of coverage.
    const PEAKS: [usize; 2] = [4_096 + 334 + 5_120, 4_096 + 334 + 5_120 + 195];
    assert_eq!(edgegait_core::budget::SKIA_HEAP_BYTES, PEAKS[1]);
    assert_eq!(heap_of_a_wide_figure(TinySkia::new), PEAKS[0]);
    assert_eq!(heap_of_a_wide_figure(TinySkia::anti_aliased), PEAKS[1]);
}

#[cfg(feature = "tiny-skia")]
fn heap_of_a_wide_figure<W>(window: impl Fn(Size) -> W) -> usize
where
    W: for<'a> Window<Figure<'a>>,
{
    let body = ring(64.0, LARGEST);
    let figure = Figure::at_rest(&body);
    let (drawn, all) = taken(|| {
        let mut renderer = Renderer::with_window(window(LARGEST));
        draw(&mut renderer, &figure, &camera(0.0, 0.0)).is_ok()
    });
    assert!(drawn);
    all.peak
}

/// Returns 24 hulls of 32 points in the plane of the front view: rings 1 m high and `width_m` wide.
fn rings(width_m: f64) -> Vec<u8> {
    let ring = (0..32).map(|i| {
        let turn = f64::from(i) / 32.0 * std::f64::consts::TAU;
        let [x, y] = [0.5 * width_m * turn.cos(), 0.5 * turn.sin()];
        [x, y, 0.0].map(|metres| (metres * 5_000.0).round() as i32)
    });
    plain_avatar::avatar(200, &vec![ring.collect(); MAX_POINTS / MAX_HULL_POINTS])
}

/// Measures the heap use of drawing bodies hull by hull from everywhere and adding up the
/// silhouettes.
fn taken_by_compact<W>(size: Size, window: impl Fn(Size) -> W) -> Taken
where
    W: for<'a> Window<compact::CompactFigure<'a>, Image = Silhouette>,
{
    let mut random = Random(5);
    let mut avatars = vec![rings(0.5), rings(2.0), rings(6.0)];
    avatars.extend((0..9).map(|round| small_pack::avatar(&mut random, 8 + round)));
    let mut body = compact::CompactBody::<768, 1536>::EMPTY;
    let mut counts = [0; 4_096];
    let (drawn, used) = taken(|| {
        let mut renderer = Renderer::with_window(window(size));
        let mut gei = GeiInPlace::new(size, &mut counts).expect("4,096 bytes");
        for bytes in &avatars {
            let avatar = Avatar::parse(bytes).expect("an avatar");
            body.load(&avatar).expect("room for every avatar");
            let pose = ModelPose::new(&avatar.skeleton(), &Pose::REST);
            for view in 0..20u8 {
                let camera = camera(18.0 * f64::from(view), 15.0 * f64::from(view % 7));
                let framing = [Framing::Height, Framing::Box][usize::from(view % 2)];
                let drawing = renderer.draw(&body.posed(&pose), &camera, framing, Vec2::ZERO);
                if let Ok(drawing) = drawing {
                    gei.add(drawing.frame).expect("room");
                }
            }
        }
        gei.frames()
    });
    assert!(drawn > 200, "{drawn} of 240 drawn");
    used
}

#[test]
fn drawing_hull_by_hull_never_touches_the_heap() {
    for size in Size::ALL {
        assert_eq!(taken_by_compact(size, CompactRows::new), NOTHING);
        assert_eq!(taken_by_compact(size, Skia::new), NOTHING);
    }
}

#[test]
fn everything_before_the_rasteriser_takes_nothing() {
    let bytes = small_pack();
    let [code, templates, wild] = wild_clip(&mut Random(3));
    let mut buffer = vec![0.0; 63 * 60];
    let ((), used) = taken(|| {
        let codebook = Codebook::parse(&code).and_then(|code| code.with_templates(&templates));
        let clip = Clip::parse(&wild, &codebook.expect("a codebook")).expect("a clip");
        let cycle = clip.as_loop().expect("a loop");
        let expanded = cycle
            .expand(&mut buffer)
            .expect("63 coefficients of 60 channels");
        assert_eq!(expanded.pose(0.3), cycle.pose(0.3));
        let pack = Pack::parse(&bytes).expect("a pack");
        for walk in pack.walks() {
            let avatar: Avatar<'_> = pack.avatar(walk.avatar).expect("an avatar");
            let clip = pack.clip(walk.clip).expect("a clip");
            let mut body = UnpackedBody::new(&avatar);
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
            let joints = [
                Joint::LeftShank,
                Joint::RightShank,
                Joint::Spine,
                Joint::Head,
            ];
            let cloth = body.push_draped(joints.into_iter().zip(corners));
            cloth.expect("within the budget");
            let mut figure = Figure::at_rest(&body);
            for frame in 0..32u8 {
                let pose = clip.sample(f64::from(frame) / 32.0);
                let model = ModelPose::new(&avatar.skeleton(), &pose);
                figure.update(&model);
            }
            assert!(!figure.is_empty());
        }
        assert!(Pack::parse(&bytes[1..]).is_err());
    });
    assert_eq!(used, NOTHING);
}

#[test]
fn building_a_gei_takes_nothing() {
    let body = ring(20.0, LARGEST);
    for &rasterizer in Rasterizer::ALL {
        let mut renderer = Renderer::new(rasterizer, LARGEST);
        let drawing = draw(&mut renderer, &Figure::at_rest(&body), &camera(0.0, 0.0));
        let frame = drawing.expect("a ring").frame;
        let (gei, used) = taken(|| {
            let mut builder = GeiBuilder::new(LARGEST);
            for _ in 0..100 {
                builder.add(frame).expect("room");
            }
            builder.gei()
        });
        assert_eq!(gei.pixels(), frame.to_coverage().pixels());
        assert_eq!(used, NOTHING);
    }
}

#[test]
fn a_figure_that_cannot_be_drawn_takes_nothing() {
    let mut point = UnpackedBody::default();
    point
        .push(Joint::Pelvis, [Vec3::ONE; 4])
        .expect("within the budget");
    let figure = Figure::at_rest(&point);
    for &rasterizer in Rasterizer::ALL {
        let mut renderer = Renderer::new(rasterizer, Size::S50x30);
        let (drawn, used) = taken(|| draw(&mut renderer, &figure, &camera(0.0, 0.0)));
        assert_eq!(drawn, Err(DrawError::Flat));
        assert_eq!(used, NOTHING);
    }
}

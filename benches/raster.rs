//! Drawing: project, frame by height, outline and rasterise one posed figure at 50x30.
//!
//! One iteration is one silhouette. `spread` goes through the 19 viewpoints of azimuths 0, 10, ...,
//! 180 with elevations 0, 15, ..., 75 in turn, `level` through those of elevation 0, as in the
//! sweep's benchmark; `above` has the widest silhouette. `19-hulls-of-16` are the same hulls with
//! at most 16 points. `skia` and `rows` are also measured with registers of each width: `portable`
//! and those that the processor has (`avx2`, `avx512bw`, `avx512` or `neon`). `tiny-skia` is the
//! library, whose pixels `skia` has.

mod common;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer, Simd};
use edgegait_core::silhouette::Size;
use glam::Vec2;
use std::hint::black_box;

fn main() {
    let mut criterion = common::criterion();
    raster(&mut criterion);
    criterion.final_summary();
}

fn raster(criterion: &mut Criterion) {
    let body = body(usize::MAX);
    let thinned = self::body(16);
    let figures = figures(&body);
    let of_16 = self::figures(&thinned);
    let hulls = figures[0].hulls().count();
    let all = format!("{hulls}-hulls");
    let of_16 = (format!("{hulls}-hulls-of-16"), of_16);
    let spread: Vec<Camera> = (0..19u8)
        .map(|view| camera(f32::from(view) * 10.0, f32::from(view % 6) * 15.0))
        .collect();
    let level: Vec<Camera> = (0..19u8)
        .map(|view| camera(f32::from(view) * 10.0, 0.0))
        .collect();
    let above = vec![camera(90.0, 90.0)];

    let mut group = criterion.benchmark_group("raster");
    for &rasterizer in Rasterizer::ALL {
        for (views, cameras) in [("spread", &spread), ("level", &level), ("above", &above)] {
            let case = BenchmarkId::new(format!("{rasterizer}-{views}"), &all);
            let renderer = Renderer::new(rasterizer, Size::S50x30);
            draw(&mut group, case, renderer, (&figures, cameras));
        }
    }
    for (points, figures) in [(&all, &figures), (&of_16.0, &of_16.1)] {
        let case = BenchmarkId::new("tiny-skia-spread", points);
        let renderer = Renderer::new(Rasterizer::TinySkia, Size::S50x30);
        draw(&mut group, case, renderer, (figures, &spread));
        for rasterizer in [Rasterizer::Skia, Rasterizer::Rows] {
            for simd in Simd::available() {
                let case = BenchmarkId::new(format!("{rasterizer}-{simd}-spread"), points);
                let renderer = Renderer::with_simd(rasterizer, Size::S50x30, simd);
                draw(&mut group, case, renderer, (figures, &spread));
            }
        }
    }
    group.finish();
}

fn draw(
    group: &mut BenchmarkGroup<'_, WallTime>,
    case: BenchmarkId,
    mut renderer: Renderer,
    (figures, cameras): (&[Figure<'_>], &[Camera]),
) {
    group.bench_function(case, |b| {
        // 19 and 32 are coprime, so that every viewpoint meets every frame.
        let mut drawings = figures.iter().cycle().zip(cameras.iter().cycle());
        b.iter(|| {
            let (figure, camera) = drawings.next().expect("an endless cycle");
            let (figure, camera) = black_box((figure, camera));
            let drawing = renderer.draw(figure, camera, Framing::Height, Vec2::ZERO);
            black_box(drawing.is_ok())
        });
    });
}

fn camera(azimuth_deg: f32, elevation_deg: f32) -> Camera {
    let viewpoint = Viewpoint::from_degrees(azimuth_deg, elevation_deg);
    Camera::orthographic(viewpoint.expect("angles within range"))
}

/// Returns the first person's body, with `most` evenly spaced points of hulls that have more.
fn body(most: usize) -> UnpackedBody {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let avatar = pack.avatar(0).expect("a first avatar");
    let mut body = UnpackedBody::default();
    for hull in avatar.hulls() {
        let (len, most) = (hull.len(), most.min(hull.len()));
        let points = hull.points().enumerate();
        let kept = points.filter(|(at, _)| (at + 1) * most / len > at * most / len);
        body.push(hull.joint(), kept.map(|(_, point)| point))
            .expect("no more than the avatar has");
    }
    body
}

/// Returns the 32 frames of the first person's gait cycle.
fn figures(body: &UnpackedBody) -> Vec<Figure<'_>> {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let avatar = pack.avatar(0).expect("a first avatar");
    let clip = pack.clip(0).and_then(|clip| clip.as_loop());
    let clip = clip.expect("a first loop");
    (0..32u8)
        .map(|frame| {
            let pose = clip.pose(f32::from(frame) / 32.0);
            Figure::new(body, &ModelPose::new(&avatar.skeleton(), &pose))
        })
        .collect()
}

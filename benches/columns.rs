//! Drawing columns: silhouettes of one posed figure from 19 elevations in one pass, cut, drawn and
//! counted; and the same viewpoints drawn one by one.
//!
//! One iteration is one azimuth of one frame, 19 silhouettes; the figure is posed. `19-hulls` is
//! the first person of the cohort, `19-hulls-of-16` has at most 16 points a hull.

mod common;

use criterion::{BenchmarkId, Criterion, Throughput};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::columns::{Azimuth, ColumnRenderer as Columns, FigurePlace};
use edgegait_core::raster::{Rasterizer, Renderer, Simd};
use edgegait_core::silhouette::Size;
use edgegait_core::template::{GeiBuilder, GeiTally};
use glam::{Vec2, Vec3};
use std::hint::black_box;

const FRAMES: u8 = 32;
const ELEVATIONS: u8 = 19;
const SIZE: Size = Size::S50x30;
/// The height of the person, of 50 rows.
const HEIGHT_PX: f32 = 48.0;

fn main() {
    let mut criterion = common::criterion();
    columns(&mut criterion);
    criterion.final_summary();
}

fn columns(criterion: &mut Criterion) {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let viewpoints: Vec<Vec<Viewpoint>> = (0..37).map(azimuth).collect();
    let azimuths = viewpoints.iter().map(|them| Azimuth::new(them));
    let azimuths: Vec<Azimuth> = azimuths.collect::<Result<_, _>>().expect("19 elevations");

    let mut group = criterion.benchmark_group("columns");
    group.throughput(Throughput::Elements(u64::from(ELEVATIONS)));
    for (most, points) in [(usize::MAX, ""), (16, "-of-16")] {
        let body = body(&pack, most);
        let figures = figures(&pack, &body);
        let hulls = figures[0].hulls().count();
        let place = place(&figures);
        let of = |name: &str| BenchmarkId::new(name, format!("{hulls}-hulls{points}"));
        for simd in Simd::available() {
            group.bench_function(of(simd.name()), |b| {
                let mut renderer = Columns::with_simd(simd);
                let mut tally = Box::new(GeiTally::with_simd(SIZE, simd));
                // Draw a whole cycle from each azimuth in turn.
                let cycles = azimuths
                    .iter()
                    .flat_map(|azimuth| figures.iter().map(move |it| (it, azimuth)));
                let mut drawings = cycles.cycle();
                b.iter(|| {
                    let (figure, azimuth) = drawings.next().expect("an endless cycle");
                    if tally.frames() == u32::from(FRAMES) {
                        tally.clear();
                    }
                    let images = tally.next_frame().expect("at most 32 frames");
                    let drawn = renderer.draw(black_box(figure), azimuth, &place, images);
                    drawn.expect("a person within reach");
                    black_box(images);
                });
            });
        }
        for rasterizer in [Rasterizer::Rows, Rasterizer::Skia] {
            group.bench_function(of(rasterizer.name()), |b| {
                let mut renderer = Renderer::new(rasterizer, SIZE);
                let cycles = viewpoints
                    .iter()
                    .flat_map(|them| figures.iter().map(move |it| (it, them)));
                let mut drawings = cycles.cycle();
                let framing = Framing::Fixed {
                    centre: place.centre,
                    pixels_per_metre: place.pixels_per_metre,
                };
                let mut builder = GeiBuilder::new(SIZE);
                let mut frames = 0;
                b.iter(|| {
                    let (figure, viewpoints) = drawings.next().expect("an endless cycle");
                    if frames == FRAMES {
                        builder = GeiBuilder::new(SIZE);
                        frames = 0;
                    }
                    frames += 1;
                    for &viewpoint in viewpoints {
                        let camera = Camera::orthographic(viewpoint);
                        let drawing =
                            renderer.draw(black_box(figure), &camera, framing, Vec2::ZERO);
                        let frame = drawing.expect("a person within reach").frame;
                        builder.add(frame).expect("room");
                    }
                });
            });
        }
    }
    group.finish();
}

/// Returns the viewpoints of one azimuth of the paper's grid.
fn azimuth(step: u8) -> Vec<Viewpoint> {
    let viewpoint =
        |elevation: u8| Viewpoint::from_degrees(5.0 * f32::from(step), 5.0 * f32::from(elevation));
    let viewpoints = (0..ELEVATIONS).map(viewpoint).collect::<Result<_, _>>();
    viewpoints.expect("angles within range")
}

/// Returns a place and scale that suit the whole cycle.
fn place(figures: &[Figure<'_>]) -> FigurePlace {
    let heights = figures.iter().flat_map(Figure::points).map(|point| point.y);
    let (low, high) = heights.fold((f32::MAX, f32::MIN), |(low, high), y| {
        (low.min(y), high.max(y))
    });
    FigurePlace {
        centre: Vec3::Y * (0.5 * (low + high)),
        pixels_per_metre: HEIGHT_PX / (high - low),
        jitter: Vec2::ZERO,
    }
}

/// Returns the first person's body with at most `most` points a hull, those farthest apart.
fn body(pack: &Pack<'_>, most: usize) -> UnpackedBody {
    let mut body = UnpackedBody::default();
    for hull in pack.avatar(0).expect("a first avatar").hulls() {
        let points: Vec<Vec3> = hull.points().collect();
        let mut kept = vec![0];
        while kept.len() < points.len().min(most) {
            let distance = |at: usize| {
                let distances = kept.iter().map(|&other| points[at].distance(points[other]));
                distances.fold(f32::MAX, f32::min)
            };
            let farthest = (0..points.len()).max_by(|&a, &b| distance(a).total_cmp(&distance(b)));
            kept.extend(farthest);
        }
        let kept = kept.into_iter().map(|at| points[at]);
        body.push(hull.joint(), kept).expect("a parsed avatar");
    }
    body
}

/// Returns the 32 frames of the first person's gait cycle.
fn figures<'a>(pack: &Pack<'_>, body: &'a UnpackedBody) -> Vec<Figure<'a>> {
    let skeleton = pack.avatar(0).expect("a first avatar").skeleton();
    let clip = pack.clip(0).and_then(|clip| clip.as_loop());
    let clip = clip.expect("a first loop");
    (0..FRAMES)
        .map(|frame| {
            let pose = clip.pose(f32::from(frame) / f32::from(FRAMES));
            Figure::new(body, &ModelPose::new(&skeleton, &pose))
        })
        .collect()
}

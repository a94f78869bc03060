//! The costs per frame of detecting gait cycles and of measuring the legs.

mod common;

use criterion::{BenchmarkId, Criterion, Throughput};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::cycle::{CycleDetector, LowerBody};
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{Silhouette, Size};
use glam::Vec2;
use std::hint::black_box;

/// The length of the walks; each second is a cycle.
const SECONDS: u16 = 10;

fn main() {
    let mut criterion = common::criterion();
    cycle(&mut criterion);
    criterion.final_summary();
}

/// Measures all frames of ten seconds, including the first, which are too few for a detection.
fn cycle(criterion: &mut Criterion) {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let mut group = criterion.benchmark_group("cycle");
    for (view, azimuth_deg) in [("side", 90.0), ("front", 0.0)] {
        for rate_hz in [10, 30, 60, 120_u16] {
            let walk = walk(&pack, azimuth_deg, rate_hz);
            let legs: Vec<_> = walk.iter().map(LowerBody::measure).collect();
            group.throughput(Throughput::Elements(legs.len() as u64));
            let case = BenchmarkId::new(view, format!("{rate_hz}-hz"));
            group.bench_with_input(case, &legs, |b, legs| {
                b.iter(|| {
                    let mut detector = CycleDetector::new(rate_hz.into()).expect("a frame rate");
                    let found = legs.iter().filter_map(|legs| detector.push(*legs));
                    black_box(found.count())
                });
            });
        }
    }
    let walk = walk(&pack, 90.0, 30);
    group.throughput(Throughput::Elements(walk.len() as u64));
    let case = BenchmarkId::new("lower-body", Size::S50x30.name());
    group.bench_with_input(case, &walk, |b, walk| {
        b.iter(|| {
            let legs = walk.iter().filter_map(LowerBody::measure);
            black_box(legs.map(|legs| legs.spread).sum::<f32>())
        });
    });
    group.finish();
}

/// Returns silhouettes of the first walk of a pack.
fn walk(pack: &Pack<'_>, azimuth_deg: f32, rate_hz: u16) -> Vec<Silhouette> {
    let avatar = pack.avatar(0).expect("a first avatar");
    let (body, skeleton) = (UnpackedBody::new(&avatar), avatar.skeleton());
    let clip = pack.clip(0).and_then(|clip| clip.as_loop());
    let clip = clip.expect("a first loop");
    let viewpoint = Viewpoint::from_degrees(azimuth_deg, 0.0).expect("angles within range");
    let camera = Camera::orthographic(viewpoint);
    let mut renderer = Renderer::new(Rasterizer::Rows, Size::S50x30);
    let mut figure = Figure::at_rest(&body);
    let frames = 0..SECONDS * rate_hz;
    let silhouettes = frames.map(|frame| {
        let pose = clip.pose(f32::from(frame % rate_hz) / f32::from(rate_hz));
        figure.update(&ModelPose::new(&skeleton, &pose));
        let drawing = renderer.draw(&figure, &camera, Framing::Height, Vec2::ZERO);
        drawing.expect("a walker").frame.silhouette()
    });
    silhouettes.collect()
}

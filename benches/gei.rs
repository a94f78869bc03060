//! A whole Gait Energy Image from one viewpoint: decode, pose, draw and sum 32 frames.

mod common;

use criterion::{BenchmarkId, Criterion};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::clip::Loop;
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use edgegait_core::skeleton::Skeleton;
use edgegait_core::template::{Gei, GeiBuilder};
use glam::Vec2;
use std::hint::black_box;

const FRAMES: u8 = 32;

fn main() {
    let mut criterion = common::criterion();
    gei(&mut criterion);
    criterion.final_summary();
}

fn gei(criterion: &mut Criterion) {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let avatar = pack.avatar(0).expect("a first avatar");
    let (body, skeleton) = (UnpackedBody::new(&avatar), avatar.skeleton());
    let clip = pack.clip(0).and_then(|clip| clip.as_loop());
    let clip = clip.expect("a first loop");
    let side = Viewpoint::from_degrees(90.0, 0.0).expect("angles within range");
    let camera = Camera::orthographic(side);

    let mut group = criterion.benchmark_group("gei");
    for &rasterizer in Rasterizer::ALL {
        let case = BenchmarkId::new(rasterizer.name(), format!("{FRAMES}-frames"));
        group.bench_function(case, |b| {
            let mut renderer = Renderer::new(rasterizer, Size::S50x30);
            b.iter(|| {
                let walker = black_box((&body, &skeleton, &clip));
                gei_of(walker, &camera, &mut renderer)
            });
        });
    }
    group.finish();
}

fn gei_of(
    (body, skeleton, clip): (&UnpackedBody, &Skeleton, &Loop<'_>),
    camera: &Camera,
    renderer: &mut Renderer,
) -> Gei {
    let mut figure = Figure::at_rest(body);
    let mut gei = GeiBuilder::new(renderer.size());
    for frame in 0..FRAMES {
        let pose = clip.pose(f32::from(frame) / f32::from(FRAMES));
        figure.update(&ModelPose::new(skeleton, &pose));
        let drawing = renderer.draw(&figure, camera, Framing::Height, Vec2::ZERO);
        gei.add(drawing.expect("a walker").frame).expect("room");
    }
    gei.gei()
}

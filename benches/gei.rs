//! A whole Gait Energy Image from one view: decode, pose, draw and sum 32 frames.

mod common;

use criterion::{BenchmarkId, Criterion};
use edgegait_core::avatar::{Avatar, PosedHulls};
use edgegait_core::camera::{Camera, Viewpoint};
use edgegait_core::clip::Loop;
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::template::{Gei, GeiBuilder};
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
    let clip = pack.clip(0).and_then(|clip| clip.as_loop());
    let clip = clip.expect("a first loop");
    let side = Viewpoint::from_degrees(90.0, 0.0).expect("angles within range");
    let camera = Camera::orthographic(side);

    let mut group = criterion.benchmark_group("gei");
    for rasterizer in Rasterizer::ALL {
        let case = BenchmarkId::new(rasterizer.name(), format!("{FRAMES}-frames"));
        group.bench_function(case, |b| {
            let mut renderer = Renderer::new(rasterizer);
            b.iter(|| gei_of(black_box(&avatar), black_box(&clip), &camera, &mut renderer));
        });
    }
    group.finish();
}

fn gei_of(avatar: &Avatar<'_>, clip: &Loop<'_>, camera: &Camera, renderer: &mut Renderer) -> Gei {
    let skeleton = avatar.skeleton();
    let mut figure = PosedHulls::default();
    let mut gei = GeiBuilder::new();
    for frame in 0..FRAMES {
        let pose = clip.pose(f32::from(frame) / f32::from(FRAMES));
        figure.update(avatar, &ModelPose::new(&skeleton, &pose));
        let drawing = renderer.draw(&figure, camera).expect("a walker");
        gei.add(&drawing.frame);
    }
    gei.finish()
}

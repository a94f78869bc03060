//! Drawing: project, frame by height, outline and rasterise one posed figure at 50x30.
//!
//! One iteration is one silhouette. `spread` goes through the 19 viewpoints of azimuths
//! 0, 10, ..., 180 at elevations 0, 15, ..., 75 in turn; `above` is the widest view.

mod common;

use criterion::{BenchmarkId, Criterion};
use edgegait_core::avatar::PosedHulls;
use edgegait_core::camera::{Camera, Viewpoint};
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer};
use std::hint::black_box;

fn main() {
    let mut criterion = common::criterion();
    raster(&mut criterion);
    criterion.final_summary();
}

fn raster(criterion: &mut Criterion) {
    let figures = figures();
    let hulls = figures[0].hulls().count();
    let spread: Vec<Camera> = (0..19u8)
        .map(|view| camera(f32::from(view) * 10.0, f32::from(view % 6) * 15.0))
        .collect();
    let above = vec![camera(90.0, 90.0)];

    let mut group = criterion.benchmark_group("raster");
    for rasterizer in Rasterizer::ALL {
        for (views, cameras) in [("spread", &spread), ("above", &above)] {
            let case = BenchmarkId::new(format!("{rasterizer}-{views}"), format!("{hulls}-hulls"));
            group.bench_function(case, |b| {
                let mut renderer = Renderer::new(rasterizer);
                // 19 and 32 have no common divisor: every view meets every frame.
                let mut drawings = figures.iter().cycle().zip(cameras.iter().cycle());
                b.iter(|| {
                    let (figure, camera) = drawings.next().expect("an endless cycle");
                    black_box(renderer.draw(black_box(figure), black_box(camera)))
                });
            });
        }
    }
    group.finish();
}

fn camera(azimuth_deg: f32, elevation_deg: f32) -> Camera {
    let viewpoint = Viewpoint::from_degrees(azimuth_deg, elevation_deg);
    Camera::orthographic(viewpoint.expect("angles within range"))
}

/// The 32 frames of the first person's gait cycle.
fn figures() -> Vec<PosedHulls> {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let avatar = pack.avatar(0).expect("a first avatar");
    let clip = pack.clip(0).and_then(|clip| clip.as_loop());
    let clip = clip.expect("a first loop");
    (0..32u8)
        .map(|frame| {
            let pose = clip.pose(f32::from(frame) / 32.0);
            PosedHulls::new(&avatar, &ModelPose::new(&avatar.skeleton(), &pose))
        })
        .collect()
}

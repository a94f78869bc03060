//! Draws silhouettes of one person to count instructions: `.ci/arm aarch64 full` runs it under an
//! emulator twice, the second time with more rounds, and takes the difference.
//!
//! `silhouettes RASTERISER REGISTERS ROUNDS` prints the number of silhouettes, and the number of
//! pixels that are on in the first round.

#[path = "../tests/golden/study.rs"]
#[expect(dead_code, unused_imports, reason = "firmware needs more of it")]
mod study;

use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, RenderView, Renderer, Simd};
use edgegait_core::silhouette::Size;
use glam::Vec2;
use std::convert::Infallible;
use std::hint::black_box;

/// Frames of a cycle that are drawn.
const FRAMES: u8 = 2;
const AZIMUTHS_DEG: [f32; 5] = [0.0, 45.0, 90.0, 135.0, 180.0];
const ELEVATIONS_DEG: [f32; 2] = [0.0, 40.0];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [rasterizer, registers, rounds] = arguments.as_slice() else {
        panic!("expected a rasteriser, registers and rounds, found {arguments:?}");
    };
    let rasterizer = Rasterizer::ALL
        .iter()
        .find(|known| known.name() == rasterizer);
    let simd = Simd::available().find(|known| known.name() == registers);
    let rounds: u32 = rounds.parse().expect("a number of rounds");
    let simd = simd.expect("registers that this processor has");
    let mut renderer = Renderer::with_simd(*rasterizer.expect("a rasteriser"), Size::S50x30, simd);

    let pack = Pack::parse(study::BARE.pack).expect("the cohort");
    let job = study::BARE.job(&pack, 0);
    let (body, skeleton) = (UnpackedBody::new(&job.avatar), job.avatar.skeleton());
    let viewpoints = AZIMUTHS_DEG.iter().flat_map(|&azimuth| {
        ELEVATIONS_DEG.map(|elevation| Viewpoint::from_degrees(azimuth, elevation))
    });
    let views: Vec<RenderView> = viewpoints
        .map(|viewpoint| RenderView {
            camera: Camera::orthographic(viewpoint.expect("a viewpoint")),
            framing: Framing::Height,
            jitter: Vec2::ZERO,
        })
        .collect();
    let (mut drawn, mut on) = (0u32, 0u32);
    for round in 0..rounds {
        for frame in 0..FRAMES {
            let phase = f32::from(frame) / f32::from(FRAMES);
            let pose = ModelPose::new(&skeleton, &job.cycle.pose(phase));
            let done: Result<(), Infallible> =
                renderer.draw_views(&Figure::new(&body, &pose), &views, |_, drawing| {
                    let frame = black_box(drawing.expect("a figure").frame);
                    // Only in the first round, because this takes instructions too.
                    if round == 0 {
                        on += frame.silhouette().area();
                    }
                    drawn += 1;
                    Ok(())
                });
            let Ok(()) = done;
        }
    }
    println!("{drawn} silhouettes, {on} pixels on");
}

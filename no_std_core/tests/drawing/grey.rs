//! A test of the distance of each rasteriser's GEIs from exact coverage. It is the error of the
//! rasteriser alone, because figures, frames and framing are the same on both sides.

use crate::plain::{body, dot, image_axes, posed, single, wrapped};
use crate::random::Random;
use edgegait_core::body::Figure;
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use edgegait_core::template::GeiBuilder;
use glam::Vec2;

type V3 = [f64; 3];

const FRAMES: usize = 48;
const PIXELS_PER_METRE: f64 = 24.0;
/// The place of the bodies, in the middle of the image.
const CENTRE: V3 = [3.0, 0.9, -2.0];
/// Samples of a pixel along each axis.
const SAMPLES: usize = 16;

/// Returns a heap of hulls at a moment of the cycle: every third is still, the others swing by up
/// to 12 cm, each in its own way.
fn swung(hulls: &[Vec<V3>], frame: usize) -> Vec<Vec<V3>> {
    let phase = std::f64::consts::TAU * frame as f64 / FRAMES as f64;
    let swing = |hull: usize, axis: usize| {
        0.06 * (hull % 3) as f64 * (phase + (3 * hull + axis) as f64).sin()
    };
    let moved = |(number, hull): (usize, &Vec<V3>)| {
        let at = |point: &V3| [0, 1, 2].map(|axis| point[axis] + swing(number, axis));
        hull.iter().map(at).collect()
    };
    hulls.iter().enumerate().map(moved).collect()
}

/// Adds the covered share of each pixel, 0..=1, by 16 x 16 samples.
fn add_coverage(hulls: &[Vec<V3>], (azimuth, elevation): (f64, f64), sums: &mut [f64; 1_500]) {
    let (right, up) = image_axes(azimuth, elevation);
    let mut rows = vec![[false; 30 * SAMPLES]; 50 * SAMPLES];
    for hull in hulls {
        let points: Vec<[f64; 2]> = hull
            .iter()
            .map(|&p| {
                let p = [0, 1, 2].map(|axis| p[axis] - CENTRE[axis]);
                let x = 15.0 + PIXELS_PER_METRE * dot(right, p);
                let y = 25.0 - PIXELS_PER_METRE * dot(up, p);
                [x * SAMPLES as f64, y * SAMPLES as f64]
            })
            .collect();
        let outline = wrapped(&points);
        for (row, samples) in rows.iter_mut().enumerate() {
            let y = row as f64 + 0.5;
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
                if (a[1] < y) != (b[1] < y) {
                    let x = a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]);
                    (left, right) = (left.min(x), right.max(x));
                }
            }
            for (column, sample) in samples.iter_mut().enumerate() {
                let x = column as f64 + 0.5;
                *sample |= left < x && x <= right;
            }
        }
    }
    for (pixel, sum) in sums.iter_mut().enumerate() {
        let (row, column) = (pixel / 30 * SAMPLES, pixel % 30 * SAMPLES);
        let block = rows[row..row + SAMPLES]
            .iter()
            .flat_map(|samples| &samples[column..column + SAMPLES]);
        let on = block.filter(|&&sample| sample).count();
        *sum += on as f64 / (SAMPLES * SAMPLES) as f64;
    }
}

/// Returns the sampling offset of a frame (Roberts 2018, the R2 sequence).
fn r2(frame: usize) -> Vec2 {
    let step = |share: f64| ((0.5 + frame as f64 * share).fract() - 0.5) as f32;
    Vec2::new(step(0.754_877_666_246_692_7), step(0.569_840_290_998_053_2))
}

#[test]
fn geis_are_as_close_to_exact_coverage_as_the_readme_says() {
    let mut random = Random(404);
    let cases: Vec<(Rasterizer, bool)> = Rasterizer::ALL
        .iter()
        .flat_map(|&raster| [(raster, false), (raster, true)])
        .collect();
    let mut squares = vec![0.0; cases.len()];
    let mut pixels = 0.0;
    for _ in 0..3 {
        let hulls = body(&mut random);
        let moments: Vec<_> = (0..FRAMES).map(|frame| swung(&hulls, frame)).collect();
        for angles in [(0.0, 0.0), (90.0, 0.0), (35.0, 30.0), (140.0, 75.0)] {
            let mut exact = [0.0; 1_500];
            for hulls in &moments {
                add_coverage(hulls, angles, &mut exact);
            }
            assert!(exact.iter().sum::<f64>() > 50.0 * FRAMES as f64, "a body");
            let viewpoint = Viewpoint::from_degrees(angles.0 as f32, angles.1 as f32);
            let camera = Camera::orthographic(viewpoint.expect("a viewpoint"));
            let framing = Framing::Fixed {
                centre: single(CENTRE),
                pixels_per_metre: PIXELS_PER_METRE as f32,
            };
            for ((raster, jitters), sum) in cases.iter().zip(&mut squares) {
                let mut renderer = Renderer::new(*raster, Size::S50x30);
                let mut builder = GeiBuilder::new(Size::S50x30);
                for (frame, hulls) in moments.iter().enumerate() {
                    let body = posed(hulls);
                    let jitter = if *jitters {
                        r2(frame) * raster.spacing()
                    } else {
                        Vec2::ZERO
                    };
                    let figure = Figure::at_rest(&body);
                    let drawing = renderer.draw(&figure, &camera, framing, jitter);
                    builder.add(drawing.expect("a body").frame).expect("room");
                }
                let gei = builder.gei();
                for (&found, exact) in gei.pixels().iter().zip(exact) {
                    *sum += (f64::from(found) - 255.0 * exact / FRAMES as f64).powi(2);
                }
            }
            pixels += 1_500.0;
        }
    }
    for ((raster, jitters), sum) in cases.iter().zip(&squares) {
        let error = f64::sqrt(sum / pixels);
        let jitter = if *jitters { " r2" } else { "" };
        println!("{raster}{jitter}: {error:.2} of 255");
        let most = match (raster.name(), jitters) {
            ("rows-3x3", true) => 1.0,
            ("rows-3x3", false) => 4.2,
            ("rows" | "skia", true) => 3.5,
            ("skia-aa", _) => 3.2,
            _ => 20.0,
        };
        assert!(error <= most, "{raster}{jitter}: {error}");
    }
}

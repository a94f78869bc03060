//! Templates against plain f64 code.
#![expect(dead_code, reason = "`plain` is shared with other tests")]

mod plain;
mod random;

use edgegait_core::body::Figure;
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{Coverage, Frame, Silhouette, Size};
use edgegait_core::template::GeiBuilder;
use glam::Vec2;
use plain::{body, posed};
use random::Random;

/// A frame of any bytes, of any bits, or of a drawn person's ninths.
fn frame(random: &mut Random, kind: usize, size: Size) -> Frame {
    match kind {
        0 => {
            let mut coverage = Coverage::empty(size);
            coverage.pixels_mut().fill_with(|| random.below(256) as u8);
            Frame::Grey(coverage)
        }
        1 => {
            let rows: [u64; 64] = std::array::from_fn(|_| random.bits());
            Frame::Binary(Silhouette::from_rows(size, &rows))
        }
        _ => {
            let mut renderer = Renderer::new(Rasterizer::Rows3x3, size);
            let body = posed(&body(random));
            let viewpoint = Viewpoint::from_degrees(random.between(0.0, 360.0) as f32, 20.0);
            let camera = Camera::orthographic(viewpoint.expect("a viewpoint"));
            let drawing = renderer.draw(
                &Figure::at_rest(&body),
                &camera,
                Framing::Height,
                Vec2::ZERO,
            );
            *drawing.expect("a person").frame
        }
    }
}

#[test]
fn a_gei_is_the_mean_in_f64_rounded_half_up() {
    let mut random = Random(24);
    let counts = [1, 2, 3, 7, 8, 9, 32, 100, 255];
    for (turn, (frames, size)) in counts
        .into_iter()
        .zip(Size::ALL.into_iter().cycle())
        .flat_map(|case| [case; 3])
        .enumerate()
    {
        let mut builder = GeiBuilder::new(size);
        let mut sums = vec![0.0f64; size.pixels()];
        for _ in 0..frames {
            let frame = frame(&mut random, turn % 3, size);
            builder.add(&frame);
            let is_ninths = matches!(frame, Frame::Ninths(_));
            let coverage = frame.to_coverage();
            for (sum, &pixel) in sums.iter_mut().zip(coverage.pixels()) {
                // A byte tells which ninth it is.
                let ninths = (f64::from(pixel) * 9.0 / 255.0).round();
                *sum += if is_ninths {
                    ninths * 255.0 / 9.0
                } else {
                    f64::from(pixel)
                };
            }
        }
        let found = builder.finish();
        for (&pixel, sum) in found.pixels().iter().zip(sums) {
            // Sums of ninths carry f64's rounding; a half is a multiple of 1 / (18 frames).
            let mean = sum / f64::from(frames) + 1e-9;
            assert_eq!(f64::from(pixel), (mean + 0.5).floor(), "{mean} of {frames}");
        }
    }
}

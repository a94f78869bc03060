//! Tests of templates against plain f64 code.

use crate::plain::{body, posed};
use crate::random::Random;
use edgegait_core::body::Figure;
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{AnySilhouette, Coverage, Silhouette, Size};
use edgegait_core::template::{GeiBuilder, TemplateBuilder, TemplateKind};
use glam::Vec2;

/// Returns a frame of random bytes, of random bits, or of a drawn person's ninths.
fn frame(random: &mut Random, kind: usize, size: Size) -> AnySilhouette {
    match kind {
        0 => {
            let mut coverage = Coverage::empty(size);
            coverage.pixels_mut().fill_with(|| random.below(256) as u8);
            AnySilhouette::Grey(coverage)
        }
        1 => {
            let rows: [u64; 64] = std::array::from_fn(|_| random.bits());
            AnySilhouette::Binary(Silhouette::from_rows(size, &rows))
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
            builder.add(&frame).expect("room");
            let is_ninths = matches!(frame, AnySilhouette::Ninths(_));
            let coverage = frame.to_coverage();
            for (sum, &pixel) in sums.iter_mut().zip(coverage.pixels()) {
                // The ninth follows from the byte.
                let ninths = (f64::from(pixel) * 9.0 / 255.0).round();
                *sum += if is_ninths {
                    ninths * 255.0 / 9.0
                } else {
                    f64::from(pixel)
                };
            }
        }
        let found = builder.gei();
        for (&pixel, sum) in found.pixels().iter().zip(sums) {
            // Sums of ninths have rounding errors in f64; a half is a multiple of 1 / (18 frames).
            let mean = sum / f64::from(frames) + 1e-9;
            assert_eq!(f64::from(pixel), (mean + 0.5).floor(), "{mean} of {frames}");
        }
    }
}

/// Computes a template from all of its frames together, before rounding to bytes.
fn expected(kind: TemplateKind, frames: &[AnySilhouette]) -> Vec<f64> {
    let size = frames[0].size();
    let count = frames.len();
    let tau = (count - 1).max(1) as f64;
    let on: Vec<Vec<bool>> = frames
        .iter()
        .map(|frame| {
            let coverage = frame.silhouette().to_coverage();
            coverage.pixels().iter().map(|&byte| byte > 0).collect()
        })
        .collect();
    // The covered share, 0 to 1; ninths exactly.
    let covered: Vec<Vec<f64>> = frames
        .iter()
        .map(|frame| {
            let is_ninths = matches!(frame, AnySilhouette::Ninths(_));
            let share = |&byte: &u8| {
                let ninths = (f64::from(byte) * 9.0 / 255.0).round();
                if is_ninths {
                    ninths / 9.0
                } else {
                    f64::from(byte) / 255.0
                }
            };
            frame.to_coverage().pixels().iter().map(share).collect()
        })
        .collect();
    let bytes: Vec<Coverage> = frames.iter().map(AnySilhouette::to_coverage).collect();
    let moved = |step: usize, pixel: usize| on[step][pixel] != on[step - 1][pixel];
    let mean = |pixel: usize| covered.iter().map(|f| f[pixel]).sum::<f64>() / count as f64;
    let of = |pixel: usize, frequency: usize| match kind {
        TemplateKind::Gei => 255.0 * mean(pixel),
        TemplateKind::Mei => {
            let has = (1..count).any(|step| moved(step, pixel));
            255.0 * f64::from(u8::from(has))
        }
        TemplateKind::Mhi => {
            // Bobick & Davis, equation 1, step by step.
            let step = |value: f64, step| {
                if moved(step, pixel) {
                    tau
                } else {
                    (value - 1.0).max(0.0)
                }
            };
            255.0 * (1..count).fold(0.0, step) / tau
        }
        TemplateKind::Msi => {
            let frame = |value: f64, frame: &Vec<bool>| {
                if frame[pixel] {
                    255.0
                } else {
                    (value - 1.0).max(0.0)
                }
            };
            on.iter().fold(0.0, frame)
        }
        TemplateKind::Ghi => {
            let steps = (count - 1) as f64;
            let last = (1..count).rfind(|&step| moved(step, pixel));
            if on.iter().all(|frame| frame[pixel]) {
                255.0
            } else {
                last.map_or(0.0, |last| {
                    255.0 * last as f64 / steps * (1.0 - 1.0 / steps)
                })
            }
        }
        TemplateKind::Geni => {
            let p = mean(pixel).clamp(0.0, 1.0);
            let term = |p: f64| if p > 1e-12 { -p * p.log2() } else { 0.0 };
            term(p) + term(1.0 - p)
        }
        TemplateKind::Frequency if frequency == 0 => 255.0 * mean(pixel),
        TemplateKind::Frequency => {
            let (mut re, mut im) = (0.0, 0.0);
            for (number, bytes) in bytes.iter().enumerate() {
                let byte = f64::from(bytes.pixels()[pixel]);
                let turns = (frequency * number) as f64 / count as f64;
                re += byte * (std::f64::consts::TAU * turns).cos();
                im -= byte * (std::f64::consts::TAU * turns).sin();
            }
            re.hypot(im) / count as f64
        }
        other => panic!("no oracle of {}", other.name()),
    };
    let planes = (0..kind.planes()).flat_map(|plane| (0..size.pixels()).map(move |at| (at, plane)));
    let mut values: Vec<f64> = planes.map(|(pixel, plane)| of(pixel, plane)).collect();
    if kind == TemplateKind::Geni {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let range = largest - least;
        for value in &mut values {
            *value = if range > 1e-12 {
                (*value - least) * 255.0 / range
            } else {
                0.0
            };
        }
    }
    values
}

#[test]
fn every_template_is_what_its_definition_gives_of_all_frames_at_once() {
    let mut random = Random(7);
    let counts = [1, 2, 3, 9, 33, 120];
    for (turn, count) in counts.into_iter().flat_map(|count| [count; 3]).enumerate() {
        let size = Size::ALL[turn % 2 + turn % 3 / 2];
        let mut frames: Vec<AnySilhouette> = (0..count)
            .map(|_| frame(&mut random, turn % 3, size))
            .collect();
        // Some pixels that hardly change, or never.
        if let [first, .., _] = frames[..] {
            frames
                .iter_mut()
                .skip(1)
                .step_by(2)
                .for_each(|frame| *frame = first);
        }
        for kind in TemplateKind::ALL {
            let mut builder = TemplateBuilder::for_kind(kind, size, count);
            for frame in &frames {
                builder.add(frame).expect("room");
            }
            let mut found = vec![0; kind.bytes(size)];
            builder.finish(&mut found);
            let expected = expected(kind, &frames);
            assert_eq!(found.len(), expected.len());
            for (&byte, value) in found.iter().zip(expected) {
                let off = f64::from(byte) - value;
                // Rounded half up; a value too near a half may be either.
                assert!(
                    (-0.5 - 1e-3..0.5 + 1e-3).contains(&off),
                    "{kind:?} of {count} frames: {byte} for {value}"
                );
            }
        }
    }
}

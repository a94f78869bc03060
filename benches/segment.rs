//! Segmenting frames of 480 by 240 pixels, on one thread: alone, and from JPEG to PNG. The command
//! takes 33 MB for such a video on one thread, of any length (`/usr/bin/time -v edgegait segment
//! frames --threads 1 ...`, 2026-11-24).

use criterion::{Criterion, Throughput};
use edgegait::segment::{SegmentSettings, Segmenter};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _, ImageFormat, Rgb, RgbImage};
use std::hint::black_box;
use std::io::Cursor;

#[expect(dead_code, reason = "no pack is drawn here")]
mod common;

const SIZE: (u32, u32) = (480, 240);

fn main() {
    let mut criterion = common::criterion();
    segment(&mut criterion);
    criterion.final_summary();
}

/// Returns a wall with noise, optionally with a figure of 60 by 130 pixels.
fn picture(seed: u32, has_figure: bool) -> RgbImage {
    let mut state = seed;
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = (state >> 29) as u8;
        let is_on = has_figure && (200..260).contains(&x) && (60..190).contains(&y);
        Rgb(if is_on {
            [60 + noise, 40 + noise, 90 + noise]
        } else {
            [140 + noise, 130 + noise, (x / 4) as u8 + noise]
        })
    })
}

fn segment(criterion: &mut Criterion) {
    let segmenter = Segmenter::new(picture(1, false), SegmentSettings::default());
    let frame = picture(2, true);
    let mut jpeg = Cursor::new(Vec::new());
    frame
        .write_to(&mut jpeg, ImageFormat::Jpeg)
        .expect("a JPEG");
    let jpeg = jpeg.into_inner();
    let mut group = criterion.benchmark_group("segment");
    group.throughput(Throughput::Elements(1));
    group.bench_function("frame/480x240", |b| {
        b.iter(|| segmenter.segment(black_box(&frame)));
    });
    group.bench_function("jpeg-to-png/480x240", |b| {
        b.iter(|| {
            let frame = image::load_from_memory(black_box(&jpeg)).expect("a JPEG");
            let found = segmenter.segment(&frame.into_rgb8());
            let mut bytes = Vec::new();
            PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::NoFilter)
                .write_image(&found.mask.grey(), SIZE.0, SIZE.1, ExtendedColorType::L8)
                .expect("a PNG");
            bytes
        });
    });
    group.finish();
}

//! What a frame costs while gait cycles are looked for, and the measure of its legs.

mod common;

use criterion::{BenchmarkId, Criterion, Throughput};
use edgegait_core::cycle::{CycleDetector, LowerBody};
use edgegait_core::silhouette::{Silhouette, Size};
use std::f32::consts::TAU;
use std::hint::black_box;

/// Ten seconds.
const SECONDS: u16 = 10;

fn main() {
    let mut criterion = common::criterion();
    detector(&mut criterion);
    lower_body(&mut criterion);
    criterion.final_summary();
}

/// Frames of somebody who makes two steps a second, `swing` of whose width swings: much seen from a
/// side, where the width is enough, and little from in front, where the pixels are asked as well.
fn walk(rate_hz: u16, swing: f32) -> Vec<LowerBody> {
    let frames = 0..SECONDS * rate_hz;
    let legs = frames.map(|frame| {
        let wave = (f32::from(frame) / f32::from(rate_hz) * 2.0 * TAU).cos();
        LowerBody {
            pixels: 900.0 + 60.0 * wave,
            width: 40.0 * (1.0 + swing * wave),
        }
    });
    legs.collect()
}

/// Each frame of ten seconds, the first ones, which are too few to be looked at, included.
fn detector(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cycle");
    for (view, swing) in [("side", 0.4), ("front", 0.04)] {
        for rate_hz in [10, 30, 60, 120_u16] {
            let frames = walk(rate_hz, swing);
            group.throughput(Throughput::Elements(frames.len() as u64));
            let case = BenchmarkId::new(view, format!("{rate_hz}-hz"));
            group.bench_with_input(case, &frames, |b, frames| {
                b.iter(|| {
                    let mut detector = CycleDetector::new(rate_hz.into()).expect("a frame rate");
                    let found = frames.iter().filter_map(|legs| detector.push(Some(*legs)));
                    black_box(found.count())
                });
            });
        }
    }
    group.finish();
}

fn lower_body(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cycle");
    for size in Size::ALL {
        let silhouette = Silhouette::from_rows(size, &[0b1111 << 12; 64]);
        group.throughput(Throughput::Elements(1));
        let case = BenchmarkId::new("lower-body", size.name());
        group.bench_with_input(case, &silhouette, |b, silhouette| {
            b.iter(|| LowerBody::of(black_box(silhouette)));
        });
    }
    group.finish();
}

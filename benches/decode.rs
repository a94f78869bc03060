//! Decoding: one pose of 19 joints from a compressed gait cycle, from its bytes or from
//! coefficients that were unpacked once, and from an uncut motion.

mod common;

use criterion::{BenchmarkId, Criterion};
use edgegait_core::pack::Pack;
use std::fs;
use std::hint::black_box;

/// An uncut motion of four seconds: starting to walk and turning.
const TAKE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/golden/v1-take.egp");

fn main() {
    let mut criterion = common::criterion();
    decode(&mut criterion);
    criterion.final_summary();
}

fn decode(criterion: &mut Criterion) {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let cycle = pack.clip(0).and_then(|clip| clip.as_loop());
    let cycle = cycle.expect("a first loop");
    let mut buffer = vec![0.0; cycle.expanded_len()];
    let expanded = cycle.expand(&mut buffer).expect("a buffer of that length");
    // Steps of a little more than a third of a cycle, so that phases never repeat exactly.
    let mut phase = 0.0f32;
    let take_bytes = fs::read(TAKE).expect("the golden take");
    let take_pack = Pack::parse(&take_bytes).expect("a pack");
    let take = take_pack.clip(0).expect("a take");
    let mut group = criterion.benchmark_group("decode");
    group.bench_function(BenchmarkId::new("pose", "loop-streamed"), |b| {
        b.iter(|| {
            phase = (phase + 0.337).fract();
            black_box(cycle.pose(black_box(phase)))
        });
    });
    group.bench_function(BenchmarkId::new("pose", "loop-expanded"), |b| {
        b.iter(|| {
            phase = (phase + 0.337).fract();
            black_box(expanded.pose(black_box(phase)))
        });
    });
    group.bench_function(BenchmarkId::new("pose", "uncut-streamed"), |b| {
        b.iter(|| {
            phase = (phase + 0.337).fract();
            black_box(take.sample(black_box(f64::from(phase) * take.duration_s())))
        });
    });
    group.bench_function(
        BenchmarkId::new("pack", format!("{}-bytes", pack.len_bytes())),
        |b| b.iter(|| Pack::parse(black_box(&bytes)).is_ok()),
    );
    group.finish();
}

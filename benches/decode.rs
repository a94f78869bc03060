//! Decoding: one pose of 19 joints from a compressed gait cycle.

mod common;

use criterion::{BenchmarkId, Criterion};
use edgegait_core::pack::Pack;
use edgegait_core::skeleton::JOINTS;
use std::hint::black_box;

fn main() {
    let mut criterion = common::criterion();
    decode(&mut criterion);
    criterion.final_summary();
}

fn decode(criterion: &mut Criterion) {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let clip = pack.clip(0).expect("a first clip");
    // A third of a cycle and a bit: phases that never repeat exactly.
    let mut phase = 0.0f32;
    let mut group = criterion.benchmark_group("decode");
    group.bench_function(BenchmarkId::new("pose", format!("{JOINTS}-joints")), |b| {
        b.iter(|| {
            phase = (phase + 0.337).fract();
            black_box(clip.pose(black_box(phase)))
        });
    });
    group.bench_function(
        BenchmarkId::new("pack", format!("{}-bytes", pack.len_bytes())),
        |b| b.iter(|| Pack::parse(black_box(&bytes)).is_ok()),
    );
    group.finish();
}

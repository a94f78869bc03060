//! Posing: forward kinematics, and moving a body's hulls.

mod common;

use criterion::{BenchmarkId, Criterion};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::skeleton::JOINTS;
use std::hint::black_box;

fn main() {
    let mut criterion = common::criterion();
    pose(&mut criterion);
    criterion.final_summary();
}

fn pose(criterion: &mut Criterion) {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let avatar = pack.avatar(0).expect("a first avatar");
    let skeleton = avatar.skeleton();
    let pose = pack.clip(0).expect("a first clip").sample(0.3);
    let model = ModelPose::new(&skeleton, &pose);
    let body = UnpackedBody::new(&avatar);
    let mut figure = Figure::new(&body, &model);
    let points = figure.len();

    let mut group = criterion.benchmark_group("pose");
    group.bench_function(
        BenchmarkId::new("kinematics", format!("{JOINTS}-joints")),
        |b| b.iter(|| ModelPose::new(black_box(&skeleton), black_box(&pose))),
    );
    group.bench_function(BenchmarkId::new("hulls", format!("{points}-points")), |b| {
        b.iter(|| {
            figure.update(black_box(&model));
            black_box(&figure);
        });
    });
    group.finish();
}

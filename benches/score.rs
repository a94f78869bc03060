//! Recognizing: a fitted PCA + LDA recognizer on the embedded runtime, with one GEI and with 64;
//! and the shipped networks, with one input each, on the embedded runtime and, if
//! `EDGEGAIT_ORT_LIB` names its library, on ONNX Runtime.

mod common;

use criterion::{BenchmarkId, Criterion, Throughput};
use edgegait::Template;
use edgegait::draw::sweep::{Job, Settings, Views, sweep};
use edgegait::inference::{Contract, Model, Recognizer, Runtime, shipped};
use edgegait::train::{TrainOptions, fit, onnx};
use edgegait_core::budget::PIXELS;
use edgegait_core::pack::Pack;
use ndarray::ArrayView2;
use std::hint::black_box;
use std::path::Path;

/// The cycles of each person, each seen from two sides.
const CYCLES: u32 = 8;

fn main() {
    let mut criterion = common::criterion();
    score(&mut criterion);
    criterion.final_summary();
}

fn score(criterion: &mut Criterion) {
    let (geis, people) = geis();
    let recognizer = recognizer(&geis, &people);

    let mut group = criterion.benchmark_group("score");
    for batch in [1, 64] {
        group.throughput(Throughput::Elements(batch as u64));
        let case = BenchmarkId::new("rten-pca-lda", format!("batch-{batch}"));
        let input = &geis[..batch * PIXELS];
        group.bench_function(case, |b| {
            b.iter(|| recognizer.run(black_box(input), batch).expect("a batch"));
        });
    }
    let mut runtimes = vec![("rten", Runtime::rten())];
    if let Some(library) = std::env::var_os("EDGEGAIT_ORT_LIB") {
        runtimes.push(("ort", Runtime::ort(library).expect("ONNX Runtime")));
    }
    group.throughput(Throughput::Elements(1));
    for name in ["gei-small", "geinet", "geinet-int8", "gaitset-small"] {
        let model = shipped::open(Path::new(name)).expect("a shipped model");
        // A sequence repeats one image, as the time does not depend on the values.
        let frames = match model.contract().template {
            Template::Silhouettes => 8,
            _ => 1,
        };
        let input = geis[..PIXELS].repeat(frames);
        for (runtime_name, runtime) in &runtimes {
            let recognizer = runtime.load(&model).expect("both run it");
            let case = BenchmarkId::new(format!("{runtime_name}-{name}"), "batch-1");
            group.bench_function(case, |b| {
                b.iter(|| recognizer.run(black_box(&input), 1).expect("an answer"));
            });
        }
    }
    group.finish();
}

/// Returns GEIs in 0..1, and the person of each.
fn geis() -> (Vec<f32>, Vec<usize>) {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let jobs: Vec<Job> = (0..pack.walks().len())
        .flat_map(|walk| (0..CYCLES).map(move |cycle| Job::plain(walk, cycle)))
        .collect();
    let views = Views::grid("sides", [45.0, 90.0], [0.0]).expect("two viewpoints");
    let settings = Settings::default();
    let (mut pixels, mut people) = (Vec::new(), Vec::new());
    let sink = |job: Job, swept: edgegait::draw::sweep::Swept| {
        for gei in swept.templates {
            pixels.extend(gei.iter().map(|&pixel| f32::from(pixel) / 255.0));
            people.push(job.walk);
        }
        Ok(())
    };
    let keep = |_, swept| Ok(swept);
    sweep(&pack, &jobs, &views.list, settings, keep, sink).expect("walkers can be drawn");
    (pixels, people)
}

fn recognizer(geis: &[f32], people: &[usize]) -> Box<dyn Recognizer> {
    let samples = ArrayView2::from_shape((people.len(), PIXELS), geis).expect("whole GEIs");
    let classes = people.iter().max().map_or(0, |last| last + 1);
    let fitted = fit(samples, people, classes, TrainOptions::default()).expect("different people");
    let bytes = onnx::write(&fitted, "bench", &[]);
    let model = Model::from_bytes("bench.onnx", bytes, Contract::default()).expect("our own model");
    Runtime::rten().load(&model).expect("plain operators")
}

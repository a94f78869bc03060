//! A sweep on the host: eight cycles of one person from 19 azimuths, on 1 and 2 threads (and
//! how long these are idle), and under confounders; and two cycles from the paper's 703 viewpoints, with one framing per cycle.
//!
//! Criterion's elements are silhouettes: 8 cycles x 19 views x 32 frames = 4,864, and 2 cycles
//! x 703 views x 32 frames = 44,992.

mod common;

use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput};
use edgegait::draw::sweep::{
    FRAMES_PER_CYCLE, FramingMode, Job, Raster, Settings, View, Views, sweep,
};
use edgegait::{Condition, Doses, dose};
use edgegait_core::pack::Pack;
use edgegait_core::raster::Rasterizer;
use std::hint::black_box;
#[cfg(target_os = "linux")]
use std::time::{Duration, Instant};

const CYCLES: u32 = 8;
/// The cycles that are seen from all 703 viewpoints.
const CYCLES_OF_ALL: u32 = 2;

fn main() {
    let mut criterion = common::criterion();
    sweeps(&mut criterion);
    criterion.final_summary();
}

fn sweeps(criterion: &mut Criterion) {
    let bytes = common::pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let azimuths = (0..=180u8).step_by(10).map(f32::from);
    let views = Views::grid("azimuths", azimuths, [0.0]).expect("19 viewpoints");
    let silhouettes = u64::from(CYCLES * FRAMES_PER_CYCLE) * views.list.len() as u64;

    let mut group = criterion.benchmark_group("sweep");
    group.sampling_mode(SamplingMode::Flat).sample_size(20);
    group.throughput(Throughput::Elements(silhouettes));
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("two threads at most");
        let case = BenchmarkId::new(
            format!("skia-threads-{threads}"),
            format!("{}-views", views.list.len()),
        );
        group.bench_function(case, |b| {
            let settings = Settings::default();
            b.iter(|| pool.install(|| geis(black_box(&pack), CYCLES, &views.list, settings)));
        });
    }
    #[cfg(target_os = "linux")]
    group
        .sample_size(10)
        .bench_function("skia-idle-of-2/19-views", |b| {
            b.iter_custom(|sweeps| idle_of_two(&pack, &views.list, sweeps));
        });
    group.sample_size(20);
    // The costs of confounders of each stage: on hulls, on poses, on silhouettes.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.expect("one thread");
    for confounder in ["none", "backpack", "coat", "asymmetric-gait", "holes"] {
        let case = BenchmarkId::new(
            format!("confounders-{confounder}"),
            format!("{}-views", views.list.len()),
        );
        let settings = Settings {
            rasterizer: Rasterizer::Rows.into(),
            ..Settings::default()
        };
        let condition = condition(confounder);
        group.bench_function(case, |b| {
            b.iter(|| pool.install(|| under(black_box(&pack), &condition, &views.list, settings)));
        });
    }
    let views = Views::paper().expect("the grid").list;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.expect("one thread");
    group.throughput(Throughput::Elements(
        u64::from(CYCLES_OF_ALL * FRAMES_PER_CYCLE) * views.len() as u64,
    ));
    for rasterizer in [Raster::Columns, Rasterizer::Rows.into()] {
        let case = BenchmarkId::new(
            format!("{rasterizer}-threads-1"),
            format!("{}-views", views.len()),
        );
        let settings = Settings {
            rasterizer,
            framing: FramingMode::Cycle,
            ..Settings::default()
        };
        group.bench_function(case, |b| {
            b.iter(|| pool.install(|| geis(black_box(&pack), CYCLES_OF_ALL, &views, settings)));
        });
    }
    group.finish();
}

/// Returns the time per eight cycles that two threads of one sweep are idle, for a number of sweeps,
/// from processor time.
///
/// Two threads against one would judge the machine, whose processors may share a core.
#[cfg(target_os = "linux")]
fn idle_of_two(pack: &Pack<'_>, views: &[View], sweeps: u64) -> Duration {
    // More cycles than elsewhere: stolen time is counted in hundredths of a second, and at the end one
    // thread waits for the other's last cycle.
    const TIMES: u32 = 32;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let pool = pool.expect("two threads");
    let jobs: Vec<Job<'_>> = (0..TIMES * CYCLES)
        .map(|cycle| Job::plain(0, cycle % CYCLES))
        .collect();
    let start = (Instant::now(), processor_time());
    for _ in 0..sweeps {
        pool.install(|| swept(black_box(pack), &jobs, views, Settings::default()));
    }
    let busy = processor_time() - start.1;
    // Criterion refuses times of zero.
    (2 * start.0.elapsed())
        .saturating_sub(busy)
        .max(Duration::from_nanos(1_000))
        / TIMES
}

/// Returns the time that processors spent on the threads of this process or, in a virtual machine,
/// had for others (`steal` of `proc_stat(5)`, in hundredths of a second).
#[cfg(target_os = "linux")]
fn processor_time() -> Duration {
    let own = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    let stat = std::fs::read_to_string("/proc/stat").expect("a table of the kernel");
    let stolen = stat.split_whitespace().nth(8).map(str::parse::<u64>);
    let stolen = stolen.expect("eight columns").expect("ticks");
    Duration::try_from(own).expect("not negative") + Duration::from_millis(10 * stolen)
}

/// Returns the condition of a confounder at half of its strength, or of none.
fn condition(name: &str) -> Condition {
    let doses = match name {
        "none" => Vec::new(),
        name => vec![dose(&format!("{name}=0.5")).expect("a confounder")],
    };
    Condition::from_doses(Doses::new(doses))
}

/// Sweeps cycles of the first walk and returns the number of GEIs.
fn geis(pack: &Pack<'_>, cycles: u32, views: &[View], settings: Settings) -> usize {
    let jobs: Vec<Job<'_>> = (0..cycles).map(|cycle| Job::plain(0, cycle)).collect();
    swept(pack, &jobs, views, settings)
}

/// Sweeps cycles of the first walk under a condition and returns the number of GEIs.
fn under(pack: &Pack<'_>, condition: &Condition, views: &[View], settings: Settings) -> usize {
    let jobs: Vec<Job<'_>> = (0..CYCLES).map(|cycle| Job::plain(0, cycle)).collect();
    let jobs = Job::under(&jobs, std::slice::from_ref(condition));
    swept(pack, &jobs, views, settings)
}

fn swept(pack: &Pack<'_>, jobs: &[Job<'_>], views: &[View], settings: Settings) -> usize {
    let mut made = 0;
    let sink = |_, geis: usize| {
        made += geis;
        Ok(())
    };
    let count = |_, swept: edgegait::draw::sweep::Swept| Ok(black_box(swept).templates.len());
    sweep(pack, jobs, views, settings, count, sink).expect("a walker can be drawn");
    made
}

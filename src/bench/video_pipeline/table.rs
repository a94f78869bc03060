//! The table of the pipeline's results.

use super::results::PathResult;
use crate::bench::cells::{ResultRow, degrees, megabytes, of_clocks, per_second, us};
use crate::bench::statistics::Times;
use crate::report::microseconds;

/// The rows of the table.
pub(in crate::bench) const ROWS: [ResultRow<PathResult>; 25] = [
    ("runtime", |p| Some(p.runtime.to_string())),
    ("threads: inference, all else", |p| {
        Some(format!("{}, {}", p.threads, p.path_threads))
    }),
    ("input", |p| Some(p.template.clone())),
    ("video", |p| {
        let video = &p.video;
        Some(format!(
            "{}x{}, {} frames at {} a second, gait cycles: {}",
            video.columns, video.rows, video.frames, video.fps, video.cycles
        ))
    }),
    ("measured, s", |p| Some(format!("{:.1}", p.rates.seconds))),
    ("frames a second", |p| {
        Some(per_second(p.rates.frames_per_second))
    }),
    ("times real time", |p| {
        Some(format!("{:.2}", p.rates.times_real_time))
    }),
    ("frames a second: first, last, slowest window", |p| {
        let rates = &p.rates;
        let windows = [
            rates.first_per_second,
            rates.last_per_second,
            rates.slowest_per_second,
        ];
        Some(windows.map(per_second).join(", "))
    }),
    ("frames a second without decoding", |p| {
        Some(per_second(p.rates.without_decoding_per_second))
    }),
    ("a frame: p50, p90, p99, us", |p| some(&p.stages.frame)),
    ("decode", |p| some(&p.stages.decode)),
    ("segment", |p| some(&p.stages.segment)),
    ("frame the figure", |p| some(&p.stages.framing)),
    ("detect the cycle", |p| some(&p.stages.cycle)),
    ("a cycle's template", |p| some(&p.stages.template)),
    ("network", |p| some(&p.stages.network)),
    ("answers a second", |p| {
        Some(per_second(p.answers.per_second))
    }),
    ("an answer, once its cycle is known: p50, us", |p| {
        us(p.answers.times.p50_us)
    }),
    ("delay of the cycle's detection, frames: mean, max", |p| {
        Some(format!(
            "{:.1}, {}",
            p.answers.waited_frames_mean, p.answers.waited_frames_most
        ))
    }),
    ("load, ms", |p| Some(format!("{:.2}", p.load_ms))),
    ("peak memory: first answer, end", |p| {
        let both = [p.peak_rss_start_bytes?, p.peak_rss_end_bytes?];
        Some(both.map(megabytes).join(", "))
    }),
    ("energy of a frame, mJ", |p| {
        Some(format!("{:.3}", p.energy.as_ref()?.frame_mj))
    }),
    ("energy meter", |p| Some(p.energy.as_ref()?.source.clone())),
    ("clock: start, end", |p| of_clocks(&p.conditions)),
    ("temperature, C: start, highest, end", |p| {
        degrees(&p.conditions)
    }),
];

/// Returns the median, p90 and p99, with `-` for absent ones.
fn some(times: &Times) -> Option<String> {
    let all = [Some(times.p50_us), times.p90_us, times.p99_us];
    let all = all.map(|us| us.map_or("-".to_owned(), |us| microseconds(us, ",")));
    Some(all.join(", "))
}

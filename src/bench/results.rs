//! The results of `edgegait bench`, as the JSON that it writes.

use super::accuracy::Accuracy;
use super::board::Board;
use super::conditions::MachineConditions;
use super::statistics::median_index;
use super::timing::Timing;
use super::video_pipeline::PathResult;
use super::windows::MeasuredWindow;
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use crate::inference::{OperatorTime, RuntimeName};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The results of `edgegait bench`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BenchResults {
    /// The command, version and settings that produced the results.
    #[serde(flatten)]
    pub header: ResultHeader,
    /// The date, UTC, such as `2026-11-21T20:38:00Z`.
    pub date: String,
    /// The machine.
    pub board: Board,
    /// The share of the processors that other processes kept busy before the measurement, 0..1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_of_others: Option<f64>,
    /// One entry per model, in the order given.
    pub models: Vec<ModelResult>,
    /// The results of `--video`, one per model, if that was measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub paths: Vec<PathResult>,
}

/// The costs of one model. Times are in microseconds unless their name states another unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ModelResult {
    /// The model's name, usually that of its file.
    pub name: String,
    /// The runtime that ran the model.
    pub runtime: RuntimeName,
    /// The number of threads within one inference.
    pub threads: usize,
    /// Shape of the input for one inference.
    pub input: Vec<usize>,
    /// The size of the file, bytes.
    pub bytes: u64,
    /// The number of parameters, as counted by [`crate::inference::Graph::parameters`].
    pub params: u64,
    /// The multiply-accumulates of one inference, as counted by [`crate::inference::Graph::macs`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub macs: Option<u64>,
    /// The reason why the multiply-accumulates are absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub macs_unknown: Option<String>,
    /// The time to start the runtime, milliseconds; for ONNX Runtime, to load its library.
    pub runtime_load_ms: f64,
    /// The time from the model's path to a recognizer that is ready, milliseconds.
    pub load_ms: f64,
    /// The time of the first inference, milliseconds.
    pub first_ms: f64,
    /// The times of single inferences.
    #[serde(flatten)]
    pub single: Timing,
    /// The peak memory of the process after its first single inference and the warm-up, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_bytes: Option<u64>,
    /// That peak less the memory before the runtime was started, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_over_baseline_bytes: Option<u64>,
    /// Inferences in batches, if time and memory allowed any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offline: Option<Offline>,
    /// Batches of the other requested sizes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub batches: Vec<Offline>,
    /// The time of each operator, if requested and reported by the runtime.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub operators: Vec<OperatorTime>,
    /// The times of drawing an input, and of drawing and inference.
    pub parts: AnswerParts,
    /// The times of loops around ONNX Runtime alone, in the same run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bare: Option<BareLoops>,
    /// Energy, where the machine meters it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<Energy>,
    /// The model's accuracy with this runtime and these settings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// The costs of inputs of other lengths, if requested.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lengths: Vec<Length>,
    /// The time limit of the measurement, seconds; none if it had no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_seconds: Option<f64>,
    /// The duration from the first inference on, seconds; none in results of versions that do not
    /// state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// What was cut to stay within the time limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut: Option<LeftOut>,
    /// The state of the machine during the measurement.
    pub conditions: MachineConditions,
    /// The share of the processors that other processes kept busy during the measurement, 0..1, if
    /// known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub others_busy: Option<f64>,
    /// Reasons to doubt these numbers.
    pub warnings: Vec<String>,
}

/// The work that was left out to stay within the time limit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct LeftOut {
    /// A description of each part.
    pub what: Vec<String>,
    /// The estimated time of the full measurement, seconds.
    pub full_seconds: f64,
}

/// Inferences in batches, with the times of a whole batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Offline {
    /// The number of inferences in a batch.
    pub batch: usize,
    /// The requested number; none in results of versions that do not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batch_planned: Option<usize>,
    /// The times of batches.
    #[serde(flatten)]
    pub timing: Timing,
    /// The peak memory of the process with batches, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_bytes: Option<u64>,
}

/// The times of what an answer takes besides the inference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct AnswerParts {
    /// The times of making one input from the pack: decode, pose, project, draw and average, on one
    /// thread.
    pub preprocessing: Timing,
    /// The times of making one input and its inference.
    pub end_to_end: Timing,
}

/// Loops around the runtime alone, whose windows alternate with those of EdgeGait.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BareLoops {
    /// The times of the usual loop: the input is in memory, and each call allocates its outputs.
    #[serde(flatten)]
    pub timing: Timing,
    /// EdgeGait's overhead: the median over pairs of windows of its p50 over the loop's p50, less
    /// 1.
    pub overhead: f64,
    /// The median time of a loop that reuses the output tensors, microseconds.
    pub reusing_p50_us: f64,
    /// EdgeGait's overhead over the loop that reuses the output tensors.
    pub overhead_reusing: f64,
}

impl BareLoops {
    /// Compares windows that alternated; none if there are none.
    #[must_use]
    pub(crate) fn compare(
        ours: &[MeasuredWindow],
        bare: &[MeasuredWindow],
        reusing: &[MeasuredWindow],
    ) -> Option<Self> {
        let overhead = |bare: &[MeasuredWindow]| -> Option<f64> {
            let pairs = ours.iter().zip(bare);
            let ratios: Vec<f64> = pairs
                .map(|(a, b)| a.times.p50_us / b.times.p50_us)
                .collect();
            Some(ratios[median_index(&ratios)?] - 1.0)
        };
        Some(Self {
            timing: Timing::from_windows(bare, 1)?,
            overhead: overhead(bare)?,
            reusing_p50_us: Timing::from_windows(reusing, 1)?.times.p50_us,
            overhead_reusing: overhead(reusing)?,
        })
    }
}

/// The energy of all that the meter covers, per inference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Energy {
    /// The name of the meter.
    pub source: String,
    /// The energy of a single inference, millijoules.
    pub single_mj: f64,
    /// The energy of an inference in the largest batch, millijoules.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offline_mj: Option<f64>,
}

/// Returns the millijoules per inference over all windows; none if a window was not metered.
pub(super) fn millijoules(windows: &[MeasuredWindow], batch: usize) -> Option<f64> {
    let joules = windows
        .iter()
        .map(|window| window.energy_j)
        .sum::<Option<f64>>()?;
    let calls: u64 = windows.iter().map(|window| window.times.calls).sum();
    Some(1e3 * joules / (calls * batch as u64) as f64)
}

impl ModelResult {
    /// Records further work that was cut.
    pub(crate) fn add(&mut self, cut: Option<LeftOut>) {
        if let Some(more) = cut {
            let all = self.cut.get_or_insert_default();
            all.what.extend(more.what);
            all.full_seconds += more.full_seconds;
        }
    }
}

impl BenchResults {
    /// Reads the results of `edgegait bench` from JSON.
    ///
    /// # Errors
    /// If the file cannot be read, or holds something else.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = crate::files::read_to_string(path)?;
        serde_json::from_str(&text).map_err(|error| {
            let expected = "expected the JSON results of edgegait bench";
            let stated: Option<serde_json::Value> = serde_json::from_str(&text).ok();
            let command = stated.as_ref().and_then(|it| it.get("command")?.as_str());
            let problem = match command.filter(|command| *command != "bench") {
                Some(command) => format!("{expected}, found results of {command}"),
                None => format!("{expected}: {error}"),
            };
            Error::input(path, problem)
        })
    }
}

/// The costs of inputs of one length, one at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Length {
    /// The number of frames in an input.
    pub frames: usize,
    /// Shape of the input for one inference.
    pub input: Vec<usize>,
    /// The multiply-accumulates of one inference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub macs: Option<u64>,
    /// The time of the first inference on this length, milliseconds.
    pub first_ms: f64,
    /// The times of single inferences.
    #[serde(flatten)]
    pub timing: Timing,
    /// The peak memory of the process with this length, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_bytes: Option<u64>,
    /// That peak less the memory before the runtime was started, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_over_baseline_bytes: Option<u64>,
    /// The share of the processors that other processes kept busy during the measurement, 0..1, if
    /// known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub others_busy: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::statistics::Times;
    use crate::bench::timing::WorkExtent;
    use crate::bench::windows::TimingPlan;

    fn window(ns: &[u64], energy_j: Option<f64>) -> MeasuredWindow {
        let times = Times::from_samples(&mut ns.to_vec()).expect("times");
        MeasuredWindow { times, energy_j }
    }

    #[test]
    fn times_are_of_the_median_window_and_the_spread_is_of_all() {
        let windows = [
            window(&[3_000, 5_000], None),
            window(&[1_000, 1_000], None),
            window(&[2_000, 2_000], None),
        ];
        let timing = Timing::from_windows(&windows, 8).expect("windows");
        assert_eq!(timing.window_mean_us, [4.0, 1.0, 2.0]);
        assert_eq!((timing.times.mean_us, timing.spread), (2.0, 1.5));
        // Batches of 8 in 2 us each.
        assert!((timing.throughput - 4e6).abs() < 1e-6);
        assert_eq!(Timing::from_windows(&[], 1), None);
    }

    #[test]
    fn only_what_is_less_than_planned_is_stated() {
        let second = 1_000_000_000;
        let said = |planned: TimingPlan, made: TimingPlan, windows: &[MeasuredWindow], batch| {
            let mut timing = Timing::from_windows(windows, batch).expect("windows");
            timing.extent = Some(WorkExtent::from_windows(&planned, &made, windows, batch));
            timing.cut()
        };
        let full = TimingPlan::DEFAULT;
        let whole = vec![window(&[second / 100; 100], None); 5];
        assert_eq!(said(full, full, &whole, 1), None);
        let fewer = TimingPlan {
            warm_up: 1,
            windows: 2,
            inferences: 3,
            ..full
        };
        let windows = [window(&[second; 3], None), window(&[second; 4], None)];
        let expected = "2 of 5 windows, 3 to 4 of 100 inferences in each, 1 of 10 warm-up calls";
        assert_eq!(said(full, fewer, &windows, 1).as_deref(), Some(expected));
        // Three batches of 8; one window and no warm-up were requested.
        let one = TimingPlan {
            warm_up: 0,
            windows: 1,
            ..full
        };
        let expected = "24 of 100 inferences in it";
        let found = said(one, one, &windows[..1], 8);
        assert_eq!(found.as_deref(), Some(expected));
        // Enough inferences, in a window that is too short.
        let short = vec![window(&[second / 200; 100], None); 5];
        let expected = "windows of 0.50 s, not 1 s";
        assert_eq!(said(full, full, &short, 1).as_deref(), Some(expected));
        // Results of versions that do not state the plan.
        assert_eq!(
            Timing::from_windows(&windows, 1).and_then(|it| it.cut()),
            None
        );
    }

    #[test]
    fn overhead_is_the_median_of_pairs() {
        let windows = |p50: [u64; 3]| p50.map(|ns| window(&[ns], None));
        // 10 % more in a slow pair, 2 % and 3 % in the others.
        let (ours, bare) = (
            windows([1_020, 22_000, 1_030]),
            windows([1_000, 20_000, 1_000]),
        );
        let reusing = windows([500, 500, 500]);
        let found = BareLoops::compare(&ours, &bare, &reusing).expect("pairs");
        assert!((found.overhead - 0.03).abs() < 1e-12, "{}", found.overhead);
        // Of 2.04, 44 and 2.06 times as much.
        assert!((found.overhead_reusing - 1.06).abs() < 1e-12);
        assert_eq!(found.reusing_p50_us, 0.5);
    }

    #[test]
    fn energy_is_shared_by_all_inferences_or_absent() {
        let metered = [window(&[1; 4], Some(1.0)), window(&[1; 6], Some(2.0))];
        assert_eq!(millijoules(&metered, 2), Some(150.0));
        assert_eq!(millijoules(&[window(&[1], None)], 1), None);
    }
}

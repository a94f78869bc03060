//! The results of `edgegait bench`, as the JSON that it writes.

use super::accuracy::Accuracy;
use super::board::Board;
use super::conditions::MachineConditions;
use super::statistics::median_index;
use super::timing::Timing;
use super::video_pipeline::PathResult;
use super::windows::MeasuredWindow;
use crate::dataset::ResultHeader;
use crate::error::{Error, Result};
use crate::score::{OperatorTime, RuntimeName};
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
    /// The number of parameters, as counted by [`crate::score::Graph::parameters`].
    pub params: u64,
    /// The multiply-accumulates of one inference, as counted by [`crate::score::Graph::macs`].
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
    /// The same above what it had before the runtime was started, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_over_baseline_bytes: Option<u64>,
    /// Inferences in batches, if there was time and memory for any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offline: Option<Offline>,
    /// Batches of the other sizes that were asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub batches: Vec<Offline>,
    /// What each operator takes, if that was asked for and the runtime tells.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub operators: Vec<OperatorTime>,
    /// What comes before an inference, and both together.
    pub parts: AnswerParts,
    /// Loops around nothing but ONNX Runtime, in the same run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bare: Option<BareLoops>,
    /// Energy, where the machine meters it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<Energy>,
    /// How often it is right, with this runtime and these settings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Inputs of other lengths, if they were asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lengths: Vec<Length>,
    /// What its measuring might take, seconds; none if it had no end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_seconds: Option<f64>,
    /// What it took from the first inference on, seconds; none in results of versions that do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// What was cut to end in that time, if anything was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut: Option<LeftOut>,
    /// The machine while this was measured.
    pub conditions: MachineConditions,
    /// The share of its processors that others kept busy meanwhile, 0..1, if the machine tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub others_busy: Option<f64>,
    /// What should be known before these numbers are trusted.
    pub warnings: Vec<String>,
}

/// What was left out, because all of it would have taken longer than it might.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct LeftOut {
    /// Each thing, in words.
    pub what: Vec<String>,
    /// How long all of it would take, seconds, estimated.
    pub full_seconds: f64,
}

/// Inferences in batches; the times are those of a batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Offline {
    /// Inferences of a batch.
    pub batch: usize,
    /// How many they were to have; none in results of versions that do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batch_planned: Option<usize>,
    /// Times of batches.
    #[serde(flatten)]
    pub timing: Timing,
    /// The most memory that the process had with batches, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_bytes: Option<u64>,
}

/// From silhouettes to an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct AnswerParts {
    /// One input from the pack: decode, pose, project, draw and average, on one thread.
    pub preprocessing: Timing,
    /// The same and the inference.
    pub end_to_end: Timing,
}

/// Loops around nothing but the runtime, window by window in turn with ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BareLoops {
    /// Times of the usual loop: the input lies ready, the runtime makes outputs in each call.
    #[serde(flatten)]
    pub timing: Timing,
    /// The median over pairs of windows of our p50 over its p50, less 1.
    pub overhead: f64,
    /// Median time of the same with outputs in the same tensors each time, microseconds.
    pub reusing_p50_us: f64,
    /// Our overhead over that.
    pub overhead_reusing: f64,
}

impl BareLoops {
    /// Of windows that took turns; none of no windows.
    #[must_use]
    pub(crate) fn of(
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
            timing: Timing::of(bare, 1)?,
            overhead: overhead(bare)?,
            reusing_p50_us: Timing::of(reusing, 1)?.times.p50_us,
            overhead_reusing: overhead(reusing)?,
        })
    }
}

/// Energy of all that the counter sees, divided by the inferences.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Energy {
    /// What was read.
    pub source: String,
    /// Millijoules of an inference, one at a time.
    pub single_mj: f64,
    /// Millijoules of an inference in the largest batch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offline_mj: Option<f64>,
}

/// Millijoules of an inference over all windows; none if one was not metered.
pub(super) fn millijoules(windows: &[MeasuredWindow], batch: usize) -> Option<f64> {
    let joules = windows
        .iter()
        .map(|window| window.energy_j)
        .sum::<Option<f64>>()?;
    let calls: u64 = windows.iter().map(|window| window.times.calls).sum();
    Some(1e3 * joules / (calls * batch as u64) as f64)
}

impl ModelResult {
    /// More of it was cut.
    pub(crate) fn add(&mut self, cut: Option<LeftOut>) {
        if let Some(more) = cut {
            let all = self.cut.get_or_insert_default();
            all.what.extend(more.what);
            all.full_seconds += more.full_seconds;
        }
    }
}

impl BenchResults {
    /// Reads the JSON that `edgegait bench` wrote.
    ///
    /// # Errors
    /// If the file cannot be read, or holds something else.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|error| Error::io(path, error))?;
        serde_json::from_str(&text).map_err(|error| {
            let expected = "expected the JSON results of edgegait bench";
            let stated: Option<serde_json::Value> = serde_json::from_str(&text).ok();
            let command = stated.as_ref().and_then(|it| it.get("command")?.as_str());
            let problem = match command.filter(|command| *command != "bench") {
                Some(command) => format!("{expected}, found those of {command}"),
                None => format!("{expected}: {error}"),
            };
            Error::input(path, problem)
        })
    }
}

/// What inputs of one length cost, one at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Length {
    /// Frames of an input.
    pub frames: usize,
    /// Shape of the input for one inference.
    pub input: Vec<usize>,
    /// Multiply-accumulates of one inference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub macs: Option<u64>,
    /// The first inference on this length, milliseconds.
    pub first_ms: f64,
    /// Inferences one at a time.
    #[serde(flatten)]
    pub timing: Timing,
    /// The most memory that the process had with this length, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_bytes: Option<u64>,
    /// The same above what it had before the runtime was started, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_over_baseline_bytes: Option<u64>,
    /// The share of the processors that others kept busy meanwhile, 0..1, if the machine tells.
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
        let times = Times::of(&mut ns.to_vec()).expect("times");
        MeasuredWindow { times, energy_j }
    }

    #[test]
    fn the_median_window_speaks_and_the_spread_is_of_all() {
        let windows = [
            window(&[3_000, 5_000], None),
            window(&[1_000, 1_000], None),
            window(&[2_000, 2_000], None),
        ];
        let timing = Timing::of(&windows, 8).expect("windows");
        assert_eq!(timing.window_mean_us, [4.0, 1.0, 2.0]);
        assert_eq!((timing.times.mean_us, timing.spread), (2.0, 1.5));
        // Batches of 8 in 2 us each.
        assert!((timing.throughput - 4e6).abs() < 1e-6);
        assert_eq!(Timing::of(&[], 1), None);
    }

    #[test]
    fn what_is_less_than_was_planned_is_said_and_nothing_else() {
        let second = 1_000_000_000;
        let said = |planned: TimingPlan, made: TimingPlan, windows: &[MeasuredWindow], batch| {
            let mut timing = Timing::of(windows, batch).expect("windows");
            timing.extent = Some(WorkExtent::of(&planned, &made, windows, batch));
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
        let expected = "2 of 5 windows, 3 to 4 of 100 inferences in each, 1 of 10 calls to warm up";
        assert_eq!(said(full, fewer, &windows, 1).as_deref(), Some(expected));
        // Three batches of 8; nobody asked for more windows or a warm-up.
        let one = TimingPlan {
            warm_up: 0,
            windows: 1,
            ..full
        };
        let expected = "24 of 100 inferences in it";
        let found = said(one, one, &windows[..1], 8);
        assert_eq!(found.as_deref(), Some(expected));
        // Enough inferences in too short a time.
        let short = vec![window(&[second / 200; 100], None); 5];
        let expected = "windows of 0.50 s, not 1 s";
        assert_eq!(said(full, full, &short, 1).as_deref(), Some(expected));
        // Results of versions that do not say.
        assert_eq!(Timing::of(&windows, 1).and_then(|it| it.cut()), None);
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
        let found = BareLoops::of(&ours, &bare, &reusing).expect("pairs");
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

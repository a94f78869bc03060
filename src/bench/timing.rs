//! The times of inferences, as results state them.

use super::statistics::{Times, median_index};
use super::windows::{MeasuredWindow, TimingPlan};
use serde::{Deserialize, Serialize};

/// How much was planned, and how much was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct WorkExtent {
    /// The planned number of windows.
    pub windows_planned: u32,
    /// The number of windows.
    pub windows: u32,
    /// The planned minimum of inferences in each window.
    pub inferences_planned: u64,
    /// The number of inferences in each window.
    pub inferences: Vec<u64>,
    /// The planned number of untimed calls before each window.
    pub warm_up_planned: u32,
    /// The actual number of untimed calls before each window, at most.
    pub warm_up: u32,
    /// The planned minimum length of a window, seconds.
    pub window_s_planned: f64,
}

impl WorkExtent {
    /// Describes windows with `batch` inferences a call.
    #[must_use]
    pub(super) fn from_windows(
        planned: &TimingPlan,
        made: &TimingPlan,
        windows: &[MeasuredWindow],
        batch: usize,
    ) -> Self {
        Self {
            windows_planned: planned.windows,
            windows: u32::try_from(windows.len()).unwrap_or(u32::MAX),
            inferences_planned: planned.inferences,
            inferences: windows
                .iter()
                .map(|window| window.times.calls * batch as u64)
                .collect(),
            warm_up_planned: planned.warm_up,
            warm_up: made.warm_up,
            window_s_planned: planned.window.as_secs_f64(),
        }
    }

    /// Describes what is less than planned, such as `3 of 5 windows, 10 of 100 inferences in each`;
    /// none if nothing is. `window_s` is the length of the shortest window, seconds.
    #[must_use]
    pub(super) fn cut(&self, window_s: f64) -> Option<String> {
        let mut cut = Vec::new();
        if self.windows < self.windows_planned {
            cut.push(format!(
                "{} of {} windows",
                self.windows, self.windows_planned
            ));
        }
        let (least, most) = (self.inferences.iter().min(), self.inferences.iter().max());
        let (least, most) = (least.copied().unwrap_or(0), most.copied().unwrap_or(0));
        if least < self.inferences_planned {
            let made = if least == most {
                least.to_string()
            } else {
                format!("{least} to {most}")
            };
            let each = if self.windows == 1 { "it" } else { "each" };
            let planned = self.inferences_planned;
            cut.push(format!("{made} of {planned} inferences in {each}"));
        } else if window_s < 0.999 * self.window_s_planned {
            let planned = self.window_s_planned;
            cut.push(format!("windows of {window_s:.2} s, not {planned} s"));
        }
        if self.warm_up < self.warm_up_planned {
            cut.push(format!(
                "{} of {} warm-up calls",
                self.warm_up, self.warm_up_planned
            ));
        }
        (!cut.is_empty()).then(|| cut.join(", "))
    }
}

/// The summary of several windows of calls. Times and throughput are from the window whose mean is
/// the median of the windows' means (the lower of two).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Timing {
    /// The times of the median window's calls.
    #[serde(flatten)]
    pub times: Times,
    /// The inferences a second in the median window.
    pub throughput: f64,
    /// The mean of each window, in order.
    pub window_mean_us: Vec<f64>,
    /// The spread of windows: their largest mean less their smallest, over the median.
    pub spread: f64,
    /// How much was planned and measured; none in results of versions that do not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extent: Option<WorkExtent>,
}

impl Timing {
    /// Summarises windows with `batch` inferences a call; none if there are none.
    #[must_use]
    pub(crate) fn from_windows(windows: &[MeasuredWindow], batch: usize) -> Option<Self> {
        let window_mean_us: Vec<f64> = windows.iter().map(|w| w.times.mean_us).collect();
        let times = windows[median_index(&window_mean_us)?].times;
        let most = window_mean_us.iter().copied().fold(0.0, f64::max);
        let least = window_mean_us.iter().copied().fold(f64::INFINITY, f64::min);
        Some(Self {
            throughput: 1e6 * batch as f64 / times.mean_us,
            spread: (most - least) / times.mean_us,
            window_mean_us,
            times,
            extent: None,
        })
    }

    /// Describes what is less than planned; none if nothing is.
    #[must_use]
    pub(super) fn cut(&self) -> Option<String> {
        let extent = self.extent.as_ref()?;
        // The inferences in a call follow from the throughput.
        let batch = (self.throughput * self.times.mean_us * 1e-6).max(1.0);
        let windows = extent.inferences.iter().zip(&self.window_mean_us);
        let seconds = windows.map(|(&count, mean_us)| count as f64 / batch * mean_us * 1e-6);
        extent.cut(seconds.fold(f64::INFINITY, f64::min))
    }
}

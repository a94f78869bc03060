//! The gait cycles that were found in a recording.

use super::{DetectedCycle, NoCycle};

/// The gait cycles of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundCycles {
    /// The cycles in order, without overlap; at least one. A cycle does not always begin where the
    /// one before ends: the person may have stopped or turned.
    pub cycles: Vec<DetectedCycle>,
    /// Median duration of a cycle in frames, a real number.
    pub period_frames: f64,
    /// Steadiness of the gait, 0..1: the wave's median share of the change.
    pub regular: f64,
}

impl FoundCycles {
    /// Collects cycles, with the median of their periods; returns `reason` if there are none.
    pub(super) fn collect(cycles: Vec<DetectedCycle>, reason: NoCycle) -> Result<Self, NoCycle> {
        let periods = cycles.iter().map(DetectedCycle::period_frames);
        let period_frames = median(periods.collect()).ok_or(reason)?;
        let regular = cycles.iter().map(|cycle| f64::from(cycle.regular));
        let regular = median(regular.collect()).ok_or(reason)?;
        Ok(Self {
            cycles,
            period_frames,
            regular,
        })
    }

    /// Returns the cycles in a recording of which every second frame was looked at.
    pub(super) fn at_half_speed(self) -> Self {
        let cycles = self.cycles.into_iter().map(|cycle| DetectedCycle {
            start: 2.0 * cycle.start,
            end: 2.0 * cycle.end,
            ..cycle
        });
        Self {
            cycles: cycles.collect(),
            period_frames: 2.0 * self.period_frames,
            regular: self.regular,
        }
    }
}

/// Returns the median, of an even number the mean of the middle two; `None` without numbers.
pub(in crate::dataset) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let (&low, &high) = (
        values.get(values.len().checked_sub(1)? / 2)?,
        values.get(values.len() / 2)?,
    );
    Some(f64::midpoint(low, high))
}

//! The gait cycles that were found in a recording.

use super::series::SmoothedSignal;
use super::series::median;
use super::{DetectedCycle, NoCycle};

/// The gait cycles of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundCycles {
    /// The cycles in order, without overlap; at least one. A cycle does not always begin where the
    /// one before ends: the person may have stopped or turned.
    pub cycles: Vec<DetectedCycle>,
    /// Duration of a cycle in frames, a real number: the median, or the method's own value.
    pub period_frames: f64,
    /// Steadiness of the gait, 0..1. For the wave, its median share of the change. For peaks and
    /// minima, 1 less the mean deviation of their distances from the median, over the median. For
    /// the autocorrelation, its value at one period.
    pub regular: f64,
}

impl FoundCycles {
    /// Collects cycles, with the median of their periods; returns `reason` if there are none.
    pub(super) fn of(cycles: Vec<DetectedCycle>, reason: NoCycle) -> Result<Self, NoCycle> {
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

    /// Makes cycles of one length from `start` to the end of the series.
    pub(super) fn evenly(
        series: &SmoothedSignal,
        start: f64,
        period: f64,
        regular: f64,
    ) -> Result<Self, NoCycle> {
        let last = series.values.len() as f64 - 1.0;
        let count = ((last - start) / period).floor().max(0.0) as usize;
        let at = |number: usize| start + number as f64 * period;
        let cycles = (0..count).map(|number| cycle(at(number), at(number + 1), regular));
        let mut found = Self::of(cycles.collect(), series.too_short())?;
        found.period_frames = period;
        Ok(found)
    }

    /// Makes cycles between every second of these places.
    pub(super) fn between(
        series: &SmoothedSignal,
        places: &[f64],
        regular: f64,
    ) -> Result<Self, NoCycle> {
        let cycles = places.windows(3).step_by(2);
        let cycles = cycles.map(|three| cycle(three[0], three[2], regular));
        Self::of(cycles.collect(), series.too_short())
    }
}

pub(super) fn cycle(start: f64, end: f64, regular: f64) -> DetectedCycle {
    DetectedCycle {
        start,
        end,
        regular: regular as f32,
    }
}

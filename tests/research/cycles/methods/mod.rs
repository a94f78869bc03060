//! Methods that the wave is compared with: peaks, minima and autocorrelation of one signal.

mod autocorrelation;
mod extrema;
mod series;
mod unit;

use edgegait::dataset::gait_cycles::{DetectedCycle, FoundCycles, NoCycle};
pub use series::{Outline, Signal};
use series::{SmoothedSignal, median};

/// The method by which cycles are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleMethod {
    /// Every second peak of the signal (Charalambous & Bharath, BMVC 2016).
    Peaks(Signal),
    /// The mean of the median distances between every second minimum (Sarkar et al., IEEE TPAMI
    /// 27(2), 2005). Cycles follow one another from the first minimum on.
    Minima(Signal),
    /// The lag of the signal's highest autocorrelation. Cycles follow one another from where the
    /// superposed steps are widest.
    Autocorrelation(Signal),
}

impl CycleMethod {
    /// Finds the cycles of a sequence, or the reason why there are none.
    pub fn find(
        self,
        frame_rate_hz: f32,
        frames: impl IntoIterator<Item = Option<Outline>>,
    ) -> Result<FoundCycles, NoCycle> {
        let series = |frames, signal| SmoothedSignal::new(frames, signal, frame_rate_hz.into());
        match self {
            Self::Peaks(signal) => extrema::by_peaks(&series(frames, signal)?),
            Self::Minima(signal) => extrema::by_minima(&series(frames, signal)?),
            Self::Autocorrelation(signal) => autocorrelation::cycles(&series(frames, signal)?),
        }
    }
}

/// Makes cycles of one length from `start` to the end of the series.
fn evenly(
    series: &SmoothedSignal,
    start: f64,
    period: f64,
    regular: f64,
) -> Result<FoundCycles, NoCycle> {
    let last = series.values.len() as f64 - 1.0;
    let count = ((last - start) / period).floor().max(0.0) as usize;
    let at = |number: usize| start + number as f64 * period;
    let cycles = (0..count).map(|number| [at(number), at(number + 1)]);
    let mut found = found(cycles, regular, series)?;
    found.period_frames = period;
    Ok(found)
}

/// Makes cycles between every second of these places.
fn between(series: &SmoothedSignal, places: &[f64], regular: f64) -> Result<FoundCycles, NoCycle> {
    let cycles = places.windows(3).step_by(2);
    found(cycles.map(|three| [three[0], three[2]]), regular, series)
}

fn found(
    bounds: impl Iterator<Item = [f64; 2]>,
    regular: f64,
    series: &SmoothedSignal,
) -> Result<FoundCycles, NoCycle> {
    let cycles = bounds.map(|[start, end]| DetectedCycle {
        start,
        end,
        regular: regular as f32,
    });
    let cycles: Vec<_> = cycles.collect();
    let periods = cycles.iter().map(DetectedCycle::period_frames);
    let period_frames = median(periods.collect()).ok_or(series.too_short())?;
    Ok(FoundCycles {
        cycles,
        period_frames,
        regular: f64::from(regular as f32),
    })
}

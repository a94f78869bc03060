//! A signal with one number for each frame, without gaps.

use super::NoCycle;
use edgegait_core::budget::CYCLE_STEPS_PER_MINUTE;

/// The outline of the legs in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// Pixels in the lower half of the figure, as Sarkar et al. count them.
    pub pixels: f32,
    /// Columns from the leftmost to the rightmost pixel in the lowest fifth of the height.
    pub width: f32,
}

/// The number that is followed over the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// The number of pixels of the lower body.
    Pixels,
    /// The width of the lower body.
    Width,
}

/// The minimum swing of the signal of walking legs, as a share of its mean. Our choice.
const LEAST_SWING: f64 = 0.03;
/// Time over which the signal is smoothed, seconds: a tenth of a usual cycle. Our choice.
const SMOOTHED_S: f64 = 0.1;

/// A signal that swings, with gaps filled, smoothed by a moving mean.
pub struct SmoothedSignal {
    pub values: Vec<f64>,
    /// Durations of the shortest and the longest step, frames.
    pub steps: (f64, f64),
    /// Amplitude of a sine wave of the same variance, over the mean.
    swing: f64,
}

impl SmoothedSignal {
    pub fn new(
        frames: impl IntoIterator<Item = Option<Outline>>,
        signal: Signal,
        frame_rate_hz: f64,
    ) -> Result<Self, NoCycle> {
        let value = |body: Outline| match signal {
            Signal::Pixels => body.pixels,
            Signal::Width => body.width,
        };
        let usable = |value: &f32| value.is_finite() && *value > 0.0;
        let known = frames
            .into_iter()
            .map(|frame| frame.map(value).filter(usable));
        let known: Vec<Option<f64>> = known.map(|value| value.map(f64::from)).collect();
        let (slow, fast) = CYCLE_STEPS_PER_MINUTE;
        let step = |per_minute: f32| 60.0 / f64::from(per_minute) * frame_rate_hz;
        let mut series = Self {
            values: Vec::new(),
            steps: (step(fast), step(slow)),
            swing: 0.0,
        };
        if (known.len() as f64) < 2.0 * series.steps.0 {
            return Err(NoCycle::TooShort {
                frames: known.len() as u64,
            });
        }
        if 2 * known.iter().flatten().count() < known.len() {
            return Err(NoCycle::Absent);
        }
        let half = (SMOOTHED_S / 2.0 * frame_rate_hz) as usize;
        series.values = smoothed(&filled(&known), half);
        let count = series.values.len() as f64;
        let mean = series.values.iter().sum::<f64>() / count;
        let squares = series.values.iter().map(|value| (value - mean).powi(2));
        series.swing = (2.0 * squares.sum::<f64>() / count).sqrt() / mean;
        if series.swing < LEAST_SWING {
            return Err(NoCycle::Standing {
                swing: series.swing as f32,
            });
        }
        Ok(series)
    }

    /// Returns the error of a series that is too short.
    pub fn too_short(&self) -> NoCycle {
        NoCycle::TooShort {
            frames: self.values.len() as u64,
        }
    }

    /// Returns the values without their linear trend.
    pub fn detrended(&self) -> Vec<f64> {
        let middle = (self.values.len() as f64 - 1.0) / 2.0;
        let timed = || {
            self.values
                .iter()
                .enumerate()
                .map(|(at, value)| (at as f64 - middle, value))
        };
        let mean = self.values.iter().sum::<f64>() / self.values.len() as f64;
        let (by_time, squares) = timed().fold((0.0, 0.0), |(by_time, squares), (t, value)| {
            (by_time + t * value, squares + t * t)
        });
        let slope = if squares > 0.0 {
            by_time / squares
        } else {
            0.0
        };
        timed().map(|(t, value)| value - mean - slope * t).collect()
    }
}

/// Fills gaps along straight lines, and the ends with the first and last values.
fn filled(known: &[Option<f64>]) -> Vec<f64> {
    let mut values = Vec::with_capacity(known.len());
    let mut before: Option<f64> = None;
    for (at, value) in known.iter().enumerate() {
        let Some(value) = *value else { continue };
        let gap = at - values.len();
        let from = before.unwrap_or(value);
        let part = |number: usize| from + (value - from) * (number + 1) as f64 / (gap + 1) as f64;
        values.extend((0..=gap).map(part));
        before = Some(value);
    }
    values.resize(known.len(), before.unwrap_or(0.0));
    values
}

/// Returns moving means over `half` values on each side, fewer but equally many near the ends.
fn smoothed(values: &[f64], half: usize) -> Vec<f64> {
    let mean = |at: usize| {
        let reach = half.min(at).min(values.len() - 1 - at);
        let around = &values[at - reach..=at + reach];
        around.iter().sum::<f64>() / around.len() as f64
    };
    (0..values.len()).map(mean).collect()
}

/// Returns how equal numbers are: 1 less their mean deviation from the median, over the median, at
/// least 0.
pub fn evenness(values: &[f64]) -> f64 {
    let Some(middle) = median(values.to_vec()) else {
        return 0.0;
    };
    let off = values.iter().map(|value| (value - middle).abs());
    let off = off.sum::<f64>() / values.len() as f64;
    (1.0 - off / middle).max(0.0)
}

/// Returns the median, of an even number the mean of the middle two; `None` without numbers.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let (&low, &high) = (
        values.get(values.len().checked_sub(1)? / 2)?,
        values.get(values.len() / 2)?,
    );
    Some(f64::midpoint(low, high))
}

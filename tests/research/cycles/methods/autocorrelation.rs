//! Finds cycles by the lag of the highest autocorrelation of a signal.

use super::series::SmoothedSignal;
use super::{FoundCycles, NoCycle};

/// The minimum autocorrelation at the lag of a cycle. Our choice.
const LEAST_ALIKE: f64 = 0.3;
/// Number of lags tried for each frame. Our choice: a parabola interpolates between them.
const FINENESS: f64 = 4.0;

/// Finds cycles of one length. The lag of a step is searched, not of a cycle, so that a cycle is
/// two steps: the autocorrelation must be high at one and two steps, and low at half and one and a
/// half.
pub fn cycles(series: &SmoothedSignal) -> Result<FoundCycles, NoCycle> {
    let values = series.detrended();
    let all: f64 = values.iter().map(|value| value * value).sum();
    let count = values.len() as f64;
    // At least a third of the values must be compared.
    let longest_lag = (count * 2.0 / 3.0).min(2.0 * series.steps.1);
    let most = longest_lag.ceil() as usize + 1;
    let alike: Vec<f64> = (0..=most.min(values.len() - 1))
        .map(|lag| {
            let pairs = values.iter().zip(&values[lag..]);
            let products: f64 = pairs.map(|(early, late)| early * late).sum();
            products * count / (all * (count - lag as f64))
        })
        .collect();
    let score = |step: f64| {
        let [half, one, more, two] = [0.5, 1.0, 1.5, 2.0].map(|part| between(&alike, part * step));
        one + two - half - more
    };
    let (shortest, longest) = (series.steps.0, series.steps.1.min(longest_lag / 2.0));
    if longest < shortest {
        return Err(series.too_short());
    }
    let tries = ((longest - shortest) * FINENESS) as usize;
    let scores: Vec<f64> = (0..=tries)
        .map(|number| score(shortest + number as f64 / FINENESS))
        .collect();
    let best = highest(&scores);
    // A maximum at the edge is not a repetition: signals resemble themselves at short lags.
    if best <= 0.0 || best >= tries as f64 {
        let is_cut = longest < series.steps.1 && best > 0.0;
        return Err(if is_cut {
            series.too_short()
        } else {
            NoCycle::Irregular { regular: 0.0 }
        });
    }
    let step = shortest + best / FINENESS;
    let regular = between(&alike, 2.0 * step).clamp(0.0, 1.0);
    if regular < LEAST_ALIKE || all <= 0.0 {
        return Err(NoCycle::Irregular {
            regular: regular as f32,
        });
    }
    let offsets = (step * FINENESS).ceil() as usize;
    let sums: Vec<f64> = (0..=offsets)
        .map(|number| {
            let offset = number as f64 / FINENESS;
            let steps = ((count - 1.0 - offset) / step).floor().max(0.0) as usize;
            let laid = (0..=steps).map(|at| between(&values, offset + at as f64 * step));
            laid.sum::<f64>() / (steps + 1) as f64
        })
        .collect();
    super::evenly(series, highest(&sums) / FINENESS, 2.0 * step, regular)
}

/// Interpolates linearly between values; beyond the last one, returns it.
fn between(values: &[f64], at: f64) -> f64 {
    let index = (at.max(0.0) as usize).min(values.len() - 1);
    let next = (index + 1).min(values.len() - 1);
    let part = (at - index as f64).clamp(0.0, 1.0);
    values[index] + part * (values[next] - values[index])
}

/// Returns the place of the highest value: the vertex of the parabola through it and its
/// neighbours.
fn highest(values: &[f64]) -> f64 {
    let order = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]).then(b.cmp(a));
    let best = (0..values.len()).max_by(order).unwrap_or(0);
    if best == 0 || best + 1 >= values.len() {
        return best as f64;
    }
    let (before, height, after) = (values[best - 1], values[best], values[best + 1]);
    let bend = before - 2.0 * height + after;
    if bend >= 0.0 {
        return best as f64;
    }
    best as f64 + 0.5 * (before - after) / bend
}

//! Finds cycles between peaks, after Charalambous & Bharath, or between minima, after Sarkar et al.

use super::series::{SmoothedSignal, evenness, median};
use super::{FoundCycles, NoCycle};

/// The minimum evenness of the distances between steps. Our choice.
const LEAST_EVEN: f64 = 0.7;

/// Finds cycles that are bounded by every second peak.
pub fn by_peaks(series: &SmoothedSignal) -> Result<FoundCycles, NoCycle> {
    let peaks = places(&series.values, series.steps.0);
    let regular = regularity(series, &peaks)?;
    super::between(series, &peaks, regular)
}

/// Finds cycles from minima. The period is the mean of two medians: of the distances between
/// successive odd minima, and between successive even ones.
pub fn by_minima(series: &SmoothedSignal) -> Result<FoundCycles, NoCycle> {
    let upside_down: Vec<f64> = series.values.iter().map(|value| -value).collect();
    let minima = places(&upside_down, series.steps.0);
    let regular = regularity(series, &minima)?;
    let distances = |first: usize| {
        let every_other: Vec<f64> = minima.iter().skip(first).step_by(2).copied().collect();
        let distances = every_other.windows(2).map(|pair| pair[1] - pair[0]);
        median(distances.collect())
    };
    // With three minima there is only one distance.
    let medians: Vec<f64> = [0, 1].into_iter().filter_map(distances).collect();
    let (Some(start), false) = (minima.first(), medians.is_empty()) else {
        return Err(series.too_short());
    };
    let period = medians.iter().sum::<f64>() / medians.len() as f64;
    super::evenly(series, *start, period, regular)
}

/// Returns the evenness of the distances between places; an error if they are not even.
fn regularity(series: &SmoothedSignal, places: &[f64]) -> Result<f64, NoCycle> {
    if places.len() < 3 {
        return Err(series.too_short());
    }
    // Distances over two steps, since left and right steps may differ.
    let distances: Vec<f64> = places.windows(3).map(|three| three[2] - three[0]).collect();
    let regular = evenness(&distances);
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    let (shortest, longest) = (2.0 * series.steps.0, 2.0 * series.steps.1);
    if regular < LEAST_EVEN || !(shortest..=longest).contains(&mean) {
        return Err(NoCycle::Irregular {
            regular: regular as f32,
        });
    }
    Ok(regular)
}

/// Returns the places of local maxima as real numbers: the vertex of the parabola through the value
/// and its neighbours, or the middle of equal values. Of maxima closer than `apart`, the highest is
/// kept.
fn places(values: &[f64], apart: f64) -> Vec<f64> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut at = 1;
    while at + 1 < values.len() {
        let height = values[at];
        let equal = values[at..]
            .iter()
            .take_while(|value| **value == height)
            .count();
        let (before, after) = (values[at - 1], values.get(at + equal));
        if let Some(&after) = after
            && before < height
            && after < height
        {
            let place = if equal == 1 {
                at as f64 + 0.5 * (before - after) / (before - 2.0 * height + after)
            } else {
                at as f64 + (equal - 1) as f64 / 2.0
            };
            let close = found.last_mut().filter(|(last, _)| place - *last < apart);
            match close {
                Some(last) if last.1 < height => *last = (place, height),
                Some(_) => {}
                None => found.push((place, height)),
            }
        }
        at += equal;
    }
    found.into_iter().map(|(place, _)| place).collect()
}

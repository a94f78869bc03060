//! Cycles between peaks, as Charalambous & Bharath count them, or minima, as Sarkar et al. do.

use super::NoCycle;
use super::found::FoundCycles;
use super::series::{SmoothedSignal, evenness, median};

/// Distances that are less alike are no steps. Ours.
const LEAST_EVEN: f64 = 0.7;

/// Every second peak bounds a cycle.
pub(super) fn by_peaks(series: &SmoothedSignal) -> Result<FoundCycles, NoCycle> {
    let peaks = places(&series.values, series.steps.0);
    let regular = regularity(series, &peaks)?;
    FoundCycles::between(series, &peaks, regular)
}

/// The period is the mean of two medians: of the distances from every odd minimum to the next but one,
/// and from every even one.
pub(super) fn by_minima(series: &SmoothedSignal) -> Result<FoundCycles, NoCycle> {
    let upside_down: Vec<f64> = series.values.iter().map(|value| -value).collect();
    let minima = places(&upside_down, series.steps.0);
    let regular = regularity(series, &minima)?;
    let distances = |first: usize| {
        let every_other: Vec<f64> = minima.iter().skip(first).step_by(2).copied().collect();
        let distances = every_other.windows(2).map(|pair| pair[1] - pair[0]);
        median(distances.collect())
    };
    // With three minima there is one distance alone.
    let medians: Vec<f64> = [0, 1].into_iter().filter_map(distances).collect();
    let (Some(start), false) = (minima.first(), medians.is_empty()) else {
        return Err(series.too_short());
    };
    let period = medians.iter().sum::<f64>() / medians.len() as f64;
    FoundCycles::evenly(series, *start, period, regular)
}

/// How even the distances are; refused if they are not.
fn regularity(series: &SmoothedSignal, places: &[f64]) -> Result<f64, NoCycle> {
    if places.len() < 3 {
        return Err(series.too_short());
    }
    // From one to the next but one: left and right steps may differ.
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

/// Where the values are highest, as real numbers: the vertex of the parabola through the value and
/// its neighbours, or the middle of equal ones. Of those closer than `apart` the highest one stays.
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

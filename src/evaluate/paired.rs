//! Paired differences: Rank-1 of two recognizers on the same probes, person by person.
//!
//! Two recognizers may differ although their intervals overlap, because people who are hard for one
//! are hard for the other. So the interval is that of the difference, resampled over people (the
//! paired bootstrap; Efron and Tibshirani, "An Introduction to the Bootstrap", 1993, chapter 8).

use super::bootstrap::interval_95;
use super::paired_results::{HitsByView, PairedResult, PairedViewpoint, PersonResult};
use super::rank1::Tally;
use super::results::{ProbeSetResult, RecognizerResult};
use super::wilson::Interval;
use rayon::prelude::*;
use std::ops::AddAssign;

/// Hits of two recognizers on the same probes.
#[derive(Clone)]
struct PairedHits {
    probes: u64,
    hits: [u64; 2],
}

impl AddAssign<&Self> for PairedHits {
    #[inline]
    fn add_assign(&mut self, more: &Self) {
        self.probes += more.probes;
        self.hits[0] += more.hits[0];
        self.hits[1] += more.hits[1];
    }
}

/// Returns the differences between all pairs of recognizers, the best one's first: on the leading
/// probe sets and on each probe set, where both have the same probes.
///
/// Differences at each viewpoint are of the best of each group with the same probes: recognizers of
/// another group change nothing. The best is chosen on these same probes, so its lead is slightly
/// overestimated. `seed` is the seed for resampling people.
pub(super) fn each_from_each(results: &[RecognizerResult], seed: u64) -> Vec<PairedResult> {
    let mut ranked: Vec<&RecognizerResult> =
        results.iter().filter(|result| result.probes > 0).collect();
    // A stable sort: ties keep their order.
    ranked.sort_by(|a, b| b.rank1.total_cmp(&a.rank1));
    let of = |(at, one): (usize, &&RecognizerResult)| {
        let others = ranked[at + 1..].iter();
        others
            .flat_map(|other| between(one, other, seed))
            .collect::<Vec<_>>()
    };
    let mut all: Vec<PairedResult> = ranked.iter().enumerate().flat_map(of).collect();
    for best in &ranked {
        if all.iter().any(|pair| pair.other == best.name) {
            continue;
        }
        let of_best = all
            .iter_mut()
            .filter(|pair| pair.recognizer == best.name && pair.probe_set.is_none());
        let mut of_best: Vec<&mut PairedResult> = of_best.collect();
        let tallies = best.hits_by_view.tallies.iter().map(Vec::len);
        if tallies.sum::<usize>() * of_best.len() > MOST_DRAWN {
            continue;
        }
        for pair in &mut of_best {
            if let Some(other) = ranked.iter().find(|other| other.name == pair.other) {
                pair.by_viewpoint = at_viewpoints([&best.hits_by_view, &other.hits_by_view], seed);
            }
        }
    }
    all
}

/// The maximum of viewpoints times people times pairs of recognizers for which intervals are
/// computed: some seconds. Our choice.
const MOST_DRAWN: usize = 1_000_000;

/// Returns the differences at the viewpoints where both have the same probes.
fn at_viewpoints([one, other]: [&HitsByView; 2], seed: u64) -> Vec<PairedViewpoint> {
    if one.views != other.views {
        return Vec::new();
    }
    let both = one.tallies.par_iter().zip(&other.tallies);
    let found = one.views.par_iter().zip(both).map(|(view, (one, other))| {
        let pair = |(one, other): (&Tally, &Tally)| {
            (one.probes == other.probes).then_some(PairedHits {
                probes: one.probes,
                hits: [one.hits, other.hits],
            })
        };
        let pairs: Option<Vec<PairedHits>> = one.iter().zip(other).map(pair).collect();
        let probed = pairs?.into_iter().filter(|pair| pair.probes > 0).collect();
        let PairedEstimate { value, interval } = drawn_of(probed, seed, difference_of)?;
        let angles = view.angles_deg();
        Some(PairedViewpoint {
            azimuth_deg: angles.map(|angles| angles.0),
            elevation_deg: angles.map(|angles| angles.1),
            view: view.name().map(str::to_owned),
            difference: value,
            low: interval.map(|interval| interval.low),
            high: interval.map(|interval| interval.high),
        })
    });
    found.flatten().collect()
}

/// Returns the differences between two recognizers, on the headline probe sets and on each probe
/// set; only where both have the same probes.
#[must_use]
pub(crate) fn between(
    one: &RecognizerResult,
    other: &RecognizerResult,
    seed: u64,
) -> Vec<PairedResult> {
    let named = |probe_set, people: [&[PersonResult]; 2]| {
        let PairedEstimate { value, interval } = difference(people, seed)?;
        Some(PairedResult {
            recognizer: one.name.clone(),
            other: other.name.clone(),
            probe_set,
            people: people[0].len() as u64,
            difference: value,
            low: interval.map(|interval| interval.low),
            high: interval.map(|interval| interval.high),
            by_viewpoint: Vec::new(),
        })
    };
    let is_led_alike = one.of_probe_sets == other.of_probe_sets;
    let leading = is_led_alike.then(|| named(None, [&one.by_person, &other.by_person]));
    let of_set = |set: &ProbeSetResult| {
        let mut others = other.probe_sets.iter();
        let same = others.find(|its| its.name == set.name)?;
        named(Some(set.name.clone()), [&set.by_person, &same.by_person])
    };
    // A single set is the leading one, which is there already.
    let sets = if one.probe_sets.len() > 1 {
        &one.probe_sets[..]
    } else {
        &[]
    };
    let sets = sets.iter().filter_map(of_set);
    leading.flatten().into_iter().chain(sets).collect()
}

/// A number and its interval over people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PairedEstimate {
    pub value: f64,
    /// The interval; none with fewer than two people.
    pub interval: Option<Interval>,
}

/// The ratio and the difference of two rates of hits on the same probes.
pub(crate) struct PairedRates {
    /// The first rate divided by the second; 1 where they are equal.
    pub ratio: PairedEstimate,
    /// The first rate minus the second.
    pub difference: PairedEstimate,
}

/// Returns the ratio and the difference of two rates, with intervals over people; none if the
/// probes are not the same.
pub(crate) fn paired_rates(both: [&[PersonResult]; 2], seed: u64) -> Option<PairedRates> {
    let ratio = |sum: &PairedHits| {
        let [a, b] = sum.hits.map(|hits| hits as f64);
        (sum.probes > 0).then_some(if a == b { 1.0 } else { a / b })
    };
    Some(PairedRates {
        ratio: drawn(both, seed, ratio)?,
        difference: difference(both, seed)?,
    })
}

/// Returns the difference and its interval over people; none if the probes are not the same.
fn difference(both: [&[PersonResult]; 2], seed: u64) -> Option<PairedEstimate> {
    drawn(both, seed, difference_of)
}

fn difference_of(sum: &PairedHits) -> Option<f64> {
    let [a, b] = sum.hits.map(|hits| hits as f64);
    (sum.probes > 0).then(|| (a - b) / sum.probes as f64)
}

fn drawn(
    [one, other]: [&[PersonResult]; 2],
    seed: u64,
    statistic: impl Fn(&PairedHits) -> Option<f64> + Sync,
) -> Option<PairedEstimate> {
    let is_same =
        |(a, b): (&PersonResult, &PersonResult)| (&a.person, a.probes) == (&b.person, b.probes);
    if one.len() != other.len() || !one.iter().zip(other).all(is_same) {
        return None;
    }
    let both = one.iter().zip(other);
    let pairs: Vec<PairedHits> = both
        .map(|(a, b)| PairedHits {
            probes: a.probes,
            hits: [a.hits, b.hits],
        })
        .collect();
    drawn_of(pairs, seed, statistic)
}

fn drawn_of(
    pairs: Vec<PairedHits>,
    seed: u64,
    statistic: impl Fn(&PairedHits) -> Option<f64> + Sync,
) -> Option<PairedEstimate> {
    let (first, more) = pairs.split_first()?;
    let mut all = first.clone();
    more.iter().for_each(|pair| all += pair);
    Some(PairedEstimate {
        value: statistic(&all)?,
        interval: interval_95(&pairs, seed, statistic),
    })
}

#[cfg(test)]
mod tests;

//! Do two recognizers differ? Rank-1 on the same probes, person by person.
//!
//! Two intervals that overlap do not say that two recognizers are alike: people who are hard for one
//! are hard for the other. What counts is the difference, drawn over people who answer to both
//! (the paired bootstrap; Efron and Tibshirani, "An Introduction to the Bootstrap", 1993, chapter 8).

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::AddAssign;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::bootstrap::interval_95;
use super::rank1::Tally;
use super::results::{ProbeSetResult, RecognizerResult};
use super::wilson::Interval;
use crate::sequences::ViewLabel;

/// Rank-1 on the probes of one person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PersonResult {
    /// The person's name.
    pub person: String,
    /// Probes of this person.
    pub probes: u64,
    /// Those at Rank-1.
    pub hits: u64,
    /// Whom this person was taken for most often, the most frequent first; at most three.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub taken_for: Vec<Confusion>,
}

/// Somebody whom a person was taken for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Confusion {
    /// The other one's name.
    pub person: String,
    /// In how many probes.
    pub probes: u64,
}

/// Most confusions of a person that results name.
const MOST_CONFUSIONS: usize = 3;

/// How often each person was taken for each other one, `[person]` and by the other's name.
pub(super) type Confused = Vec<BTreeMap<String, u64>>;

impl PersonResult {
    /// One entry for each person who is looked for, in the order of `names`.
    pub(super) fn list(names: &[String], tallies: &[Tally], confused: &Confused) -> Vec<Self> {
        let of = |person: usize| {
            let all = confused.get(person).into_iter().flatten();
            let all = all.map(|(other, &probes)| Confusion {
                person: other.clone(),
                probes,
            });
            let mut all: Vec<Confusion> = all.collect();
            // Of equals the one first in the alphabet.
            all.sort_by_key(|one| Reverse(one.probes));
            all.truncate(MOST_CONFUSIONS);
            all
        };
        let people = names.iter().zip(tallies).enumerate();
        let person = |(at, (name, tally)): (usize, (&String, &Tally))| Self {
            person: name.clone(),
            probes: tally.probes,
            hits: tally.hits,
            taken_for: of(at),
        };
        let probed = people.filter(|(_, (_, tally))| tally.probes > 0);
        probed.map(person).collect()
    }
}

/// Hits by viewpoint and person, of what leads a recognizer's results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitsByView {
    /// The viewpoints.
    pub(super) views: Vec<ViewLabel>,
    /// `[viewpoint][person]`.
    pub(super) tallies: Vec<Vec<Tally>>,
}

/// How far Rank-1 is apart at one viewpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairedViewpoint {
    /// Azimuth in degrees, if the angles are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<f64>,
    /// Elevation in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation_deg: Option<f64>,
    /// The camera or recording, where only a name is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// As [`PairedResult::difference`].
    pub difference: f64,
    /// As [`PairedResult::low`].
    pub low: Option<f64>,
    /// As [`PairedResult::high`].
    pub high: Option<f64>,
}

/// How far Rank-1 of two recognizers is apart on the same probes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairedResult {
    /// The better one, or of equals the one that is listed first.
    pub recognizer: String,
    /// The other one.
    pub other: String,
    /// The set of probes; none where it is what leads, as [`RecognizerResult::of_probe_sets`] says.
    pub probe_set: Option<String>,
    /// People who are looked for.
    pub people: u64,
    /// Rank-1 of the one less Rank-1 of the other, -1..1.
    pub difference: f64,
    /// Lower end of the 95 % interval of the difference that draws people; none of fewer than two.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// The same at each viewpoint, of what leads and of the best recognizer's differences alone; empty
    /// of others, and where there are more viewpoints and people than are drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_viewpoint: Vec<PairedViewpoint>,
}

impl PairedResult {
    /// Whether 0 is outside the interval; none without an interval.
    #[must_use]
    pub fn differs(&self) -> Option<bool> {
        let (low, high) = self.low.zip(self.high)?;
        Some(low > 0.0 || high < 0.0)
    }

    /// At how many viewpoints the one is beyond the other, and behind it, by intervals. Of a hundred
    /// viewpoints where nothing is between them about five are either by chance.
    #[must_use]
    pub fn viewpoints_beyond_and_behind(&self) -> (usize, usize) {
        let all = || self.by_viewpoint.iter();
        let beyond = all().filter(|one| one.low.is_some_and(|low| low > 0.0));
        let behind = all().filter(|one| one.high.is_some_and(|high| high < 0.0));
        (beyond.count(), behind.count())
    }
}

/// Hits of two recognizers among the same probes.
#[derive(Clone)]
struct PairedHits {
    probes: u64,
    hits: [u64; 2],
}

impl AddAssign<&Self> for PairedHits {
    fn add_assign(&mut self, more: &Self) {
        self.probes += more.probes;
        for (sum, hits) in self.hits.iter_mut().zip(more.hits) {
            *sum += hits;
        }
    }
}

/// How far recognizers are apart, each from each, the best from the others first; on what leads and
/// on each set of probes, as far as their probes are the same.
///
/// The best is chosen by these very probes: that it is beyond others is said a little too easily.
/// `seed` draws people.
pub(super) fn each_from_each(results: &[RecognizerResult], seed: u64) -> Vec<PairedResult> {
    let mut ranked: Vec<&RecognizerResult> = results.iter().filter(|one| one.probes > 0).collect();
    // Of equals the first stays first.
    ranked.sort_by(|a, b| b.rank1.total_cmp(&a.rank1));
    let of = |(at, one): (usize, &&RecognizerResult)| {
        let others = ranked[at + 1..].iter();
        others
            .flat_map(|other| between(one, other, seed))
            .collect::<Vec<_>>()
    };
    let mut all: Vec<PairedResult> = ranked.iter().enumerate().flat_map(of).collect();
    let Some((best, others)) = ranked.split_first() else {
        return all;
    };
    let drawn = best
        .hits_by_view
        .tallies
        .iter()
        .map(Vec::len)
        .sum::<usize>()
        * others.len();
    if drawn <= MOST_DRAWN {
        let of_best = all
            .iter_mut()
            .filter(|pair| pair.recognizer == best.name && pair.probe_set.is_none());
        for pair in of_best {
            if let Some(other) = others.iter().find(|other| other.name == pair.other) {
                pair.by_viewpoint = at_viewpoints([&best.hits_by_view, &other.hits_by_view], seed);
            }
        }
    }
    all
}

/// Most viewpoints times people times pairs of recognizers of which intervals are drawn: some seconds.
/// Ours.
const MOST_DRAWN: usize = 1_000_000;

/// The differences at the viewpoints where both have the same probes.
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
        let (difference, drawn) = drawn_of(probed, seed, difference_of)?;
        let angles = view.angles_deg();
        Some(PairedViewpoint {
            azimuth_deg: angles.map(|angles| angles.0),
            elevation_deg: angles.map(|angles| angles.1),
            view: view.name().map(str::to_owned),
            difference,
            low: drawn.map(|drawn| drawn.low),
            high: drawn.map(|drawn| drawn.high),
        })
    });
    found.flatten().collect()
}

/// How far one recognizer is from another, on what leads and on each set of probes; of these
/// only what both were asked in the same way.
#[must_use]
pub(crate) fn between(
    one: &RecognizerResult,
    other: &RecognizerResult,
    seed: u64,
) -> Vec<PairedResult> {
    let named = |probe_set, people: [&[PersonResult]; 2]| {
        let (difference, drawn) = difference(people, seed)?;
        Some(PairedResult {
            recognizer: one.name.clone(),
            other: other.name.clone(),
            probe_set,
            people: people[0].len() as u64,
            difference,
            low: drawn.map(|drawn| drawn.low),
            high: drawn.map(|drawn| drawn.high),
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
    // One set is what leads, once more.
    let sets = if one.probe_sets.len() > 1 {
        &one.probe_sets[..]
    } else {
        &[]
    };
    let sets = sets.iter().filter_map(of_set);
    leading.flatten().into_iter().chain(sets).collect()
}

/// A number and its interval over people; none of fewer than two.
type PairedEstimate = (f64, Option<Interval>);

/// What is between two rates of hits on the same probes.
pub(crate) struct PairedRates {
    /// The one divided by the other; 1 where both are 0.
    pub ratio: PairedEstimate,
    /// The one less the other.
    pub difference: PairedEstimate,
}

/// What is between two rates, with intervals over people; none if the probes are not the same.
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

/// The difference and its interval over people; none if the probes are not the same.
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
    statistic: impl Fn(&PairedHits) -> Option<f64>,
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
    statistic: impl Fn(&PairedHits) -> Option<f64>,
) -> Option<PairedEstimate> {
    let (first, more) = pairs.split_first()?;
    let mut all = first.clone();
    more.iter().for_each(|pair| all += pair);
    Some((statistic(&all)?, interval_95(&pairs, seed, statistic)))
}

#[cfg(test)]
mod tests;

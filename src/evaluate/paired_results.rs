//! Paired differences in results.

use super::rank1::Tally;
use crate::dataset::sequences::ViewLabel;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Rank-1 on the probes of one person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PersonResult {
    /// The person's name.
    pub person: String,
    /// Probes of this person.
    pub probes: u64,
    /// Probes at Rank-1.
    pub hits: u64,
    /// The people with whom this person was confused most often, the most frequent first; at most
    /// three.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub taken_for: Vec<Confusion>,
}

/// A person with whom another one was confused.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Confusion {
    /// The name of the wrong person.
    pub person: String,
    /// Number of probes.
    pub probes: u64,
}

impl PersonResult {
    /// Returns one entry for each person with probes, in the order of `names`.
    pub(super) fn list(names: &[String], tallies: &[Tally], confused: &Confused) -> Vec<Self> {
        let of = |person: usize| {
            let all = confused.get(person).into_iter().flatten();
            let all = all.map(|(other, &probes)| Confusion {
                person: other.clone(),
                probes,
            });
            let mut all: Vec<Confusion> = all.collect();
            // Ties are in alphabetical order.
            all.sort_by_key(|entry| Reverse(entry.probes));
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

/// Hits by viewpoint and person, on the headline probe sets of a recognizer's results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitsByView {
    /// The viewpoints.
    pub(super) views: Vec<ViewLabel>,
    /// Tallies `[viewpoint][person]`.
    pub(super) tallies: Vec<Vec<Tally>>,
}

/// The difference in Rank-1 at one viewpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairedViewpoint {
    /// Azimuth in degrees, if the angles are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<f64>,
    /// Elevation in degrees, if the angles are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation_deg: Option<f64>,
    /// The camera or recording, where only a name is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// The difference, as [`PairedResult::difference`].
    pub difference: f64,
    /// Lower end of its interval, as [`PairedResult::low`].
    pub low: Option<f64>,
    /// Upper end of its interval, as [`PairedResult::high`].
    pub high: Option<f64>,
}

/// The difference in Rank-1 between two recognizers on the same probes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairedResult {
    /// The better recognizer; in a tie, the one listed first.
    pub recognizer: String,
    /// The other recognizer.
    pub other: String,
    /// The set of probes; none for the headline sets,
    /// [`super::results::RecognizerResult::of_probe_sets`].
    pub probe_set: Option<String>,
    /// Number of people with probes.
    pub people: u64,
    /// Rank-1 of the first minus Rank-1 of the other, -1..1.
    pub difference: f64,
    /// Lower end of the 95 % interval of the difference that resamples people; none with fewer than
    /// two people.
    pub low: Option<f64>,
    /// Upper end of the interval of the difference.
    pub high: Option<f64>,
    /// Differences at each viewpoint. Only for the best recognizer on the same probes, and the
    /// headline probe sets; empty where there are too many viewpoints and people for intervals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_viewpoint: Vec<PairedViewpoint>,
}

impl PairedResult {
    /// Returns whether 0 is outside the interval; none without an interval.
    #[must_use]
    pub fn differs(&self) -> Option<bool> {
        let (low, high) = self.low.zip(self.high)?;
        Some(low > 0.0 || high < 0.0)
    }

    /// Returns at how many viewpoints the interval lies above 0, and at how many below 0. Of a
    /// hundred viewpoints without a true difference, about five do either by chance.
    #[must_use]
    pub fn viewpoints_beyond_and_behind(&self) -> (usize, usize) {
        let all = || self.by_viewpoint.iter();
        let beyond = all().filter(|entry| entry.low.is_some_and(|low| low > 0.0));
        let behind = all().filter(|entry| entry.high.is_some_and(|high| high < 0.0));
        (beyond.count(), behind.count())
    }
}

/// The maximum number of confusions per person in results.
pub(super) const MOST_CONFUSIONS: usize = 3;

/// How often each person was confused with each other one: `[person]`, then by the other's name.
pub(super) type Confused = Vec<BTreeMap<String, u64>>;

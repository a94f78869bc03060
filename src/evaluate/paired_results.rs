//! Paired differences as results state them.

use super::rank1::Tally;
use crate::sequences::ViewLabel;
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

/// Most confusions of a person that results name.
pub(super) const MOST_CONFUSIONS: usize = 3;

/// How often each person was taken for each other one, `[person]` and by the other's name.
pub(super) type Confused = Vec<BTreeMap<String, u64>>;

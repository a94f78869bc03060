//! Differences between two sides in the identification of the same probes.

use crate::error::{Error, EvaluateError, Result};
use crate::evaluate::contest::{Contest, Entrant};
use crate::evaluate::results::ProbeAnswer;
use crate::inference::answers::Answers;
use serde::Serialize;
use std::collections::BTreeMap;

/// The ranked answers of one side.
pub(super) struct SideRanks {
    /// Rank-1, as [`crate::evaluate::results::RecognizerResult::rank1`].
    pub(super) rank1: f64,
    told: BTreeMap<AskedProbe, RankedAnswer>,
}

/// A probe, against a gallery.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct AskedProbe {
    probe_set: String,
    sequence: usize,
    /// The gallery's viewpoint, if each is compared separately.
    gallery: String,
}

/// The answer to a probe.
#[derive(Default, PartialEq)]
struct RankedAnswer {
    /// The person that it is identified as.
    person: Option<String>,
    /// The rank of the right person.
    rank: Option<usize>,
}

/// Changes in the identification of probes between two sides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct RankChanges {
    /// Number of probes of all sets.
    pub probes: u64,
    /// Probes that are identified as another person, or as nobody on one side.
    pub other_answers: u64,
    /// Probes that only the reference identifies correctly.
    pub lost: u64,
    /// Probes that only the other side identifies correctly.
    pub gained: u64,
    /// Probes for which the right person has another rank.
    pub other_ranks: u64,
    /// Rank-1 of the reference, 0..1, as `edgegait score` gives it.
    pub rank1_of_reference: f64,
    /// Rank-1 of the other side.
    pub rank1: f64,
}

impl SideRanks {
    /// Ranks the answers of a side; none if no answer is finite.
    ///
    /// # Errors
    /// As [`Contest::judged`].
    pub(super) fn rank(
        contest: &Contest<'_>,
        entrant: &Entrant,
        answers: &Answers,
        seed: u64,
    ) -> Result<Option<Self>> {
        let mut told = BTreeMap::new();
        let mut tell = |row: ProbeAnswer<'_>| {
            let at = row.gallery_azimuth_deg.zip(row.gallery_elevation_deg);
            let gallery = match (row.gallery_view, at) {
                (Some(name), _) => name.to_owned(),
                (None, Some((azimuth, elevation))) => format!("{azimuth}/{elevation}"),
                (None, None) => String::new(),
            };
            let probe = AskedProbe {
                probe_set: row.probe_set.to_owned(),
                sequence: row.sequence,
                gallery,
            };
            let answer = RankedAnswer {
                person: row.answer.map(str::to_owned),
                rank: row.rank,
            };
            told.insert(probe, answer);
            Ok(())
        };
        match contest.judged(entrant, answers, seed, &mut tell) {
            Ok(result) => Ok(Some(Self {
                rank1: result.rank1,
                told,
            })),
            Err(Error::Evaluate(EvaluateError::NoFiniteGallery(_))) => Ok(None),
            Err(error) => Err(error),
        }
    }
}

impl RankChanges {
    pub(super) fn compare(reference: &SideRanks, other: &SideRanks) -> Self {
        let mut changes = Self {
            probes: 0,
            other_answers: 0,
            lost: 0,
            gained: 0,
            other_ranks: 0,
            rank1_of_reference: reference.rank1,
            rank1: other.rank1,
        };
        // A side without a finite gallery at a viewpoint has no answer there.
        let none = RankedAnswer::default();
        let only_other = other.told.iter();
        let only_other = only_other.filter(|(probe, _)| !reference.told.contains_key(*probe));
        let pairs = reference.told.iter().map(|(probe, told)| {
            let found = other.told.get(probe);
            (told, found.unwrap_or(&none))
        });
        for (a, b) in pairs.chain(only_other.map(|(_, told)| (&none, told))) {
            let is_right = |told: &RankedAnswer| told.rank == Some(1);
            changes.probes += 1;
            changes.other_answers += u64::from(a.person != b.person);
            changes.lost += u64::from(is_right(a) && !is_right(b));
            changes.gained += u64::from(is_right(b) && !is_right(a));
            changes.other_ranks += u64::from(a.rank != b.rank);
        }
        changes
    }

    /// Returns the share of probes that only one side identifies correctly, 0..1.
    pub(crate) fn changed_hits(&self) -> f64 {
        (self.lost + self.gained) as f64 / self.probes.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranked(told: &[(Option<&str>, Option<usize>)]) -> SideRanks {
        let probe = |sequence: usize| AskedProbe {
            probe_set: "probes".to_owned(),
            sequence,
            gallery: String::new(),
        };
        let answer = |person: Option<&str>, rank| RankedAnswer {
            person: person.map(str::to_owned),
            rank,
        };
        let told = told.iter().enumerate();
        SideRanks {
            rank1: 0.5,
            told: told
                .map(|(at, &(person, rank))| (probe(at), answer(person, rank)))
                .collect(),
        }
    }

    #[test]
    fn answers_and_ranks_that_change_are_counted_apart() {
        // Bob is the right person for all probes.
        let reference = ranked(&[
            (Some("bob"), Some(1)),
            (Some("bob"), Some(1)),
            (Some("ann"), Some(2)),
            (Some("ann"), Some(2)),
            (Some("ann"), Some(2)),
            (None, None),
            (Some("bob"), Some(1)),
        ]);
        let other = ranked(&[
            (Some("bob"), Some(1)),
            (Some("ann"), Some(3)),
            (Some("bob"), Some(1)),
            (Some("ann"), Some(4)),
            (Some("cid"), Some(2)),
            (None, None),
        ]);
        let found = RankChanges::compare(&reference, &other);
        assert_eq!(found.probes, 7);
        // Changes to ann, to bob, to cid, and to nobody.
        assert_eq!((found.other_answers, found.other_ranks), (4, 4));
        assert_eq!((found.lost, found.gained), (2, 1));
        assert_eq!(found.changed_hits(), 3.0 / 7.0);
        let back = RankChanges::compare(&other, &reference);
        assert_eq!((back.probes, back.lost, back.gained), (7, 1, 2));
        let same = RankChanges::compare(&reference, &reference);
        assert_eq!((same.other_answers, same.other_ranks), (0, 0));
    }
}

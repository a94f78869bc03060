//! Identification by distance: Rank-k, the CMC, mAP and mINP.
//!
//! A probe's gallery is sorted by (distance, gallery index). Ties go to the lower index, so that a
//! recognizer with constant answers is not flattered and every run gives the same numbers.
//!
//! Two kinds of probes are also counted separately:
//! - *without mate*: the person is not in the compared gallery. A miss for Rank-k; mAP and mINP
//!   leave it out (both as OpenGait's `compute_ACC_mAP`; its `evaluate_rank` leaves it out of
//!   Rank-k too).
//! - *not finite*: a compared distance is NaN or infinite. A miss for Rank-k; mAP and mINP leave
//!   it out, so never quote them without [`Ranking::non_finite`].

use super::rank1::Tally;

/// Number of ranks of a CMC, as OpenGait's `max_rank`.
pub(crate) const MAX_RANK: usize = 50;

/// The rank of one probe, or why it has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ProbeRank {
    /// No compared entry is a mate. Decided first: it does not depend on the distances.
    NoMate,
    /// A compared distance is NaN or infinite.
    NonFinite,
    /// The probe has a rank.
    Found {
        /// Entries before the nearest mate; 0 is a hit at Rank-1.
        strangers_before: usize,
        /// Mean over the mates of the precision at each: mates so far divided by entries so far.
        average_precision: f64,
        /// Mates divided by the 1-based rank of the farthest mate (inverse negative penalty; Ye et
        /// al., "Deep Learning for Person Re-identification", TPAMI 44, 2022).
        inp: f64,
    },
}

/// Ranks one probe from its distances, one per gallery entry; `is_mate` returns whether an entry is
/// the same person.
///
/// Sorts only the m mates: about n log m steps for n entries, and n where there is one mate.
#[must_use]
pub(crate) fn rank(distances: &[f64], is_mate: impl Fn(usize) -> bool) -> ProbeRank {
    let entries = || distances.iter().copied().enumerate();
    let mut mates: Vec<(usize, f64)> = entries().filter(|entry| is_mate(entry.0)).collect();
    if mates.is_empty() {
        return ProbeRank::NoMate;
    }
    if !distances.iter().all(|distance| distance.is_finite()) {
        return ProbeRank::NonFinite;
    }
    // Not `total_cmp`, which puts -0 before 0.
    let is_before = |a: &(usize, f64), b: &(usize, f64)| a.1 < b.1 || (a.1 == b.1 && a.0 < b.0);
    mates.sort_by(|a, b| is_before(b, a).cmp(&is_before(a, b)));
    let mut strangers_between = vec![0; mates.len() + 1];
    for entry in entries() {
        if !is_mate(entry.0) {
            strangers_between[mates.partition_point(|mate| is_before(mate, &entry))] += 1;
        }
    }
    let (mut strangers, mut precisions, mut inp) = (0, 0.0, 0.0);
    for (mates_before, between) in strangers_between[..mates.len()].iter().enumerate() {
        strangers += between;
        inp = (mates_before + 1) as f64 / (mates_before + 1 + strangers) as f64;
        precisions += inp;
    }
    ProbeRank::Found {
        strangers_before: strangers_between[0],
        average_precision: precisions / mates.len() as f64,
        inp,
    }
}

/// Sums over ranked probes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ranking {
    probes: u64,
    without_mate: u64,
    non_finite: u64,
    /// Number of probes by the number of entries before the nearest mate.
    strangers_before: [u64; MAX_RANK],
    average_precisions: f64,
    inps: f64,
}

impl Default for Ranking {
    fn default() -> Self {
        Self {
            probes: 0,
            without_mate: 0,
            non_finite: 0,
            strangers_before: [0; MAX_RANK],
            average_precisions: 0.0,
            inps: 0.0,
        }
    }
}

impl Ranking {
    /// Counts one more probe.
    pub(crate) fn add(&mut self, ranked: ProbeRank) {
        self.probes += 1;
        match ranked {
            ProbeRank::NoMate => self.without_mate += 1,
            ProbeRank::NonFinite => self.non_finite += 1,
            ProbeRank::Found {
                strangers_before,
                average_precision,
                inp,
            } => {
                if let Some(count) = self.strangers_before.get_mut(strangers_before) {
                    *count += 1;
                }
                self.average_precisions += average_precision;
                self.inps += inp;
            }
        }
    }

    /// Returns the number of all probes.
    #[must_use]
    pub(crate) const fn probes(&self) -> u64 {
        self.probes
    }

    /// Returns the number of probes without a mate in the gallery.
    #[must_use]
    pub(crate) const fn without_mate(&self) -> u64 {
        self.without_mate
    }

    /// Returns the number of probes with a mate and a distance that is not finite.
    #[must_use]
    pub(crate) const fn non_finite(&self) -> u64 {
        self.non_finite
    }

    /// Returns the hits at rank `k`: probes with a mate among the first `k` entries. `k` counts
    /// from 1, and is limited to [`MAX_RANK`].
    #[must_use]
    pub(crate) fn tally(&self, k: usize) -> Tally {
        Tally {
            probes: self.probes,
            hits: self.strangers_before[..k.min(MAX_RANK)].iter().sum(),
            non_finite: self.non_finite,
        }
    }

    /// Returns Rank-k, 0..1; none without probes.
    #[must_use]
    pub(crate) fn rank_k(&self, k: usize) -> Option<f64> {
        self.tally(k).rank1()
    }

    /// Returns the cumulative match characteristic: Rank-1 to Rank-50. None without probes.
    #[must_use]
    pub(crate) fn cmc(&self) -> Option<Vec<f64>> {
        (1..=MAX_RANK).map(|k| self.rank_k(k)).collect()
    }

    /// Returns the mean average precision, 0..1; none if no probe has a mate and finite distances.
    #[must_use]
    pub(crate) fn map(&self) -> Option<f64> {
        self.mean(self.average_precisions)
    }

    /// Returns the mean inverse negative penalty, 0..1; none as for [`Self::map`].
    #[must_use]
    pub(crate) fn minp(&self) -> Option<f64> {
        self.mean(self.inps)
    }

    fn mean(&self, sum: f64) -> Option<f64> {
        let counted = self.probes - self.without_mate - self.non_finite;
        (counted > 0).then(|| sum / counted as f64)
    }
}

impl std::ops::AddAssign<&Self> for Ranking {
    fn add_assign(&mut self, other: &Self) {
        self.probes += other.probes;
        self.without_mate += other.without_mate;
        self.non_finite += other.non_finite;
        for (sum, count) in self.strangers_before.iter_mut().zip(other.strangers_before) {
            *sum += count;
        }
        self.average_precisions += other.average_precisions;
        self.inps += other.inps;
    }
}

impl FromIterator<ProbeRank> for Ranking {
    fn from_iter<I: IntoIterator<Item = ProbeRank>>(probes: I) -> Self {
        let mut ranking = Self::default();
        for probe in probes {
            ranking.add(probe);
        }
        ranking
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::testing::{E1, E1_GALLERY, E1_PROBES};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn by_labels(distances: &[f64], gallery: &[usize], person: usize) -> ProbeRank {
        rank(distances, |index| gallery[index] == person)
    }

    fn found(ranked: ProbeRank) -> (usize, f64, f64) {
        match ranked {
            ProbeRank::Found {
                strangers_before,
                average_precision,
                inp,
            } => (strangers_before, average_precision, inp),
            other => panic!("expected a rank, found {other:?}"),
        }
    }

    /// Expected values were worked out by hand: the order of the first probe is 1 2 1 3 2 3.
    #[test]
    fn the_reference_matrix_has_its_worked_ranks() {
        let probes: Vec<ProbeRank> = E1
            .iter()
            .zip(E1_PROBES)
            .map(|(row, person)| by_labels(row, &E1_GALLERY, person))
            .collect();
        let expected = [
            (0, 5.0 / 6.0, 2.0 / 3.0),
            (0, 5.0 / 6.0, 2.0 / 3.0),
            (0, 1.0, 1.0),
        ];
        for (ranked, (first, ap, inp)) in probes.iter().zip(expected) {
            let (a, b, c) = found(*ranked);
            assert_eq!(a, first);
            assert!((b - ap).abs() < 1e-15 && (c - inp).abs() < 1e-15, "{b} {c}");
        }
        let ranking: Ranking = probes.into_iter().collect();
        assert_eq!(ranking.rank_k(1), Some(1.0));
        assert!((ranking.map().unwrap() - 0.888_889).abs() < 5e-7);
        assert!((ranking.minp().unwrap() - 0.777_778).abs() < 5e-7);
    }

    #[test]
    fn an_all_equal_matrix_hits_only_the_person_enrolled_first() {
        let gallery = [0, 1, 2, 3];
        let ranking: Ranking = gallery
            .iter()
            .map(|&person| by_labels(&[7.0; 4], &gallery, person))
            .collect();
        assert_eq!(ranking.cmc().unwrap()[..5], [0.25, 0.5, 0.75, 1.0, 1.0]);
        // (1 + 1/2 + 1/3 + 1/4) / 4.
        assert!((ranking.map().unwrap() - 25.0 / 48.0).abs() < 1e-15);
    }

    #[test]
    fn identical_samples_in_two_classes_are_told_apart_by_the_index_alone() {
        assert_eq!(found(by_labels(&[0.0, 0.0], &[4, 5], 4)), (0, 1.0, 1.0));
        assert_eq!(found(by_labels(&[0.0, -0.0], &[4, 5], 5)), (1, 0.5, 0.5));
    }

    #[test]
    fn a_single_class_is_always_right() {
        assert_eq!(
            found(by_labels(&[3.0, 1.0, 2.0], &[0; 3], 0)),
            (0, 1.0, 1.0)
        );
    }

    #[test]
    fn a_nan_and_an_infinite_distance_are_misses_that_no_mean_contains() {
        let gallery = [0, 1];
        let ranking: Ranking = [
            by_labels(&[f64::NAN, 1.0], &gallery, 0),
            by_labels(&[0.0, f64::INFINITY], &gallery, 0),
            by_labels(&[0.0, 1.0], &gallery, 0),
            by_labels(&[f64::NAN, 1.0], &gallery, 9),
        ]
        .into_iter()
        .collect();
        assert_eq!(
            (
                ranking.probes(),
                ranking.non_finite(),
                ranking.without_mate()
            ),
            (4, 2, 1)
        );
        assert_eq!(ranking.rank_k(1), Some(0.25));
        assert_eq!((ranking.map(), ranking.minp()), (Some(1.0), Some(1.0)));
    }

    #[test]
    fn nothing_is_known_without_probes_or_without_mates() {
        assert_eq!(Ranking::default().rank_k(1), None);
        assert_eq!(Ranking::default().cmc(), None);
        let ranking: Ranking = [by_labels(&[], &[], 0), by_labels(&[1.0], &[1], 0)]
            .into_iter()
            .collect();
        assert_eq!((ranking.rank_k(50), ranking.map()), (Some(0.0), None));
    }

    #[test]
    fn a_mate_behind_fifty_strangers_is_in_no_rank() {
        let at = |strangers: u32| {
            let mut distances: Vec<f64> = (0..strangers).map(f64::from).collect();
            distances.push(1e3);
            let ranked = rank(&distances, |index| index == strangers as usize);
            Ranking::from_iter([ranked])
        };
        assert_eq!(
            (at(49).rank_k(49), at(49).rank_k(50)),
            (Some(0.0), Some(1.0))
        );
        assert_eq!(
            (at(50).rank_k(50), at(50).rank_k(99)),
            (Some(0.0), Some(0.0))
        );
    }

    /// The oracle sorts everything and reads precisions off the explicit list of hits.
    #[test]
    fn ranks_are_those_of_a_full_stable_sort() {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        for _ in 0..500 {
            let people = random.random_range(1..5);
            let gallery: Vec<(usize, usize)> = (0..random.random_range(1..15))
                .map(|_| (random.random_range(0..people), random.random_range(0..3)))
                .collect();
            let (mut ranking, mut parts) =
                (Ranking::default(), [Ranking::default(), Ranking::default()]);
            let (mut first_hits, mut aps, mut inps) = (vec![0.0; 50], vec![], vec![]);
            let probes: usize = random.random_range(1..8);
            for probe in 0..probes {
                let (person, view) = (probe % (people + 1), probe % 3);
                let distances: Vec<f64> = gallery
                    .iter()
                    .map(|_| f64::from(random.random_range(0..4)))
                    .collect();
                let compared: Vec<usize> = (0..gallery.len())
                    .filter(|&i| gallery[i].1 != view)
                    .collect();
                let seen: Vec<f64> = compared.iter().map(|&i| distances[i]).collect();
                let ranked = rank(&seen, |index| gallery[compared[index]].0 == person);
                ranking.add(ranked);
                parts[probe % 2].add(ranked);

                let mut order = compared;
                order.sort_by_key(|&i| distances[i] as i64);
                let hits: Vec<bool> = order.iter().map(|&i| gallery[i].0 == person).collect();
                let ranks: Vec<usize> = (1..=hits.len()).filter(|&r| hits[r - 1]).collect();
                if ranks.is_empty() {
                    continue;
                }
                for hit in &mut first_hits[ranks[0] - 1..] {
                    *hit += 1.0;
                }
                let precision =
                    |r: &usize| hits[..*r].iter().filter(|h| **h).count() as f64 / *r as f64;
                aps.push(ranks.iter().map(precision).sum::<f64>() / ranks.len() as f64);
                inps.push(ranks.len() as f64 / *ranks.last().unwrap() as f64);
            }
            let cmc = ranking.cmc().unwrap();
            for (found, hits) in cmc.iter().zip(&first_hits) {
                assert!((found - hits / probes as f64).abs() < 1e-12);
            }
            let mean = |v: &[f64]| (!v.is_empty()).then(|| v.iter().sum::<f64>() / v.len() as f64);
            let close = |a: Option<f64>, b: Option<f64>| match (a, b) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-12,
                (a, b) => a == b,
            };
            assert!(close(ranking.map(), mean(&aps)) && close(ranking.minp(), mean(&inps)));
            assert_eq!(ranking.without_mate() as usize, probes - aps.len());
            let [mut sum, other] = parts;
            sum += &other;
            assert_eq!(sum.cmc(), ranking.cmc());
            assert!(close(sum.map(), ranking.map()));
        }
    }
}

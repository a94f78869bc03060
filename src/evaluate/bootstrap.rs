//! Confidence intervals by the cluster bootstrap, which resamples people.
//!
//! Probes of one person are not independent: one walk seen from 703 viewpoints gives 703 probes of
//! the same walk. The cluster bootstrap therefore resamples people instead of probes (Field and
//! Welsh, "Bootstrapping clustered data", J. R. Stat. Soc. B 69, 2007). A statistic must be
//! computable from sums over people: of counts, of precisions, of pairs by distance.

use std::ops::AddAssign;
use std::sync::{Arc, Mutex, PoisonError};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::rank1::Tally;
use super::verification::{Pairs, Verification, finite};
use super::wilson::Interval;

/// Resamples per interval (our choice; 1,000 is the usual minimum).
pub(crate) const RESAMPLES: usize = 2_000;

/// The maximum number of thresholds of [`PairCounts`] from each kind of pair (our choice).
const THRESHOLDS: usize = 512;

/// Returns the 95 % percentile interval of a statistic of the sum over `subjects`, from
/// [`RESAMPLES`] resamples of as many subjects with replacement. None with fewer than two subjects,
/// or if the statistic is not defined for a resample.
#[must_use]
pub(crate) fn interval_95<T>(
    subjects: &[T],
    seed: u64,
    statistic: impl Fn(&T) -> Option<f64> + Sync,
) -> Option<Interval>
where
    T: Clone + Sync + for<'a> AddAssign<&'a T>,
{
    if subjects.len() < 2 {
        return None;
    }
    let mut values = Vec::with_capacity(RESAMPLES);
    let of_resample = |drawn: &[u32]| {
        let mut sum = subjects[drawn[0] as usize].clone();
        for &at in &drawn[1..] {
            sum += &subjects[at as usize];
        }
        statistic(&sum)
    };
    each_draws(subjects.len(), seed, |draws| {
        let drawn = draws.par_chunks_exact(subjects.len());
        values.extend(drawn.map(of_resample).collect::<Option<Vec<f64>>>()?);
        Some(())
    })?;
    let mut ranked = |rank| *values.select_nth_unstable_by(rank, f64::total_cmp).1;
    Some(Interval {
        low: ranked(RESAMPLES / 40 - 1),
        high: ranked(RESAMPLES - RESAMPLES / 40),
    })
}

/// The maximum number of subjects whose draws are kept: 8 MB (our choice).
const MOST_KEPT: usize = 1_000;

/// Calls `see` with the numbers of the subjects in [`RESAMPLES`] resamples, one resample behind
/// another, in one or several parts, until it returns none.
///
/// The last draws are kept: results have an interval for each viewpoint, of the same people.
fn each_draws(subjects: usize, seed: u64, mut see: impl FnMut(&[u32]) -> Option<()>) -> Option<()> {
    static LAST: Mutex<Option<KeptDraws>> = Mutex::new(None);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draws = |resamples: usize| -> Arc<[u32]> {
        (0..resamples * subjects)
            .map(|_| random.random_range(0..subjects) as u32)
            .collect()
    };
    if subjects > MOST_KEPT {
        const PART: usize = RESAMPLES / 100;
        return (0..RESAMPLES / PART).try_for_each(|_| see(&draws(PART)));
    }
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let kept = { last.take() }.filter(|kept| (kept.subjects, kept.seed) == (subjects, seed));
    let numbers = kept.map_or_else(|| draws(RESAMPLES), |kept| kept.numbers);
    *last = Some(KeptDraws {
        subjects,
        seed,
        numbers: Arc::clone(&numbers),
    });
    drop(last);
    see(&numbers)
}

struct KeptDraws {
    subjects: usize,
    seed: u64,
    numbers: Arc<[u32]>,
}

/// Returns [`interval_95`] of Rank-1. Subjects without probes do not count.
#[must_use]
pub(crate) fn rank1_95(subjects: &[Tally], seed: u64) -> Option<Interval> {
    let probed: Vec<Tally> = subjects
        .iter()
        .copied()
        .filter(|tally| tally.probes > 0)
        .collect();
    interval_95(&probed, seed, Tally::rank1)
}

/// Returns [`interval_95`] of a statistic of a [`Verification`], such as its EER or a TAR, from the
/// distances of each subject's pairs.
///
/// A pair belongs to the subject of its probe; the gallery is fixed. The distances of all subjects
/// are counted between shared thresholds. If there are at most 512 distinct distances of genuine
/// and 512 of impostor pairs, all of them are thresholds, and the interval is exact. Otherwise
/// there are 512 genuine distances evenly spaced by rank, and 512 impostor distances evenly spaced
/// by the logarithm of their rank, so that low false accept rates are resolved to a few percent of
/// their value.
///
/// Takes 16 kB a subject, and [`RESAMPLES`] times as many additions.
#[must_use]
pub(crate) fn verification_95(
    subjects: &[Pairs],
    seed: u64,
    statistic: impl Fn(&Verification) -> Option<f64> + Sync,
) -> Option<Interval> {
    let thresholds = shared_thresholds(subjects);
    let counts: Vec<PairCounts> = subjects
        .par_iter()
        .filter(|pairs| !pairs.genuine.is_empty() || !pairs.impostor.is_empty())
        .map(|pairs| PairCounts {
            genuine: count(&pairs.genuine, &thresholds),
            impostor: count(&pairs.impostor, &thresholds),
        })
        .collect();
    interval_95(&counts, seed, |sum| {
        let counts = sum.genuine.iter().zip(&sum.impostor);
        let steps = thresholds.iter().zip(counts);
        statistic(&Verification::of_counts(steps.map(
            |(&threshold, (&genuine, &impostor))| (threshold, genuine, impostor),
        )))
    })
}

/// Counts of pairs by the first threshold that accepts them.
#[derive(Clone)]
struct PairCounts {
    genuine: Vec<u64>,
    impostor: Vec<u64>,
}

impl AddAssign<&Self> for PairCounts {
    fn add_assign(&mut self, other: &Self) {
        for (sum, count) in self.genuine.iter_mut().zip(&other.genuine) {
            *sum += count;
        }
        for (sum, count) in self.impostor.iter_mut().zip(&other.impostor) {
            *sum += count;
        }
    }
}

fn shared_thresholds(subjects: &[Pairs]) -> Vec<f64> {
    let sorted = |of: fn(&Pairs) -> &Vec<f64>| {
        let mut all: Vec<f64> = subjects
            .iter()
            .flat_map(|subject| finite(of(subject)).0)
            .collect();
        all.par_sort_unstable_by(f64::total_cmp);
        all
    };
    let last = |all: &[f64]| all.len().saturating_sub(1) as f64;
    let genuine = thinned(sorted(|pairs| &pairs.genuine), |all, share| {
        share * last(all)
    });
    let impostor = thinned(sorted(|pairs| &pairs.impostor), |all, share| {
        (last(all) + 1.0).powf(share) - 1.0
    });
    let mut thresholds = [genuine, impostor].concat();
    thresholds.sort_unstable_by(f64::total_cmp);
    thresholds.dedup();
    thresholds
}

/// Returns at most [`THRESHOLDS`] distinct values, including the first and the last; if there are
/// more, the values at `index(all, 0..1)`.
fn thinned(all: Vec<f64>, index: impl Fn(&[f64], f64) -> f64) -> Vec<f64> {
    let mut distinct = all.clone();
    distinct.dedup();
    if distinct.len() <= THRESHOLDS {
        return distinct;
    }
    (0..THRESHOLDS)
        .map(|step| {
            let at = index(&all, step as f64 / (THRESHOLDS - 1) as f64).round();
            // Not negative, and below the length except for rounding.
            all[(at as usize).min(all.len() - 1)]
        })
        .collect()
}

fn count(distances: &[f64], thresholds: &[f64]) -> Vec<u64> {
    let mut counts = vec![0; thresholds.len()];
    for distance in finite(distances).0 {
        counts[thresholds.partition_point(|&threshold| threshold < distance)] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::identification::{ProbeRank, Ranking};
    use crate::evaluate::wilson::wilson_95;

    fn tally(hits: u64, probes: u64) -> Tally {
        Tally {
            probes,
            hits,
            non_finite: 0,
        }
    }

    fn count_pairs(genuine: &[f64], impostor: &[f64]) -> Pairs {
        Pairs {
            genuine: genuine.to_vec(),
            impostor: impostor.to_vec(),
        }
    }

    #[test]
    fn people_who_are_all_alike_leave_no_doubt() {
        let interval = rank1_95(&[tally(3, 4); 10], 1).unwrap();
        assert_eq!((interval.low, interval.high), (0.75, 0.75));
    }

    /// With one probe each, resampling people is resampling probes, and the exact bootstrap
    /// distribution is binomial. For 60 of 100 its 2.5 % and 97.5 % quantiles are
    /// 0.50 and 0.69 or 0.70.
    #[test]
    fn with_one_probe_each_the_interval_is_the_binomial_one() {
        let subjects: Vec<_> = (0..100).map(|i| tally(u64::from(i < 60), 1)).collect();
        let interval = rank1_95(&subjects, 7).unwrap();
        assert!((interval.low - 0.50).abs() < 0.016, "{interval:?}");
        assert!((interval.high - 0.695).abs() < 0.016, "{interval:?}");
    }

    #[test]
    fn people_who_differ_leave_more_doubt_than_wilson_says() {
        let subjects: Vec<_> = (0..26)
            .map(|i| tally(if i % 2 == 0 { 700 } else { 300 }, 1000))
            .collect();
        let interval = rank1_95(&subjects, 3).unwrap();
        let wilson = wilson_95(13_000, 26_000);
        assert!(interval.high - interval.low > 10.0 * (wilson.high - wilson.low));
        assert_eq!(rank1_95(&subjects, 3), Some(interval), "the seed decides");
    }

    #[test]
    fn one_person_says_nothing_about_others() {
        assert_eq!(rank1_95(&[tally(1, 2), tally(0, 0)], 1), None);
        assert_eq!(rank1_95(&[], 1), None);
        let one = [count_pairs(&[0.1], &[0.2])];
        assert_eq!(verification_95(&one, 1, Verification::auc), None);
    }

    #[test]
    fn rank_1_and_map_of_rankings_are_drawn_alike() {
        // One probe each: at Rank-1 with AP 1, or behind one non-mate with AP 1/2.
        let subjects: Vec<Ranking> = (0..100)
            .map(|i| {
                let strangers_before = usize::from(i >= 60);
                let average_precision = 1.0 / (strangers_before + 1) as f64;
                Ranking::from_iter([ProbeRank::Found {
                    strangers_before,
                    average_precision,
                    inp: average_precision,
                }])
            })
            .collect();
        let tallies: Vec<Tally> = subjects.iter().map(|subject| subject.tally(1)).collect();
        let rank1 = interval_95(&subjects, 7, |sum| sum.rank_k(1)).unwrap();
        assert_eq!(Some(rank1), rank1_95(&tallies, 7));
        let map = interval_95(&subjects, 7, Ranking::map).unwrap();
        // AP is 1/2 + hit/2 in every resample.
        assert!((map.low - (1.0 + rank1.low) / 2.0).abs() < 1e-12);
        assert!((map.high - (1.0 + rank1.high) / 2.0).abs() < 1e-12);
    }

    /// Returns genuine pairs at i and impostor pairs at i + shift, all distinct between subjects.
    fn pairs(subjects: u32, each: u32, shift: f64) -> Vec<Pairs> {
        (0..subjects)
            .map(|s| {
                let genuine = (0..each).map(|i| f64::from(i * subjects + s));
                Pairs {
                    impostor: genuine.clone().map(|d| d + shift).collect(),
                    genuine: genuine.collect(),
                }
            })
            .collect()
    }

    #[test]
    fn few_distances_are_drawn_exactly() {
        let subjects = pairs(20, 10, 150.5);
        let exact = |sum: &Verification| sum.eer().map(|eer| eer.rate);
        let found = verification_95(&subjects, 5, exact).unwrap();
        // The oracle resamples the lists themselves.
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut rates: Vec<f64> = (0..RESAMPLES)
            .map(|_| {
                let (mut genuine, mut impostor) = (Vec::new(), Vec::new());
                for _ in 0..20 {
                    let drawn = &subjects[random.random_range(0..20)];
                    genuine.extend(&drawn.genuine);
                    impostor.extend(&drawn.impostor);
                }
                Verification::from_distances(&genuine, &impostor)
                    .eer()
                    .unwrap()
                    .rate
            })
            .collect();
        rates.sort_by(f64::total_cmp);
        assert!((found.low - rates[49]).abs() < 1e-12, "{found:?}");
        assert!((found.high - rates[1950]).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn many_distances_are_counted_between_thresholds_that_hold_the_rates() {
        let subjects = pairs(10, 5_000, 40_000.5);
        let thresholds = shared_thresholds(&subjects);
        assert!(thresholds.len() <= 2 * THRESHOLDS, "{}", thresholds.len());
        let all = |of: fn(&Pairs) -> &Vec<f64>| -> Vec<f64> {
            subjects.iter().flat_map(|s| of(s).clone()).collect()
        };
        let (genuine, impostor) = (all(|pairs| &pairs.genuine), all(|pairs| &pairs.impostor));
        let exact = Verification::from_distances(&genuine, &impostor);
        let steps = count(&genuine, &thresholds)
            .into_iter()
            .zip(count(&impostor, &thresholds));
        let counted =
            Verification::of_counts(thresholds.iter().zip(steps).map(|(&t, (g, i))| (t, g, i)));
        assert_eq!((counted.genuine(), counted.impostors()), (50_000, 50_000));
        let rates = |v: &Verification| {
            let tar = |far| v.tar_at(far).unwrap().tar.unwrap();
            [
                v.auc().unwrap(),
                v.eer().unwrap().rate,
                tar(1e-2),
                tar(1e-3),
                tar(1e-4),
            ]
        };
        for (a, b) in rates(&counted).iter().zip(rates(&exact)) {
            assert!((a - b).abs() < 0.003, "{a} {b}");
        }
    }

    #[test]
    fn a_statistic_that_a_draw_does_not_have_has_no_interval() {
        let subjects = [count_pairs(&[], &[0.5]), count_pairs(&[0.1], &[0.4])];
        assert_eq!(verification_95(&subjects, 1, Verification::auc), None);
    }
}

//! An interval of a rate that knows that probes of one person go together.
//!
//! One walk seen from 703 viewpoints gives 703 probes, but not 703 opinions. The
//! cluster bootstrap draws people instead of probes (Field and Welsh, "Bootstrapping
//! clustered data", J. R. Stat. Soc. B 69, 2007).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::rank::Tally;
use super::wilson::Interval;

/// Resamples of [`bootstrap_95`]; our choice, 1,000 is the usual least.
pub const RESAMPLES: usize = 2_000;

/// The 95 % percentile interval of the rate over `subjects`, each with its own
/// tally, from [`RESAMPLES`] draws. None with fewer than two subjects that have
/// probes: one person says nothing about others.
#[must_use]
pub fn bootstrap_95(subjects: &[Tally], seed: u64) -> Option<Interval> {
    let subjects: Vec<_> = subjects.iter().filter(|tally| tally.probes > 0).collect();
    if subjects.len() < 2 {
        return None;
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut rates: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let draw = subjects
                .iter()
                .map(|_| *subjects[random.random_range(0..subjects.len())]);
            draw.sum::<Tally>().rank1().unwrap_or_default()
        })
        .collect();
    rates.sort_unstable_by(f64::total_cmp);
    Some(Interval {
        low: rates[RESAMPLES / 40 - 1],
        high: rates[RESAMPLES - RESAMPLES / 40],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::wilson::wilson_95;

    fn tally(hits: u64, probes: u64) -> Tally {
        Tally {
            probes,
            hits,
            non_finite: 0,
        }
    }

    #[test]
    fn people_who_are_all_alike_leave_no_doubt() {
        let interval = bootstrap_95(&[tally(3, 4); 10], 1).unwrap();
        assert_eq!((interval.low, interval.high), (0.75, 0.75));
    }

    /// With one probe each, drawing people is drawing probes: the exact bootstrap
    /// distribution is binomial. For 60 of 100 its 2.5 % and 97.5 % quantiles are
    /// 0.50 and 0.69 or 0.70.
    #[test]
    fn with_one_probe_each_the_interval_is_the_binomial_one() {
        let subjects: Vec<_> = (0..100).map(|i| tally(u64::from(i < 60), 1)).collect();
        let interval = bootstrap_95(&subjects, 7).unwrap();
        assert!((interval.low - 0.50).abs() < 0.016, "{interval:?}");
        assert!((interval.high - 0.695).abs() < 0.016, "{interval:?}");
    }

    #[test]
    fn people_who_differ_leave_more_doubt_than_wilson_says() {
        let subjects: Vec<_> = (0..26)
            .map(|i| tally(if i % 2 == 0 { 700 } else { 300 }, 1000))
            .collect();
        let interval = bootstrap_95(&subjects, 3).unwrap();
        let wilson = wilson_95(13_000, 26_000);
        assert!(interval.high - interval.low > 10.0 * (wilson.high - wilson.low));
        assert_eq!(
            bootstrap_95(&subjects, 3),
            Some(interval),
            "the seed decides"
        );
    }

    #[test]
    fn one_person_says_nothing_about_others() {
        assert_eq!(bootstrap_95(&[tally(1, 2), tally(0, 0)], 1), None);
        assert_eq!(bootstrap_95(&[], 1), None);
    }
}

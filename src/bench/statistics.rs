//! Statistics of a list of times.

use serde::{Deserialize, Serialize};

/// The distribution of times, microseconds.
///
/// Percentiles are by nearest rank: the `ceil(p n)`-th smallest, always one of the times. A
/// percentile that needs more times is absent: p90 needs 10 times, p95 needs 20, p99 needs 100,
/// p99.9 needs 1000.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Times {
    /// The number of times.
    pub calls: u64,
    /// Minimum.
    pub min_us: f64,
    /// Arithmetic mean.
    pub mean_us: f64,
    /// Sample standard deviation (divisor n - 1; 0 for one time).
    pub sd_us: f64,
    /// Median.
    pub p50_us: f64,
    /// 90th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p90_us: Option<f64>,
    /// 95th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p95_us: Option<f64>,
    /// 99th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p99_us: Option<f64>,
    /// 99.9th percentile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p999_us: Option<f64>,
    /// Maximum.
    pub max_us: f64,
}

impl Times {
    /// Returns the distribution of times in nanoseconds, after sorting them; none if there are
    /// none.
    #[must_use]
    pub(crate) fn from_samples(times_ns: &mut [u64]) -> Option<Self> {
        times_ns.sort_unstable();
        let sorted: &[u64] = times_ns;
        let us = |ns: u64| ns as f64 * 1e-3;
        let percentile = |per_mille: u64| -> Option<f64> {
            let rank = rank(per_mille, sorted.len() as u64)?;
            let at = usize::try_from(rank - 1).ok()?;
            sorted.get(at).map(|&ns| us(ns))
        };
        let count = sorted.len() as f64;
        let mean_us = sorted.iter().map(|&ns| us(ns)).sum::<f64>() / count;
        let squares: f64 = sorted.iter().map(|&ns| (us(ns) - mean_us).powi(2)).sum();
        Some(Self {
            calls: sorted.len() as u64,
            min_us: us(*sorted.first()?),
            mean_us,
            sd_us: (squares / (count - 1.0).max(1.0)).sqrt(),
            p50_us: percentile(500)?,
            p90_us: percentile(900),
            p95_us: percentile(950),
            p99_us: percentile(990),
            p999_us: percentile(999),
            max_us: us(*sorted.last()?),
        })
    }
}

/// Returns the nearest rank of a percentile among `count` numbers, from 1 for the smallest; none if
/// there are too few (the median needs one). The percentile is in thousandths, so that ceil(p n) is
/// exact.
pub(super) fn rank(per_mille: u64, count: u64) -> Option<u64> {
    let exceeding = count.checked_mul(1000 - per_mille)?;
    let is_enough = per_mille == 500 || exceeding >= 1000;
    let rank = (per_mille * count).div_ceil(1000);
    (is_enough && rank > 0).then_some(rank)
}

/// Returns the index of the median, the lower of two; none for an empty list.
pub(super) fn median_index(values: &[f64]) -> Option<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    order.get(values.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_one_to_a_thousand_are_their_own_numbers() {
        // 1000, 2000, ..., 1000000 ns in an order that is not sorted: 7 is coprime to 1000.
        let mut ns: Vec<u64> = (0..1000).map(|i| 1000 * (1 + i * 7 % 1000)).collect();
        let times = Times::from_samples(&mut ns).expect("a thousand");
        assert_eq!(
            (times.calls, times.min_us, times.max_us),
            (1000, 1.0, 1000.0)
        );
        assert_eq!((times.p50_us, times.p90_us), (500.0, Some(900.0)));
        assert_eq!((times.p95_us, times.p99_us), (Some(950.0), Some(990.0)));
        assert_eq!(times.p999_us, Some(999.0));
        assert!((times.mean_us - 500.5).abs() < 1e-9);
        // The variance of 1..=n by n - 1 is n (n + 1) / 12.
        let sd = (1000.0 * 1001.0 / 12.0_f64).sqrt();
        assert!((times.sd_us - sd).abs() < 1e-9, "{} {sd}", times.sd_us);
    }

    #[test]
    fn a_percentile_that_no_time_would_exceed_is_absent() {
        let of = |count: u64| {
            let times = Times::from_samples(&mut (1..=count).collect::<Vec<_>>()).expect("some");
            [times.p90_us, times.p95_us, times.p99_us, times.p999_us].map(|p| p.is_some())
        };
        assert_eq!(of(9), [false; 4]);
        assert_eq!(of(10), [true, false, false, false]);
        assert_eq!(of(20), [true, true, false, false]);
        assert_eq!(of(99), [true, true, false, false]);
        assert_eq!(of(100), [true, true, true, false]);
        assert_eq!(of(999), [true, true, true, false]);
        assert_eq!(of(1000), [true; 4]);
    }

    #[test]
    fn of_few_times_the_nearest_rank_is_one_of_them() {
        // The worked example of nearest rank: 15, 20, 35, 40, 50; the 50th percentile is 35.
        let mut ns = [40_000, 15_000, 50_000, 20_000, 35_000];
        let times = Times::from_samples(&mut ns).expect("five");
        assert_eq!((times.p50_us, times.p90_us), (35.0, None));
        let one = Times::from_samples(&mut [7_000]).expect("one");
        assert_eq!((one.p50_us, one.sd_us), (7.0, 0.0));
        assert_eq!(Times::from_samples(&mut []), None);
    }

    #[test]
    fn the_median_is_the_middle_one_or_the_lower_of_two() {
        assert_eq!(median_index(&[3.0, 1.0, 2.0]), Some(2));
        assert_eq!(median_index(&[4.0, 1.0, 3.0, 2.0]), Some(3));
        assert_eq!(median_index(&[]), None);
    }
}

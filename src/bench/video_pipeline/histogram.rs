//! A histogram of times, in constant memory.

use crate::bench::statistics::{Times, rank};
use hdrhistogram::Histogram as Buckets;

/// The decimal digits of a bucket: 128 buckets for each doubling. Our choice: the error of a
/// percentile is at most half of 1/128, 0.4 %.
const DIGITS: u8 = 2;
/// The longest time that has a bucket, five hours; longer ones count in the last.
const LONGEST_NS: u64 = 1 << 44;

/// The number of times in each bucket, with exact sums and extremes.
#[derive(Clone, Debug)]
pub(super) struct Histogram {
    buckets: Buckets<u64>,
    least_ns: u64,
    most_ns: u64,
    sum_us: f64,
    squares_us: f64,
}

impl Histogram {
    /// Returns an empty histogram.
    pub(super) fn new() -> Self {
        Self {
            buckets: Buckets::new_with_bounds(1, LONGEST_NS, DIGITS).expect("valid bounds"),
            least_ns: u64::MAX,
            most_ns: 0,
            sum_us: 0.0,
            squares_us: 0.0,
        }
    }

    /// Counts a time.
    pub(super) fn add(&mut self, ns: u64) {
        self.buckets.saturating_record(ns);
        self.least_ns = self.least_ns.min(ns);
        self.most_ns = self.most_ns.max(ns);
        let us = ns as f64 * 1e-3;
        self.sum_us += us;
        self.squares_us += us * us;
    }

    /// Returns the distribution, exact except for percentiles; none if there are no times.
    pub(super) fn times(&self) -> Option<Times> {
        let calls = self.buckets.len();
        let count = calls as f64;
        let mean_us = self.sum_us / count;
        let us = |ns: u64| ns as f64 * 1e-3;
        let percentile = |per_mille: u64| {
            // Between two ranks, so that rounding cannot lead to another one.
            let at = rank(per_mille, calls)? as f64 - 0.5;
            let bucket = self.buckets.value_at_quantile(at / count);
            let middle = self.buckets.median_equivalent(bucket);
            Some(us(middle.clamp(self.least_ns, self.most_ns)))
        };
        let spread = (self.squares_us - count * mean_us * mean_us).max(0.0);
        Some(Times {
            calls,
            mean_us,
            sd_us: (spread / (count - 1.0).max(1.0)).sqrt(),
            p50_us: percentile(500)?,
            p90_us: percentile(900),
            p95_us: percentile(950),
            p99_us: percentile(990),
            p999_us: percentile(999),
            min_us: us(self.least_ns),
            max_us: us(self.most_ns),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_sorted_times_within_four_thousandths() {
        // From 50 ns to an hour.
        let mut ns: Vec<u64> = (0..4000_u64)
            .map(|at| 50 + (at * 2_654_435_761 % 4_294_967_296) * (1 + at % 830))
            .collect();
        let mut histogram = Histogram::new();
        for &time in &ns {
            histogram.add(time);
        }
        let (found, exact) = (
            histogram.times().expect("some"),
            Times::from_samples(&mut ns),
        );
        let exact = exact.expect("some");
        let near = |a: f64, b: f64, by: f64| assert!((a / b - 1.0).abs() <= by, "{a} {b}");
        near(found.p50_us, exact.p50_us, 0.004);
        for (found, exact) in [
            (found.p90_us, exact.p90_us),
            (found.p95_us, exact.p95_us),
            (found.p99_us, exact.p99_us),
            (found.p999_us, exact.p999_us),
        ] {
            near(found.expect("enough"), exact.expect("enough"), 0.004);
        }
        near(found.mean_us, exact.mean_us, 1e-9);
        near(found.sd_us, exact.sd_us, 1e-9);
        assert_eq!(
            (found.calls, found.min_us, found.max_us),
            (exact.calls, exact.min_us, exact.max_us)
        );
    }

    #[test]
    fn percentiles_of_few_times_are_absent_and_no_times_have_no_distribution() {
        let mut histogram = Histogram::new();
        assert_eq!(histogram.times(), None);
        histogram.add(7_000);
        let one = histogram.times().expect("one");
        assert_eq!((one.p50_us, one.p90_us, one.sd_us), (7.0, None, 0.0));
        // Longer than all buckets: it counts in the last, and the maximum is exact.
        histogram.add(u64::MAX / 4);
        assert!(histogram.times().expect("two").max_us > 1e12);
    }
}

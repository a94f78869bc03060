//! A histogram of times, in constant memory.

use crate::bench::statistics::{Times, rank};

/// The number of buckets for each doubling. Our choice: the error of a percentile is at most half
/// of 1/128, 0.4 %.
const STEPS: u64 = 128;
/// The number of doublings of 1 ns: up to five hours.
const DOUBLINGS: u64 = 44;

/// The number of times in each bucket, with exact sums and extremes.
#[derive(Clone, Debug)]
pub(super) struct Histogram {
    buckets: Vec<u64>,
    count: u64,
    least_ns: u64,
    most_ns: u64,
    sum_us: f64,
    squares_us: f64,
}

impl Histogram {
    /// Returns an empty histogram.
    pub(super) fn new() -> Self {
        Self {
            buckets: vec![0; (STEPS * DOUBLINGS) as usize],
            count: 0,
            least_ns: u64::MAX,
            most_ns: 0,
            sum_us: 0.0,
            squares_us: 0.0,
        }
    }

    /// Counts a time.
    pub(super) fn add(&mut self, ns: u64) {
        let last = self.buckets.len() - 1;
        self.buckets[bucket(ns).min(last)] += 1;
        self.count += 1;
        self.least_ns = self.least_ns.min(ns);
        self.most_ns = self.most_ns.max(ns);
        let us = ns as f64 * 1e-3;
        self.sum_us += us;
        self.squares_us += us * us;
    }

    /// Returns the distribution, exact except for percentiles; none if there are no times.
    pub(super) fn times(&self) -> Option<Times> {
        let count = self.count as f64;
        let mean_us = self.sum_us / count;
        let us = |ns: u64| ns as f64 * 1e-3;
        let percentile = |per_mille: u64| -> Option<f64> {
            let mut left = rank(per_mille, self.count)?;
            let at = self.buckets.iter().position(|here| {
                let is_here = left <= *here;
                left = left.saturating_sub(*here);
                is_here
            })?;
            let (least, most) = (self.least_ns as f64, self.most_ns as f64);
            Some(1e-3 * middle_ns(at).clamp(least, most))
        };
        let spread = (self.squares_us - count * mean_us * mean_us).max(0.0);
        Some(Times {
            calls: self.count,
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

/// Returns the bucket of a time: one for each value below 128 ns, then by the first eight bits.
const fn bucket(ns: u64) -> usize {
    if ns < STEPS {
        return ns as usize;
    }
    let doublings = ns.ilog2() as u64 - STEPS.ilog2() as u64 + 1;
    (doublings * STEPS + (ns >> (doublings - 1)) - STEPS) as usize
}

/// Returns the middle of a bucket.
fn middle_ns(bucket: usize) -> f64 {
    let bucket = bucket as u64;
    let (doublings, step) = (bucket / STEPS, bucket % STEPS);
    if doublings == 0 {
        return step as f64;
    }
    let width = (1_u64 << (doublings - 1)) as f64;
    ((STEPS + step) as f64 + 0.5) * width - 0.5
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
        let (found, exact) = (histogram.times().expect("some"), Times::of(&mut ns));
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
    fn each_time_is_in_the_bucket_whose_middle_is_nearest() {
        // Computed by hand: 127 and 128 ns have separate buckets, 256 and 257 share one, 258 is in
        // the next.
        assert_eq!(
            [0, 127, 128, 255, 256, 257, 258].map(bucket),
            [0, 127, 128, 255, 256, 256, 257]
        );
        assert_eq!(
            [0, 127, 128, 256].map(middle_ns),
            [0.0, 127.0, 128.0, 256.5]
        );
        for ns in (0..60)
            .map(|power| 1_u64 << power >> 18)
            .chain([999, 12_345, 7_000_000])
        {
            let off = (middle_ns(bucket(ns)) - ns as f64).abs();
            assert!(off <= 0.004 * ns as f64, "{ns}: {off}");
        }
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

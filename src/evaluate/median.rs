//! The median of a few numbers, and its confidence interval.

use super::wilson::Interval;

/// Returns the median (for an even count the mean of the two middle values) and an interval that
/// contains the median of the distribution with at least 95 %. Fewer than six values do not reach
/// 95 %; the interval is then the least to the greatest value, 94 % with five values. None without
/// values.
///
/// The median lies between the k-th least and the k-th greatest of n values unless fewer than k are
/// on one of its sides, which has the probability 2 P(B < k), B binomial with n and 1/2 (David and
/// Nagaraja, "Order Statistics", 2003, section 7.1).
#[must_use]
pub(crate) fn median_interval(values: &[f64]) -> Option<(f64, Interval)> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let n = sorted.len();
    let &last = sorted.last()?;
    let median = f64::midpoint(sorted[(n - 1) / 2], sorted[n / 2]);
    // `below` is P(B < k), and `next` is P(B = k).
    let (mut k, mut below, mut next) = (0, 0.0, 0.5_f64.powf(n as f64));
    while k < n / 2 && 2.0 * (below + next) <= 0.05 {
        below += next;
        next *= (n - k) as f64 / (k + 1) as f64;
        k += 1;
    }
    let out = k.saturating_sub(1);
    let interval = Interval {
        low: sorted[out],
        high: sorted.get(n - 1 - out).copied().unwrap_or(last),
    };
    Some((median, interval))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The oracle: the exact binomial distribution.
    #[test]
    fn the_interval_of_a_median_leaves_out_as_many_as_it_may() {
        let choose = |n: u64, k: u64| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
        for n in 1..40_u64 {
            let values: Vec<f64> = (0..n).map(|i| i as f64).collect();
            let (median, found) = median_interval(&values).expect("numbers");
            let outside = |k: u64| {
                let few: f64 = (0..k).map(|i| choose(n, i)).sum();
                2.0 * few / 2_f64.powf(n as f64)
            };
            // The k-th least, for the greatest k with enough confidence.
            let k = (1..=n / 2).rev().find(|&k| outside(k) <= 0.05).unwrap_or(1);
            assert_eq!(found.low, (k - 1) as f64, "{n}");
            assert_eq!(found.high, (n - k) as f64, "{n}");
            assert_eq!(median, (n - 1) as f64 / 2.0);
        }
    }

    #[test]
    fn nothing_has_no_median() {
        assert!(median_interval(&[]).is_none());
    }
}

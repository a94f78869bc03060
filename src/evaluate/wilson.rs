//! Wilson's score interval of a rate.
//!
//! Wilson, "Probable inference, the law of succession, and statistical inference", JASA 22 (1927).
//! Unlike the usual +-1.96 standard errors, it stays within 0..1 and has a width at 0 and at 100 %.

/// The 97.5th percentile of the normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// An interval of rates, `0 <= low <= high <= 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// Returns Wilson's 95 % interval of a rate of `hits` in `probes`; 0..1 without probes.
///
/// It takes the probes as independent. Views of one walk are not independent: see
/// [`super::bootstrap`].
///
/// # Panics
///
/// If there are more hits than probes.
#[must_use]
pub(crate) fn wilson_95(hits: u64, probes: u64) -> Interval {
    assert!(hits <= probes, "{hits} hits in {probes} probes");
    if probes == 0 {
        return Interval {
            low: 0.0,
            high: 1.0,
        };
    }
    let n = probes as f64;
    let rate = hits as f64 / n;
    let z2 = Z * Z;
    let centre = rate + z2 / (2.0 * n);
    let half = Z * (rate * (1.0 - rate) / n + z2 / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z2 / n;
    // At the ends the formula gives exactly 0 and 1; rounding may miss them.
    Interval {
        low: if hits == 0 {
            0.0
        } else {
            ((centre - half) / scale).max(0.0)
        },
        high: if hits == probes {
            1.0
        } else {
            ((centre + half) / scale).min(1.0)
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_has_the_worked_values() {
        for (hits, probes, low, high) in [
            (19, 20, 0.763_869, 0.991_119),
            (95, 100, 0.888_250, 0.978_456),
            (950, 1000, 0.934_686, 0.961_870),
            (20, 20, 0.838_875, 1.0),
            (26, 26, 0.871_271, 1.0),
            (0, 10, 0.0, 0.277_533),
            (3, 4, 0.300_642, 0.954_413),
        ] {
            let found = wilson_95(hits, probes);
            assert!((found.low - low).abs() < 5e-7, "{hits}/{probes}: {found:?}");
            assert!(
                (found.high - high).abs() < 5e-7,
                "{hits}/{probes}: {found:?}"
            );
        }
    }

    #[test]
    fn the_ends_solve_the_equation_that_defines_them() {
        // (rate - p)^2 = z^2 p (1 - p) / n at both ends.
        for (hits, probes) in [(1, 3), (17, 703), (700, 703), (123_456, 182_780)] {
            let rate = hits as f64 / probes as f64;
            let Interval { low, high } = wilson_95(hits, probes);
            for p in [low, high] {
                let left = (rate - p).powi(2);
                let right = Z * Z * p * (1.0 - p) / probes as f64;
                assert!((left - right).abs() <= 1e-9 * right, "{hits}/{probes}");
            }
        }
    }

    #[test]
    fn nothing_is_known_without_probes() {
        assert_eq!(
            wilson_95(0, 0),
            Interval {
                low: 0.0,
                high: 1.0
            }
        );
    }
}

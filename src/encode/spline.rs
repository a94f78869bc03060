//! Uniform cubic B-splines through weighted samples, by least squares.
//!
//! Each sample depends on four knots, so the normal equations have seven diagonals and take time
//! proportional to samples and knots.

/// The penalties on second and first differences of the knots, relative to weights of 1: just
/// enough to determine knots without samples. Our choice.
const SMOOTHNESS: [f64; 2] = [1e-7, 1e-10];

/// The places of samples among knots.
pub(super) struct KnotGrid {
    /// For each sample the first of its four knots, and the weight of each.
    places: Vec<(u32, [f64; 4])>,
    knots: usize,
}

/// The Cholesky factor of a grid's normal equations: for each knot its own entry and the entries
/// with the three knots after it.
pub(super) struct Factor(Vec<[f64; 4]>);

impl KnotGrid {
    /// Creates a grid for samples at `positions`, in intervals, each from 0 to `intervals`, which
    /// is at least 1.
    pub(super) fn new(positions: impl Iterator<Item = f64>, intervals: u32) -> Self {
        let places = positions.map(|position| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "0 to `intervals`"
            )]
            let index = (position as u32).min(intervals - 1);
            (index, shares(position - f64::from(index)))
        });
        Self {
            places: places.collect(),
            knots: intervals as usize + 3,
        }
    }

    /// Factors the normal equations for these weights, one for each sample.
    pub(super) fn factor(&self, weights: &[f64]) -> Factor {
        let mut band = vec![[0.0; 4]; self.knots];
        for ((index, shares), weight) in self.places.iter().zip(weights) {
            for (i, a) in shares.iter().enumerate() {
                for (j, b) in shares.iter().enumerate().skip(i) {
                    band[*index as usize + i][j - i] += weight * a * b;
                }
            }
        }
        for (strength, differences) in SMOOTHNESS
            .iter()
            .zip([&[1.0, -2.0, 1.0] as &[f64], &[1.0, -1.0]])
        {
            for first in 0..=self.knots - differences.len() {
                for (i, a) in differences.iter().enumerate() {
                    for (j, b) in differences.iter().enumerate().skip(i) {
                        band[first + i][j - i] += strength * a * b;
                    }
                }
            }
        }
        for knot in 0..self.knots {
            for below in 0..4.min(self.knots - knot) {
                let mut entry = band[knot][below];
                for before in 1..=(3 - below).min(knot) {
                    entry -= band[knot - before][before] * band[knot - before][before + below];
                }
                band[knot][below] = if below == 0 {
                    entry.max(f64::MIN_POSITIVE).sqrt()
                } else {
                    entry / band[knot][0]
                };
            }
        }
        Factor(band)
    }

    /// Returns the knots that fit these values best. With a `step`, knots are whole numbers of
    /// steps: each is rounded as soon as it is known, and the remaining ones compensate for the
    /// rounding (nearest plane of Babai 1986, "On Lovasz' lattice reduction and the nearest lattice
    /// point problem", Combinatorica 6:1-13).
    pub(super) fn fit(
        &self,
        factor: &Factor,
        weights: &[f64],
        values: &[f64],
        step: Option<f64>,
    ) -> Vec<f64> {
        let Factor(band) = factor;
        let mut knots = vec![0.0; self.knots];
        for (((index, shares), weight), value) in self.places.iter().zip(weights).zip(values) {
            for (knot, share) in knots[*index as usize..].iter_mut().zip(shares) {
                *knot += weight * share * value;
            }
        }
        for knot in 0..self.knots {
            for before in 1..=3.min(knot) {
                knots[knot] -= band[knot - before][before] * knots[knot - before];
            }
            knots[knot] /= band[knot][0];
        }
        for knot in (0..self.knots).rev() {
            for behind in 1..4.min(self.knots - knot) {
                knots[knot] -= band[knot][behind] * knots[knot + behind];
            }
            knots[knot] /= band[knot][0];
            if let Some(step) = step {
                knots[knot] = (knots[knot] / step).round() * step;
            }
        }
        knots
    }

    /// Returns the spline's values at the samples.
    pub(super) fn values<'a>(&'a self, knots: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.places.iter().map(|(index, shares)| {
            let taps = &knots[*index as usize..];
            shares
                .iter()
                .zip(taps)
                .map(|(share, knot)| share * knot)
                .sum()
        })
    }
}

/// Returns the weights of the four knots of a spline at `x` in 0..=1.
fn shares(x: f64) -> [f64; 4] {
    let rest = 1.0 - x;
    [
        rest * rest * rest / 6.0,
        (4.0 - 3.0 * x * x * (2.0 - x)) / 6.0,
        (4.0 - 3.0 * rest * rest * (2.0 - rest)) / 6.0,
        x * x * x / 6.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a grid with four samples in each interval.
    fn grid(intervals: u32) -> KnotGrid {
        KnotGrid::new((0..=4 * intervals).map(|i| f64::from(i) / 4.0), intervals)
    }

    fn cubic(x: f64) -> f64 {
        1.0 - 2.0 * x + 0.5 * x * x - 0.125 * x * x * x
    }

    #[test]
    fn a_cubic_is_met_by_its_blossom() {
        // The knot of a cubic at i is its blossom at i - 1, i and i + 1 (Ramshaw 1989): for 1, x,
        // x^2 and x^3 that is 1, i, i^2 - 1/3 and i^3 - i.
        let values: Vec<f64> = (0..=40).map(|i| cubic(f64::from(i) / 4.0)).collect();
        let (grid, weights) = (grid(10), vec![1.0; values.len()]);
        let knots = grid.fit(&grid.factor(&weights), &weights, &values, None);
        for (knot, i) in knots.iter().zip(-1..) {
            let i = f64::from(i);
            let exact = 1.0 - 2.0 * i + 0.5 * (i * i - 1.0 / 3.0) - 0.125 * (i * i * i - i);
            assert!((knot - exact).abs() < 1e-3, "{i}: {knot} {exact}");
        }
        for (found, value) in grid.values(&knots).zip(&values) {
            assert!((found - value).abs() < 1e-3);
        }
    }

    #[test]
    fn a_heavy_sample_draws_the_spline() {
        let values: Vec<f64> = (0..=40).map(|i| f64::from(u8::from(i == 20))).collect();
        let mut weights = vec![1.0; values.len()];
        let grid = grid(10);
        let at_peak = |weights: &[f64]| {
            let knots = grid.fit(&grid.factor(weights), weights, &values, None);
            grid.values(&knots).nth(20).unwrap()
        };
        let before = at_peak(&weights);
        weights[20] = 100.0;
        assert!(before < 0.5 && at_peak(&weights) > 0.9);
    }

    #[test]
    fn one_sample_gives_a_constant() {
        let grid = KnotGrid::new(std::iter::once(0.0), 1);
        let knots = grid.fit(&grid.factor(&[1.0]), &[1.0], &[7.0], None);
        assert!(
            knots.iter().all(|knot| (knot - 7.0).abs() < 1e-6),
            "{knots:?}"
        );
    }

    #[test]
    fn rounding_in_turn_is_nearer_than_rounding_at_the_end() {
        let values: Vec<f64> = (0..=400).map(|i| libm::sin(f64::from(i) * 0.1)).collect();
        let (grid, weights) = (grid(100), vec![1.0; 401]);
        let factor = grid.factor(&weights);
        let misfit = |knots: &[f64]| -> f64 {
            let pairs = grid.values(knots).zip(&values);
            pairs.map(|(a, b)| (a - b) * (a - b)).sum()
        };
        let plain: Vec<f64> = grid.fit(&factor, &weights, &values, None);
        let plain: Vec<f64> = plain.iter().map(|k| (k / 0.1).round() * 0.1).collect();
        let in_turn = grid.fit(&factor, &weights, &values, Some(0.1));
        assert!(
            in_turn
                .iter()
                .all(|k| ((k / 0.1) - (k / 0.1).round()).abs() < 1e-9)
        );
        assert!(misfit(&in_turn) < 0.9 * misfit(&plain));
    }
}

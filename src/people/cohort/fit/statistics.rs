//! Correlations of many features over few people, shrunk and reduced to a few factors.

/// A matrix as rows.
pub(super) type Matrix = Vec<Vec<f64>>;

/// Returns mean and standard deviation (with n - 1).
pub(super) fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, libm::sqrt(squares / (n - 1.0)))
}

/// Correlations shrunk towards the identity.
pub(super) struct Shrunk {
    /// The intensity: 0 keeps the sample's correlations, 1 leaves none.
    pub intensity: f64,
    /// The correlations of the sample itself.
    pub sample: Matrix,
    /// The shrunk correlations.
    pub shrunk: Matrix,
}

/// Returns the correlations of columns over rows, shrunk by the intensity of Schaefer & Strimmer
/// (2005, Stat. Appl. Genet. Mol. Biol. 4:32, table 1, target D with unit variances), the
/// estimate that minimises the expected squared error (Ledoit & Wolf 2003, J. Empirical Finance
/// 10:603-621).
pub(super) fn shrunk_correlations(rows: &[Vec<f64>]) -> Shrunk {
    let (n, p) = (rows.len() as f64, rows[0].len());
    let scaled: Vec<Vec<f64>> = (0..p)
        .map(|column| {
            let values: Vec<f64> = rows.iter().map(|row| row[column]).collect();
            let (mean, sd) = mean_and_sd(&values);
            values.iter().map(|value| (value - mean) / sd).collect()
        })
        .collect();
    let mut sample = identity(p);
    let (mut variances, mut squares) = (0.0, 0.0);
    for i in 0..p {
        for j in 0..i {
            let products: Vec<f64> = scaled[i]
                .iter()
                .zip(&scaled[j])
                .map(|(a, b)| a * b)
                .collect();
            let mean = products.iter().sum::<f64>() / n;
            let r = n / (n - 1.0) * mean;
            let spread: f64 = products.iter().map(|w| (w - mean).powi(2)).sum();
            variances += n / (n - 1.0).powi(3) * spread;
            squares += r * r;
            sample[i][j] = r;
            sample[j][i] = r;
        }
    }
    let intensity = (variances / squares).clamp(0.0, 1.0);
    let mut shrunk = sample.clone();
    for (i, row) in shrunk.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            if i != j {
                *value *= 1.0 - intensity;
            }
        }
    }
    Shrunk {
        intensity,
        sample,
        shrunk,
    }
}

/// Returns the loadings of `factors` factors, one row per feature: the iterated principal factors
/// of a correlation matrix (Harman 1976, Modern Factor Analysis, chapter 8). A row's squares sum to
/// the variance that the feature shares with others, at most `MOST_SHARED`; the rest of 1 is its
/// own.
pub(super) fn principal_factors(correlations: &Matrix, factors: usize) -> Matrix {
    const MOST_SHARED: f64 = 0.95;
    const ROUNDS: usize = 100;
    let p = correlations.len();
    let mut reduced = correlations.clone();
    let mut loadings = vec![vec![0.0; factors]; p];
    for _ in 0..ROUNDS {
        let (values, vectors) = eigen(&reduced);
        for (feature, row) in loadings.iter_mut().enumerate() {
            for (factor, loading) in row.iter_mut().enumerate() {
                *loading = libm::sqrt(values[factor].max(0.0)) * vectors[factor][feature];
            }
            let shared: f64 = row.iter().map(|loading| loading * loading).sum();
            if shared > MOST_SHARED {
                let factor = libm::sqrt(MOST_SHARED / shared);
                row.iter_mut().for_each(|loading| *loading *= factor);
            }
            reduced[feature][feature] = shared.min(MOST_SHARED);
        }
    }
    // Of a factor's two signs, takes the one with the greater sum of loadings.
    for factor in 0..factors {
        if loadings.iter().map(|row| row[factor]).sum::<f64>() < 0.0 {
            loadings.iter_mut().for_each(|row| row[factor] *= -1.0);
        }
    }
    loadings
}

/// Returns the eigenvalues, largest first, and their unit eigenvectors, by Jacobi's rotations.
pub(super) fn eigen(symmetric: &Matrix) -> (Vec<f64>, Matrix) {
    const SWEEPS: usize = 60;
    let p = symmetric.len();
    let mut m = symmetric.clone();
    let mut vectors = identity(p);
    for _ in 0..SWEEPS {
        for i in 0..p {
            for j in i + 1..p {
                if m[i][j].abs() < 1e-15 {
                    continue;
                }
                let angle = 0.5 * libm::atan2(2.0 * m[i][j], m[j][j] - m[i][i]);
                let (s, c) = libm::sincos(angle);
                for row in &mut m {
                    (row[i], row[j]) = (c * row[i] - s * row[j], s * row[i] + c * row[j]);
                }
                for rows in [&mut m, &mut vectors] {
                    let (before, from) = rows.split_at_mut(j);
                    for (a, b) in before[i].iter_mut().zip(&mut from[0]) {
                        (*a, *b) = (c * *a - s * *b, s * *a + c * *b);
                    }
                }
            }
        }
    }
    let mut order: Vec<usize> = (0..p).collect();
    order.sort_by(|&a, &b| m[b][b].total_cmp(&m[a][a]));
    let values = order.iter().map(|&i| m[i][i]).collect();
    let sorted = order.iter().map(|&i| vectors[i].clone()).collect();
    (values, sorted)
}

/// Returns the identity matrix.
fn identity(p: usize) -> Matrix {
    (0..p)
        .map(|i| (0..p).map(|j| f64::from(u8::from(i == j))).collect())
        .collect()
}

/// Returns the correlation of two series.
pub(super) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let ((mean_a, sd_a), (mean_b, sd_b)) = (mean_and_sd(a), mean_and_sd(b));
    let products = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b));
    products.sum::<f64>() / (a.len() as f64 - 1.0) / (sd_a * sd_b)
}

#[cfg(test)]
mod tests {
    use super::super::super::style::normal;
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_intensity_of_four_rows_is_the_one_by_hand() {
        // Scaled: x = +-sqrt(3)/2, y = 1/2, 1/2, 1/2, -3/2. Products: a, a, -a, 3a with
        // a = sqrt(3)/4, mean a; squares about it 0 + 0 + 4 a^2 + 4 a^2 = 3/2. The variance of
        // r is 4/27 of that, 2/9; r^2 = (4/3 a)^2 = 1/3.
        let rows = [[1.0, 1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -3.0]].map(|row| row.to_vec());
        let shrunk = shrunk_correlations(&rows);
        assert!((shrunk.intensity - 2.0 / 3.0).abs() < 1e-12);
        let r = libm::sqrt(1.0 / 3.0);
        assert!((shrunk.sample[0][1] - r).abs() < 1e-12);
        assert!((shrunk.shrunk[1][0] - r / 3.0).abs() < 1e-12);
    }

    #[test]
    fn eigenvectors_of_two_by_two_are_the_diagonals() {
        let (values, vectors) = eigen(&vec![vec![1.0, 0.5], vec![0.5, 1.0]]);
        assert!((values[0] - 1.5).abs() < 1e-12 && (values[1] - 0.5).abs() < 1e-12);
        assert!((vectors[0][0] * vectors[0][1] - 0.5).abs() < 1e-12);
    }

    #[test]
    fn planted_factors_are_found_again() {
        let planted = [
            [0.8, 0.0],
            [0.7, 0.3],
            [-0.6, 0.5],
            [0.0, 0.8],
            [0.5, -0.6],
            [0.4, 0.4],
            [0.0, 0.0],
            [-0.7, -0.3],
        ];
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let rows: Vec<Vec<f64>> = (0..2_000)
            .map(|_| {
                let factors = [normal(&mut rng), normal(&mut rng)];
                planted
                    .iter()
                    .map(|row| {
                        let shared = row[0] * factors[0] + row[1] * factors[1];
                        let own = 1.0 - row[0] * row[0] - row[1] * row[1];
                        shared + libm::sqrt(own) * normal(&mut rng)
                    })
                    .collect()
            })
            .collect();
        let shrunk = shrunk_correlations(&rows);
        assert!(shrunk.intensity < 0.02, "{}", shrunk.intensity);
        let found = principal_factors(&shrunk.shrunk, 2);
        for i in 0..planted.len() {
            for j in 0..=i {
                let of = |a: &[f64], b: &[f64]| a[0] * b[0] + a[1] * b[1];
                let (expected, found) = (of(&planted[i], &planted[j]), of(&found[i], &found[j]));
                // Three standard errors of a correlation of 2,000 people.
                assert!(
                    (expected - found).abs() < 0.07,
                    "{i} {j} {expected} {found}"
                );
            }
        }
    }
}

//! Shared parts of the crate's tests: noise, made-up people, and slow independent solvers.

use ndarray::{Array1, Array2};

use super::{LinearModel, TrainOptions, fit};

/// Draws numbers evenly from -1..1, from the splitmix64 sequence (Steele, Lea and Flood, 2014).
pub(crate) fn noise(rows: usize, columns: usize, seed: u64) -> Array2<f64> {
    let mut state = seed;
    Array2::from_shape_simple_fn((rows, columns), || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

/// Draws GEI-like images in 0..1: people are blobs of their own widths, corners stay empty.
pub(crate) fn people(count: usize, classes: usize, seed: u64) -> (Array2<f32>, Vec<usize>) {
    let traits = noise(classes, 3, 1);
    let walks = noise(count, 4, seed);
    let grain = noise(count, 1500, seed ^ 0xA5A5);
    let labels: Vec<usize> = (0..count).map(|i| i % classes).collect();
    let geis = Array2::from_shape_fn((count, 1500), |(i, pixel)| {
        let (row, column) = ((pixel / 30) as f64, (pixel % 30) as f64);
        let person = traits.row(labels[i]);
        let lean = 15.0 + walks[[i, 0]] + (row - 25.0) * 0.05 * walks[[i, 1]];
        let width = 4.0
            + person[0]
            + (1.5 + 0.5 * person[1]) * (row * 0.12 + person[2]).sin()
            + 0.3 * walks[[i, 2]] * (row * 0.3 + walks[[i, 3]]).cos();
        let inside = 1.0 - ((column - lean).abs() - width) / 2.0;
        let edge = inside.clamp(0.0, 1.0);
        let grain = if edge > 0.0 && edge < 1.0 {
            0.05 * grain[[i, pixel]]
        } else {
            0.0
        };
        ((edge + grain).clamp(0.0, 1.0) * 255.0).round() as f32 / 255.0
    });
    (geis, labels)
}

/// Returns a recognizer of two people, learnt from 40 made-up GEIs.
pub(crate) fn small_recognizer() -> LinearModel {
    let (geis, labels) = people(40, 2, 9);
    fit(geis.view(), &labels, 2, TrainOptions::default()).expect("two different people")
}

/// Computes eigenvalues (descending) and eigenvectors (one a row) by cyclic Jacobi rotations.
///
/// Golub and Van Loan, Matrix Computations, section 8.5. It is slow and simple, and shares no code
/// with `faer`.
pub(crate) fn jacobi(mut a: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = a.len();
    let mut v = vec![vec![0.0; n]; n];
    for (i, row) in v.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for _ in 0..60 {
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q] == 0.0 {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut a {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for k in 0..n {
                    (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                    (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
                }
            }
        }
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    (
        order.iter().map(|&i| a[i][i]).collect(),
        order.iter().map(|&i| v[i].clone()).collect(),
    )
}

/// Solves `a x = b` by Gaussian elimination with pivoting.
pub(crate) fn solve(mut a: Array2<f64>, b: &Array1<f64>) -> Array1<f64> {
    let n = b.len();
    let mut b = b.clone();
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|&i, &j| a[[i, k]].abs().total_cmp(&a[[j, k]].abs()))
            .expect("at least row k");
        for j in 0..n {
            a.swap([k, j], [pivot, j]);
        }
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[[i, k]] / a[[k, k]];
            for j in k..n {
                a[[i, j]] -= factor * a[[k, j]];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[[k, j]] * b[j]).sum();
        b[k] = (b[k] - known) / a[[k, k]];
    }
    b
}

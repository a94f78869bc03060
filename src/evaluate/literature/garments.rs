//! Measures how row widths change with clothes, after Nandy et al.: the correlation of garments
//! with each other, and variances within and between them.

use crate::train::Samples;
use ndarray::{Array1, Array2, ArrayView1, Axis};
use serde::Serialize;

/// Statistics of the row widths of people in several garments.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Garments {
    pub names: Vec<String>,
    /// Pearson's correlation of the mean row widths of each pair of garments, -1..1, one row for
    /// each garment.
    pub correlations: Vec<Vec<f64>>,
    /// For each garment, the variance of a row's width among people and cycles, mean over the rows;
    /// widths in 0..1.
    pub within: Vec<f64>,
    /// Variance of a row's mean width between garments, mean over the rows.
    pub between: f64,
    /// Rows that were chosen, 0 at the top.
    pub chosen: Vec<usize>,
}

impl Garments {
    /// Computes the statistics of samples in these garments; `chosen` are the rows that were
    /// chosen.
    #[must_use]
    pub(super) fn compute(
        samples: &Samples,
        names: Vec<String>,
        garments: &[usize],
        chosen: Vec<usize>,
    ) -> Self {
        let in_garment = |garment: usize| -> Array2<f64> {
            let own: Vec<usize> = (0..garments.len())
                .filter(|&at| garments[at] == garment)
                .collect();
            samples.numbers.select(Axis(0), &own).mapv(f64::from)
        };
        let all: Vec<Array2<f64>> = (0..names.len()).map(in_garment).collect();
        let means: Vec<Array1<f64>> = all.iter().map(mean).collect();
        let correlations = means.iter().map(|mean| {
            let of = |other: &Array1<f64>| correlation(mean.view(), other.view());
            means.iter().map(of).collect()
        });
        let views: Vec<_> = means.iter().map(|mean| mean.view()).collect();
        let between = ndarray::stack(Axis(0), &views).expect("rows of one length");
        Self {
            correlations: correlations.collect(),
            within: all.iter().map(variance).collect(),
            between: variance(&between),
            names,
            chosen,
        }
    }
}

fn mean(rows: &Array2<f64>) -> Array1<f64> {
    rows.sum_axis(Axis(0)) / rows.nrows().max(1) as f64
}

/// Returns the variance of each column, mean over the columns.
fn variance(rows: &Array2<f64>) -> f64 {
    let offsets = rows - &mean(rows);
    let squares: f64 = offsets.iter().map(|offset| offset * offset).sum();
    squares / (rows.nrows().saturating_sub(1).max(1) * rows.ncols().max(1)) as f64
}

/// Computes Pearson's correlation; 0 if one side does not vary.
fn correlation(a: ArrayView1<'_, f64>, b: ArrayView1<'_, f64>) -> f64 {
    let offsets = |of: ArrayView1<'_, f64>| of.mapv(|value| value - of.mean().unwrap_or_default());
    let (a, b) = (offsets(a), offsets(b));
    let lengths = (a.dot(&a) * b.dot(&b)).sqrt();
    if lengths > 0.0 {
        (a.dot(&b) / lengths).clamp(-1.0, 1.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::template::Template;
    use crate::inference::Training;
    use edgegait_core::silhouette::Size;
    use ndarray::array;

    #[test]
    fn correlations_and_variances_are_those_of_a_worked_example() {
        // Three rows (the others are empty): two samples of each of two garments.
        let mut numbers = Array2::zeros((4, 50));
        let rows = array![
            [0.1, 0.2, 0.3],
            [0.3, 0.2, 0.3],
            [0.4, 0.4, 0.2],
            [0.4, 0.2, 0.2]
        ];
        numbers.slice_mut(ndarray::s![.., ..3]).assign(&rows);
        let samples = Samples {
            numbers,
            template: Template::RowWidth,
            size: Size::S50x30,
            framing: None,
            labels: vec![0, 1, 0, 1],
            views: vec![Some(0); 4],
            names: vec!["ann".into(), "bob".into()],
            found: 4,
            training: Training::default(),
        };
        let names = vec!["plain".to_owned(), "coat".to_owned()];
        let found = Garments::compute(&samples, names, &[0, 0, 1, 1], vec![2]);
        // Within: 0.02 and 0.02, of one row each, over 50 rows.
        for within in &found.within {
            assert!((within - 0.02 / 50.0).abs() < 1e-7, "{within}");
        }
        // Means 0.2 0.2 0.3 and 0.4 0.3 0.2: differences 0.2, 0.1, 0.1, half their squares.
        let expected = (0.04 + 0.01 + 0.01) / 2.0 / 50.0;
        assert!((found.between - expected).abs() < 1e-7);
        // Sums over 50 rows: 0.17 - 0.7^2 / 50, 0.29 - 0.9^2 / 50, and 0.20 - 0.7 0.9 / 50 of both.
        let expected = (0.20 - 0.0126) / ((0.17 - 0.0098) * (0.29 - 0.0162_f64)).sqrt();
        assert!((found.correlations[0][1] - expected).abs() < 1e-6);
        assert!((found.correlations[1][1] - 1.0).abs() < 1e-12);
    }
}

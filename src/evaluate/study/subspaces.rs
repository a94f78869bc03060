//! The principal components of real and of synthetic Gait Energy Images (GEI), and the angles
//! between them.

use super::example::{Example, SIZE};
use crate::error::Result;
use crate::train::linear_algebra::{eigen, multiply};
use crate::train::pca::Pca;
use ndarray::{Array2, ArrayView2, s};
use serde::Serialize;

/// The number of components that are shown and compared, as in the paper.
pub(crate) const SHOWN: usize = 9;

/// The principal components of one set of GEIs.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SubspaceSide {
    /// The number of cycles.
    pub cycles: usize,
    /// The share of the variance that each of the first nine components explains, 0..1.
    pub explained: Vec<f64>,
    /// The number of components that explain 95 % of the variance.
    pub for_95_percent: usize,
    /// The mean GEI, 0..1.
    #[serde(skip)]
    pub mean: Vec<f64>,
    /// The first nine components, unit vectors.
    #[serde(skip)]
    pub components: Array2<f64>,
}

/// The comparison of real and synthetic subspaces from one viewpoint.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ComparedSubspaces {
    /// The view's name.
    pub view: String,
    /// The components of real GEIs.
    pub real: SubspaceSide,
    /// The components of synthetic GEIs.
    pub synthetic: SubspaceSide,
    /// The principal angles between the two spans of nine components, degrees, rising.
    pub angles_deg: Vec<f64>,
    /// The principal angles between two halves of the real GEIs, every other cycle: the effect of
    /// sampling.
    pub halves_deg: Vec<f64>,
    /// The difference of the mean GEIs, root mean square of 255.
    pub means_apart: f64,
}

impl ComparedSubspaces {
    /// Compares GEIs from one viewpoint; none if a side has fewer than three.
    ///
    /// # Errors
    /// If an eigenproblem has no solution.
    pub(crate) fn compare(
        view: &str,
        real: &[Example],
        synthetic: &[Example],
    ) -> Result<Option<Self>> {
        if real.len() < 3 || synthetic.len() < 3 {
            return Ok(None);
        }
        let all = |examples: &[Example]| {
            SubspaceSide::from_examples(&examples.iter().collect::<Vec<_>>())
        };
        let (real_side, synthetic_side) = (all(real)?, all(synthetic)?);
        let squares = real_side.mean.iter().zip(&synthetic_side.mean);
        let squares: f64 = squares.map(|(a, b)| (a - b).powi(2)).sum();
        let half = |odd: usize| {
            let every_other = real.iter().enumerate().filter(|(at, _)| at % 2 == odd);
            let half: Vec<&Example> = every_other.map(|(_, example)| example).collect();
            (half.len() > 2)
                .then(|| SubspaceSide::from_examples(&half))
                .transpose()
        };
        let halves_deg = match (half(0)?, half(1)?) {
            (Some(a), Some(b)) => angles_deg(a.components.view(), b.components.view())?,
            _ => Vec::new(),
        };
        Ok(Some(Self {
            view: view.to_owned(),
            angles_deg: angles_deg(
                real_side.components.view(),
                synthetic_side.components.view(),
            )?,
            halves_deg,
            means_apart: 255.0 * (squares / SIZE.pixels() as f64).sqrt(),
            real: real_side,
            synthetic: synthetic_side,
        }))
    }
}

impl SubspaceSide {
    fn from_examples(examples: &[&Example]) -> Result<Self> {
        let samples = Array2::from_shape_fn((examples.len(), SIZE.pixels()), |(row, pixel)| {
            f64::from(examples[row].gei[pixel]) / 255.0
        });
        let pca = Pca::<f64>::fit(samples.view())?;
        let kept = SHOWN.min(pca.components.nrows());
        let all = pca.eigenvalues.sum();
        let explained = pca.eigenvalues.iter().take(kept).map(|value| value / all);
        Ok(Self {
            cycles: examples.len(),
            explained: explained.collect(),
            for_95_percent: pca.components_for(0.95),
            mean: pca.mean.to_vec(),
            components: pca.components.slice(s![..kept, ..]).to_owned(),
        })
    }
}

/// Returns the principal angles between the spans of two sets of orthonormal rows, degrees, rising:
/// the arc cosines of the singular values of their product (Björck and Golub, "Numerical methods
/// for computing angles between linear subspaces", Math. Comp. 27, 1973). Singular values are
/// computed here as roots of eigenvalues, so angles below 1e-6 degrees are 0.
pub(crate) fn angles_deg(a: ArrayView2<'_, f64>, b: ArrayView2<'_, f64>) -> Result<Vec<f64>> {
    let product = multiply(a, b.t());
    let square = multiply(product.view(), product.t());
    let square = Array2::from_shape_fn(square.dim(), |(i, j)| {
        f64::midpoint(square[[i, j]], square[[j, i]])
    });
    let cosines = eigen(&square)?.values;
    let count = a.nrows().min(b.nrows());
    let angle = |square: &f64| square.clamp(0.0, 1.0).sqrt().acos().to_degrees();
    Ok(cosines.iter().take(count).map(angle).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn planes_that_share_a_line_and_are_tilted_about_it_have_angles_0_and_the_tilt() {
        let tilt = 30.0_f64.to_radians();
        let flat = array![[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]];
        let tilted = array![[0.0, tilt.cos(), tilt.sin(), 0.0], [1.0, 0.0, 0.0, 0.0]];
        let found = angles_deg(flat.view(), tilted.view()).expect("angles");
        assert!(
            found[0].abs() < 1e-5 && (found[1] - 30.0).abs() < 1e-9,
            "{found:?}"
        );
        let across = array![[0.0, 0.0, 1.0, 0.0]];
        let found = angles_deg(flat.view(), across.view()).expect("an angle");
        assert_eq!(found, [90.0]);
    }

    #[test]
    fn the_first_component_of_geis_that_differ_in_one_pixel_is_that_pixel() {
        let of = |pixel: usize| -> Vec<Example> {
            let one = |at: u8| {
                let mut gei = vec![0; SIZE.pixels()];
                gei[pixel] = 50 * at;
                Example {
                    person: 0,
                    take: 0,
                    position: usize::from(at),
                    span_s: (0.0, 1.0),
                    frames: Vec::new(),
                    gei,
                }
            };
            (0..6).map(one).collect()
        };
        let found = ComparedSubspaces::compare("090", &of(700), &of(701)).expect("no error");
        let found = found.expect("enough");
        assert_eq!(found.real.components[[0, 700]], 1.0);
        assert_eq!((found.angles_deg[0], found.halves_deg[0]), (90.0, 0.0));
        assert_eq!(
            (found.real.explained[0], found.real.for_95_percent),
            (1.0, 1)
        );
        // The two halves of R vary in different pixels.
        let (mut even, mut odd) = (of(700).into_iter(), of(702).into_iter());
        let turns = (0..12).map(|at| if at % 2 == 0 { even.next() } else { odd.next() });
        let mixed: Vec<Example> = turns.flatten().collect();
        let found_halves = ComparedSubspaces::compare("090", &mixed, &of(701)).expect("no error");
        assert_eq!(found_halves.expect("enough").halves_deg, [90.0]);
        // Two of the 1,500 pixels differ by 125 of 255.
        let expected = (2.0 * 125.0_f64.powi(2) / 1500.0).sqrt();
        assert!((found.means_apart - expected).abs() < 1e-9);
        assert!(
            ComparedSubspaces::compare("090", &of(1)[..2], &of(2))
                .expect("no error")
                .is_none()
        );
    }
}

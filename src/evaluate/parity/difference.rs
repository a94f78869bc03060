//! Differences between two lists of vectors.
//!
//! The size of a difference depends on the scale of the numbers. People are distinguished by the
//! differences between embeddings, not by their common part. So differences are relative to the
//! spread of the reference: the root mean square distance of its vectors from their mean.

use crate::inference::Distance;
use serde::Serialize;

/// The minimum spread, as a share of the size. A smaller one could be due to rounding in f32. Our
/// choice: a rounding error of 1e-6, as in sums of thousands of products, is then at most a
/// thousandth of the spread.
const LEAST_SPREAD: f64 = 1e-3;

/// The differences between the answers of two sides, over all inputs whose answers are finite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct AnswerDifference {
    /// Number of inputs that were compared.
    pub inputs: u64,
    /// Numbers per answer.
    pub numbers: usize,
    /// The greatest absolute difference of two numbers.
    pub greatest: f64,
    /// Mean absolute difference of two numbers.
    pub mean: f64,
    /// Root mean square of the lengths of the reference's answers.
    pub size: f64,
    /// Root mean square distance of the reference's answers from their mean, at least a thousandth
    /// of their size.
    pub spread: f64,
    /// The greatest relative difference over the inputs: the length of the difference, relative to
    /// the spread. Infinite where the reference gives only zeros and the other side does not.
    pub greatest_relative: f64,
    /// Mean relative difference over the inputs.
    pub mean_relative: f64,
    /// The lowest cosine between two answers, -1..1.
    pub worst_cosine: f64,
}

/// A vector of the reference and one of another side, of one length and finite.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct VectorPair<'a> {
    pub(crate) reference: &'a [f32],
    pub(crate) other: &'a [f32],
}

impl AnswerDifference {
    /// Returns the differences of all pairs, and the relative difference of each pair; none without
    /// numbers.
    pub(crate) fn measure(pairs: &[VectorPair<'_>]) -> Option<(Self, Vec<f64>)> {
        let width = pairs.first()?.reference.len();
        if width == 0 {
            return None;
        }
        let count = pairs.len() as f64;
        let mut mean = vec![0.0; width];
        for pair in pairs {
            for (sum, &number) in mean.iter_mut().zip(pair.reference) {
                *sum += f64::from(number) / count;
            }
        }
        let root_mean_square = |from: &[f64]| {
            let squares = pairs.iter().flat_map(|pair| {
                let numbers = pair.reference.iter().copied().map(f64::from);
                numbers.zip(from).map(|(a, b)| (a - b) * (a - b))
            });
            (squares.sum::<f64>() / count).sqrt()
        };
        let size = root_mean_square(&vec![0.0; width]);
        let spread = root_mean_square(&mean).max(LEAST_SPREAD * size);

        let relative = |pair: &VectorPair<'_>| match pair.distance(Distance::Euclidean) {
            0.0 => 0.0,
            length => length / spread,
        };
        let relatives: Vec<f64> = pairs.iter().map(relative).collect();
        let numbers = || {
            let pairs = pairs
                .iter()
                .flat_map(|pair| pair.reference.iter().zip(pair.other));
            pairs.map(|(&a, &b)| (f64::from(a) - f64::from(b)).abs())
        };
        let difference = Self {
            inputs: pairs.len() as u64,
            numbers: width,
            greatest: numbers().fold(0.0, f64::max),
            mean: numbers().sum::<f64>() / (count * width as f64),
            size,
            spread,
            greatest_relative: relatives.iter().copied().fold(0.0, f64::max),
            mean_relative: relatives.iter().sum::<f64>() / count,
            worst_cosine: pairs.iter().map(VectorPair::cosine).fold(1.0, f64::min),
        };
        Some((difference, relatives))
    }
}

impl<'a> VectorPair<'a> {
    pub(crate) const fn new(reference: &'a [f32], other: &'a [f32]) -> Self {
        Self { reference, other }
    }

    fn distance(&self, distance: Distance) -> f64 {
        distance.between(self.reference, self.other, 1)
    }

    /// Returns the cosine between the vectors; 1 for equal vectors, even if they are zero.
    fn cosine(&self) -> f64 {
        if self.reference == self.other {
            return 1.0;
        }
        1.0 - self.distance(Distance::Cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_measured_from_the_spread_of_the_reference() {
        // The mean is (10, 0): each vector is 5 away from it.
        let reference = [[13.0_f32, 4.0], [7.0, -4.0]];
        let other = [[13.0_f32, 4.0], [7.0, -3.0]];
        let pairs = [0, 1].map(|at| VectorPair::new(&reference[at], &other[at]));
        let (found, relatives) = AnswerDifference::measure(&pairs).expect("numbers");
        assert_eq!((found.inputs, found.numbers), (2, 2));
        assert_eq!((found.greatest, found.mean), (1.0, 0.25));
        assert_eq!((found.size, found.spread), (125.0_f64.sqrt(), 5.0));
        assert_eq!(relatives, [0.0, 0.2]);
        assert_eq!((found.greatest_relative, found.mean_relative), (0.2, 0.1));
        // (7, -4) and (7, -3): 61 / sqrt(65 * 58).
        let cosine = 61.0 / (65.0_f64 * 58.0).sqrt();
        assert!((found.worst_cosine - cosine).abs() < 1e-15);
    }

    #[test]
    fn a_reference_that_hardly_varies_is_measured_by_a_thousandth_of_its_size() {
        let (a, b) = ([1000.0_f32], [1000.5_f32]);
        let (found, _) =
            AnswerDifference::measure(&[VectorPair::new(&a, &b), VectorPair::new(&a, &a)])
                .expect("numbers");
        assert_eq!((found.size, found.spread), (1000.0, 1.0));
        assert_eq!((found.greatest_relative, found.mean_relative), (0.5, 0.25));
    }

    #[test]
    fn zeros_are_the_same_as_zeros_and_infinitely_far_from_others() {
        let (zero, one) = ([0.0_f32; 3], [1.0_f32; 3]);
        let (same, _) =
            AnswerDifference::measure(&[VectorPair::new(&zero, &zero)]).expect("numbers");
        assert_eq!((same.greatest_relative, same.worst_cosine), (0.0, 1.0));
        let (other, _) =
            AnswerDifference::measure(&[VectorPair::new(&zero, &one)]).expect("numbers");
        assert_eq!(other.greatest_relative, f64::INFINITY);
        assert_eq!(other.worst_cosine, 0.0);
        assert_eq!(AnswerDifference::measure(&[]), None);
        assert_eq!(
            AnswerDifference::measure(&[VectorPair::new(&[], &[])]),
            None
        );
    }
}

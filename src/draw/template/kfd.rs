//! Key Fourier Descriptors-style vectors: the frequencies of the outlines of a gait cycle.
//!
//! After Yu, Wang, Hu & Tan 2004, "Gait recognition based on key Fourier descriptors": the
//! outlines of a cycle's T silhouettes, N points each, form one curve of N T complex numbers.
//! The frequencies m T hold what all outlines share; the frequencies m T - 1 and m T + 1 beside
//! them hold what changes once a cycle. The number of points and the choice of frequencies are
//! ours.

use super::outline;
use edgegait_core::silhouette::Silhouette;
use glam::DVec2;
use std::f64::consts::TAU;

/// The number of points of each outline. Our choice: about as many as on the boundary of a
/// silhouette of 50 rows.
pub(crate) const POINTS: usize = 128;
/// The number of frequencies of the outline, M: m runs from -M to M. Our choice.
pub(crate) const HARMONICS: usize = 10;
/// The length of a descriptor: three numbers for each m except 0.
pub(crate) const NUMBERS: usize = 6 * HARMONICS;

/// Returns [`POINTS`] points of the outline of the largest figure, relative to their mean, or
/// `None` if no pixel is on.
#[must_use]
pub(crate) fn centred_outline(silhouette: &Silhouette) -> Option<Vec<DVec2>> {
    let mut points = outline(silhouette, POINTS)?;
    let mean = points.iter().sum::<DVec2>() / points.len() as f64;
    points.iter_mut().for_each(|point| *point -= mean);
    Some(points)
}

/// Returns the [`NUMBERS`] numbers |a_k| / |a_T| for k in (m T - 1, m T, m T + 1), m from -M to
/// -1, then from 1 to M. `outlines` are T outlines of N points each, a_k = sum over n of
/// s_n e^(-2 pi i k n / N T) / N T, and s = x + i y. All numbers are 0 if a_T is 0.
///
/// The numbers do not change when all figures are moved, turned or scaled in the same way.
#[must_use]
pub(crate) fn descriptors(outlines: &[Vec<DVec2>]) -> Vec<f64> {
    let points: Vec<DVec2> = outlines.concat();
    let cycle = outlines.len() as i64;
    let waves = waves(points.len());
    let first = amplitude(&points, &waves, cycle);
    let harmonics = HARMONICS as i64;
    let steps = (-harmonics..=harmonics).filter(|&m| m != 0);
    let frequencies = steps.flat_map(|m| [m * cycle - 1, m * cycle, m * cycle + 1]);
    frequencies
        .map(|k| {
            // The amplitude of a figure of one point is only rounding.
            if first > 1e-9 {
                amplitude(&points, &waves, k) / first
            } else {
                0.0
            }
        })
        .collect()
}

/// Returns descriptors as bytes: 255 (1 + log10(g) / 4), clamped to 0..=255, so that 1 is white
/// and a ten-thousandth black. The scale is ours.
#[must_use]
pub(crate) fn bytes(descriptors: &[f64]) -> Vec<u8> {
    let byte = |&g: &f64| {
        let share = if g > 0.0 {
            (1.0 + libm::log10(g) / 4.0).clamp(0.0, 1.0)
        } else {
            0.0
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 255"
        )]
        {
            (255.0 * share).round() as u8
        }
    };
    descriptors.iter().map(byte).collect()
}

/// Returns e^(-2 pi i n / count) as (real, imaginary) for n from 0 to count - 1.
fn waves(count: usize) -> Vec<DVec2> {
    let wave = |n: usize| {
        let (sin, cos) = libm::sincos(TAU * n as f64 / count as f64);
        DVec2::new(cos, -sin)
    };
    (0..count).map(wave).collect()
}

/// Returns |a_k|, or 0 without points.
fn amplitude(points: &[DVec2], waves: &[DVec2], k: i64) -> f64 {
    let count = points.len();
    if count == 0 {
        return 0.0;
    }
    let step = usize::try_from(k.rem_euclid(count as i64)).unwrap_or(0);
    let (mut sum, mut at) = (DVec2::ZERO, 0);
    for point in points {
        let wave = waves[at];
        sum += DVec2::new(
            point.x * wave.x - point.y * wave.y,
            point.x * wave.y + point.y * wave.x,
        );
        at += step;
        if at >= count {
            at -= count;
        }
    }
    sum.length() / count as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::silhouette::Size;

    #[test]
    fn a_square_has_the_amplitudes_that_can_be_worked_out() {
        // 1, 1+i, i, -1+i, -1, -1-i, -i, 1-i: (1 + sqrt 2) / 2 and (sqrt 2 - 1) / 2.
        let square = [
            (1, 0),
            (1, 1),
            (0, 1),
            (-1, 1),
            (-1, 0),
            (-1, -1),
            (0, -1),
            (1, -1),
        ];
        let points = square.map(|(x, y)| DVec2::new(f64::from(x), f64::from(y)));
        let waves = waves(8);
        let found = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| amplitude(&points, &waves, k));
        let expected = [0.0, 1.2071, 0.0, 0.0, 0.0, 0.2071, 0.0, 0.0];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 5e-5, "{found} {expected}");
        }
        // Frequencies are periodic: -3 is 5.
        assert_eq!(found[5], amplitude(&points, &waves, -3));
    }

    /// Returns the outline of a figure of 20 x 11 pixels with a leg that stands out by `step`.
    fn walker(step: u32, (down, right): (usize, u32)) -> Vec<DVec2> {
        let mut rows = vec![0; down];
        rows.extend([0b111_1111_1111u64 << right; 12]);
        rows.extend([(0b111 << (right + 4)) | (0b111 << (right + 4 + step)); 8]);
        let silhouette = Silhouette::from_rows(Size::S50x30, &rows);
        centred_outline(&silhouette).expect("a figure")
    }

    #[test]
    fn a_figure_that_stands_still_has_nothing_beside_multiples_of_its_frames() {
        let still = descriptors(&vec![walker(2, (3, 4)); 5]);
        assert_eq!(still.len(), NUMBERS);
        for (place, g) in still.iter().enumerate() {
            assert!(place % 3 == 1 || *g < 1e-12, "{place}: {g}");
        }
        // Ten triples have negative m. In the next one, of m = 1, the middle is a_T itself.
        assert_eq!(still[3 * HARMONICS + 1], 1.0);
        let strides =
            |from| -> Vec<Vec<DVec2>> { [0, 1, 3, 1].map(|step| walker(step, from)).to_vec() };
        let walks = descriptors(&strides((3, 4)));
        assert!(walks[3 * HARMONICS] > 1e-3);
        // The place of the figure does not matter.
        let there = descriptors(&strides((9, 12)));
        for (here, there) in walks.iter().zip(there) {
            assert!((here - there).abs() < 1e-12);
        }
    }

    #[test]
    fn scaled_and_turned_alike_they_stay_the_same() {
        let outlines = [0, 1, 3, 1].map(|step| walker(step, (3, 4)));
        let turned = outlines.each_ref().map(|outline| -> Vec<DVec2> {
            let turn = DVec2::new(0.6, 0.8) * 2.5;
            outline.iter().map(|point| turn.rotate(*point)).collect()
        });
        for (a, b) in descriptors(&outlines).iter().zip(descriptors(&turned)) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn without_a_figure_all_are_zero() {
        assert_eq!(descriptors(&[]), [0.0; NUMBERS]);
        let point = Silhouette::from_rows(Size::S50x30, &[1]);
        let point = centred_outline(&point).expect("a pixel");
        assert_eq!(descriptors(&[point]), [0.0; NUMBERS]);
    }

    #[test]
    fn bytes_are_decades() {
        let found = bytes(&[1.0, 10.0, 0.1, 0.01, 1e-3, 1e-4, 1e-9, 0.0]);
        assert_eq!(found, [255, 255, 191, 128, 64, 0, 0, 0]);
    }
}

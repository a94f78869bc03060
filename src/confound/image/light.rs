//! Light and contrast: a difference image, and the segmentation of Charalambous & Bharath.
//!
//! They subtract the background and part the grey differences into two clusters (BMVC 2016,
//! section 3.3; k and initial values are ours: two, least and greatest). The difference image is
//! ours: a level for the figure, lower in patches that stay on the body, noise as wide as a
//! pixel, and a side of the scene that has grown lighter.

use super::fine::Fine;
use super::phases::FINE;
use super::picture::Picture;
use glam::DVec2;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// Grey levels, of 255, by which a figure differs from the background in good light.
const CONTRAST: f32 = 110.0;
/// What of it is lost at strength 1 in the middle of a patch.
const PATCHED: f32 = 2.0;
/// Grey levels at strength 1: standard deviation of noise, and what light adds a figure's
/// height away from the figure's middle.
const NOISE: f32 = 8.0;
const LIGHTER: f32 = 30.0;

/// Knots of the patches across and along the body.
const ACROSS: usize = 5;
const ALONG: usize = 9;

/// Light, and how well a walker's clothes are told from the background.
#[derive(Clone, Debug)]
pub(crate) struct Light {
    strength: f32,
    /// Depths, 0 to 1, rows from the head down.
    patches: [[f32; ACROSS]; ALONG],
    /// The side that is lighter, to the right and down.
    side: DVec2,
}

impl Light {
    /// Draws patches and the side that is lighter. At strength 1 patches take all of the
    /// figure's contrast of 110 grey levels, from where they are half deep, noise has a standard
    /// deviation of 8, and the scene is lighter by 30 a figure's height beside the middle; all
    /// are in proportion to the strength. Up to 0.25, segmentation is perfect.
    #[must_use]
    pub(crate) fn new(strength: f64, rng: &mut ChaCha8Rng) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let strength = strength as f32;
        // Squares: few places are deep.
        let mut depth = || {
            let even = rng.random::<f32>();
            even * even
        };
        let patches = std::array::from_fn(|_| std::array::from_fn(|_| depth()));
        let (sin, cos) = libm::sincos(rng.random::<f64>() * std::f64::consts::TAU);
        Self {
            strength,
            patches,
            side: DVec2::new(cos, sin),
        }
    }

    /// Segments what a sensor sees of the picture, whose pixels are three by three samples;
    /// noise is drawn.
    pub(crate) fn segment(&self, picture: &mut Picture, fine: &Fine, rng: &mut ChaCha8Rng) {
        let (rows, columns) = (picture.rows() / FINE, picture.columns().div_ceil(FINE));
        let noise = self.noise(rows, columns, rng);
        let figure = fine.figure();
        // Levels where a pixel shows the background, and where it shows the figure.
        let mut levels = Vec::with_capacity(rows * columns);
        let mut counts = [0; 256];
        for (row, noise) in noise.chunks_exact(columns).enumerate() {
            for (column, noise) in noise.iter().enumerate() {
                let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * FINE as f64;
                let from_corner = at - figure.corner;
                let from_middle = (from_corner - 0.5 * figure.size) / figure.size.y;
                #[expect(clippy::cast_possible_truncation, reason = "grey levels")]
                let lighter = self.side.dot(from_middle).clamp(0.0, 1.5) as f32;
                let background = noise + self.strength * LIGHTER * lighter;
                let on = on(picture, row, column);
                let shown = background + self.contrast(from_corner / figure.size);
                let pair = [grey(background), grey(shown)];
                counts[usize::from(pair[0])] += 9 - on;
                counts[usize::from(pair[1])] += on;
                levels.push(pair);
            }
        }
        let threshold = threshold(&counts);
        let words = picture.columns() / 64;
        for (row, levels) in levels.chunks_exact(columns).enumerate() {
            let mut found = [Picture::empty(1, words), Picture::empty(1, words)];
            for (column, pair) in levels.iter().enumerate() {
                for (found, &level) in found.iter_mut().zip(pair) {
                    if f64::from(level) > threshold {
                        let from = (FINE * column).cast_signed();
                        found.fill(0, from, from + FINE.cast_signed(), true);
                    }
                }
            }
            for row in FINE * row..FINE * (row + 1) {
                let found = found[0].row(0).iter().zip(found[1].row(0));
                for (word, (background, figure)) in picture.row_mut(row).iter_mut().zip(found) {
                    *word = (*word & figure) | (!*word & background);
                }
            }
        }
    }

    /// Levels by which a figure differs at a place, shares of its rectangle: between the knots
    /// of the patches on straight lines.
    fn contrast(&self, at: DVec2) -> f32 {
        let along = |share: f64, knots: usize| {
            let last = (knots - 1) as f64;
            let place = (share * last).clamp(0.0, last);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a few knots"
            )]
            let knot = (place as usize).min(knots - 2);
            #[expect(clippy::cast_possible_truncation, reason = "a share")]
            let share = (place - knot as f64) as f32;
            (knot, share)
        };
        let ((row, down), (column, right)) = (along(at.y, ALONG), along(at.x, ACROSS));
        let across = |row: usize| {
            let [from, to] = [column, column + 1].map(|column| self.patches[row][column]);
            from + (to - from) * right
        };
        let (from, to) = (across(row), across(row + 1));
        let patch = from + (to - from) * down;
        CONTRAST * (1.0 - self.strength * PATCHED * patch).max(0.0)
    }

    /// Noise of every pixel: means of three by three draws.
    fn noise(&self, rows: usize, columns: usize, rng: &mut ChaCha8Rng) -> Vec<f32> {
        // A mean of nine has a third of the deviation.
        let scale = 3.0 * NOISE * self.strength / 9.0;
        let wide = columns + 2;
        let draws: Vec<f32> = (0..wide * (rows + 2)).map(|_| deviate(rng)).collect();
        let sums: Vec<f32> = (0..wide * rows)
            .map(|at| draws[at] + draws[at + wide] + draws[at + 2 * wide])
            .collect();
        let rows = sums.chunks_exact(wide);
        let means = rows.flat_map(|row| row.windows(3).map(|three| three[0] + three[1] + three[2]));
        means.map(|sum| scale * sum).collect()
    }
}

/// A number of mean 0 and deviation 1: a sum of four even ones (Irwin 1927, Hall 1927), from
/// 16 bits each.
fn deviate(rng: &mut ChaCha8Rng) -> f32 {
    let bits = rng.random::<u64>();
    let sum: u64 = (0..4).map(|part| bits >> (16 * part) & 0xffff).sum();
    #[expect(clippy::cast_precision_loss, reason = "18 bits")]
    let sum = sum as f32;
    // Four have a variance of a third.
    (sum / 65_536.0 - 2.0) * 1.732_050_8
}

/// A difference as a sensor of 256 levels has it.
fn grey(difference: f32) -> u8 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let level = (difference.abs() + 0.5).min(255.0) as u8;
    level
}

/// How many of a pixel's samples are on.
fn on(picture: &Picture, row: usize, column: usize) -> u32 {
    let rows = FINE * row..FINE * (row + 1);
    let columns = FINE * column..FINE * (column + 1);
    let ons = rows.map(|row| {
        let on = columns.clone().filter(|&column| picture.is_on(row, column));
        u32::try_from(on.count()).unwrap_or(0)
    });
    ons.sum()
}

/// Midway between the means of two clusters of levels, of which there are so many each: k-means
/// (Lloyd 1982) from the least and the greatest level on. What is above it is the figure.
fn threshold(counts: &[u32; 256]) -> f64 {
    let used = |level: &usize| counts[*level] > 0;
    let (first, last) = ((0..256).find(used), (0..256).rfind(used));
    let mut threshold = 0.5 * (first.unwrap_or(0) + last.unwrap_or(0)) as f64;
    // Each step moves levels to one side, so that there are at most 256.
    for _ in 0..256 {
        let mean = |levels: std::ops::Range<usize>| {
            let (mut count, mut sum) = (0.0, 0.0);
            for level in levels {
                count += f64::from(counts[level]);
                sum += f64::from(counts[level]) * level as f64;
            }
            (count > 0.0).then(|| sum / count)
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 255"
        )]
        let split = threshold as usize + 1;
        let Some((low, high)) = mean(0..split).zip(mean(split..256)) else {
            break;
        };
        let next = 0.5 * (low + high);
        if next == threshold {
            break;
        }
        threshold = next;
    }
    threshold
}

#[cfg(test)]
mod tests {
    use super::super::tests::side_view;
    use super::*;
    use rand::SeedableRng as _;

    #[test]
    fn the_threshold_lies_midway_between_the_clusters_means() {
        let counts = |levels: &[(usize, u32)]| {
            let mut counts = [0; 256];
            for &(level, count) in levels {
                counts[level] = count;
            }
            counts
        };
        assert_eq!(threshold(&counts(&[(10, 90), (110, 3)])), 60.0);
        // From 50 on: 0 and 10 have the mean 2.5, so that 40 is nearer to it than to 100.
        assert_eq!(threshold(&counts(&[(0, 6), (10, 2), (100, 2)])), 51.25);
        // From 50: (0 x 8 + 45 x 1) / 9 = 5, and 100; from 52.5 on nothing moves.
        assert_eq!(threshold(&counts(&[(0, 8), (45, 1), (100, 4)])), 52.5);
        // From 30 on 40 goes with 60: 3 and 55 give 29; then 30 goes with them: 0 and 50.
        assert_eq!(
            threshold(&counts(&[(0, 9), (30, 1), (40, 1), (60, 3)])),
            25.0
        );
        assert_eq!(threshold(&counts(&[(7, 3)])), 7.0);
    }

    #[test]
    fn little_strength_is_segmented_perfectly_and_much_loses_and_adds() {
        let (mut lost, mut added) = (0, 0);
        for seed in 0..40_u8 {
            let (fine, before, _) = side_view(usize::from(seed));
            for strength in [0.1, 0.25, 1.0] {
                let mut rng = ChaCha8Rng::seed_from_u64(seed.into());
                let mut picture = before.clone();
                Light::new(strength, &mut rng).segment(&mut picture, &fine, &mut rng);
                if strength < 1.0 {
                    assert_eq!(picture, before, "{seed}");
                    continue;
                }
                let (mut less, mut more) = (before.clone(), picture.clone());
                less.remove(&picture);
                more.remove(&before);
                lost += less.area();
                added += more.area();
            }
        }
        assert!(lost > 0 && added > 0, "{lost} {added}");
    }

    #[test]
    fn deviates_have_mean_0_and_deviation_1() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let draws: Vec<f64> = (0..20_000).map(|_| deviate(&mut rng).into()).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let square = draws.iter().map(|draw| draw * draw).sum::<f64>() / 20_000.0;
        assert!(
            mean.abs() < 0.03 && (square - 1.0).abs() < 0.03,
            "{mean} {square}"
        );
    }
}

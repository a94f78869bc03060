//! Light and contrast: a difference image, and the segmentation of Charalambous & Bharath.
//!
//! The segmentation subtracts the background and splits the grey differences into two clusters
//! by k-means (BMVC 2016, section 3.3; k = 2 and the initial values, least and greatest, are
//! ours). The difference image is ours: a grey level for the figure, lower in patches that stay
//! on the body, noise of the width of a pixel, and a scene that is lighter towards one side.

use super::fine::Fine;
use super::phases::{FINE, WINDOW, interleaved, merge, thirds};
use super::picture::BitPicture;
use crate::draw::grey_threshold::threshold;
use glam::DVec2;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// Contrast between figure and background in good light, grey levels of 255.
const CONTRAST: f32 = 110.0;
/// The share of the contrast that patches take at strength 1, for each unit of depth; at most all.
const PATCHED: f32 = 2.0;
/// Grey levels at strength 1: the standard deviation of noise, and the light added at a figure's
/// height from its middle.
const NOISE: f32 = 8.0;
const LIGHTER: f32 = 30.0;

/// The number of separate histograms, so that no count waits for the previous one.
const LANES: usize = 4;

/// The number of patch knots across and along the body.
const ACROSS: usize = 5;
const ALONG: usize = 9;

/// The light of a scene, and the contrast of a walker's clothes with the background.
#[derive(Clone, Debug)]
pub(crate) struct Light {
    strength: f32,
    /// Depths of the patches, 0 to 1, in rows from the head down.
    patches: [[f32; ACROSS]; ALONG],
    /// The direction towards the lighter side, to the right and down.
    side: DVec2,
}

impl Light {
    /// Samples patches and the lighter side. At strength 1, patches take all of the figure's
    /// contrast of 110 grey levels where they are at least half deep, noise has a standard
    /// deviation of 8 levels, and the scene is lighter by 30 levels at a figure's height from its
    /// middle. All are proportional to the strength. Up to 0.25, segmentation is perfect.
    #[must_use]
    pub(crate) fn new(strength: f64, rng: &mut ChaCha8Rng) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let strength = strength as f32;
        // Squares of uniform numbers, so that few places are deep.
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

    /// Segments the picture as a sensor with noise sees it. A sensor pixel is 3x3 samples.
    pub(crate) fn segment(&self, picture: &mut BitPicture, fine: &Fine, rng: &mut ChaCha8Rng) {
        let (rows, columns) = (picture.rows() / FINE, picture.columns().div_ceil(FINE));
        let noise = self.noise(rows, columns, rng);
        let figure = fine.figure();
        let along = |pixel: usize, axis: fn(DVec2) -> f64| {
            let at = (pixel as f64 + 0.5) * FINE as f64;
            let from_corner = at - axis(figure.corner);
            let from_middle = (from_corner - 0.5 * axis(figure.size)) / figure.size.y;
            (from_corner / axis(figure.size), from_middle)
        };
        // Values that are the same for all pixels of a column: knots and light.
        let across: Vec<(f64, f64)> = (0..columns).map(|at| along(at, |point| point.x)).collect();
        let lighter: Vec<f64> = across.iter().map(|(_, x)| self.side.x * x).collect();
        let knots = self.knots(across.iter().map(|&(share, _)| share));
        // Grey levels of pixels that show the background, and of those that show the figure.
        let mut levels = [vec![0; rows * columns], vec![0; rows * columns]];
        // The pixels of the figure.
        let (figure_rows, figure_columns) = picture.bounds().map_or((0..0, 0..0), |bounds| {
            (
                bounds.top / FINE..bounds.bottom.div_ceil(FINE),
                bounds.left / FINE..bounds.right.div_ceil(FINE),
            )
        });
        let [background, shown] = &mut levels;
        let mut lit = vec![0.0; columns];
        let each = background
            .chunks_exact_mut(columns)
            .zip(shown.chunks_exact_mut(columns));
        for (row, ((background, shown), noise)) in each.zip(noise.chunks_exact(columns)).enumerate()
        {
            let (share, from_middle) = along(row, |point| point.y);
            let (knot, down) = between(share, ALONG);
            let [from, to] = [&knots[knot], &knots[knot + 1]];
            let y = self.side.y * from_middle;
            for ((lit, noise), x) in lit.iter_mut().zip(noise).zip(&lighter) {
                #[expect(clippy::cast_possible_truncation, reason = "grey levels")]
                let lighter = (x + y).clamp(0.0, 1.5) as f32;
                *lit = noise + self.strength * LIGHTER * lighter;
            }
            for (lit, background) in lit.iter().zip(background) {
                *background = grey(*lit);
            }
            if !figure_rows.contains(&row) {
                continue;
            }
            let part = figure_columns.clone();
            let knots = from[part.clone()].iter().zip(&to[part.clone()]);
            let each = lit[part.clone()].iter().zip(knots);
            for ((lit, (from, to)), shown) in each.zip(&mut shown[part]) {
                let patch = from + (to - from) * down;
                let contrast = CONTRAST * (1.0 - self.strength * PATCHED * patch).max(0.0);
                *shown = grey(lit + contrast);
            }
        }
        let counts = counts(&levels, columns, picture, &figure_rows);
        // Levels are whole numbers, so the threshold's whole part is enough.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 255"
        )]
        let threshold = threshold(&counts) as u8;
        let mut found = [
            BitPicture::empty(1, picture.columns() / 64),
            BitPicture::empty(1, picture.columns() / 64),
        ];
        for row in 0..rows {
            for (found, levels) in found.iter_mut().zip(&levels) {
                let found = found.row_mut(0);
                found.fill(0);
                let levels = &levels[row * columns..][..columns];
                for (number, levels) in levels.chunks(WINDOW).enumerate() {
                    let above = above(levels, threshold);
                    let offset = (FINE * WINDOW * number).cast_signed();
                    merge(found, interleaved([above; FINE]), offset);
                }
            }
            let [background, figure] = &found;
            for row in FINE * row..FINE * (row + 1) {
                let found = background.row(0).iter().zip(figure.row(0));
                for (word, (background, figure)) in picture.row_mut(row).iter_mut().zip(found) {
                    *word = (*word & figure) | (!*word & background);
                }
            }
        }
    }

    /// Interpolates the depths of patches linearly at places across the body, in shares of its
    /// width; returns one row for each row of knots.
    fn knots(&self, places: impl Iterator<Item = f64> + Clone) -> [Vec<f32>; ALONG] {
        self.patches.each_ref().map(|knots| {
            let depth = |share| {
                let (knot, right) = between(share, ACROSS);
                let (from, to) = (knots[knot], knots[knot + 1]);
                from + (to - from) * right
            };
            places.clone().map(depth).collect()
        })
    }

    /// Samples the noise of every pixel: means of 3x3 random numbers.
    fn noise(&self, rows: usize, columns: usize, rng: &mut ChaCha8Rng) -> Vec<f32> {
        // A mean of nine numbers has a third of their deviation.
        let scale = 3.0 * NOISE * self.strength / 9.0;
        let wide = columns + 2;
        let bits: Vec<u64> = (0..wide * (rows + 2)).map(|_| rng.random()).collect();
        let draws: Vec<f32> = bits.iter().map(|&bits| deviate(bits)).collect();
        let (mut means, mut sums) = (Vec::with_capacity(rows * columns), vec![0.0; wide]);
        for row in 0..rows {
            let draws = |down: usize| draws[(row + down) * wide..][..wide].iter();
            let draws = draws(0).zip(draws(1)).zip(draws(2));
            for (sum, ((above, draw), below)) in sums.iter_mut().zip(draws) {
                *sum = above + draw + below;
            }
            let three = sums.iter().zip(&sums[1..]).zip(&sums[2..]);
            means.extend(three.map(|((left, sum), right)| scale * (left + sum + right)));
        }
        means
    }
}

/// Returns the knot before a share of the way along `knots` knots, and the share of the way from
/// this knot to the next.
fn between(share: f64, knots: usize) -> (usize, f32) {
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
}

/// Returns a number of mean 0 and deviation 1 from 64 random bits: the sum of four uniform numbers
/// (Irwin 1927, Hall 1927) of 16 bits each.
fn deviate(bits: u64) -> f32 {
    // Two sums of two numbers, then their sum: 18 bits.
    let pairs = (bits & 0xffff_0000_ffff) + (bits >> 16 & 0xffff_0000_ffff);
    let sum = ((pairs + (pairs >> 32)) & 0x3_ffff) as i32;
    #[expect(clippy::cast_precision_loss, reason = "18 bits")]
    let sum = sum as f32;
    // The sum of four uniform numbers has a variance of a third.
    (sum / 65_536.0 - 2.0) * 1.732_050_8
}

/// Returns a difference as one of a sensor's 256 levels, rounded half up.
fn grey(difference: f32) -> u8 {
    // Adding 2^23 leaves the nearest whole number in the lowest bits. Unlike Rust's conversions,
    // this vectorises.
    const SHIFT: f32 = 8_388_608.0;
    let level = (difference.abs() + 0.5).min(255.0);
    let nearest = level + SHIFT;
    let excess = u32::from(nearest - SHIFT > level);
    #[expect(clippy::cast_possible_truncation, reason = "0 to 255")]
    let level = (nearest.to_bits() - excess) as u8;
    level
}

/// Returns one bit for each of at most 64 levels: whether the level is above a threshold.
fn above(levels: &[u8], threshold: u8) -> u64 {
    const ONES: u64 = 0x0101_0101_0101_0101;
    let (low, is_high) = (threshold & 0x7f, threshold > 0x7f);
    // Eight levels at a time: the eighth bit of the sum states whether the lower seven bits are
    // above those of the threshold.
    let above = |eight: u64| {
        let low = (eight & (0x7f * ONES)) + u64::from(0x7f - low) * ONES;
        let above = if is_high { eight & low } else { eight | low };
        // Gathers one bit of each byte in the highest byte.
        (above >> 7 & ONES).wrapping_mul(0x0102_0408_1020_4080) >> 56
    };
    let (eights, rest) = levels.as_chunks::<8>();
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    let all = eights.iter().chain((!rest.is_empty()).then_some(&last));
    let all = all.map(|&eight| above(u64::from_le_bytes(eight)));
    all.zip(0..)
        .fold(0, |bits, (eight, at)| bits | eight << (8 * at))
}

/// Counts the samples of each grey level, nine a pixel: those of the figure have its level, the
/// others that of the background. `levels` are those of the background and of the figure.
fn counts(
    levels: &[Vec<u8>; 2],
    columns: usize,
    picture: &BitPicture,
    figure_rows: &Range<usize>,
) -> [u32; 256] {
    let mut counts = [0; 256];
    let mut nothing = [[0; 256]; LANES];
    let each = levels[0]
        .chunks_exact(columns)
        .zip(levels[1].chunks_exact(columns));
    for (row, (background, shown)) in each.enumerate() {
        let (fours, rest) = background.as_chunks::<LANES>();
        for levels in fours {
            for (counts, &level) in nothing.iter_mut().zip(levels) {
                counts[usize::from(level)] += 9;
            }
        }
        for (counts, &level) in nothing.iter_mut().zip(rest) {
            counts[usize::from(level)] += 9;
        }
        if figure_rows.contains(&row) {
            each_on(picture, row, |column, on| {
                counts[usize::from(shown[column])] += on;
                nothing[column % LANES][usize::from(background[column])] -= on;
            });
        }
    }
    for of in &nothing {
        for (count, of) in counts.iter_mut().zip(of) {
            *count += of;
        }
    }
    counts
}

/// Calls `act` with each pixel of a row that has samples on, and the number of these samples.
fn each_on(picture: &BitPicture, row: usize, mut act: impl FnMut(usize, u32)) {
    let [a, b, c] = [0, 1, 2].map(|down| picture.row(FINE * row + down));
    let rows = a.iter().zip(b).zip(c);
    let either: Vec<u64> = rows.clone().map(|((a, b), c)| a | b | c).collect();
    let all: Vec<u64> = rows.map(|((a, b), c)| a & b & c).collect();
    for first in (0..picture.columns().div_ceil(FINE)).step_by(WINDOW) {
        let from = |row: &[u64], across: usize| thirds(row, (FINE * first + across).cast_signed());
        let mut some = (0..FINE).fold(0, |some, across| some | from(&either, across));
        let whole = (0..FINE).fold(u64::MAX, |whole, across| whole & from(&all, across));
        while some != 0 {
            let bit = some.trailing_zeros();
            let pixel = first + bit as usize;
            let on = if whole >> bit & 1 == 1 {
                9
            } else {
                let rows = FINE * row..FINE * (row + 1);
                rows.map(|row| picture.count(row, FINE * pixel, FINE * (pixel + 1)))
                    .sum()
            };
            act(pixel, on);
            some &= some - 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::side_view;
    use super::*;
    use rand::SeedableRng as _;

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
        let draws: Vec<f64> = (0..20_000).map(|_| deviate(rng.random()).into()).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let square = draws.iter().map(|draw| draw * draw).sum::<f64>() / 20_000.0;
        assert!(
            mean.abs() < 0.03 && (square - 1.0).abs() < 0.03,
            "{mean} {square}"
        );
    }
}

//! Paints a synthetic video from silhouettes: a figure before a wall, with changing light and
//! noise.
//!
//! All constants are ours. Figures, light and noise resemble the videos with which segmentation was
//! measured: light from 0.95 to 1.1, soft shadows, and noise that grows with the signal.

use image::{Rgb, RgbImage};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// Shares of a figure's height at which hair and skin end and clothes change.
const BROW: f32 = 0.06;
const NECK: f32 = 0.15;
const WAIST: f32 = 0.5;

/// A synthetic video that is painted frame by frame.
pub(crate) struct Painted {
    columns: usize,
    /// The empty scene: red, green and blue of each pixel, 0..=255.
    empty: Vec<[f32; 3]>,
    /// Colours of hair, skin, upper and lower clothes.
    colours: [[f32; 3]; 4],
    /// Standard deviations of the noise in black and in white.
    noise: (f32, f32),
    /// Changes of the light: amplitude, and radians a frame.
    light: (f32, f32),
    normals: Normals,
    /// Number of frames so far.
    painted: usize,
}

impl Painted {
    /// Makes a video of this many columns and rows, without frames yet.
    pub(crate) fn new((columns, rows): (usize, usize), rng: &mut ChaCha8Rng) -> Self {
        let mut colour = |low: f32, high: f32| -> [f32; 3] {
            let grey = rng.random_range(low..high);
            [0, 1, 2].map(|_| (grey + rng.random_range(-18.0..18.0_f32)).clamp(0.0, 255.0))
        };
        let (wall, floor) = (colour(130.0, 200.0), colour(80.0, 130.0));
        // Clothes are darker than the background, sometimes by little.
        let upper = colour(25.0, 90.0);
        let lower = colour(15.0, 70.0);
        let (hair, skin) = (colour(20.0, 90.0), [205.0, 160.0, 135.0]);
        let waves: Vec<[f32; 4]> = (0..8)
            .map(|_| {
                [
                    rng.random_range(0.01..0.12),
                    rng.random_range(0.01..0.12),
                    rng.random_range(0.0..std::f32::consts::TAU),
                    rng.random_range(1.0..4.0),
                ]
            })
            .collect();
        let edge = 0.8 * rows as f32;
        let empty = (0..rows * columns).map(|at| {
            let (x, y) = ((at % columns) as f32, (at / columns) as f32);
            let base = if y < edge { wall } else { floor };
            let texture: f32 = waves
                .iter()
                .map(|[across, down, phase, by]| by * (across * x + down * y + phase).sin())
                .sum();
            base.map(|value| value + texture)
        });
        Self {
            columns,
            empty: empty.collect(),
            colours: [hair, skin, upper, lower],
            noise: (rng.random_range(1.5..3.0), rng.random_range(4.0..7.0)),
            light: (rng.random_range(0.02..0.07), rng.random_range(0.02..0.06)),
            normals: Normals::new(rng),
            painted: 0,
        }
    }

    /// Returns the scene without people and noise.
    pub(crate) fn empty(&self) -> RgbImage {
        self.picture(&self.empty)
    }

    /// Paints the next frame from a mask, row by row, whose figure has bytes of 128 and more.
    ///
    /// # Panics
    /// If the mask has another number of pixels.
    pub(crate) fn frame(&mut self, mask: &[u8]) -> RgbImage {
        assert_eq!(mask.len(), self.empty.len(), "the video's size");
        let seen = self.seen(mask);
        self.painted += 1;
        self.picture(&seen)
    }

    fn picture(&self, pixels: &[[f32; 3]]) -> RgbImage {
        let rows = pixels.len() / self.columns;
        let mut image = RgbImage::new(self.columns as u32, rows as u32);
        for (pixel, values) in image.pixels_mut().zip(pixels) {
            // Rounded and cut off at both ends by the conversion.
            *pixel = Rgb(values.map(|value| (value + 0.5) as u8));
        }
        image
    }

    /// Returns the camera's view: the figure over the empty scene, mixed at its rim, and its
    /// shadow.
    fn seen(&mut self, mask: &[u8]) -> Vec<[f32; 3]> {
        let columns = self.columns;
        let on: Vec<f32> = mask
            .iter()
            .map(|pixel| f32::from(u8::from(*pixel >= 128)))
            .collect();
        let share = softened(&softened(&on, columns), columns);
        let rows_of = |mut rows: std::iter::Enumerate<std::slice::Chunks<'_, f32>>| {
            rows.by_ref()
                .filter(|(_, row)| row.iter().any(|on| *on > 0.0))
                .fold(None, |span: Option<(usize, usize)>, (at, _)| {
                    Some((span.map_or(at, |span| span.0), at))
                })
        };
        let (top, bottom) = rows_of(on.chunks(columns).enumerate()).unwrap_or((0, 1));
        let height = (bottom + 1 - top) as f32;
        let feet = on[(bottom.saturating_sub(4)) * columns..(bottom + 1) * columns]
            .iter()
            .enumerate()
            .filter(|(_, on)| **on > 0.0)
            .fold((0.0, 0.0_f32), |(sum, count), (at, _)| {
                (sum + (at % columns) as f32, count + 1.0)
            });
        let feet = feet.0 / feet.1.max(1.0);
        let gain = 1.0 + self.light.0 * (self.light.1 * self.painted as f32).sin();
        let (empty, noise, normals) = (&self.empty, self.noise, &mut self.normals);
        let see = |at: usize| {
            let (x, y) = ((at % columns) as f32, (at / columns) as f32);
            // A soft elliptical shadow on the floor around the feet.
            let away = ((x - feet) / (0.28 * height)).powi(2)
                + ((y - bottom as f32) / (0.045 * height)).powi(2);
            let shade = 1.0 - 0.14 * (-away).exp();
            let along = (y - top as f32) / height;
            let below = [BROW, NECK, WAIST].into_iter().filter(|end| along >= *end);
            let colour = self.colours[below.count()];
            // Folds and roundness.
            let fold = 6.0 * (0.35 * x + 0.11 * y).sin();
            let alpha = share[at];
            std::array::from_fn(|of| {
                let light =
                    gain * (alpha * (colour[of] + fold) + (1.0 - alpha) * shade * empty[at][of]);
                let deviation =
                    noise.0 + (noise.1 - noise.0) * (light / 255.0).clamp(0.0, 1.0).sqrt();
                light + deviation * normals.next()
            })
        };
        (0..mask.len()).map(see).collect()
    }
}

/// Normal deviates from a table that is sampled once, since a video needs millions.
struct Normals {
    table: Vec<f32>,
    state: u64,
}

impl Normals {
    const COUNT: usize = 1 << 16;

    fn new(rng: &mut ChaCha8Rng) -> Self {
        let table = (0..Self::COUNT).map(|_| crate::people::cohort::normal(rng) as f32);
        Self {
            table: table.collect(),
            state: rng.random_range(1..u64::MAX),
        }
    }

    fn next(&mut self) -> f32 {
        // Xorshift (Marsaglia, "Xorshift RNGs", J. Stat. Softw. 8, 2003) chooses the entry.
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.table[(self.state >> 40) as usize % Self::COUNT]
    }
}

/// Returns the mean of each pixel and its neighbours; the middle counts twice along each axis.
pub(crate) fn softened(on: &[f32], columns: usize) -> Vec<f32> {
    let rows = on.len() / columns;
    let at = |row: usize, column: usize| on[row * columns + column];
    let across = |row: usize, column: usize| {
        0.25 * (at(row, column.saturating_sub(1))
            + 2.0 * at(row, column)
            + at(row, (column + 1).min(columns - 1)))
    };
    (0..on.len())
        .map(|place| {
            let (row, column) = (place / columns, place % columns);
            0.25 * (across(row.saturating_sub(1), column)
                + 2.0 * across(row, column)
                + across((row + 1).min(rows - 1), column))
        })
        .collect()
}

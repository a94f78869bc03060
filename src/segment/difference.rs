//! The difference between a frame and the empty scene, without changes of light and shadows, in
//! units of the noise.

use super::cie_lab::{Lab, Tables};
use super::slow_light::{median, remove_slow};
use image::RgbImage;
use libm::logf;

/// Stride of the pixels, row by row, of which medians are taken: a prime, so that they come from
/// all columns. Our choice.
const STRIDE: usize = 7;
/// Bytes of the background from which the light is estimated: lower ones are mostly noise, and
/// higher ones may be clipped. Our choice.
const TELLING: std::ops::RangeInclusive<u8> = 10..=245;
/// Limits of the change of light. Our choice: beyond them, it is another scene.
const GAIN: (f32, f32) = (0.25, 4.0);
/// The minimum noise, in LAB. Our choice: a third of a byte at middle grey, the noise of rounding.
const LEAST_NOISE: f32 = 0.2;
/// Median length of a vector with three components of standard deviation 1: the root of the median
/// of chi-squared with three degrees of freedom, 2.366.
const MEDIAN_LENGTH: f32 = 1.538;
/// Largest share by which a shadow reduces `L* + 16` and the chroma. Our choice, between shadows on
/// the floors of rendered videos (up to 0.25, rarely above 0.17) and a share at which clothes would
/// be ignored too. The remaining 0.8 is the cube root of 0.51 of the light.
const SHADOW: f32 = 0.2;
/// The share of the scene's pixels that are edges: those where lightness changes most. Our choice.
const EDGES: f64 = 0.05;
/// Grey levels for each factor of e of a difference. Our choice: 255 levels reach 587 times the
/// noise.
const LEVELS: f32 = 40.0;

/// The scene without people.
#[derive(Clone, Debug)]
pub(super) struct EmptyScene {
    tables: Tables,
    columns: u32,
    rows: u32,
    picture: RgbImage,
    lab: Vec<Lab>,
    /// The pixels at edges.
    edges: Vec<usize>,
}

/// The difference between a frame and the scene, row by row.
#[derive(Clone, Debug)]
pub(super) struct SceneDifference {
    /// Length of the difference in LAB, over the noise.
    pub raw: Vec<f32>,
    /// Difference without the part that a shadow explains, as grey levels: [`level`].
    pub levels: Vec<u8>,
    /// Noise in LAB: standard deviation of each of the three components after smoothing.
    pub noise: f32,
    /// The frame's light over the scene's, in red, green and blue.
    pub gain: [f32; 3],
    /// Median difference at the scene's edges, in LAB.
    pub at_edges: f32,
}

impl EmptyScene {
    pub(super) fn new(picture: RgbImage) -> Self {
        let tables = Tables::new();
        let lab = tables.picture(&picture);
        Self {
            columns: picture.width(),
            rows: picture.height(),
            edges: edges(&lab, picture.width() as usize),
            lab,
            picture,
            tables,
        }
    }

    /// Returns the picture of the scene.
    pub(super) const fn picture(&self) -> &RgbImage {
        &self.picture
    }

    /// Returns the columns and rows.
    pub(super) const fn size(&self) -> (u32, u32) {
        (self.columns, self.rows)
    }

    /// Compares a frame with the scene.
    ///
    /// # Panics
    /// If the frame has another size.
    pub(super) fn difference(&self, frame: &RgbImage) -> SceneDifference {
        assert_eq!(frame.dimensions(), self.size(), "the scene's size");
        let gain = self.gain(frame);
        let without = gain.map(|gain| 1.0 / gain);
        let empty = self.seen(without);
        let columns = self.columns as usize;
        let row = |at: usize| {
            let pixels = frame.as_raw()[3 * columns * at..].chunks_exact(3);
            let pixels = pixels.zip(&empty[columns * at..][..columns]);
            let away = pixels.map(|(pixel, Lab(empty))| {
                let Lab(found) = self.tables.lab([pixel[0], pixel[1], pixel[2]], without);
                std::array::from_fn(|part| found[part] - empty[part])
            });
            away.collect::<Vec<[f32; 3]>>()
        };
        let mut away = smoothed(self.rows as usize, row);
        remove_slow(&mut away, columns);
        let length = |of: &[f32; 3]| (of[0] * of[0] + of[1] * of[1] + of[2] * of[2]).sqrt();
        let mut raw: Vec<f32> = away.iter().map(length).collect();
        let some = raw.iter().step_by(STRIDE).copied();
        let noise = median(some.collect()).unwrap_or(0.0) / MEDIAN_LENGTH;
        let noise = noise.max(LEAST_NOISE);
        let pairs = away.iter().zip(&empty);
        let levels = pairs.map(|(away, Lab(empty))| level(lit(*away, *empty) / noise));
        let at_edges = self.edges.iter().map(|at| raw[*at]);
        let at_edges = median(at_edges.collect()).unwrap_or(0.0);
        for raw in &mut raw {
            *raw /= noise;
        }
        SceneDifference {
            at_edges,
            levels: levels.collect(),
            raw,
            noise,
            gain,
        }
    }

    /// Returns the colours of the scene as the sensor sees them under the frame's light, of which
    /// `without` is the inverse: brighter than white is clipped to white.
    fn seen(&self, without: [f32; 3]) -> Vec<Lab> {
        let pixels = self.picture.pixels().zip(&self.lab);
        let seen = pixels.map(|(pixel, lab)| {
            let light = pixel.0.map(|byte| self.tables.linear(byte));
            if light
                .iter()
                .zip(&without)
                .all(|(light, most)| light <= most)
            {
                return *lab;
            }
            self.tables
                .lab_of_light(std::array::from_fn(|of| light[of].min(without[of])))
        });
        seen.collect()
    }

    /// Returns the frame's light over the scene's in red, green and blue: the medians over the
    /// picture, of which the figure covers less than half.
    fn gain(&self, frame: &RgbImage) -> [f32; 3] {
        std::array::from_fn(|channel| {
            let pairs = frame.pixels().zip(self.picture.pixels()).step_by(STRIDE);
            let telling = pairs.filter(|(_, empty)| TELLING.contains(&empty.0[channel]));
            let ratios = telling.map(|(pixel, empty)| {
                let light = |byte| self.tables.linear(byte);
                light(pixel.0[channel]) / light(empty.0[channel])
            });
            let found = median(ratios.collect()).unwrap_or(1.0);
            found.clamp(GAIN.0, GAIN.1)
        })
    }
}

/// Returns the pixels at which lightness changes most to the right or below, of every
/// [`STRIDE`]th pixel.
fn edges(lab: &[Lab], columns: usize) -> Vec<usize> {
    let change = |at: usize| {
        let lightness = |at: usize| lab[at].0[0];
        let here = lightness(at);
        let is_last = (at + 1).is_multiple_of(columns);
        let right = if is_last { here } else { lightness(at + 1) };
        let below = { lab.get(at + columns) }.map_or(here, |Lab(below)| below[0]);
        (right - here).abs().max((below - here).abs())
    };
    let mut some: Vec<(f32, usize)> = { (0..lab.len()).step_by(STRIDE) }
        .map(|at| (change(at), at))
        .collect();
    some.sort_by(|a, b| b.0.total_cmp(&a.0));
    some.truncate((EDGES * some.len() as f64).ceil() as usize);
    some.into_iter().map(|(_, at)| at).collect()
}

/// Returns the length of a difference without the part that a shadow on the scene's colour
/// explains.
///
/// A shadow multiplies `L* + 16`, `a*` and `b*` by one number below 1 (the chromaticity line of
/// Horprasert, Harwood & Davis, ICCV FRAME-RATE 1999, in LAB).
fn lit(away: [f32; 3], empty: [f32; 3]) -> f32 {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // Lightness + 16 is at least 16, as f is at least 16 / 116, so this divides by no zero.
    let share = dot(away, empty) / dot(empty, empty);
    let forgiven = share.clamp(-SHADOW, 0.0);
    let left: [f32; 3] = std::array::from_fn(|part| away[part] - forgiven * empty[part]);
    dot(left, left).sqrt()
}

/// Returns the grey level of a difference over the noise: 40 for each factor of e of 1 plus it, so
/// that clothes of high and low contrast fall into one cluster.
pub(super) fn level(over_noise: f32) -> u8 {
    // Saturating.
    (LEVELS * logf(1.0 + over_noise) + 0.5) as u8
}

/// Returns the difference over the noise of a level.
pub(super) fn over_noise(level: f64) -> f64 {
    libm::exp(level / f64::from(LEVELS)) - 1.0
}

/// Returns binomial means over three by three pixels of these rows; the edges are repeated.
fn smoothed(rows: usize, row: impl Fn(usize) -> Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    let mean = |before: [f32; 3], here: [f32; 3], after: [f32; 3]| {
        std::array::from_fn(|part| 0.25 * (before[part] + after[part]) + 0.5 * here[part])
    };
    let across = |at: usize| -> Vec<[f32; 3]> {
        let row = row(at);
        let at = |column: usize| row[column.min(row.len() - 1)];
        { 0..row.len() }
            .map(|column| mean(at(column.saturating_sub(1)), at(column), at(column + 1)))
            .collect()
    };
    let mut here = across(0);
    let mut above = here.clone();
    let mut both = Vec::with_capacity(rows * here.len());
    for at in 0..rows {
        let below = if at + 1 < rows {
            across(at + 1)
        } else {
            here.clone()
        };
        let rows = above.iter().zip(&here).zip(&below);
        both.extend(rows.map(|((above, here), below)| mean(*above, *here, *below)));
        above = std::mem::replace(&mut here, below);
    }
    both
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    fn picture(of: impl Fn(u32, u32) -> [u8; 3]) -> RgbImage {
        RgbImage::from_fn(40, 30, |x, y| Rgb(of(x, y)))
    }

    #[test]
    fn light_and_tint_are_found_and_taken_out() {
        let scene = EmptyScene::new(picture(|x, y| [60 + 4 * x as u8, 90 + 3 * y as u8, 120]));
        // Linear light times 1.1, 1.0 and 0.9, rounded to bytes.
        let brighter = |byte: u8, gain: f64| {
            let light = f64::from(scene.tables.linear(byte)) * gain;
            let value = 1.055 * light.powf(1.0 / 2.4) - 0.055;
            (255.0 * value).round() as u8
        };
        let frame = picture(|x, y| {
            let Rgb([r, g, b]) = *scene.picture.get_pixel(x, y);
            [brighter(r, 1.1), brighter(g, 1.0), brighter(b, 0.9)]
        });
        let found = scene.difference(&frame);
        for (gain, expected) in found.gain.into_iter().zip([1.1, 1.0, 0.9]) {
            assert!((gain - expected).abs() < 0.01, "{:?}", found.gain);
        }
        assert_eq!(found.noise, LEAST_NOISE);
        let most = found.raw.iter().copied().fold(0.0, f32::max) * found.noise;
        assert!(most < 0.6, "{most}");
    }

    #[test]
    fn what_the_sensor_cuts_off_under_more_light_is_no_difference() {
        // A quarter of the scene is a red that is clipped under more light; all of it gets 1.2
        // times the light.
        let colour = |x: u32, red: f64, other: f64| {
            let byte =
                |light: f64| (255.0 * (1.055 * light.min(1.0).powf(1.0 / 2.4) - 0.055)).round();
            let (red, other) = (byte(red) as u8, byte(other) as u8);
            if x < 10 {
                [red, other, other]
            } else {
                [other; 3]
            }
        };
        let scene = EmptyScene::new(picture(|x, _| colour(x, 0.95, 0.2)));
        let found = scene.difference(&picture(|x, _| colour(x, 1.14, 0.24)));
        let most = found.raw.iter().copied().fold(0.0, f32::max) * found.noise;
        assert!(most < 0.6, "{most}");
    }

    #[test]
    fn a_shadow_is_forgiven_and_a_dark_cloth_of_another_colour_is_not() {
        // 0.512 of the light multiplies all three components of the floor by 0.8.
        let floor = [70.0, 6.0, 12.0];
        let shadow = [-14.0, -1.2, -2.4];
        assert!(lit(shadow, floor) < 1e-4);
        // Half of twice the darkening remains.
        let darker = [-28.0, -2.4, -4.8];
        assert!(
            (lit(darker, floor) - 14.255_5).abs() < 1e-3,
            "{}",
            lit(darker, floor)
        );
        // Brightening is not ignored, nor is a change of chroma.
        assert!((lit([14.0, 1.2, 2.4], floor) - 14.255_5).abs() < 1e-3);
        let blue = lit([-14.0, -1.2, -32.4], floor);
        assert!(blue > 28.0, "{blue}");
    }

    #[test]
    fn levels_are_40_for_each_factor_of_e() {
        // ln 1 = 0, ln 2 = 0.6931, ln e^3 = 3; 255 is the last.
        assert_eq!([level(0.0), level(1.0), level(19.085_5)], [0, 28, 120]);
        assert_eq!(
            [level(1e9), level(f32::INFINITY), level(f32::NAN)],
            [255, 255, 0]
        );
        assert!((over_noise(120.0) - 19.085_5).abs() < 1e-3);
    }

    #[test]
    fn smoothing_is_binomial_and_keeps_what_is_even() {
        let even = vec![[3.0, -1.0, 2.0]; 12];
        let of = |pixels: &[[f32; 3]], columns: usize| {
            let row = |at: usize| pixels[at * columns..][..columns].to_vec();
            smoothed(pixels.len() / columns, row)
        };
        assert_eq!(of(&even, 4), even);
        let mut point = vec![[0.0; 3]; 25];
        point[12] = [16.0; 3];
        let found = of(&point, 5);
        let row = |at: usize| -> Vec<f32> { (0..5).map(|x| found[at * 5 + x][0]).collect() };
        assert_eq!(row(1), [0.0, 1.0, 2.0, 1.0, 0.0]);
        assert_eq!(row(2), [0.0, 2.0, 4.0, 2.0, 0.0]);
        assert_eq!(row(4), [0.0; 5]);
    }

    #[test]
    fn noise_is_its_deviation_whatever_the_figure() {
        // A quarter that differs by much does not change medians.
        let scene = EmptyScene::new(picture(|_, _| [128; 3]));
        let frame = picture(|x, _| if x < 10 { [250, 20, 20] } else { [128; 3] });
        let found = scene.difference(&frame);
        assert_eq!((found.noise, found.gain), (LEAST_NOISE, [1.0; 3]));
    }
}

//! CIE LAB colours from tables.
//!
//! Bytes are sRGB (IEC 61966-2-1), and white is D65 for 2 degrees (CIE 15:2004, 8.2.1). Lightness
//! is stored as `L* + 16`, 16 to 116. Except for the darkest colours, all three components are then
//! proportional to the cube root of the light, so a gain of the light or a shadow multiplies them
//! by one number.

use image::RgbImage;
use libm::{cbrt, pow};

/// Matrix from sRGB to XYZ, for linear light 0 to 1 (IEC 61966-2-1, inverse of the matrix in its
/// annex).
const XYZ: [[f32; 3]; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.019_333_9, 0.119_192, 0.950_304_1],
];
/// Steps of the cube root's table for each unit. Our choice: errors are below 0.003 in LAB.
const STEPS: usize = 4096;
/// The brightest light in the table, relative to white: frames are divided by a gain, which may be
/// below 1.
const MOST: usize = 2;

/// A colour: `L* + 16`, `a*` and `b*`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lab(pub [f32; 3]);

/// The tables for the conversion of colours.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    /// Light of each byte, 0 to 1.
    linear: [f32; 256],
    /// CIE 15's f at each step.
    root: Vec<f32>,
    /// [`XYZ`], scaled so that white is 1, 1, 1.
    xyz: [[f32; 3]; 3],
}

impl Tables {
    pub(super) fn new() -> Self {
        let linear = std::array::from_fn(|byte| {
            let value = byte as f64 / 255.0;
            let light = if value <= 0.040_45 {
                value / 12.92
            } else {
                pow((value + 0.055) / 1.055, 2.4)
            };
            narrow(light)
        });
        let f = |step: usize| {
            let share = step as f64 / STEPS as f64;
            let delta = 6.0 / 29.0;
            let root = if share > delta * delta * delta {
                cbrt(share)
            } else {
                share / (3.0 * delta * delta) + 4.0 / 29.0
            };
            narrow(root)
        };
        Self {
            linear,
            root: (0..=MOST * STEPS + 1).map(f).collect(),
            // White has red, green and blue of 1.
            xyz: XYZ.map(|row| row.map(|of| of / (row[0] + row[1] + row[2]))),
        }
    }

    /// Returns the light of a byte, 0 to 1.
    pub(super) fn linear(&self, byte: u8) -> f32 {
        self.linear[usize::from(byte)]
    }

    /// Returns a colour with its red, green and blue light multiplied by these factors.
    pub(super) fn lab(&self, rgb: [u8; 3], by: [f32; 3]) -> Lab {
        self.lab_of_light(std::array::from_fn(|of| self.linear(rgb[of]) * by[of]))
    }

    /// Returns the colour of red, green and blue light, 0 to 1.
    pub(super) fn lab_of_light(&self, light: [f32; 3]) -> Lab {
        let [x, y, z] = self
            .xyz
            .map(|row| self.root(row[0] * light[0] + row[1] * light[1] + row[2] * light[2]));
        Lab([116.0 * y, 500.0 * (x - y), 200.0 * (y - z)])
    }

    /// Returns all colours of a picture.
    pub(super) fn picture(&self, picture: &RgbImage) -> Vec<Lab> {
        let pixels = picture.pixels();
        pixels.map(|pixel| self.lab(pixel.0, [1.0; 3])).collect()
    }

    /// Returns CIE 15's f, interpolated linearly between steps.
    fn root(&self, share: f32) -> f32 {
        let place = (share * STEPS as f32).clamp(0.0, (MOST * STEPS) as f32);
        let step = place as usize;
        let (from, to) = (self.root[step], self.root[step + 1]);
        from + (to - from) * (place - step as f32)
    }
}

/// Rounds to the nearest `f32`.
fn narrow(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns `L*`, `a*` and `b*` from the definitions, in f64 and without tables.
    fn slow(rgb: [u8; 3]) -> [f64; 3] {
        let linear = rgb.map(|byte| {
            let value = f64::from(byte) / 255.0;
            if value <= 0.040_45 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        });
        let row = |r: f64, g: f64, b: f64| r * linear[0] + g * linear[1] + b * linear[2];
        let x = row(0.412_456_4, 0.357_576_1, 0.180_437_5) / 0.950_47;
        let y = row(0.212_672_9, 0.715_152_2, 0.072_175_0);
        let z = row(0.019_333_9, 0.119_192_0, 0.950_304_1) / 1.088_83;
        let f = |t: f64| {
            // CIE 15: (24/116)^3, 841/108 and 16/116.
            if t > (24.0_f64 / 116.0).powi(3) {
                t.cbrt()
            } else {
                841.0 / 108.0 * t + 16.0 / 116.0
            }
        };
        [
            116.0 * f(y) - 16.0,
            500.0 * (f(x) - f(y)),
            200.0 * (f(y) - f(z)),
        ]
    }

    #[test]
    fn colours_have_their_published_values() {
        // sRGB's corners and middle grey, D65 and 2 degrees, as rounded by Bruce Lindbloom's
        // calculator (brucelindbloom.com) and the CSS Color 4 drafts.
        let tables = Tables::new();
        for (rgb, expected) in [
            ([255, 255, 255], [100.0, 0.0, 0.0]),
            ([0, 0, 0], [0.0, 0.0, 0.0]),
            ([255, 0, 0], [53.24, 80.09, 67.20]),
            ([0, 255, 0], [87.73, -86.18, 83.18]),
            ([0, 0, 255], [32.30, 79.19, -107.86]),
            ([255, 255, 0], [97.14, -21.55, 94.48]),
            ([0, 255, 255], [91.11, -48.09, -14.13]),
            ([255, 0, 255], [60.32, 98.23, -60.82]),
            ([128, 128, 128], [53.59, 0.0, 0.0]),
        ] {
            let Lab([lightness, a, b]) = tables.lab(rgb, [1.0; 3]);
            let found = [lightness - 16.0, a, b];
            let slow = slow(rgb);
            for at in 0..3 {
                let near = |value: f64, to: f64| (value - to).abs() < 0.02;
                assert!(
                    near(f64::from(found[at]), expected[at]),
                    "{rgb:?}: {found:?}"
                );
                assert!(near(slow[at], expected[at]), "{rgb:?}: {slow:?}");
            }
        }
    }

    #[test]
    fn tables_differ_by_less_than_a_hundredth_from_the_definitions() {
        let tables = Tables::new();
        for red in (0..=255).step_by(15) {
            for green in (0..=255).step_by(15) {
                for blue in 0..=255 {
                    let rgb = [red, green, blue];
                    let Lab(found) = tables.lab(rgb, [1.0; 3]);
                    let [lightness, a, b] = slow(rgb);
                    for (found, slow) in found.into_iter().zip([lightness + 16.0, a, b]) {
                        assert!((f64::from(found) - slow).abs() < 0.01, "{rgb:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn half_the_light_multiplies_all_three_by_the_cube_root_of_a_half() {
        let tables = Tables::new();
        let Lab(full) = tables.lab([200, 120, 90], [1.0; 3]);
        let Lab(half) = tables.lab([200, 120, 90], [0.5; 3]);
        for (full, half) in full.into_iter().zip(half) {
            assert!((half - 0.793_700_5 * full).abs() < 0.01);
        }
    }
}

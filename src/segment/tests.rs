//! Tests with a synthetic video whose silhouettes are known.

use super::*;
use image::Rgb;

/// Columns and rows of a video of a disc that moves over a gradient, with noise of a few bytes.
const SIZE: (u32, u32) = (160, 120);
const RADIUS: i64 = 20;

/// The linear congruential generator of Numerical Recipes.
struct Noise(u32);

impl Noise {
    /// Adds roughly normal noise of deviation 2, the sum of four uniform deviates of deviation 1.
    fn byte(&mut self, value: f64) -> u8 {
        let mut sum = 0.0;
        for _ in 0..4 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += f64::from(self.0 >> 8) / f64::from(1 << 24) - 0.5;
        }
        // A uniform number from 0 to 1 has a variance of 1/12.
        (value + sum * 2.0 * 3.0_f64.sqrt() + 0.5) as u8
    }
}

fn wall(x: u32, y: u32) -> [f64; 3] {
    let (x, y) = (f64::from(x), f64::from(y));
    [90.0 + 0.5 * x, 110.0 + 0.4 * y, 100.0 + 0.2 * x]
}

fn is_on(at: i64, x: u32, y: u32) -> bool {
    let (dx, dy) = (i64::from(x) - at, i64::from(y) - 60);
    dx * dx + dy * dy <= RADIUS * RADIUS
}

/// Returns a frame with the disc's centre at a column, under light `gain` times as strong.
fn frame(at: i64, gain: f64, noise: &mut Noise) -> RgbImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let colour = if is_on(at, x, y) {
            [170.0, 60.0, 50.0]
        } else {
            wall(x, y)
        };
        // Bytes are roughly light to the power of 1 / 2.4.
        Rgb(colour.map(|value| noise.byte(value * gain.powf(1.0 / 2.4))))
    })
}

fn jaccard(mask: &Mask, at: i64) -> f64 {
    let (mut both, mut either) = (0, 0);
    for (pixel, on) in mask.pixels().iter().enumerate() {
        let (x, y) = (pixel as u32 % SIZE.0, pixel as u32 / SIZE.0);
        let truth = is_on(at, x, y);
        both += u32::from(*on && truth);
        either += u32::from(*on || truth);
    }
    f64::from(both) / f64::from(either)
}

#[test]
fn a_disc_is_found_under_any_light_with_a_given_or_a_median_background() {
    let mut noise = Noise(1);
    let places: Vec<i64> = (0..24).map(|at| 22 + 5 * at).collect();
    let frames: Vec<RgbImage> = places
        .iter()
        .zip(0..)
        .map(|(at, number)| frame(*at, 0.95 + 0.007 * f64::from(number), &mut noise))
        .collect();
    let empty = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        Rgb(wall(x, y).map(|value| value as u8))
    });
    for background in [empty.clone(), median(&frames).unwrap()] {
        let segmenter = Segmenter::new(background, SegmentSettings::default());
        for (frame, at) in frames.iter().zip(&places) {
            let found = segmenter.segment(frame);
            assert!(
                jaccard(&found.mask, *at) > 0.97,
                "{at}: {}",
                jaccard(&found.mask, *at)
            );
        }
    }
    let segmenter = Segmenter::new(empty.clone(), SegmentSettings::default());
    // The light of the last frame is 1.111 times as strong.
    let last = segmenter.segment(&frames[23]);
    assert!(
        last.gain.iter().all(|gain| (gain - 1.111).abs() < 0.03),
        "{:?}",
        last.gain
    );
    // The empty scene, with noise and without.
    assert_eq!(
        segmenter.segment(&frame(-100, 1.0, &mut noise)).mask.area(),
        0
    );
    assert_eq!(segmenter.segment(&empty).mask.area(), 0);
}

#[test]
fn a_shadow_beside_the_disc_is_not_its_part() {
    let mut noise = Noise(2);
    let empty = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        Rgb(wall(x, y).map(|value| value as u8))
    });
    let mut frame = frame(60, 1.0, &mut noise);
    // 0.7 of the light, on the right of the disc.
    for (x, y) in (82..110).flat_map(|x| (50..70).map(move |y| (x, y))) {
        let dark = wall(x, y).map(|value| noise.byte(value * 0.7_f64.powf(1.0 / 2.4)));
        frame.put_pixel(x, y, Rgb(dark));
    }
    let found = Segmenter::new(empty, SegmentSettings::default()).segment(&frame);
    assert!(
        jaccard(&found.mask, 60) > 0.96,
        "{}",
        jaccard(&found.mask, 60)
    );
}

#[test]
fn settings_keep_all_parts_and_close_or_leave_gaps() {
    let grey = RgbImage::from_pixel(120, 80, Rgb([128; 3]));
    let mut frame = grey.clone();
    let mut fill = |columns: std::ops::Range<u32>| {
        for (x, y) in columns.flat_map(|x| (20..60).map(move |y| (x, y))) {
            frame.put_pixel(x, y, Rgb([30, 30, 180]));
        }
    };
    fill(20..50);
    fill(80..90);
    let area = |largest_part, closing_px| {
        let settings = SegmentSettings {
            largest_part,
            closing_px,
        };
        Segmenter::new(grey.clone(), settings)
            .segment(&frame)
            .mask
            .area()
    };
    assert_eq!([area(true, 1), area(false, 1)], [30 * 40, 40 * 40]);
    // A square of 31 by 31 pixels fills the gap between the two.
    assert_eq!(area(false, 15), 70 * 40);
}

#[test]
fn pictures_of_any_size_and_colour_are_taken() {
    for size in [(1, 1), (2, 1), (1, 9), (3, 3)] {
        for byte in [0, 255] {
            let background = RgbImage::from_pixel(size.0, size.1, Rgb([byte; 3]));
            let segmenter = Segmenter::new(background.clone(), SegmentSettings::default());
            assert_eq!(segmenter.segment(&background).mask.area(), 0);
            let other = RgbImage::from_pixel(size.0, size.1, Rgb([255 - byte, byte, 0]));
            let found = segmenter.segment(&other);
            assert!(found.threshold.is_finite() && found.noise.is_finite());
        }
    }
}

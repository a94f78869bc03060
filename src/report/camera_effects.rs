//! Effects of the image stage on a camera's picture, for viewing.

use image::{Rgb, RgbImage, imageops};

/// Middle of the range of a pixel's bytes.
const MIDDLE: f64 = 127.5;

/// Returns a picture with coarser pixels: each cell of `cell_px` by `cell_px`, from the upper left
/// corner, has the mean colour of its pixels. Cells of at most one pixel change nothing.
#[must_use]
pub(super) fn pixelated(picture: &RgbImage, cell_px: f64) -> RgbImage {
    if cell_px <= 1.0 {
        return picture.clone();
    }
    // Rounded down; saturating.
    let cell = |pixel: u32| ((f64::from(pixel) + 0.5) / cell_px) as usize;
    let columns = cell(picture.width()) + 1;
    let mut sums = vec![[0.0; 4]; columns * (cell(picture.height()) + 1)];
    for (x, y, pixel) in picture.enumerate_pixels() {
        let sum = &mut sums[cell(y) * columns + cell(x)];
        for (part, value) in sum.iter_mut().zip(pixel.0) {
            *part += f64::from(value);
        }
        sum[3] += 1.0;
    }
    let (width, height) = picture.dimensions();
    RgbImage::from_fn(width, height, |x, y| {
        let [red, green, blue, pixels] = sums[cell(y) * columns + cell(x)];
        Rgb([red, green, blue].map(|sum| byte(sum / pixels)))
    })
}

/// Returns a picture with `contrast` times the distance from middle grey, and then `light` times
/// the brightness; 1 changes nothing.
#[must_use]
pub(super) fn faded(picture: &RgbImage, light: f64, contrast: f64) -> RgbImage {
    let mut faded = picture.clone();
    for value in faded.iter_mut() {
        *value = byte(light * (MIDDLE + contrast * (f64::from(*value) - MIDDLE)));
    }
    faded
}

/// Returns the mean of pictures of one size, like an exposure over all of them; none without
/// pictures.
///
/// # Panics
/// If their sizes differ.
#[must_use]
pub(super) fn mean(pictures: &[RgbImage]) -> Option<RgbImage> {
    let first = pictures.first()?;
    let mut sums = vec![0.0; first.len()];
    for picture in pictures {
        assert_eq!(picture.dimensions(), first.dimensions(), "one size");
        for (sum, value) in sums.iter_mut().zip(picture.iter()) {
            *sum += f64::from(*value);
        }
    }
    let count = pictures.len() as f64;
    let bytes = sums.into_iter().map(|sum| byte(sum / count)).collect();
    RgbImage::from_raw(first.width(), first.height(), bytes)
}

/// Returns a warped picture: `source` maps a place of the new picture to one of the old, both
/// `[x, y]` in pixels from the upper left corner, with pixel centres at halves. Interpolates
/// bilinearly; outside, the edge continues.
#[must_use]
pub(super) fn warped(picture: &RgbImage, source: impl Fn([f64; 2]) -> [f64; 2]) -> RgbImage {
    let (width, height) = picture.dimensions();
    RgbImage::from_fn(width, height, |x, y| {
        let [from_x, from_y] = source([f64::from(x) + 0.5, f64::from(y) + 0.5]);
        let within = |place: f64, pixels: u32| {
            let last = f64::from(pixels.saturating_sub(1));
            // NaN becomes 0.
            (place - 0.5).max(0.0).min(last) as f32
        };
        let at = (within(from_x, width), within(from_y, height));
        imageops::interpolate_bilinear(picture, at.0, at.1).unwrap_or(Rgb([0; 3]))
    })
}

/// Rounds to a byte, saturating.
fn byte(value: f64) -> u8 {
    (value + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a picture with one row of greys.
    fn row(greys: &[u8]) -> RgbImage {
        RgbImage::from_fn(greys.len() as u32, 1, |x, _| Rgb([greys[x as usize]; 3]))
    }

    #[test]
    fn cells_have_the_mean_of_their_pixels() {
        let coarse = pixelated(&row(&[10, 20, 30, 50, 7]), 2.0);
        assert_eq!(coarse, row(&[15, 15, 40, 40, 7]));
        // Cells of one and a half pixels: centres at 0.5, 1.5, 2.5 fall into cells 0, 1, 1.
        assert_eq!(pixelated(&row(&[0, 10, 20]), 1.5), row(&[0, 15, 15]));
        assert_eq!(pixelated(&row(&[3, 4]), 1.0), row(&[3, 4]));
    }

    #[test]
    fn contrast_is_about_middle_grey_and_light_is_a_factor() {
        let picture = row(&[0, 100, 255]);
        assert_eq!(faded(&picture, 1.0, 1.0), picture);
        assert_eq!(faded(&picture, 1.0, 0.0), row(&[128; 3]));
        assert_eq!(faded(&picture, 0.5, 1.0), row(&[0, 50, 128]));
        assert_eq!(faded(&picture, 2.0, 1.0), row(&[0, 200, 255]));
    }

    #[test]
    fn an_exposure_is_the_mean_of_its_moments() {
        let moments = [row(&[0, 255]), row(&[10, 255]), row(&[20, 0])];
        assert_eq!(mean(&moments), Some(row(&[10, 170])));
        assert_eq!(mean(&[]), None);
    }

    #[test]
    fn a_warp_fetches_pixels_and_blends_them() {
        let picture = row(&[0, 100, 200]);
        assert_eq!(warped(&picture, |at| at), picture);
        assert_eq!(
            warped(&picture, |[x, y]| [x + 0.5, y]),
            row(&[50, 150, 200])
        );
        assert_eq!(warped(&picture, |[x, y]| [3.0 - x, y]), row(&[200, 100, 0]));
    }
}

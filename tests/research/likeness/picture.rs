//! Images of mean templates and their differences.

use edgegait_core::silhouette::Size;
use image::{GrayImage, Luma};
use std::path::Path;

/// The size of a template's pixel in the image.
const ZOOM: u32 = 8;
/// The factor by which differences are enlarged.
const GAIN: f64 = 2.0;

/// Returns the difference of two templates as an image: middle grey for none, white where the first
/// has more.
pub fn difference(first: &[f64], second: &[f64]) -> Vec<f64> {
    let pairs = first.iter().zip(second);
    pairs
        .map(|(a, b)| (0.5 + GAIN * 0.5 * (a - b)).clamp(0.0, 1.0))
        .collect()
}

/// Writes templates with pixels in 0..1 side by side, one list per row.
pub fn write(path: &Path, rows: &[Vec<Vec<f64>>]) {
    let (height, width) = (
        Size::S50x30.rows() as u32 + 1,
        Size::S50x30.columns() as u32 + 1,
    );
    let columns = rows.iter().map(Vec::len).max().expect("a row") as u32;
    let mut picture = GrayImage::new(columns * width * ZOOM, rows.len() as u32 * height * ZOOM);
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        let (x, y) = (x / ZOOM, y / ZOOM);
        let (column, row) = ((x / width) as usize, (y / height) as usize);
        let at = (x % width) + (y % height) * (width - 1);
        let is_line = x % width == width - 1 || y % height == height - 1;
        let template = rows[row].get(column).filter(|_| !is_line);
        let value = template.map_or(0.0, |template| template[at as usize]);
        *pixel = Luma([(255.0 * value).round() as u8]);
    }
    picture.save(path).expect("a picture");
}

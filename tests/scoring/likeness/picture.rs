//! Pictures of mean templates and of where they differ.

use edgegait_core::silhouette::Size;
use image::{GrayImage, Luma};
use std::path::Path;

/// Screen pixels of a pixel.
const ZOOM: u32 = 8;
/// How much a difference is enlarged.
const GAIN: f64 = 2.0;

/// The difference of two templates as one: middle grey is none, white more in the first.
pub fn difference(first: &[f64], second: &[f64]) -> Vec<f64> {
    let pairs = first.iter().zip(second);
    pairs
        .map(|(a, b)| (0.5 + GAIN * 0.5 * (a - b)).clamp(0.0, 1.0))
        .collect()
}

/// Writes templates with pixels in 0..1 side by side, one list a row.
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

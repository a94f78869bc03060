//! Contact sheets: many small images side by side as one PNG.

use std::io::{Cursor, Write};
use std::path::Path;

use image::{GrayImage, ImageFormat, Luma};

use crate::dataset::{COLUMNS, Pixels, ROWS, write_atomically};
use crate::error::{Error, Result};

/// Grey of the lines between cells: neither a figure's 255 nor the ground's 0.
const LINE: u8 = 96;
/// The most pixels of a sheet, 64 Mi: more is a mistake in the arguments.
const MAX_PIXELS: u64 = 1 << 26;

/// Rows of images as one picture: each image enlarged `scale` times without
/// smoothing, one line of `scale` pixels around each. Short rows end in black.
///
/// # Errors
///
/// If there is no image, if `scale` is 0, or if the picture would have more than
/// 64 Mi pixels.
pub fn contact_sheet(rows: &[Vec<Pixels>], scale: u32) -> Result<GrayImage> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let (width, height) = (
        sheet_side(columns, COLUMNS, scale),
        sheet_side(rows.len(), ROWS, scale),
    );
    let (Some(width), Some(height)) = (width, height) else {
        return Err(Error::Failed(format!(
            "contact sheet: expected images and a scale of at least 1 in 64 Mi pixels, \
             found {} rows of {columns} at scale {scale}",
            rows.len()
        )));
    };
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(Error::Failed(format!(
            "contact sheet: expected at most 64 Mi pixels, found {width} x {height} \
             (take fewer images or a smaller scale)"
        )));
    }
    let mut sheet = GrayImage::from_pixel(width, height, Luma([LINE]));
    for (row, cells) in rows.iter().enumerate() {
        for column in 0..columns {
            let cell = cells.get(column);
            draw(
                &mut sheet,
                (row, column),
                cell.unwrap_or(&[0; ROWS * COLUMNS]),
                scale,
            );
        }
    }
    Ok(sheet)
}

/// A picture as the bytes of a PNG file.
///
/// # Errors
///
/// If the encoder fails, which only a lack of memory makes it do.
pub fn png(picture: &GrayImage) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|error| Error::Failed(format!("png: {error}")))?;
    Ok(bytes.into_inner())
}

/// Writes a picture as a PNG file, whole or not at all.
///
/// # Errors
///
/// The system's, if the file cannot be written.
pub fn write_png(path: impl AsRef<Path>, picture: &GrayImage) -> Result<()> {
    let path = path.as_ref();
    let bytes = png(picture)?;
    write_atomically(path, |file| {
        file.write_all(&bytes).map_err(|e| Error::io(path, e))
    })
}

/// Pixels of `cells` cells and the lines around them; none if that is 0 or too many.
fn sheet_side(cells: usize, pixels: usize, scale: u32) -> Option<u32> {
    let units = cells.checked_mul(pixels + 1)?.checked_add(1)?;
    u32::try_from(units)
        .ok()?
        .checked_mul(scale)
        .filter(|_| cells > 0 && scale > 0)
}

fn draw(sheet: &mut GrayImage, (row, column): (usize, usize), gei: &Pixels, scale: u32) {
    let step = scale as usize;
    let (top, left) = (
        (row * (ROWS + 1) + 1) * step,
        (column * (COLUMNS + 1) + 1) * step,
    );
    let width = sheet.width() as usize;
    for y in 0..ROWS * step {
        let source = &gei[y / step * COLUMNS..][..COLUMNS];
        let start = (top + y) * width + left;
        let line = &mut (**sheet)[start..start + COLUMNS * step];
        for (block, &grey) in line.chunks_exact_mut(step).zip(source) {
            block.fill(grey);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::PIXELS;

    #[test]
    fn each_pixel_becomes_a_block_in_its_cell() {
        let mut gei = [10; PIXELS];
        gei[0] = 200;
        gei[PIXELS - 1] = 250;
        let sheet = contact_sheet(&[vec![gei, [20; PIXELS]], vec![[30; PIXELS]]], 2).unwrap();
        assert_eq!(sheet.dimensions(), (2 * (1 + 31 + 31), 2 * (1 + 51 + 51)));
        let at = |x, y| sheet.get_pixel(x, y).0[0];
        assert_eq!([at(0, 0), at(1, 1)], [LINE, LINE]);
        assert_eq!([at(2, 2), at(3, 3), at(4, 2), at(2, 4)], [200, 200, 10, 10]);
        assert_eq!(
            [at(60, 100), at(61, 101), at(62, 101), at(61, 102)],
            [250, 250, LINE, LINE]
        );
        assert_eq!([at(64, 2), at(123, 101), at(124, 50)], [20, 20, LINE]);
        assert_eq!([at(2, 104), at(64, 104), at(125, 205)], [30, 0, LINE]);
    }

    #[test]
    fn a_png_comes_back_pixel_for_pixel() {
        let gei: Pixels = std::array::from_fn(|i| (i % 251) as u8);
        let sheet = contact_sheet(&[vec![gei]], 3).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.png");
        write_png(&path, &sheet).unwrap();
        assert_eq!(image::open(&path).unwrap().into_luma8(), sheet);
    }

    #[test]
    fn sheets_without_images_or_beyond_reason_are_refused() {
        assert!(contact_sheet(&[], 1).is_err());
        assert!(contact_sheet(&[vec![]], 1).is_err());
        assert!(contact_sheet(&[vec![[0; PIXELS]]], 0).is_err());
        assert!(contact_sheet(&[vec![[0; PIXELS]]], u32::MAX).is_err());
        let refused = contact_sheet(&[vec![[0; PIXELS]]], 300)
            .unwrap_err()
            .to_string();
        assert!(refused.contains("found 9600 x 15600"), "{refused}");
    }
}

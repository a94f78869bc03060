//! Contact sheets: many small images side by side as one PNG.

use std::io::Cursor;
use std::path::Path;

use image::{GrayImage, ImageBuffer, ImageFormat, Luma, PixelWithColorType};

use crate::draw::template::TemplateShape;
use crate::error::{ReportError, Result};
use crate::files::write_bytes;
use edgegait_core::format::crc32;
use edgegait_core::silhouette::Size;

/// Grey of the lines between cells: neither a figure's 255 nor the background's 0.
const LINE: u8 = 96;
/// The maximum number of pixels in a sheet, 64 Mi: more is a mistake in the arguments.
const MAX_PIXELS: u64 = 1 << 26;

/// Draws rows of images of one size as one picture: each image enlarged `scale` times without
/// smoothing, with a line of `scale` pixels around it. Short rows and images are filled with black.
///
/// # Errors
///
/// If there is no image, if `scale` is 0, or if the picture would have more than
/// 64 Mi pixels.
pub(crate) fn contact_sheet<P: AsRef<[u8]>>(
    rows: &[Vec<P>],
    size: Size,
    scale: u32,
) -> Result<GrayImage> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let (width, height) = (
        sheet_side(columns, size.columns(), scale),
        sheet_side(rows.len(), size.rows(), scale),
    );
    let (Some(width), Some(height)) = (width, height) else {
        return Err(ReportError::NoImages {
            rows: rows.len(),
            columns,
            scale,
        }
        .into());
    };
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(ReportError::TooLarge { width, height }.into());
    }
    let mut sheet = GrayImage::from_pixel(width, height, Luma([LINE]));
    for (row, cells) in rows.iter().enumerate() {
        for column in 0..columns {
            let cell = cells.get(column).map_or(&[][..], AsRef::as_ref);
            draw(&mut sheet, row, column, cell, size, scale);
        }
    }
    Ok(sheet)
}

/// Returns a template of silhouettes of this size as images of the same size. Each image of a
/// template is one image. A vector is drawn as vertical bars, a column for each number, in as many
/// images as needed; with a number for each row, it is drawn as horizontal bars around the middle.
#[must_use]
pub(crate) fn cells(bytes: &[u8], shape: TemplateShape, size: Size) -> Vec<Vec<u8>> {
    let (rows, columns) = (size.rows(), size.columns());
    let TemplateShape::Vector(numbers) = shape else {
        let images = bytes.chunks_exact(size.pixels());
        return images.map(<[u8]>::to_vec).collect();
    };
    if numbers == rows {
        let row = |&byte: &u8| {
            let width = (usize::from(byte) * columns + 127) / 255;
            let left = (columns - width) / 2;
            (0..columns).map(move |at| {
                if (left..left + width).contains(&at) {
                    255
                } else {
                    0
                }
            })
        };
        return vec![bytes.iter().flat_map(row).collect()];
    }
    let of_numbers = |numbers: &[u8]| {
        let is_within = |row: usize, column: usize| {
            let height =
                (usize::from(numbers.get(column).copied().unwrap_or(0)) * rows + 127) / 255;
            row >= rows - height
        };
        let pixel = |at: usize| {
            if is_within(at / columns, at % columns) {
                255
            } else {
                0
            }
        };
        (0..size.pixels()).map(pixel).collect()
    };
    bytes.chunks(columns).map(of_numbers).collect()
}

/// Encodes a picture as the bytes of a PNG file.
///
/// # Errors
///
/// If the encoder fails, which only happens without memory.
pub(crate) fn png<P>(picture: &ImageBuffer<P, Vec<u8>>) -> Result<Vec<u8>>
where
    P: PixelWithColorType<Subpixel = u8>,
{
    let mut bytes = Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(ReportError::Png)?;
    Ok(signed(&bytes.into_inner()))
}

/// The chunk that names the program: its length, and its type with the registered keyword
/// `Software` (PNG, third edition, 11.3.3.2).
const SIGNATURE: (u32, &[u8]) = (17, b"tEXtSoftware\0EdgeGait");
/// The end of the first chunk of a PNG file, the header.
const HEADER_END: usize = 33;

/// Returns the bytes of a PNG file with the program's name, by which it recognizes its files.
fn signed(png: &[u8]) -> Vec<u8> {
    let (header, rest) = png.split_at(HEADER_END.min(png.len()));
    let (length, text) = SIGNATURE;
    let check = crc32(text).to_be_bytes();
    [header, &length.to_be_bytes(), text, &check, rest].concat()
}

/// Returns whether a PNG file with this beginning was written by this program.
#[must_use]
pub(crate) fn is_own_png(start: &[u8]) -> bool {
    let text = start.get(HEADER_END + 4..);
    start.starts_with(b"\x89PNG") && text.is_some_and(|text| text.starts_with(SIGNATURE.1))
}

/// Writes a picture as a PNG file atomically.
///
/// # Errors
///
/// If the file cannot be written.
pub(crate) fn write_png<P>(path: impl AsRef<Path>, picture: &ImageBuffer<P, Vec<u8>>) -> Result<()>
where
    P: PixelWithColorType<Subpixel = u8>,
{
    write_bytes(path, &png(picture)?)
}

/// Returns the pixels of `cells` cells and the lines around them; none if they are 0 or too many.
fn sheet_side(cells: usize, pixels: usize, scale: u32) -> Option<u32> {
    let units = cells.checked_mul(pixels + 1)?.checked_add(1)?;
    u32::try_from(units)
        .ok()?
        .checked_mul(scale)
        .filter(|_| cells > 0 && scale > 0)
}

fn draw(sheet: &mut GrayImage, row: usize, column: usize, pixels: &[u8], size: Size, scale: u32) {
    let step = scale as usize;
    let columns = size.columns();
    let (top, left) = (
        (row * (size.rows() + 1) + 1) * step,
        (column * (columns + 1) + 1) * step,
    );
    let width = sheet.width() as usize;
    let source = pixels.iter().copied().chain(std::iter::repeat(0));
    let source: Vec<u8> = source.take(size.pixels()).collect();
    for (y, line) in source.chunks_exact(columns).enumerate() {
        for y in y * step..(y + 1) * step {
            let start = (top + y) * width + left;
            let blocks = (**sheet)[start..start + columns * step].chunks_exact_mut(step);
            for (block, &grey) in blocks.zip(line) {
                block.fill(grey);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::budget::PIXELS;

    #[test]
    fn each_pixel_becomes_a_block_in_its_cell() {
        let mut gei = [10; PIXELS];
        gei[0] = 200;
        gei[PIXELS - 1] = 250;
        let sheet = contact_sheet(
            &[vec![gei, [20; PIXELS]], vec![[30; PIXELS]]],
            Size::S50x30,
            2,
        )
        .unwrap();
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
    fn vectors_are_shown_as_bars() {
        let size = Size::S50x30;
        // 60 numbers in two images: the first bar is 10 rows high, the last one 50.
        let mut numbers = vec![0; 60];
        (numbers[0], numbers[59]) = (51, 255);
        let found = cells(&numbers, TemplateShape::Vector(60), size);
        let white = |image: &[u8], column: usize| {
            (0..50)
                .filter(|row| image[row * 30 + column] == 255)
                .count()
        };
        assert_eq!(found.len(), 2);
        assert_eq!([white(&found[0], 0), white(&found[0], 1)], [10, 0]);
        assert_eq!([white(&found[1], 0), white(&found[1], 29)], [0, 50]);
        // 10 of 30 columns in the middle of the first of 50 rows.
        let mut widths = vec![0; 50];
        widths[0] = 85;
        let found = cells(&widths, TemplateShape::Vector(50), size);
        let row: Vec<usize> = (0..1500).filter(|&at| found[0][at] == 255).collect();
        assert_eq!(row, (10..20).collect::<Vec<_>>());
    }

    #[test]
    fn a_png_comes_back_pixel_for_pixel() {
        let gei: Vec<u8> = (0..64 * 44).map(|i| (i % 251) as u8).collect();
        let sheet = contact_sheet(&[vec![gei]], Size::S64x44, 3).unwrap();
        assert_eq!(sheet.dimensions(), (3 * 46, 3 * 66));
        // Row 63, column 43: the last one.
        assert_eq!(
            sheet.get_pixel(3 * 45 - 1, 3 * 65 - 1).0[0],
            (2_815 % 251) as u8
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.png");
        write_png(&path, &sheet).unwrap();
        assert_eq!(image::open(&path).unwrap().into_luma8(), sheet);
        // The chunk after the header, with the CRC-32 that Python's zlib computes.
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(
            &bytes[33..62],
            b"\0\0\0\x11tEXtSoftware\0EdgeGait\xde\x9e\x1b\xaf"
        );
        assert!(is_own_png(&bytes) && !is_own_png(&bytes[..40]) && !is_own_png(b"P5 1 1"));
    }

    #[test]
    fn sheets_without_images_or_beyond_reason_are_refused() {
        let sheet = |rows: &[Vec<[u8; PIXELS]>], scale| contact_sheet(rows, Size::S50x30, scale);
        assert!(sheet(&[], 1).is_err());
        assert!(sheet(&[vec![]], 1).is_err());
        assert!(sheet(&[vec![[0; PIXELS]]], 0).is_err());
        assert!(sheet(&[vec![[0; PIXELS]]], u32::MAX).is_err());
        let refused = sheet(&[vec![[0; PIXELS]]], 300).unwrap_err().to_string();
        assert!(refused.contains("found 9600 x 15600"), "{refused}");
    }
}

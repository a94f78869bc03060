//! Contact sheets: many small images side by side as one PNG.

use std::io::Cursor;
use std::path::Path;

use image::{GrayImage, ImageBuffer, ImageFormat, Luma, PixelWithColorType};

use crate::draw::template::TemplateShape;
use crate::error::{ReportError, Result};
use crate::files::write_bytes;
use edgegait_core::format::crc32;
use edgegait_core::silhouette::Size;

/// Grey between images: neither a figure's 255 nor the background's 0.
const PAPER: u8 = 96;
/// The height of a label, and the width of its letters, pixels.
const LABEL: u32 = 18;
const LETTER: u32 = 8;
/// The width of a sheet of many images: what a screen shows.
const WIDTH: u32 = 1280;
/// The maximum height of a sheet, pixels. What does not fit is left out, which the sheet states.
const MAX_HEIGHT: u32 = 1 << 14;

/// Images of one kind, with their label.
#[derive(Clone)]
pub(crate) struct SheetRow {
    pub(crate) label: String,
    /// The pixels of each image.
    pub(crate) images: Vec<Vec<u8>>,
}

/// A contact sheet.
#[derive(Debug)]
pub(crate) struct ContactSheet {
    pub(crate) picture: GrayImage,
    /// Number of images for which the sheet has no room.
    pub(crate) left_out: usize,
}

/// Draws rows of images of one size as one picture: each image enlarged `scale` times without
/// smoothing, with a line of `scale` pixels around it. A row that is wider than a screen is broken
/// into lines of nearly equal length; short rows are side by side. Without the feature `plots` labels are blank.
///
/// # Errors
///
/// If there is no image, or if not even the first one has room.
pub(crate) fn contact_sheet(rows: &[SheetRow], size: Size, scale: u32) -> Result<ContactSheet> {
    let longest = rows.iter().map(|row| row.images.len()).max().unwrap_or(0);
    let cell = |pixels: usize| (pixels as u64 + 1) * u64::from(scale);
    let (across, down) = (cell(size.columns()), cell(size.rows()));
    let least = (
        across + u64::from(scale),
        down + u64::from(scale) + 2 * u64::from(LABEL),
    );
    if longest == 0 || scale == 0 || least.0.max(least.1) > u64::from(MAX_HEIGHT) {
        return Err(ReportError::NoImages {
            rows: rows.len(),
            columns: longest,
            scale,
        }
        .into());
    }
    let (across, down) = (across as u32, down as u32);
    let most = (WIDTH.saturating_sub(scale) / across).max(1) as usize;
    let in_line = longest.div_ceil(longest.div_ceil(most));
    // Rows are side by side if a screen is wide enough for that.
    let letters = rows.iter().map(|row| row.label.chars().count()).max();
    let labels = LETTER * (letters.unwrap_or(0) as u32 + 1);
    let block = (in_line as u32 * across + scale).max(labels.min(WIDTH));
    let abreast = (WIDTH / block).clamp(1, rows.len() as u32);
    let mut lines = Vec::new();
    let (mut y, mut left_out) = (0, 0);
    for side_by_side in rows.chunks(abreast as usize) {
        let of_row = |row: &SheetRow| row.images.len().div_ceil(in_line) as u32;
        let tallest = side_by_side.iter().map(of_row).max().unwrap_or(0);
        for line in 0..tallest {
            let top = if line == 0 { LABEL } else { 0 };
            let is_full = left_out > 0 || y + top + down + scale + LABEL > MAX_HEIGHT;
            for (row, x) in side_by_side.iter().zip((0..).step_by(block as usize)) {
                let label = (line == 0).then_some(&row.label);
                let images = row.images.chunks(in_line).nth(line as usize);
                let images = images.unwrap_or_default();
                if is_full {
                    left_out += images.len();
                } else {
                    lines.push(((x, y), label, images));
                }
            }
            if !is_full {
                y += top + down;
            }
        }
    }
    let height = y + scale + if left_out > 0 { LABEL } else { 0 };
    let mut picture = GrayImage::from_pixel(abreast * block, height, Luma([PAPER]));
    for ((x, mut y), label, images) in lines {
        if let Some(label) = label {
            write_label(&mut picture, (x, y), label)?;
            y += LABEL;
        }
        for (column, image) in images.iter().enumerate() {
            let corner = (x + column as u32 * across + scale, y + scale);
            draw(&mut picture, corner, image, size, scale as usize);
        }
    }
    if left_out > 0 {
        let label = format!("{left_out} more are left out");
        write_label(&mut picture, (0, y + scale), &label)?;
    }
    Ok(ContactSheet { picture, left_out })
}

/// Writes a label at the left of a picture.
#[cfg_attr(
    not(feature = "plots"),
    expect(unused_variables, clippy::unnecessary_wraps)
)]
fn write_label(picture: &mut GrayImage, (x, y): (u32, u32), label: &str) -> Result<()> {
    #[cfg(feature = "plots")]
    super::lettering::letters((x + 4, y), label, |at, covered| {
        if let Some(pixel) = picture.get_pixel_mut_checked(at.0, at.1) {
            pixel.0[0] += (f32::from(255 - pixel.0[0]) * covered) as u8;
        }
    })?;
    Ok(())
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

/// Draws an image with its upper left corner there, each of its pixels as a square.
fn draw(sheet: &mut GrayImage, (left, top): (u32, u32), pixels: &[u8], size: Size, step: usize) {
    let width = sheet.width() as usize;
    let (left, top) = (left as usize, top as usize);
    for (y, line) in pixels.chunks_exact(size.columns()).enumerate() {
        for y in y * step..(y + 1) * step {
            let start = (top + y) * width + left;
            let blocks = (**sheet)[start..start + size.columns() * step].chunks_exact_mut(step);
            for (block, &grey) in blocks.zip(line) {
                block.fill(grey);
            }
        }
    }
}

/// The beginning of a GIF file, and the comment with the program's name (GIF89a, section 24), which
/// follows the header and the palette.
const GIF_START: &[u8] = b"GIF89a";
const GIF_NAME: &[u8] = b"\x21\xfe\x08EdgeGait\0";

/// Returns whether a file with this beginning is an animation that was written by this program.
#[must_use]
pub(crate) fn is_own_gif(start: &[u8]) -> bool {
    let mut windows = start.windows(GIF_NAME.len());
    start.starts_with(GIF_START) && windows.any(|window| window == GIF_NAME)
}

/// Encodes pictures of one size as the bytes of an animated GIF file that repeats for ever, each
/// shown for this time. Times are rounded to hundredths of a second so that their sum is right.
///
/// # Errors
///
/// If there is no picture, or one of another size or of more than 65,535 pixels a side.
pub(crate) fn gif(pictures: &[GrayImage], each_s: f64) -> Result<Vec<u8>> {
    let side = |pixels: u32| u16::try_from(pixels).ok();
    let first = pictures.first().map(GrayImage::dimensions);
    let sides = first.and_then(|(width, height)| Some((side(width)?, side(height)?)));
    let (Some((width, height)), true) = (
        sides,
        pictures
            .iter()
            .all(|picture| Some(picture.dimensions()) == first),
    ) else {
        return Err(ReportError::Empty {
            expected: "animation: expected pictures of one size",
            cells: pictures.len(),
            across: 1,
        }
        .into());
    };
    let greys: Vec<u8> = (0..=255).flat_map(|grey| [grey; 3]).collect();
    let mut bytes = Vec::new();
    let write = |bytes: &mut Vec<u8>| -> std::result::Result<(), gif::EncodingError> {
        let mut encoder = gif::Encoder::new(bytes, width, height, &greys)?;
        encoder.write_raw_extension(gif::AnyExtension(0xfe), &[b"EdgeGait"])?;
        encoder.set_repeat(gif::Repeat::Infinite)?;
        for (index, picture) in pictures.iter().enumerate() {
            let hundredths = |index: usize| (index as f64 * each_s * 100.0).round();
            let mut frame = gif::Frame::from_indexed_pixels(width, height, &**picture, None);
            frame.delay = (hundredths(index + 1) - hundredths(index)).clamp(2.0, 6e4) as u16;
            encoder.write_frame(&frame)?;
        }
        Ok(())
    };
    write(&mut bytes).map_err(ReportError::Gif)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::budget::PIXELS;

    fn row(images: &[&[u8]]) -> SheetRow {
        SheetRow {
            label: String::new(),
            images: images.iter().map(|image| image.to_vec()).collect(),
        }
    }

    #[test]
    fn each_pixel_becomes_a_block_in_its_cell() {
        let mut gei = [10; PIXELS];
        gei[0] = 200;
        gei[PIXELS - 1] = 250;
        let rows = [row(&[&gei, &[20; PIXELS]]), row(&[&[30; PIXELS]])];
        let sheet = contact_sheet(&rows, Size::S50x30, 2).unwrap();
        assert_eq!(sheet.left_out, 0);
        let sheet = sheet.picture;
        // Both rows are side by side.
        assert_eq!(sheet.dimensions(), (2 * 126, 2 * (1 + 51) + 18));
        let at = |x, y| sheet.get_pixel(x, y).0[0];
        assert_eq!([at(0, 0), at(1, 19)], [PAPER, PAPER]);
        assert_eq!(
            [at(2, 20), at(3, 21), at(4, 20), at(2, 22)],
            [200, 200, 10, 10]
        );
        assert_eq!(
            [at(60, 118), at(61, 119), at(62, 119), at(61, 120)],
            [250, 250, PAPER, PAPER]
        );
        assert_eq!([at(64, 20), at(123, 119), at(124, 68)], [20, 20, PAPER]);
        assert_eq!([at(128, 20), at(190, 20), at(128, 120)], [30, PAPER, PAPER]);
    }

    #[test]
    fn long_rows_are_broken_and_what_has_no_room_is_counted() {
        let image: &[u8] = &[7; PIXELS];
        // 20 images of 62 pixels fit a line, so that 32 are two lines of 16.
        let sheet = contact_sheet(&[row(&[image; 32])], Size::S50x30, 2).unwrap();
        assert_eq!(sheet.picture.dimensions(), (16 * 62 + 2, 18 + 204 + 2));
        assert_eq!(sheet.picture.get_pixel(991, 20 + 102 + 99).0[0], 7);
        // 136 rows of 120 pixels fit; a label that is as wide as a screen leaves no room beside it.
        let rows = vec![row(&[image]); 1000];
        let beside = contact_sheet(&rows, Size::S50x30, 2).unwrap();
        assert_eq!((beside.left_out, beside.picture.width()), (0, 20 * 64));
        let mut rows = rows;
        rows[7].label = "x".repeat(999);
        let sheet = contact_sheet(&rows, Size::S50x30, 2).unwrap();
        assert_eq!(sheet.left_out, 1000 - 136);
        assert!(sheet.picture.height() <= 16384);
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
        let sheet = contact_sheet(&[row(&[&gei])], Size::S64x44, 3).unwrap();
        let sheet = sheet.picture;
        assert_eq!(sheet.dimensions(), (3 * 46, 18 + 3 * 66));
        // Row 63, column 43: the last one.
        assert_eq!(
            sheet.get_pixel(3 * 45 - 1, 18 + 3 * 65 - 1).0[0],
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
        let sheet = |rows: &[SheetRow], scale| contact_sheet(rows, Size::S50x30, scale);
        assert!(sheet(&[], 1).is_err());
        assert!(sheet(&[row(&[])], 1).is_err());
        assert!(sheet(&[row(&[&[0; PIXELS]])], 0).is_err());
        assert!(sheet(&[row(&[&[0; PIXELS]])], u32::MAX).is_err());
        let refused = sheet(&[row(&[&[0; PIXELS]])], 400).unwrap_err().to_string();
        assert!(refused.contains("scale 400"), "{refused}");
    }

    #[test]
    fn an_animation_comes_back_pixel_for_pixel_and_lasts_as_long_as_asked() {
        let of = |grey: u8| GrayImage::from_fn(5, 3, |x, y| Luma([grey + (x + 5 * y) as u8]));
        let pictures = [of(0), of(100), of(240)];
        let bytes = gif(&pictures, 1.1 / 3.0).unwrap();
        assert!(is_own_gif(&bytes) && !is_own_gif(b"GIF89a") && !is_own_gif(&bytes[1..]));
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(&bytes[..]).unwrap();
        assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
        let mut delays = 0;
        for picture in &pictures {
            let frame = decoder.read_next_frame().unwrap().expect("a frame");
            delays += frame.delay;
            let greys: Vec<u8> = frame.buffer.chunks(4).map(|rgba| rgba[0]).collect();
            assert_eq!(greys, **picture);
        }
        assert!(decoder.read_next_frame().unwrap().is_none());
        assert_eq!(delays, 110);
        assert!(gif(&[], 0.1).is_err());
        assert!(gif(&[of(0), GrayImage::new(5, 4)], 0.1).is_err());
    }
}

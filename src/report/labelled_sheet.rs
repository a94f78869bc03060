//! Labelled sheets of pictures: one walk under each confounder, and one walk in every template.

use super::drawing::LINES;
use super::lettering::letters;
use crate::error::{ReportError, Result};
use image::{GrayImage, Luma, RgbImage, imageops};

/// Space around the sheet and between blocks, and between the pictures of a row, pixels.
const MARGIN: u32 = 12;
const GAP: u32 = 4;
/// Height of a line of text, and width of a letter, pixels.
const LINE: u32 = 18;
const LETTER: f64 = 7.2;
/// Side of the coloured square that marks a class.
const SQUARE: u32 = 8;
/// The maximum height of an enlarged template, and the width of the longest bar, pixels.
const ENLARGED: usize = 150;
const BAR: u32 = 90;
const PAPER: Rgb = image::Rgb([255; 3]);
const INK: [u8; 3] = [32, 36, 40];

/// Classes with the same colour in every gallery.
const CLASSES: [&str; 3] = ["appearance", "environment", "imaging"];
/// The minimum width, for the line of the title, pixels.
const LEAST_WIDTH: u32 = 800;

type Rgb = image::Rgb<u8>;

/// A silhouette or a plane of a template: rows of bytes, the upper one first.
#[derive(Clone, Debug)]
pub(super) struct GalleryImage {
    /// The pixels, 0..=255.
    pub bytes: Vec<u8>,
    /// Bytes per row.
    pub columns: usize,
}

/// The pictures of one confounder, for [`gallery`].
#[derive(Clone, Debug)]
pub(super) struct GalleryRow {
    /// The confounder's name, and its strength if it matters.
    pub label: String,
    /// The confounder's class.
    pub class: String,
    /// The camera view.
    pub frame: RgbImage,
    /// The silhouette in that view.
    pub silhouette: GalleryImage,
    /// The template of the whole cycle.
    pub template: GalleryImage,
}

/// One template, for [`template_sheet`].
#[derive(Clone, Debug)]
pub(super) struct TemplateCell {
    /// The template's name.
    pub label: String,
    /// The template's planes. A plane with a single column is a vector, drawn as bars.
    pub planes: Vec<GalleryImage>,
}

impl GalleryImage {
    /// Enlarges the complete rows, each byte to a square of `scale` pixels.
    fn enlarged(&self, scale: usize) -> RgbImage {
        let (columns, scale) = (self.columns.max(1), scale.max(1) as u32);
        let rows = self.bytes.len() / columns;
        let grey = GrayImage::from_fn(columns as u32 * scale, rows as u32 * scale, |x, y| {
            Luma([self.bytes[(y / scale) as usize * columns + (x / scale) as usize]])
        });
        image::DynamicImage::ImageLuma8(grey).into_rgb8()
    }

    /// Returns the greatest whole scale with at most `height` rows of pixels.
    fn scale_within(&self, height: usize) -> usize {
        height / (self.bytes.len() / self.columns.max(1)).max(1)
    }

    /// Draws a bar for each byte, the first one on top.
    fn bars(&self) -> RgbImage {
        let thickness = (ENLARGED / self.bytes.len().max(1)).max(1) as u32;
        let height = thickness * self.bytes.len() as u32;
        RgbImage::from_fn(BAR, height, |x, y| {
            let value = f64::from(self.bytes[(y / thickness) as usize]) / 255.0;
            let is_on = f64::from(x) + 0.5 < value * f64::from(BAR);
            image::Rgb([if is_on { 255 } else { 0 }; 3])
        })
    }
}

/// Draws a gallery of one subject with a row per confounder: its label, the frame, the silhouette,
/// and the template. The rows fill `blocks` blocks side by side, each from the top. Silhouettes and
/// templates are enlarged by whole numbers, up to the height of the frame beside them.
///
/// With frames of 104x100 pixels and 50x30 silhouettes a block is 232 pixels wide.
///
/// # Errors
/// If there is no row or no block.
pub(super) fn gallery(title: &str, rows: &[GalleryRow], blocks: usize) -> Result<RgbImage> {
    if rows.is_empty() || blocks == 0 {
        return Err(ReportError::Empty {
            expected: "gallery: expected rows and blocks",
            cells: rows.len(),
            across: blocks,
        }
        .into());
    }
    let strips: Vec<RgbImage> = rows.iter().map(strip).collect();
    let width = strips.iter().map(RgbImage::width).max().unwrap_or(0) + MARGIN;
    let height = strips.iter().map(RgbImage::height).max().unwrap_or(0) + LINE + GAP;
    let in_block = rows.len().div_ceil(blocks);
    let mut sheet = RgbImage::from_pixel(
        LEAST_WIDTH.max(MARGIN + width * blocks.min(rows.len()) as u32),
        MARGIN + LINE + GAP + height * in_block as u32,
        PAPER,
    );
    let mut classes = CLASSES.to_vec();
    let mut texts = vec![SheetText::plain((MARGIN, MARGIN / 2), title)];
    for (index, (row, strip)) in rows.iter().zip(&strips).enumerate() {
        let x = MARGIN + width * (index / in_block) as u32;
        let y = MARGIN + LINE + height * (index % in_block) as u32;
        imageops::replace(&mut sheet, strip, x.into(), (y + LINE).into());
        let class = classes.iter().position(|class| *class == row.class);
        let class = class.unwrap_or_else(|| {
            classes.push(&row.class);
            classes.len() - 1
        });
        texts.push(SheetText {
            at: (x, y),
            text: &row.label,
            class: Some(class),
        });
    }
    // The names of the classes at the right end of the title's line, the last one outermost.
    let mut right = sheet.width() - MARGIN;
    for (index, class) in classes.iter().enumerate().rev() {
        right = right.saturating_sub((LETTER * class.len() as f64) as u32 + 2 * SQUARE);
        texts.push(SheetText {
            at: (right, MARGIN / 2),
            text: class,
            class: Some(index),
        });
    }
    write(&mut sheet, &texts)?;
    Ok(sheet)
}

/// Draws a row's pictures side by side.
fn strip(row: &GalleryRow) -> RgbImage {
    let height = row.frame.height();
    let enlarged = |raster: &GalleryImage| raster.enlarged(raster.scale_within(height as usize));
    side_by_side(&[
        row.frame.clone(),
        enlarged(&row.silhouette),
        enlarged(&row.template),
    ])
}

/// Draws one walk in every template, with labels, in rows of at most `columns` templates.
///
/// # Errors
/// If there is no template or no column.
pub(super) fn template_sheet(
    title: &str,
    cells: &[TemplateCell],
    columns: usize,
) -> Result<RgbImage> {
    if cells.is_empty() || columns == 0 {
        return Err(ReportError::Empty {
            expected: "template sheet: expected templates and columns",
            cells: cells.len(),
            across: columns,
        }
        .into());
    }
    let pictures: Vec<RgbImage> = cells.iter().map(planes).collect();
    let height = pictures.iter().map(RgbImage::height).max().unwrap_or(0) + LINE + GAP;
    let widths: Vec<u32> = pictures
        .iter()
        .zip(cells)
        .map(|(picture, cell)| {
            let text = (LETTER * cell.label.len() as f64) as u32;
            picture.width().max(text) + MARGIN
        })
        .collect();
    let rows = widths.chunks(columns);
    let title_width = (LETTER * title.len() as f64) as u32;
    let width = rows.clone().map(|row| row.iter().sum()).max().unwrap_or(0);
    let mut sheet = RgbImage::from_pixel(
        MARGIN + width.max(title_width + MARGIN),
        MARGIN + LINE + GAP + height * rows.len() as u32,
        PAPER,
    );
    let mut texts = vec![SheetText::plain((MARGIN, MARGIN / 2), title)];
    for (index, (cell, picture)) in cells.iter().zip(&pictures).enumerate() {
        let (row, column) = (index / columns, index % columns);
        let before = &widths[row * columns..][..column];
        let x = MARGIN + before.iter().sum::<u32>();
        let y = MARGIN + LINE + height * row as u32;
        imageops::replace(&mut sheet, picture, x.into(), (y + LINE).into());
        texts.push(SheetText::plain((x, y), &cell.label));
    }
    write(&mut sheet, &texts)?;
    Ok(sheet)
}

/// Draws a template's planes side by side.
fn planes(cell: &TemplateCell) -> RgbImage {
    let planes = cell.planes.iter().map(|plane| match plane.columns {
        1 => plane.bars(),
        _ => plane.enlarged(plane.scale_within(ENLARGED)),
    });
    side_by_side(&planes.collect::<Vec<_>>())
}

fn side_by_side(pictures: &[RgbImage]) -> RgbImage {
    let width = pictures
        .iter()
        .map(|picture| picture.width() + GAP)
        .sum::<u32>();
    let height = pictures.iter().map(RgbImage::height).max().unwrap_or(0);
    let mut strip = RgbImage::from_pixel(width.saturating_sub(GAP), height, PAPER);
    let mut x = 0;
    for picture in pictures {
        imageops::replace(&mut strip, picture, x.into(), 0);
        x += picture.width() + GAP;
    }
    strip
}

/// A text on a sheet.
struct SheetText<'a> {
    /// Its upper left corner.
    at: (u32, u32),
    text: &'a str,
    /// The class whose colour a square before it has.
    class: Option<usize>,
}

impl<'a> SheetText<'a> {
    const fn plain(at: (u32, u32), text: &'a str) -> Self {
        Self {
            at,
            text,
            class: None,
        }
    }
}

fn write(sheet: &mut RgbImage, texts: &[SheetText<'_>]) -> Result<()> {
    for &SheetText { at, text, class } in texts {
        let (mut x, y) = at;
        if let Some(class) = class {
            let square = RgbImage::from_pixel(SQUARE, SQUARE, colour(class));
            imageops::replace(sheet, &square, x.into(), (y + 4).into());
            x += SQUARE + GAP;
        }
        letters((x, y), text, |at, covered| ink(sheet, at, covered))?;
    }
    Ok(())
}

/// Mixes ink into a pixel, if it is on the sheet.
fn ink(sheet: &mut RgbImage, (x, y): (u32, u32), covered: f32) {
    let Some(pixel) = sheet.get_pixel_mut_checked(x, y) else {
        return;
    };
    // An almost fully covered pixel is full ink.
    let share = match (covered * 256.0) as u32 {
        255.. => 256,
        share => share,
    };
    for (channel, ink) in pixel.0.iter_mut().zip(INK) {
        let faded = u32::from(channel.abs_diff(ink)) * share / 256;
        *channel = channel.saturating_sub(faded as u8);
    }
}

/// Returns the colour of a class, the same as that of a chart's line.
fn colour(class: usize) -> Rgb {
    let text = LINES[class % LINES.len()].colour;
    let [_, rgb @ ..] = u32::from_str_radix(&text[1..], 16).map_or([0; 4], u32::to_be_bytes);
    image::Rgb(rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(rows: usize, columns: usize, byte: u8) -> GalleryImage {
        GalleryImage {
            bytes: vec![byte; rows * columns],
            columns,
        }
    }

    fn row(class: &str) -> GalleryRow {
        GalleryRow {
            label: "hat".into(),
            class: class.into(),
            frame: RgbImage::from_pixel(104, 100, image::Rgb([1, 2, 3])),
            silhouette: raster(50, 30, 10),
            template: raster(50, 30, 20),
        }
    }

    #[test]
    fn blocks_are_filled_from_the_top_and_pictures_keep_their_pixels() {
        let rows = [row("imaging"), row("imaging"), row("appearance")];
        let sheet = gallery("all", &rows, 2).unwrap();
        // The minimum width, for the title.
        assert_eq!(sheet.dimensions(), (800, 12 + 18 + 4 + 2 * 122));
        let at = |x, y| sheet.get_pixel(x, y).0;
        // The frame, a gap, the silhouette enlarged twice, and the template.
        assert_eq!(at(12, 48), [1, 2, 3]);
        assert_eq!([at(115, 147), at(116, 147)], [[1, 2, 3], [255; 3]]);
        assert_eq!([at(120, 48), at(179, 147)], [[10; 3]; 2]);
        assert_eq!([at(184, 48), at(243, 147)], [[20; 3]; 2]);
        // The second row is below, the third in the other block; there is no fourth.
        assert_eq!([at(12, 170), at(256, 48)], [[1, 2, 3]; 2]);
        assert_eq!(at(256, 170), [255; 3]);
        // Squares of two classes, whose colours are the same in every gallery.
        assert_eq!([at(14, 40), at(258, 40)], [[0, 158, 115], [0, 114, 178]]);
    }

    #[test]
    fn vectors_are_bars_and_planes_stand_side_by_side() {
        let cells = [
            TemplateCell {
                label: "frequency".into(),
                planes: [5, 6, 7].map(|byte| raster(50, 30, byte)).into(),
            },
            TemplateCell {
                label: "row-width".into(),
                planes: vec![GalleryImage {
                    bytes: [vec![0; 25], vec![255; 25]].concat(),
                    columns: 1,
                }],
            },
        ];
        let sheet = template_sheet("one walk", &cells, 4).unwrap();
        let at = |x, y| sheet.get_pixel(x, y).0;
        assert_eq!(
            [at(12, 48), at(106, 48), at(200, 197)],
            [[5; 3], [6; 3], [7; 3]]
        );
        // The bars begin after 3 * 90 + 2 * 4 pixels and a margin.
        assert_eq!(
            [at(302, 48), at(302, 122), at(302, 123)],
            [[0; 3], [0; 3], [255; 3]]
        );
    }

    #[test]
    fn sheets_of_nothing_are_refused() {
        assert!(gallery("", &[], 2).is_err());
        assert!(gallery("", &[row("imaging")], 0).is_err());
        assert!(template_sheet("", &[], 2).is_err());
    }
}

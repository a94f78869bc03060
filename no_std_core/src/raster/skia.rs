//! Filling outlines with tiny-skia: the only file that names it.
//!
//! Hulls are filled one by one, so that what tiny-skia allocates for a fill is a
//! constant; [`crate::budget::SKIA_TRANSIENT_BYTES`] sums it.

use super::framing::Moments;
use super::place::{Placement, as_pixels};
use super::seen::Seen;
use crate::budget::{MAX_OUTLINE, SKIA_WINDOW_COLUMNS};
use crate::outline::{Outline, clipped, convex};
use crate::silhouette::{Coverage, Frame, Silhouette, Size};
use glam::Vec2;
use tiny_skia::{FillRule, Mask, PathBuilder, Transform};

/// A window of 64 columns to draw into.
#[derive(Debug)]
pub struct Window {
    mask: Mask,
    size: Size,
    /// Kept between fills, so that paths reuse one buffer.
    path: Option<PathBuilder>,
    anti_alias: bool,
}

impl Window {
    /// An empty window with the rows of `size`; `anti_alias` takes 4x4 samples a pixel
    /// instead of one.
    pub fn new(size: Size, anti_alias: bool) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "64 by at most 64")]
        let mask = Mask::new(SKIA_WINDOW_COLUMNS as u32, size.rows() as u32);
        Self {
            // tiny-skia refuses only sizes of zero and above 2^31.
            mask: mask.expect("64 by at most 64 pixels"),
            size,
            path: None,
            anti_alias,
        }
    }

    /// Empties the window.
    pub fn clear(&mut self) {
        self.mask.data_mut().fill(0);
    }

    /// Draws a figure's hulls, and nothing else.
    pub fn draw(&mut self, seen: &Seen<'_>, placement: &Placement) {
        self.clear();
        for hull in seen.figure.hull_parts() {
            let x = seen.points.x.get(hull.points.clone()).unwrap_or_default();
            let y = seen.points.y.get(hull.points).unwrap_or_default();
            let points = x.iter().zip(y).map(|(&x, &y)| Vec2::new(x, y));
            self.fill_hull(points.map(|point| placement.place(point)));
        }
    }

    /// Draws one hull over what there is: its points, pixels.
    pub fn fill_hull(&mut self, pixels: impl Iterator<Item = Vec2>) {
        let outline = self.outline(pixels);
        self.fill(&outline);
    }

    /// The outline of a hull, as far as the window shows it. Apart, so that its work gives back
    /// its stack before tiny-skia begins.
    #[inline(never)]
    fn outline(&self, pixels: impl Iterator<Item = Vec2>) -> Outline {
        // One pixel of margin, so that the cut itself is never seen.
        let min = Vec2::splat(-1.0);
        let max = Vec2::new(
            as_pixels(SKIA_WINDOW_COLUMNS + 1),
            as_pixels(self.size.rows() + 1),
        );
        clipped(&convex(pixels), min, max)
    }

    /// Area and first moment of what was drawn.
    pub fn moments(&self) -> Moments {
        // Sums of columns first: additions of whole rows vectorise.
        let mut columns = [0u32; SKIA_WINDOW_COLUMNS];
        for row in self.mask.data().chunks_exact(SKIA_WINDOW_COLUMNS) {
            for (sum, &pixel) in columns.iter_mut().zip(row) {
                *sum += u32::from(pixel);
            }
        }
        let mut moments = Moments::default();
        for (column, &sum) in columns.iter().enumerate() {
            moments.area += u64::from(sum);
            moments.doubled += u64::from(sum) * (2 * column + 1) as u64;
        }
        moments
    }

    /// Makes a frame of the columns from `left` on, those outside of the window being empty;
    /// their area in the unit of [`Self::moments`].
    pub fn cut(&self, left: isize, frame: &mut Frame) -> u64 {
        if self.anti_alias {
            let mut coverage = Coverage::empty(self.size);
            let area = self.cut_coverage(left, &mut coverage);
            *frame = Frame::Grey(coverage);
            return area;
        }
        let mut silhouette = Silhouette::empty(self.size);
        let area = self.cut_silhouette(left, &mut silhouette);
        *frame = Frame::Binary(silhouette);
        area
    }

    fn cut_coverage(&self, left: isize, coverage: &mut Coverage) -> u64 {
        let columns = self.size.columns();
        let mut area = 0;
        let out = coverage.pixels_mut().chunks_exact_mut(columns);
        for (row, out) in self.mask.data().chunks_exact(SKIA_WINDOW_COLUMNS).zip(out) {
            for (column, pixel) in out.iter_mut().enumerate() {
                *pixel = shown(row, left, column);
                area += u64::from(*pixel);
            }
        }
        area
    }

    /// [`Self::cut`] of pixels that are on or off.
    pub fn cut_silhouette(&self, left: isize, silhouette: &mut Silhouette) -> u64 {
        let mut area = 0;
        let out = silhouette.all_rows_mut().iter_mut();
        for (row, out) in self.mask.data().chunks_exact(SKIA_WINDOW_COLUMNS).zip(out) {
            *out = 0;
            for column in 0..self.size.columns() {
                let pixel = shown(row, left, column);
                *out |= u64::from(pixel >= 128) << column;
                area += u64::from(pixel);
            }
        }
        area
    }

    /// Adds a convex outline in pixel coordinates, which must lie within a pixel of
    /// the window. An outline of fewer than three corners covers nothing.
    fn fill(&mut self, outline: &Outline) {
        let [first, rest @ ..] = outline.as_slice() else {
            return;
        };
        if rest.len() < 2 {
            return;
        }
        let mut builder = self
            .path
            .take()
            .unwrap_or_else(|| PathBuilder::with_capacity(MAX_OUTLINE + 2, MAX_OUTLINE + 1));
        builder.move_to(first.x, first.y);
        for corner in rest {
            builder.line_to(corner.x, corner.y);
        }
        builder.close();
        if let Some(path) = builder.finish() {
            self.mask.fill_path(
                &path,
                FillRule::Winding,
                self.anti_alias,
                Transform::identity(),
            );
            self.path = Some(path.clear());
        }
    }
}

/// The pixel in this column of a picture that begins at column `left` of a window's row.
fn shown(row: &[u8], left: isize, column: usize) -> u8 {
    let source = left.checked_add_unsigned(column);
    let source = source.and_then(|at| row.get(usize::try_from(at).ok()?));
    source.copied().unwrap_or(0)
}

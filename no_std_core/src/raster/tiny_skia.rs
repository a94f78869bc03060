//! Filling of outlines with tiny-skia. Only this file uses it.
//!
//! Hulls are filled one by one, so that tiny-skia's allocations for a fill are bounded by a
//! constant, [`crate::budget::SKIA_TRANSIENT_BYTES`].

use super::moments::AreaMoments;
use super::placement::{Extent, Placement};
use super::skia::outline_in_window;
use super::window::{Fill, Pixels, PosedHulls};
use super::{DrawError, Rasterizer};
use crate::budget::{MAX_OUTLINE, SKIA_WINDOW_COLUMNS};
use crate::camera::Camera;
use crate::outline::Outline;
use crate::silhouette::{Coverage, Silhouette, Size};
use core::marker::PhantomData;
use tiny_skia::{FillRule, Mask, PathBuilder, Transform};

/// tiny-skia's window, of 64 columns: with anti-aliasing if the image is a [`Coverage`]. Without it,
/// [`Rasterizer::Skia`] draws the same pixels in less time. Figures may be unpacked or compact.
#[derive(Debug)]
pub struct TinySkia<I = Silhouette> {
    mask: Mask,
    size: Size,
    /// Kept between fills, so that paths reuse one buffer.
    path: Option<PathBuilder>,
    image: PhantomData<I>,
}

impl TinySkia {
    /// Makes an empty window of one sample a pixel; allocates 64 bytes a row.
    #[must_use]
    pub fn new(size: Size) -> Self {
        Self::empty(size)
    }
}

impl TinySkia<Coverage> {
    /// Makes an empty window of 4x4 samples a pixel; allocates 64 bytes a row.
    #[must_use]
    pub fn anti_aliased(size: Size) -> Self {
        Self::empty(size)
    }
}

impl<I: CutImage> TinySkia<I> {
    fn empty(size: Size) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "64 by at most 64")]
        let mask = Mask::new(SKIA_WINDOW_COLUMNS as u32, size.rows() as u32);
        Self {
            // tiny-skia rejects only sizes of zero and above 2^31.
            mask: mask.expect("64 by at most 64 pixels"),
            size,
            path: None,
            image: PhantomData,
        }
    }

    /// Returns the pixels of each row.
    #[cfg(test)]
    pub(super) fn rows(&self) -> impl Iterator<Item = &[u8]> {
        self.mask.data().chunks_exact(SKIA_WINDOW_COLUMNS)
    }

    /// Adds a convex outline in pixel coordinates, which must lie within a pixel of
    /// the window. An outline of fewer than three corners covers nothing.
    pub(super) fn fill(&mut self, outline: &Outline) {
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
            self.mask
                .fill_path(&path, FillRule::Winding, I::IS_GREY, Transform::identity());
            self.path = Some(path.clear());
        }
    }
}

impl<I: CutImage> Pixels for TinySkia<I> {
    type Image = I;
    const NEEDS_FACETS: bool = false;
    const IS_GREY: bool = I::IS_GREY;

    fn blank(&self) -> I {
        I::empty(self.size)
    }

    fn rasterizer(&self) -> Rasterizer {
        I::RASTERIZER
    }

    fn size(&self) -> Size {
        self.size
    }

    fn width(&self) -> usize {
        SKIA_WINDOW_COLUMNS
    }

    fn columns(&self, _: f32) -> usize {
        SKIA_WINDOW_COLUMNS
    }

    fn clear(&mut self) {
        self.mask.data_mut().fill(0);
    }

    fn moments(&self) -> AreaMoments {
        // Sums of columns first: additions of whole rows vectorise.
        let mut columns = [0u32; SKIA_WINDOW_COLUMNS];
        for row in self.mask.data().chunks_exact(SKIA_WINDOW_COLUMNS) {
            for (sum, &pixel) in columns.iter_mut().zip(row) {
                *sum += u32::from(pixel);
            }
        }
        let mut moments = AreaMoments::default();
        for (column, &sum) in columns.iter().enumerate() {
            moments.area += u64::from(sum);
            moments.doubled += u64::from(sum) * (2 * column + 1) as u64;
        }
        moments
    }

    /// Cuts out columns; those outside the window are empty.
    fn cut(&self, left: isize, image: &mut I) -> u64 {
        let rows = self.mask.data().chunks_exact(SKIA_WINDOW_COLUMNS);
        image.cut(rows, left)
    }
}

impl<F: PosedHulls, I: CutImage> Fill<F> for TinySkia<I> {
    fn extent(&mut self, figure: &F, camera: &Camera) -> Result<Extent, DrawError> {
        figure.extent(camera)
    }

    fn draw(&mut self, figure: &F, camera: &Camera, _: usize, placement: &Placement, _: usize) {
        self.clear();
        for hull in figure.hulls() {
            let pixels = hull.map(|point| placement.place(camera.project(point)));
            let outline = outline_in_window(pixels, self.size.rows());
            self.fill(&outline);
        }
    }
}

/// An image that is cut out of tiny-skia's window.
pub trait CutImage {
    const RASTERIZER: Rasterizer;
    const IS_GREY: bool;

    fn empty(size: Size) -> Self;

    /// Copies the columns from `left` on of the window's rows, and returns the sum of their pixels.
    fn cut<'a>(&mut self, rows: impl Iterator<Item = &'a [u8]>, left: isize) -> u64;
}

impl CutImage for Silhouette {
    const RASTERIZER: Rasterizer = Rasterizer::TinySkia;
    const IS_GREY: bool = false;

    fn empty(size: Size) -> Self {
        Self::empty(size)
    }

    fn cut<'a>(&mut self, rows: impl Iterator<Item = &'a [u8]>, left: isize) -> u64 {
        let (columns, mut area) = (self.size().columns(), 0);
        for (row, out) in rows.zip(self.all_rows_mut()) {
            *out = 0;
            for column in 0..columns {
                let pixel = shown(row, left, column);
                *out |= u64::from(pixel >= 128) << column;
                area += u64::from(pixel);
            }
        }
        area
    }
}

impl CutImage for Coverage {
    const RASTERIZER: Rasterizer = Rasterizer::SkiaAa;
    const IS_GREY: bool = true;

    fn empty(size: Size) -> Self {
        Self::empty(size)
    }

    fn cut<'a>(&mut self, rows: impl Iterator<Item = &'a [u8]>, left: isize) -> u64 {
        let (columns, mut area) = (self.size().columns(), 0);
        for (row, out) in rows.zip(self.pixels_mut().chunks_exact_mut(columns)) {
            for (column, pixel) in out.iter_mut().enumerate() {
                *pixel = shown(row, left, column);
                area += u64::from(*pixel);
            }
        }
        area
    }
}

/// Returns the pixel in this column of an image that begins at column `left` of a window's row.
fn shown(row: &[u8], left: isize, column: usize) -> u8 {
    let source = left.checked_add_unsigned(column);
    let source = source.and_then(|at| row.get(usize::try_from(at).ok()?));
    source.copied().unwrap_or(0)
}

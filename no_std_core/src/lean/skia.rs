//! tiny-skia's window, filled hull by hull.

use super::body::Sight;
use super::fill::Fill;
use crate::budget::{SKIA_EDGES_BYTES, SKIA_WINDOW_COLUMNS, skia_resident_bytes};
use crate::raster::framing::Moments;
use crate::raster::place::Placement;
use crate::raster::skia::Window;
use crate::silhouette::{Silhouette, Size};

/// tiny-skia without anti-aliasing, as [`crate::raster::Rasterizer::Skia`] draws.
#[derive(Debug)]
pub struct Skia(Window);

impl Fill for Skia {
    const NEEDS_FACETS: bool = false;
    const WIDTH: usize = SKIA_WINDOW_COLUMNS;

    fn new(size: Size) -> Self {
        Self(Window::new(size, false))
    }

    fn heap_bytes(size: Size) -> usize {
        skia_resident_bytes(size.rows()) + SKIA_EDGES_BYTES
    }

    fn columns(_: f32) -> usize {
        SKIA_WINDOW_COLUMNS
    }

    fn draw(&mut self, sight: &Sight<'_>, placement: &Placement, _: usize) {
        self.0.clear();
        for hull in sight.hulls() {
            self.0.fill_hull(sight.pixels(&hull, placement));
        }
    }

    fn clear(&mut self) {
        self.0.clear();
    }

    fn moments(&self) -> Moments {
        self.0.moments()
    }

    fn cut(&self, left: isize, silhouette: &mut Silhouette) -> u64 {
        self.0.cut_silhouette(left, silhouette)
    }
}

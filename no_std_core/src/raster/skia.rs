//! Filling outlines with tiny-skia: the only file that names it.
//!
//! Hulls are filled one by one, so that what tiny-skia allocates for a fill is a
//! constant; [`crate::budget::SKIA_TRANSIENT_BYTES`] sums it.

use crate::budget::{MAX_OUTLINE, ROWS, WINDOW_COLUMNS};
use crate::outline::Outline;
use tiny_skia::{FillRule, Mask, PathBuilder, Transform};

/// A window of 128 by 50 pixels to draw into.
#[derive(Debug)]
pub struct Window {
    mask: Mask,
    /// Kept between fills, so that paths reuse one buffer.
    path: Option<PathBuilder>,
    anti_alias: bool,
}

impl Window {
    /// An empty window; `anti_alias` takes 4x4 samples a pixel instead of one.
    pub fn new(anti_alias: bool) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "128 by 50")]
        let mask = Mask::new(WINDOW_COLUMNS as u32, ROWS as u32);
        Self {
            // tiny-skia refuses only sizes of zero and above 2^31.
            mask: mask.expect("128 by 50 pixels"),
            path: None,
            anti_alias,
        }
    }

    /// Coverage row by row from the top, 128 columns a row.
    pub fn pixels(&self) -> &[u8] {
        self.mask.data()
    }

    /// Empties the window.
    pub fn clear(&mut self) {
        self.mask.data_mut().fill(0);
    }

    /// Adds a convex outline in pixel coordinates, which must lie within a pixel of
    /// the window. An outline of fewer than three corners covers nothing.
    pub fn fill(&mut self, outline: &Outline) {
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

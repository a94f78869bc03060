//! The renderers of a sweep by columns.

use edgegait_core::raster::Renderer;
use edgegait_core::raster::columns;

/// The renderers of one frame at all elevations of an azimuth.
pub(super) struct SweepColumns {
    pub(super) columns: columns::ColumnRenderer,
    /// The renderer that measures the share of a figure outside of an image.
    pub(super) measure: Renderer,
}

//! The images of one frame and azimuth, by columns.

use edgegait_core::raster::Renderer;
use edgegait_core::raster::columns;

/// What draws by columns.
pub(super) struct SweepColumns {
    pub(super) columns: columns::ColumnRenderer,
    /// Tells which share of a figure lies outside of an image.
    pub(super) measure: Renderer,
}

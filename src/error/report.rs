//! Errors about reports.

use super::Cause;

/// An error in making a picture or a page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The font that pictures are labelled in cannot be read.
    #[error("cannot write on a picture: {0}")]
    Font(Cause),
    /// A picture cannot be encoded.
    #[error("png: {0}")]
    Png(#[source] image::ImageError),
    /// An animation cannot be encoded.
    #[error("gif: {0}")]
    Gif(#[source] gif::EncodingError),
    /// A sheet has nothing on it.
    #[error("{expected}, found {cells} and {across}")]
    Empty {
        /// The sheet, and its expected contents.
        expected: &'static str,
        /// Number of cells below each other.
        cells: usize,
        /// Number of cells side by side.
        across: usize,
    },
    /// A contact sheet has no images, or no scale.
    #[error(
        "contact sheet: expected at least one image and a scale of at least 1, within 16,384 pixels a side, found {rows} rows of {columns} images at scale {scale}"
    )]
    NoImages {
        /// Rows of images.
        rows: usize,
        /// Images in the longest row.
        columns: usize,
        /// Side of an image's pixel on the sheet, pixels.
        scale: u32,
    },
    /// A picture's number of bytes is not its number of pixels.
    #[error("expected {rows} x {columns} bytes of a picture")]
    Bytes {
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
    },
}

//! Why results are not shown.

use super::Cause;

/// What a picture or a page cannot be made of.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The font that pictures are labelled in cannot be read.
    #[error("cannot write on a picture: {0}")]
    Font(Cause),
    /// A picture cannot be encoded.
    #[error("png: {0}")]
    Png(#[source] image::ImageError),
    /// A sheet has nothing on it.
    #[error("{expected}, found {cells} and {across}")]
    Empty {
        /// The sheet, and what it has of both.
        expected: &'static str,
        /// What it has below each other.
        cells: usize,
        /// What it has side by side.
        across: usize,
    },
    /// A contact sheet has no images, or no scale.
    #[error(
        "contact sheet: expected images and a scale of at least 1 in 64 Mi pixels, found {rows} rows of {columns} at scale {scale}"
    )]
    NoImages {
        /// Rows of images.
        rows: usize,
        /// Images in the longest.
        columns: usize,
        /// Pixels of each side of an image's pixel.
        scale: u32,
    },
    /// A contact sheet is too large.
    #[error(
        "contact sheet: expected at most 64 Mi pixels, found {width} x {height} (take fewer images or a smaller scale)"
    )]
    TooLarge {
        /// Its pixels across.
        width: u32,
        /// Its pixels down.
        height: u32,
    },
    /// A picture has not as many bytes as pixels.
    #[error("expected {rows} x {columns} bytes of a picture")]
    Bytes {
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
    },
}

//! The Gait Energy Image: the mean silhouette of a gait cycle.
//!
//! The averaging is in `frame_sums.rs`, on boards in `in_place.rs`, and for the column rasteriser
//! in `elevation_tally.rs`.

use crate::budget::MAX_PIXELS;
use crate::silhouette::Size;

/// A Gait Energy Image (Han & Bhanu 2006, equation 1): the share of frames in
/// which each pixel is on, 0..=255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gei {
    size: Size,
    /// Bytes beyond the size are zero.
    pixels: [u8; MAX_PIXELS],
}

impl Gei {
    /// Makes a GEI from means of pixels, which are zero beyond the size.
    pub(super) const fn from_means(size: Size, pixels: [u8; MAX_PIXELS]) -> Self {
        Self { size, pixels }
    }

    /// Returns the rows and columns.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Returns the pixels row by row from the top, as many bytes as the size has pixels.
    #[must_use]
    pub fn pixels(&self) -> &[u8] {
        self.pixels.get(..self.size.pixels()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::silhouette::{AnySilhouette, Silhouette};
    use crate::template::{FrameError, GeiBuilder};

    fn frame(size: Size, rows: [u64; 2]) -> AnySilhouette {
        AnySilhouette::Binary(Silhouette::from_rows(size, &rows))
    }

    #[test]
    fn a_gei_is_the_mean_of_its_frames() {
        // The four frames [[1,0],[0,1]], [[1,1],[0,0]], [[1,0],[0,1]], [[1,1],[0,1]]
        // have the mean [[1, 0.5], [0, 0.75]]; bit 0 is the left column.
        for size in Size::ALL {
            let mut builder = GeiBuilder::new(size);
            for rows in [[0b01, 0b10], [0b11, 0b00], [0b01, 0b10], [0b11, 0b10]] {
                builder.add(&frame(size, rows)).expect("room");
            }
            let gei = builder.gei();
            assert_eq!((builder.frames(), gei.size()), (4, size));
            assert_eq!(gei.pixels().len(), size.pixels());
            assert_eq!(gei.pixels()[..3], [255, 128, 0]); // 127.5 rounds up
            assert_eq!(gei.pixels()[size.columns()..][..3], [0, 191, 0]); // 191.25
        }
    }

    #[test]
    fn without_frames_a_gei_is_black_and_other_sizes_are_refused() {
        let mut builder = GeiBuilder::new(Size::S64x44);
        let refused = builder.add(&frame(Size::S64x64, [1, 1]));
        let (expected, found) = (Size::S64x44, Size::S64x64);
        assert_eq!(refused, Err(FrameError::Size { expected, found }));
        assert_eq!(builder.frames(), 0);
        assert_eq!(builder.gei().pixels(), [0; 64 * 44]);
    }
}

//! Frames a figure in a picture, as the core frames the figures that it draws.

use crate::draw::sweep::FramingMode;
use crate::error::{Error, Result};
use edgegait_core::silhouette::{Silhouette, Size};

/// The lowest grey value of the figure. Our choice: half of 255, rounded up.
const ON: u8 = 128;

/// A grey picture, rows from the top.
pub(super) struct GreyPicture<'a> {
    pub pixels: &'a [u8],
    pub columns: usize,
}

/// The framings that pictures can be brought into.
#[derive(Clone, Copy)]
pub(super) enum PictureFraming {
    Height,
    Box,
}

impl PictureFraming {
    pub(super) fn from_mode(framing: FramingMode) -> Result<Self> {
        match framing {
            FramingMode::Height => Ok(Self::Height),
            FramingMode::Box => Ok(Self::Box),
            FramingMode::Cycle | FramingMode::Camera => Err(Error::Usage(format!(
                "framing {}: it depends on the camera's position, which a tree of silhouettes does not state (use height or box)",
                framing.name()
            ))),
        }
    }
}

/// The figure's first and last row and column.
struct FigureBounds {
    top: usize,
    bottom: usize,
    left: usize,
    right: usize,
}

impl GreyPicture<'_> {
    fn is_on(&self, row: usize, column: usize) -> bool {
        self.pixels[row * self.columns + column] >= ON
    }

    fn bounds(&self) -> Option<FigureBounds> {
        let mut found: Option<FigureBounds> = None;
        for (row, pixels) in self.pixels.chunks_exact(self.columns).enumerate() {
            let on = |pixel: &u8| *pixel >= ON;
            let (Some(left), Some(right)) =
                (pixels.iter().position(on), pixels.iter().rposition(on))
            else {
                continue;
            };
            let bounds = found.get_or_insert(FigureBounds {
                top: row,
                bottom: row,
                left,
                right,
            });
            bounds.bottom = row;
            bounds.left = bounds.left.min(left);
            bounds.right = bounds.right.max(right);
        }
        found
    }

    /// Appends the framed figure as 0 and 255, `[rows][columns]`. Returns the share of it that is
    /// cut off at the sides, 0..1, or `None` if there is no figure; then nothing is appended.
    ///
    /// Each pixel samples the picture at its centre. With the framing by height, the figure is
    /// scaled to fill all rows. The midpoint of its leftmost and rightmost columns is placed
    /// between two columns, and the figure is shifted by whole columns until the centroid of its
    /// pixels (centres at i + 0.5, rounded half up) is in the middle. The arithmetic is in
    /// integers and therefore exact.
    pub(super) fn frame(&self, size: Size, fit: PictureFraming, into: &mut Vec<u8>) -> Option<f64> {
        let bounds = self.bounds()?;
        let (rows, columns) = (size.rows(), size.columns());
        let height = bounds.bottom + 1 - bounds.top;
        let row = |target: usize| bounds.top + (2 * target + 1) * height / (2 * rows);
        if let PictureFraming::Box = fit {
            let width = bounds.right + 1 - bounds.left;
            let column = |target: usize| bounds.left + (2 * target + 1) * width / (2 * columns);
            let start = into.len();
            for target in 0..rows {
                let pixels = (0..columns).map(|at| self.is_on(row(target), column(at)));
                into.extend(pixels.map(grey));
            }
            if !into[start..].contains(&255) {
                into.truncate(start);
                return None;
            }
            return Some(0.0);
        }

        let signed = usize::cast_signed;
        // Column `at` right of the figure's middle, in the picture's columns.
        let column = |at: isize| {
            let middle = signed(bounds.left + bounds.right + 1) * signed(rows);
            let found = (middle + (2 * at + 1) * signed(height)).div_euclid(2 * signed(rows));
            let inside = signed(bounds.left)..=signed(bounds.right);
            inside.contains(&found).then(|| found.cast_unsigned())
        };
        let half = signed((bounds.right + 1 - bounds.left) * rows / (2 * height) + 1);
        let (mut area, mut doubled) = (0_isize, 0_isize);
        for target in 0..rows {
            for at in -half..half {
                if column(at).is_some_and(|column| self.is_on(row(target), column)) {
                    area += 1;
                    doubled += 2 * at + 1;
                }
            }
        }
        if area == 0 {
            return None;
        }
        let centroid = (doubled + area).div_euclid(2 * area);
        let left = centroid - signed(columns / 2);
        let start = into.len();
        for target in 0..rows {
            let is_on =
                |at| column(left + at).is_some_and(|column| self.is_on(row(target), column));
            into.extend((0..signed(columns)).map(is_on).map(grey));
        }
        let kept = into[start..].iter().filter(|pixel| **pixel > 0).count();
        #[expect(clippy::cast_precision_loss, reason = "a share")]
        let clipped = 1.0 - kept as f64 / area as f64;
        Some(clipped)
    }
}

/// Frames a grey picture with this number of columns, like
/// [`Tree::silhouettes`](super::Tree::silhouettes); none if there is no figure.
///
/// # Errors
/// If the framing needs a camera.
///
/// # Panics
/// If the pixels do not fill rows.
pub fn framed(
    pixels: &[u8],
    columns: usize,
    size: Size,
    framing: FramingMode,
) -> Result<Option<Silhouette>> {
    let mut found = Vec::with_capacity(size.pixels());
    let picture = GreyPicture { pixels, columns };
    if picture
        .frame(size, PictureFraming::from_mode(framing)?, &mut found)
        .is_none()
    {
        return Ok(None);
    }
    let bits = |row: &[u8]| {
        let on = (0..).zip(row).filter(|(_, pixel)| **pixel > 0);
        on.fold(0_u64, |bits, (column, _)| bits | 1 << column)
    };
    let rows: Vec<u64> = found.chunks_exact(size.columns()).map(bits).collect();
    Ok(Some(Silhouette::from_rows(size, &rows)))
}

fn grey(is_on: bool) -> u8 {
    if is_on { 255 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a picture from text, in which `#` is on.
    fn picture(text: &[&str]) -> (Vec<u8>, usize) {
        let pixels = text
            .iter()
            .flat_map(|row| row.bytes().map(|c| grey(c == b'#')));
        (pixels.collect(), text[0].len())
    }

    fn framed(pixels: &[u8], columns: usize, size: Size, fit: PictureFraming) -> (Vec<u8>, f64) {
        let mut into = Vec::new();
        let clipped = GreyPicture { pixels, columns }.frame(size, fit, &mut into);
        (into, clipped.expect("a figure"))
    }

    /// Returns the first and last columns that are on in a row.
    fn span(pixels: &[u8], size: Size, row: usize) -> Option<(usize, usize)> {
        let row = &pixels[row * size.columns()..(row + 1) * size.columns()];
        let on = |pixel: &u8| *pixel == 255;
        Some((row.iter().position(on)?, row.iter().rposition(on)?))
    }

    #[test]
    fn a_small_figure_fills_the_rows_with_its_centroid_in_the_middle() {
        let (pixels, columns) = picture(&[
            "..........", //
            ".......#..",
            "......###.",
            "..........",
        ]);
        let (framed, clipped) = framed(&pixels, columns, Size::S50x30, PictureFraming::Height);
        // Scaled by 25: one column becomes 25, three become 75, of which 30 fit.
        assert_eq!(framed.len(), 1500);
        assert_eq!(span(&framed, Size::S50x30, 0), Some((2, 26)));
        assert_eq!(span(&framed, Size::S50x30, 24), Some((2, 26)));
        assert_eq!(span(&framed, Size::S50x30, 25), Some((0, 29)));
        assert!((clipped - 45.0 / 100.0).abs() < 1e-12, "{clipped}");
    }

    #[test]
    fn a_figure_of_the_right_height_is_only_moved() {
        let size = Size::S64x64;
        // A bar of 3 columns and 64 rows, with 30 more columns to the right in the lowest row.
        let mut pixels = vec![0; 64 * 90];
        for row in 0..64 {
            let end = if row == 63 { 43 } else { 13 };
            pixels[row * 90 + 10..row * 90 + end].fill(255);
        }
        let (framed, clipped) = framed(&pixels, 90, size, PictureFraming::Height);
        // Centroid: (63 * 3 * 1.5 + 33 * 16.5) / 222 = 3.73 right of column 10, which
        // rounds to 4, so column 10 moves to 32 - 4.
        assert_eq!(span(&framed, size, 0), Some((28, 30)));
        assert_eq!(span(&framed, size, 63), Some((28, 60)));
        let area = framed.iter().filter(|pixel| **pixel == 255).count();
        assert_eq!((area, clipped), (63 * 3 + 33, 0.0));
    }

    #[test]
    fn a_large_figure_is_sampled_at_pixel_centres() {
        // 192 rows become 64: the middle one of three rows and columns counts.
        let mut pixels = vec![0; 192 * 192];
        for row in 0..192 {
            for column in 30..150 {
                let is_middle = row % 3 == 1 && column % 3 == 1;
                pixels[row * 192 + column] =
                    grey(is_middle || row == 0 || row == 191 || column == 30 || column == 149);
            }
        }
        let size = Size::S64x44;
        let (framed, clipped) = framed(&pixels, 192, size, PictureFraming::Height);
        // 120 / 3 = 40 columns, all on, in the middle of 44.
        for row in 0..64 {
            assert_eq!(span(&framed, size, row), Some((2, 41)));
        }
        let area = framed.iter().filter(|pixel| **pixel == 255).count();
        assert_eq!((area, clipped), (64 * 40, 0.0));
    }

    #[test]
    fn a_box_is_stretched_to_all_sides() {
        let (pixels, columns) = picture(&["....", ".##.", ".#..", "...."]);
        let (framed, clipped) = framed(&pixels, columns, Size::S50x30, PictureFraming::Box);
        assert_eq!(span(&framed, Size::S50x30, 24), Some((0, 29)));
        assert_eq!(span(&framed, Size::S50x30, 25), Some((0, 14)));
        assert_eq!(clipped, 0.0);
    }

    #[test]
    fn from_128_on_a_pixel_is_on_and_a_picture_without_any_is_empty() {
        for fit in [PictureFraming::Height, PictureFraming::Box] {
            let frame = |pixels: &[u8]| {
                let mut into = vec![7];
                let clipped =
                    GreyPicture { pixels, columns: 2 }.frame(Size::S50x30, fit, &mut into);
                (clipped.is_some(), into.len())
            };
            assert_eq!(frame(&[0, 127, 127, 0]), (false, 1));
            assert_eq!(frame(&[0, 127, 128, 0]), (true, 1501));
            assert_eq!(frame(&[]), (false, 1));
        }
    }

    #[test]
    fn framings_that_need_a_camera_are_refused() {
        for framing in [FramingMode::Cycle, FramingMode::Camera] {
            let error = PictureFraming::from_mode(framing)
                .err()
                .expect("refused")
                .to_string();
            assert!(error.contains("use height or box"), "{error}");
        }
    }
}

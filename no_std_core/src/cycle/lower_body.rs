//! The measurements of the legs in one frame.

use crate::silhouette::Silhouette;
use core::ops::Range;

/// The measurements of the legs in one frame, as shares of the figure's height. Pixels are square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LowerBody {
    /// The spread of the legs: the standard deviation of the columns of all pixels in the lowest
    /// third of the height; 0 if nobody is visible.
    pub spread: f32,
    /// The sway of the trunk over the feet: the mean column of the lowest quarter less that of the
    /// upper half.
    pub sway: f32,
}

/// Shares of the figure's height that are measured, as numerator and denominator. Our choice: among
/// half, third, quarter, fifth and sixth, the spread swings most steadily in the third from 18 and 90
/// degrees, and the sway of the quarter most steadily from in front. The width of the lowest fifth,
/// which needs one faulty pixel to be wrong, swings a third as steadily in degraded masks.
const THIRD: (usize, usize) = (1, 3);
const QUARTER: (usize, usize) = (1, 4);
const HALF: (usize, usize) = (1, 2);

impl LowerBody {
    /// Measures a silhouette; `None` if no pixel is on.
    #[must_use]
    pub fn measure(silhouette: &Silhouette) -> Option<Self> {
        let rows = silhouette.rows();
        let is_on = |row: &u64| *row != 0;
        let top = rows.iter().position(is_on)?;
        let bottom = rows.iter().rposition(is_on)? + 1;
        let columns = |from, to| {
            let mut columns = ColumnSums::default();
            for row in rows.get(from..to).unwrap_or_default() {
                let mut left = *row;
                while left != 0 {
                    columns.add(left.trailing_zeros());
                    left &= left - 1;
                }
            }
            columns
        };
        Some(Self::new(top..bottom, columns))
    }

    /// Measures an image, `[rows][columns]`, of a camera or a tree; pixels of 128 and more are on.
    /// `None` if none is on, or if there are no columns. Ignores an incomplete last row.
    #[must_use]
    pub fn of_pixels(pixels: &[u8], columns: usize) -> Option<Self> {
        const ON: u8 = 128;
        if columns == 0 {
            return None;
        }
        let rows = || pixels.chunks_exact(columns);
        let is_on = |row: &[u8]| row.iter().any(|&pixel| pixel >= ON);
        let top = rows().position(is_on)?;
        let bottom = rows().rposition(is_on)? + 1;
        let columns = |from: usize, to: usize| {
            let mut columns = ColumnSums::default();
            for row in rows().take(to).skip(from) {
                for (column, pixel) in (0..).zip(row) {
                    if *pixel >= ON {
                        columns.add(column);
                    }
                }
            }
            columns
        };
        Some(Self::new(top..bottom, columns))
    }

    /// Measures a figure in these rows; `columns` sums the columns of the pixels in a range of rows.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "fewer than 2^53 rows; the measurements need no more than 24 bits"
    )]
    fn new(rows: Range<usize>, columns: impl Fn(usize, usize) -> ColumnSums) -> Self {
        let Range { start: top, end } = rows;
        let height = (end - top) as f64;
        let from = |share| start(top, end, share);
        let third = columns(from(THIRD), end);
        let quarter = columns(from(QUARTER), end);
        let upper = columns(top, from(HALF));
        let sway = match (quarter.mean(), upper.mean()) {
            (Some(feet), Some(trunk)) => (feet - trunk) / height,
            _ => 0.0,
        };
        Self {
            spread: (third.deviation() / height) as f32,
            sway: sway as f32,
        }
    }

    /// Returns whether a person is visible, with plausible numbers.
    pub(super) fn is_somebody(&self) -> bool {
        // A figure is less than a thousand times as wide as high, whatever it is.
        const MOST: f32 = 1e3;
        self.spread > 0.0 && self.spread < MOST && self.sway.abs() < MOST
    }
}

/// Sums over the columns of pixels.
#[derive(Default)]
struct ColumnSums {
    pixels: u64,
    sum: u64,
    squares: u64,
}

impl ColumnSums {
    fn add(&mut self, column: u32) {
        let column = u64::from(column);
        self.pixels += 1;
        self.sum += column;
        self.squares = self.squares.saturating_add(column * column);
    }

    /// Returns the mean column; `None` without pixels.
    #[expect(
        clippy::cast_precision_loss,
        reason = "exact below 2^53, the sum of 94 million pixels"
    )]
    fn mean(&self) -> Option<f64> {
        (self.pixels > 0).then(|| self.sum as f64 / self.pixels as f64)
    }

    /// Returns the standard deviation of the columns; 0 without pixels.
    #[expect(clippy::cast_precision_loss, reason = "as for the mean")]
    fn deviation(&self) -> f64 {
        let Some(mean) = self.mean() else { return 0.0 };
        let variance = self.squares as f64 / self.pixels as f64 - mean * mean;
        libm::sqrt(variance.max(0.0))
    }
}

/// Returns the first row of the lowest share of the rows `top..bottom`.
const fn start(top: usize, bottom: usize, (part, of): (usize, usize)) -> usize {
    // Whole rows in the share, at least one.
    let rows = (bottom - top) * part / of;
    bottom - if rows == 0 { 1 } else { rows }
}

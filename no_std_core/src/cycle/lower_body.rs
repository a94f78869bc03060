//! The measurements of the legs in one frame.

use crate::silhouette::Silhouette;

/// The measurements of the legs in one frame, in pixels of an image of any size. Only their changes
/// matter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LowerBody {
    /// Pixels that are on in the lowest third of the figure's height; 0 if nobody is visible.
    pub pixels: f32,
    /// Columns from the leftmost to the rightmost pixel in the lowest fifth of the height, both
    /// included; 0 if unknown.
    pub width: f32,
}

/// Shares of the figure's height that are measured, as numerator and denominator. Our choice: among
/// the people used for tuning, of the half, the third and the fifth, pixels swing most steadily in
/// the third and the width in the fifth.
const THIRD: (usize, usize) = (1, 3);
const FIFTH: (usize, usize) = (1, 5);

impl LowerBody {
    /// Makes the measurements from a count of pixels alone, as a simple sensor may give it; 0 if
    /// nobody is visible. Works well from the side.
    #[must_use]
    pub const fn counted(pixels: f32) -> Self {
        Self { pixels, width: 0.0 }
    }

    /// Measures a silhouette; `None` if no pixel is on.
    #[must_use]
    pub fn measure(silhouette: &Silhouette) -> Option<Self> {
        let rows = silhouette.rows();
        let is_on = |row: &u64| *row != 0;
        let top = rows.iter().position(is_on)?;
        let bottom = rows.iter().rposition(is_on)? + 1;
        let lowest = |share| rows.get(start(top, bottom, share)..bottom);
        let on: u32 = lowest(THIRD)?.iter().map(|row| row.count_ones()).sum();
        let all = lowest(FIFTH)?.iter().fold(0, |all, row| all | row);
        Some(Self::new(
            on,
            64_u32.saturating_sub(all.leading_zeros() + all.trailing_zeros()),
        ))
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
        let lowest = |share| {
            let from = start(top, bottom, share);
            rows().skip(from).take(bottom - from)
        };
        let on = lowest(THIRD).flatten().filter(|&&pixel| pixel >= ON);
        let on = u32::try_from(on.count()).unwrap_or(u32::MAX);
        let ends = lowest(FIFTH).filter_map(|row| {
            let left = row.iter().position(|&pixel| pixel >= ON)?;
            let right = row.iter().rposition(|&pixel| pixel >= ON)?;
            Some((left, right + 1))
        });
        let ends = ends.reduce(|(left, right), (l, r)| (left.min(l), right.max(r)));
        let width = ends.map_or(0, |(left, right)| right - left);
        Some(Self::new(on, u32::try_from(width).unwrap_or(u32::MAX)))
    }

    #[expect(
        clippy::cast_precision_loss,
        reason = "beyond 2^24 pixels the last one does not matter"
    )]
    const fn new(pixels: u32, width: u32) -> Self {
        Self {
            pixels: pixels as f32,
            width: width as f32,
        }
    }

    /// Returns whether a person is visible, with plausible numbers.
    pub(super) fn is_somebody(&self) -> bool {
        // Squares of these are far from overflow in f32.
        let plausible = |value: f32| (0.0..=1e12).contains(&value);
        self.pixels > 0.0 && plausible(self.pixels) && plausible(self.width)
    }
}

/// Returns the first row of the lowest share of the rows `top..bottom`.
const fn start(top: usize, bottom: usize, (part, of): (usize, usize)) -> usize {
    // Whole rows in the share, at least one.
    let rows = (bottom - top) * part / of;
    bottom - if rows == 0 { 1 } else { rows }
}

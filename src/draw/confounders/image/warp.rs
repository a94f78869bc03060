//! Pictures whose samples are moved smoothly.

use super::picture::{BitPicture, SampleBounds};
use glam::DVec2;

/// Spacing of the samples whose source is computed; the others are interpolated linearly, with
/// an error below 0.01 samples.
const STEP: usize = 8;

/// Samples around the figure into which it may be moved.
const REACH: usize = 42;

/// Returns a picture each of whose samples shows what is at `source` of its middle in another
/// picture, which is on within `bounds` alone.
pub(super) fn warped(
    picture: &BitPicture,
    bounds: SampleBounds,
    source: impl Fn(DVec2) -> DVec2,
) -> BitPicture {
    let rows = bounds.top.saturating_sub(REACH)..(bounds.bottom + REACH).min(picture.rows());
    let columns = bounds.left.saturating_sub(REACH)..(bounds.right + REACH).min(picture.columns());
    let start = DVec2::new(bounds.left as f64, bounds.top as f64) - 1.0;
    let end = DVec2::new(bounds.right as f64, bounds.bottom as f64) + 1.0;
    let mut bent = BitPicture::empty(picture.rows(), picture.columns() / 64);
    // The sources of the corners of blocks, for one row of corners.
    let corners = |row: usize| -> Vec<DVec2> {
        let end = columns.end + STEP;
        let columns = (columns.start..end).step_by(STEP);
        columns
            .map(|column| source(DVec2::new(column as f64 + 0.5, row as f64 + 0.5)))
            .collect()
    };
    let mut upper = corners(rows.start);
    for top in rows.clone().step_by(STEP) {
        let bottom = top + STEP;
        let lower = corners(bottom);
        let blocks = columns.clone().step_by(STEP);
        for (left, (upper, lower)) in blocks.zip(upper.windows(2).zip(lower.windows(2))) {
            let right = left + STEP;
            let corners = [upper[0], upper[1], lower[0], lower[1]];
            // Blocks whose source is background stay off.
            let low = corners[1..].iter().fold(corners[0], |low, at| low.min(*at));
            let high = corners[1..]
                .iter()
                .fold(corners[0], |high, at| high.max(*at));
            if low.cmpge(end).any() || high.cmplt(start).any() {
                continue;
            }
            let (bottom, right) = (bottom.min(rows.end), right.min(columns.end));
            match all(picture, low, high) {
                Some(false) => continue,
                Some(true) => {
                    for row in top..bottom {
                        bent.fill(row, left.cast_signed(), right.cast_signed(), true);
                    }
                    continue;
                }
                None => {}
            }
            for row in top..bottom {
                let down = (row - top) as f64 / STEP as f64;
                let from = corners[0].lerp(corners[2], down);
                let to = corners[1].lerp(corners[3], down);
                let step = (to - from) / STEP as f64;
                let bent = bent.row_mut(row);
                let mut at = from;
                for column in left..right {
                    bent[column / 64] |= u64::from(is_on(picture, at)) << (column % 64);
                    at += step;
                }
            }
        }
        upper = lower;
    }
    bent
}

/// Returns whether all samples in a rectangle and around it are on (`true`) or off (`false`), or
/// `None` if they differ.
fn all(picture: &BitPicture, low: DVec2, high: DVec2) -> Option<bool> {
    // One more sample on each side covers rounding.
    let (low, high) = (low - 1.0, high + 2.0);
    // NaN fails the comparison.
    if !low.cmpge(DVec2::ZERO).all() {
        return None;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "samples of a picture"
    )]
    let [from, to] = [low, high].map(|at| (at.x as usize, at.y as usize));
    let width = to.0.checked_sub(from.0)?;
    let mut rows =
        (from.1..to.1.max(from.1 + 1)).map(|row| picture.count(row, from.0, to.0) as usize);
    let first = rows.next().filter(|&on| on == 0 || on == width)?;
    rows.all(|on| on == first).then_some(first > 0)
}

/// Returns whether the sample at a place is on.
fn is_on(picture: &BitPicture, at: DVec2) -> bool {
    // Fractions are cut off. Negative coordinates become so large that they lie outside.
    #[expect(clippy::cast_possible_truncation, reason = "samples of a picture")]
    let [column, row] = [at.x, at.y].map(|at| (at as i64).cast_unsigned() as usize);
    picture.is_on(row, column)
}

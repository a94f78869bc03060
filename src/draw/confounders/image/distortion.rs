//! Radial lens distortion (Brown 1966, 1971; Conrady 1919).
//!
//! A point that a perfect lens images at radius r from the optical axis, in focal lengths, is
//! imaged at r (1 + k1 r^2 + k2 r^4).

use super::fine::Fine;
use super::picture::BitPicture;
use glam::DVec2;

/// The figure's middle, focal lengths to the right of and below the optical axis, and the larger
/// of its height and width, focal lengths. Our choice: a figure near the border of an action
/// camera's image, 39 degrees off the axis, which takes half of the image's height.
const PLACE: DVec2 = DVec2::new(0.8, 0.2);
const HEIGHT: f64 = 0.7;

/// k1 at strength -1. Our choice, after action cameras.
const K1: f64 = 0.3;
/// k2 at strengths -1 and 1: enough for the distorted radius to grow with the radius.
const K2: f64 = 0.08;

/// Spacing of the samples whose source is computed; the others are interpolated linearly, with
/// an error below 0.01 samples.
const STEP: usize = 8;

/// Samples around the figure into which the distortion may move it.
const REACH: usize = 42;

/// Distorts a picture by a lens whose axis lies beside the figure: barrel distortion with
/// k1 = -0.3 and k2 = 0.08 at strength 1, pincushion distortion with k1 = 0.3 and k2 = 0.08 at
/// -1. k1 is proportional to the strength, k2 to its square. The figure's middle stays where it
/// is, and so does its size along its circle about the axis.
pub(crate) fn distort(picture: &mut BitPicture, fine: &Fine, strength: f64) {
    let Some(bounds) = picture.bounds() else {
        return;
    };
    let figure = fine.figure();
    let middle = figure.corner + 0.5 * figure.size;
    let scale = fine.samples_per_metre();
    let larger = figure.size.y.max(figure.size.x * scale.y / scale.x);
    let unit = DVec2::new(scale.x / scale.y, 1.0) * larger;
    let source = |row: usize, column: usize| {
        let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
        straightened((at - middle) / unit, strength) * unit + middle
    };
    let rows = bounds.top.saturating_sub(REACH)..(bounds.bottom + REACH).min(picture.rows());
    let columns = bounds.left.saturating_sub(REACH)..(bounds.right + REACH).min(picture.columns());
    let start = DVec2::new(bounds.left as f64, bounds.top as f64) - 1.0;
    let end = DVec2::new(bounds.right as f64, bounds.bottom as f64) + 1.0;
    let mut bent = BitPicture::empty(picture.rows(), picture.columns() / 64);
    // The sources of the corners of blocks, for one row of corners.
    let corners = |row: usize| -> Vec<DVec2> {
        let end = columns.end + STEP;
        let columns = (columns.start..end).step_by(STEP);
        columns.map(|column| source(row, column)).collect()
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
    *picture = bent;
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

/// Returns where a perfect lens images what [`distort`] shows at `place`. Both are measured from
/// the figure's middle to the right and down, in units of the larger of its height and width.
#[must_use]
pub(crate) fn straightened(place: DVec2, strength: f64) -> DVec2 {
    let lens = LensDistortion::new(strength);
    let shown = lens.growth(PLACE.length_squared());
    let bent = (place * HEIGHT + PLACE) * shown;
    (lens.straightened(bent) - PLACE) / HEIGHT
}

/// The distortion coefficients of a lens.
#[derive(Clone, Copy, Debug)]
struct LensDistortion {
    k1: f64,
    k2: f64,
}

impl LensDistortion {
    fn new(strength: f64) -> Self {
        Self {
            k1: -K1 * strength,
            k2: K2 * strength * strength,
        }
    }

    /// Returns the factor on the radius of a point whose squared radius is `square`.
    fn growth(self, square: f64) -> f64 {
        1.0 + square * (self.k1 + square * self.k2)
    }

    /// Returns where a perfect lens images what this lens images at `bent`, by Newton's iteration
    /// on the radius, which k2 keeps monotonic.
    fn straightened(self, bent: DVec2) -> DVec2 {
        let shown = bent.length();
        if shown == 0.0 {
            return bent;
        }
        let mut radius = shown;
        // Points in an image need three to five steps.
        for _ in 0..32 {
            let square = radius * radius;
            let slope = 1.0 + square * (3.0 * self.k1 + 5.0 * square * self.k2);
            let step = (radius * self.growth(square) - shown) / slope;
            radius -= step;
            if step.abs() < 1e-9 {
                break;
            }
        }
        bent * (radius / shown)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::side_view;
    use super::*;

    #[test]
    fn straightening_takes_back_what_the_lens_bends() {
        for strength in [-1.0, -0.4, 0.0, 0.3, 0.7, 1.0] {
            let lens = LensDistortion::new(strength);
            for (x, y) in [(0.0, 0.0), (0.1, -0.2), (1.0, 0.3), (-1.4, 0.9), (2.0, 2.0)] {
                let straight = DVec2::new(x, y);
                let square = x * x + y * y;
                // Brown's polynomial, with powers written out.
                let k1 = -0.3 * strength;
                let k2 = 0.08 * strength * strength;
                let bent = straight * (1.0 + k1 * square + k2 * square * square);
                let found = lens.straightened(bent);
                assert!(
                    (found - straight).length() < 1e-6,
                    "{strength} {straight} {found}"
                );
            }
        }
    }

    #[test]
    fn straight_lines_are_bent_as_browns_polynomial_says() {
        for strength in [-1.0, 0.5, 1.0] {
            let (fine, _, bounds) = side_view(2);
            let figure = fine.figure();
            let middle = figure.corner + 0.5 * figure.size;
            let mut line = fine.blank();
            let column = (bounds.left + 2).cast_signed();
            for row in bounds.top..bounds.bottom {
                line.fill(row, column, column + 3, true);
            }
            distort(&mut line, &fine, strength);
            // The figure is 150 samples high, which are 0.7 focal lengths.
            let unit = 150.0 / 0.7;
            let bend = |x: f64, y: f64| {
                let square = x * x + y * y;
                1.0 - 0.3 * strength * square + 0.08 * (strength * square) * (strength * square)
            };
            let scale = bend(0.8, 0.2);
            for row in [bounds.top + 5, bounds.top + 70, bounds.bottom - 5] {
                let x = 0.8 + (column as f64 + 1.5 - middle.x) / unit;
                let y = 0.2 + (row as f64 + 0.5 - middle.y) / unit;
                let shown = bend(x, y) / scale;
                let to_x = middle.x + (x * shown - 0.8) * unit;
                let to_y = middle.y + (y * shown - 0.2) * unit;
                let to_row = to_y.floor() as usize;
                let on: Vec<usize> = (0..line.columns())
                    .filter(|&c| line.is_on(to_row, c))
                    .collect();
                let found = on.iter().sum::<usize>() as f64 / on.len() as f64 + 0.5;
                assert!(
                    (found - to_x).abs() < 1.0,
                    "{strength} {row}: {found} {to_x}"
                );
            }
        }
    }
}

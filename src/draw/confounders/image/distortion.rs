//! Radial lens distortion (Brown 1966, 1971; Conrady 1919).
//!
//! A point that a perfect lens images at radius r from the optical axis, in focal lengths, is
//! imaged at r (1 + k1 r^2 + k2 r^4).

use super::fine::Fine;
use super::picture::BitPicture;
use super::warp::warped;
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
    let source = |at: DVec2| straightened((at - middle) / unit, strength) * unit + middle;
    *picture = warped(picture, bounds, source);
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
    use super::super::picture::FigureSamples;
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
            let (fine, _, FigureSamples { bounds, .. }) = side_view(2);
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

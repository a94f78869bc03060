//! Rings of points around a body, of which hulls consist.
//!
//! A tape around a ring is straight between its points, and so shorter than the ellipse through
//! them. Rings of a given circumference are larger by that factor.

use glam::DVec3;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Points of a ring. Four of them lie on the axes, so that breadth and depth are exact.
pub(super) const RING: usize = 8;
/// How far the diagonal points of an ellipse lie out, as a share of the half axes.
pub(super) const ELLIPSE: f64 = FRAC_1_SQRT_2;

/// Returns a horizontal ring of eight points; `diagonal` is how far the four between the axes
/// lie out, as a share of the half axes.
pub(super) fn ring(centre: DVec3, (half_x, half_z): (f64, f64), diagonal: f64) -> [DVec3; RING] {
    std::array::from_fn(|index| {
        let angle = TAU * index as f64 / RING as f64;
        let stretch = if index % 2 == 1 {
            diagonal / ELLIPSE
        } else {
            1.0
        };
        let (x, z) = (libm::cos(angle) * stretch, libm::sin(angle) * stretch);
        centre + DVec3::new(half_x * x, 0.0, half_z * z)
    })
}

/// Returns a round horizontal ring.
pub(super) fn round(centre: DVec3, radius: f64) -> [DVec3; RING] {
    ring(centre, (radius, radius), ELLIPSE)
}

/// Returns a ring across the walker, in a sagittal plane: from `low` to `high` above `centre`, and
/// `half_depth` to the front and to the back.
pub(super) fn ring_across(
    centre: DVec3,
    (low, high): (f64, f64),
    half_depth: f64,
) -> [DVec3; RING] {
    let middle = centre + DVec3::new(0.0, 0.5 * (low + high), 0.0);
    ring(DVec3::ZERO, (0.5 * (high - low), half_depth), ELLIPSE)
        .map(|p| middle + DVec3::new(0.0, p.x, p.z))
}

/// Returns the length of a tape around a ring.
fn perimeter(half: (f64, f64), diagonal: f64) -> f64 {
    let points = ring(DVec3::ZERO, half, diagonal);
    (0..RING)
        .map(|i| points[i].distance(points[(i + 1) % RING]))
        .sum()
}

/// Returns the half axes, in the proportion of `aspect`, of a ring of this circumference.
pub(super) fn around(circumference: f64, aspect: (f64, f64), diagonal: f64) -> (f64, f64) {
    let scale = circumference / perimeter(aspect, diagonal);
    (scale * aspect.0, scale * aspect.1)
}

/// Returns the radius of a round ring of this circumference.
pub(super) fn radius(circumference: f64) -> f64 {
    around(circumference, (1.0, 1.0), ELLIPSE).0
}

/// Returns half the depth of a ring of this circumference and half breadth, by bisection.
pub(super) fn half_depth(circumference: f64, half_breadth: f64, diagonal: f64) -> f64 {
    let (mut low, mut high) = (0.0, 0.5 * circumference);
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if perimeter((half_breadth, middle), diagonal) < circumference {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tape_around_a_ring_measures_the_circumference_asked_for() {
        // An octagon's side is its radius times 2 sin(pi / 8) = 0.765367.
        assert!((radius(8.0 * 0.765367) - 1.0).abs() < 1e-6);
        let wrist = around(0.176, (0.85, 1.15), 0.74);
        assert!((perimeter(wrist, 0.74) - 0.176).abs() < 1e-12);
        assert!((wrist.1 / wrist.0 - 1.15 / 0.85).abs() < 1e-12);
    }

    #[test]
    fn a_ring_of_a_breadth_is_as_deep_as_its_circumference_asks_for() {
        assert!((half_depth(8.0 * 0.765367, 1.0, ELLIPSE) - 1.0).abs() < 1e-6);
        let depth = half_depth(0.62, 0.085, ELLIPSE);
        assert!((perimeter((0.085, depth), ELLIPSE) - 0.62).abs() < 1e-9);
        let square = half_depth(0.62, 0.085, 0.77);
        assert!(square > 0.1 && square < depth, "{square} {depth}");
    }
}

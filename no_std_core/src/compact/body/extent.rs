//! The rectangle that a body takes in the image, computed from the few hulls that reach its sides.

use super::{CompactFigure, PosedHull, local};
use crate::budget::MAX_HULLS;
use crate::camera::{Camera, NEAR_M};
use crate::raster::placement::Extent;
use glam::{Vec2, Vec3};

/// The greatest error of a number that is computed in the image, relative to its inputs: some forty
/// roundings.
const ROUNDING: f32 = 1e-5;
/// The greatest sum of an orientation's squares, which is 3 except for rounding, and of the square
/// of a joint's distance from the origin in tens of metres, at which a hull's box is trusted. Our
/// choice: farther away, boxes would have to be larger because of rounding.
const MOST_SQUARES: f32 = 4.0;
/// The greatest sum of such a joint's coordinates, metres.
const FARTHEST_M: f32 = 40.0;

/// Bounds in the image: the right and the upper one, then the left and the lower one, negated.
type ExtentBounds = [f32; 4];

const NOTHING: ExtentBounds = [f32::NEG_INFINITY; 4];
const EVERYTHING: ExtentBounds = [f32::INFINITY; 4];

impl CompactFigure<'_> {
    /// Returns the rectangle that its points take in the image; `None` if a point has no place
    /// there, or without points.
    ///
    /// With parallel rays, only hulls whose boxes reach beyond it are examined point by point.
    ///
    /// Not inlined, so that its 700 bytes of stack are free again when the body is drawn.
    #[inline(never)]
    pub(super) fn known_extent(&self, camera: &Camera) -> Option<Extent> {
        let mut reached = [EVERYTHING; MAX_HULLS];
        // Numbers of the hulls whose boxes reach farthest.
        let (mut farthest, mut first) = (NOTHING, [0; 4]);
        for (number, (hull, reached)) in self.hull_parts().zip(&mut reached).enumerate() {
            *reached = self.reached(&hull, camera);
            let farthest = farthest.iter_mut().zip(&mut first);
            for ((farthest, first), &reached) in farthest.zip(&*reached) {
                if reached > *farthest {
                    (*farthest, *first) = (reached, number);
                }
            }
        }
        let first = first.iter().fold(0u32, |bits, number| bits | 1 << number);
        let mut found = FoundExtent {
            sides: NOTHING,
            wild: 0.0,
        };
        // These first, because most others then lie within.
        for is_first in [true, false] {
            for (number, reached) in reached.iter().enumerate().take(self.hulls.len()) {
                let is_within = || reached.iter().zip(&found.sides).all(|(of, side)| of < side);
                if (first >> number & 1 == 1) == is_first
                    && (is_first || !is_within())
                    && let Some(hull) = self.hull(number)
                {
                    found.add(&hull, camera)?;
                }
            }
        }
        let [right, up, left, down] = found.sides;
        let extent = Extent {
            min: Vec2::new(-left, -down),
            max: Vec2::new(right, up),
        };
        (found.wild.is_finite() && !self.points.is_empty()).then_some(extent)
    }

    /// Returns bounds that contain a hull's points in spite of rounding; [`EVERYTHING`] if unknown.
    fn reached(&self, hull: &PosedHull<'_>, camera: &Camera) -> ExtentBounds {
        let (turn, offset) = (hull.place.turn, hull.place.offset);
        let squares = |axis: Vec3| axis.length_squared();
        let turned = squares(turn.x_axis) + squares(turn.y_axis) + squares(turn.z_axis);
        // A NaN fails the comparison.
        let is_tame = turned + 0.01 * squares(offset) <= MOST_SQUARES;
        if !is_tame || camera.eye().is_some() {
            return EVERYTHING;
        }
        // Half a unit, because middles and halves are sums and differences of two bounds.
        let unit = 0.5 * f32::from(self.scale.unit) * hull.step;
        let sums = hull
            .bounds
            .map(|[least, most]| i16::from(least) + i16::from(most));
        let widths = hull
            .bounds
            .map(|[least, most]| i16::from(most) - i16::from(least));
        let [middle, half] = [sums, widths].map(|of| unit * Vec3::from(of.map(f32::from)));
        // Twice a point's distance, at most 1.74 times 127 units, and the joint's.
        let rounded = ROUNDING * (1_000.0 * unit.y + FARTHEST_M);
        let viewpoint = camera.viewpoint();
        let [x, y] = [viewpoint.right(), viewpoint.up()].map(|axis| {
            let along = hull.place.direction(axis);
            let centre = along.dot(middle) + axis.dot(offset);
            let half = (along * half).abs().element_sum() + rounded;
            [centre + half, half - centre]
        });
        [x[0], y[0], x[1], y[1]]
    }
}

/// The rectangle found so far.
struct FoundExtent {
    /// Its right and upper sides, and its left and lower sides negated.
    sides: ExtentBounds,
    /// A sum of coordinates, which is not finite if a point is not.
    wild: f32,
}

impl FoundExtent {
    /// Adds a hull's points; `None` if one is too near.
    fn add(&mut self, hull: &PosedHull<'_>, camera: &Camera) -> Option<()> {
        for &point in hull.points {
            let point = hull.place.carry(local(point, hull.step));
            if camera.depth_m(point) < NEAR_M {
                return None;
            }
            let Vec2 { x, y } = camera.project(point);
            // Once it is not finite, it stays so.
            self.wild += x + y;
            for (side, reached) in self.sides.iter_mut().zip([x, y, -x, -y]) {
                *side = if reached > *side { reached } else { *side };
            }
        }
        Some(())
    }
}

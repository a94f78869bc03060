//! The rectangle that a body takes in the image, computed from the few hulls that reach its sides.

use super::{CompactFigure, PosedHull, local, product};
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
    /// With parallel rays, only hulls whose boxes reach beyond a side of it are examined point by
    /// point, and of their points only those near that side are projected.
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
        let mut found = FoundExtent {
            sides: NOTHING,
            wild: 0.0,
        };
        // These first, because most others then lie within.
        for (side, &number) in first.iter().enumerate() {
            let is_known = reached.get(number)?[0] < f32::INFINITY;
            self.stretch(&mut found, (number, is_known), side, camera)?;
        }
        for (number, of) in reached.iter().enumerate().take(self.hulls.len()) {
            if of.iter().zip(&found.sides).all(|(of, side)| of < side) {
                continue;
            }
            for side in 0..first.len() {
                // A NaN is not within.
                if of[side] < found.sides[side] || first[side] == number {
                    continue;
                }
                let is_known = of[0] < f32::INFINITY;
                self.stretch(&mut found, (number, is_known), side, camera)?;
            }
        }
        let [right, up, left, down] = found.sides;
        let extent = Extent {
            min: Vec2::new(-left, -down),
            max: Vec2::new(right, up),
        };
        (found.wild.is_finite() && !self.points.is_empty()).then_some(extent)
    }

    /// Moves a side of the rectangle out to the points of a hull, which is within these bounds, or
    /// all of them if the bounds are unknown; `None` if a point is too near.
    fn stretch(
        &self,
        found: &mut FoundExtent,
        (number, is_known): (usize, bool),
        side: usize,
        camera: &Camera,
    ) -> Option<()> {
        if !is_known && side > 0 {
            // All points have been added for the first side.
            return Some(());
        }
        let hull = self.hull(number)?;
        let viewpoint = camera.viewpoint();
        let axis = if side & 1 == 0 {
            viewpoint.right()
        } else {
            viewpoint.up()
        };
        let axis = if side < 2 { axis } else { -axis };
        let place = hull.place();
        let (along, offset) = (place.direction(axis) * hull.step(), place.offset);
        // Whole numbers within 2^30, as axes are at most 2 long and points at most 1.74 times as
        // far away as their coordinates are. They are off by 3 for each step that coordinates
        // reach, and 400 because of floats.
        let reach = self.scale.reach.max(1);
        let units = (1 << 29) as f32 / (1.75 * f32::from(reach) * self.scale.step);
        #[expect(clippy::cast_possible_truncation, reason = "saturates")]
        let whole = |metres: f32| (metres * units) as i32;
        let along = along.to_array().map(whole);
        let slack = 3 * i32::from(reach) + 400;
        // A point is certainly within if it is farther inside than twice what is rounded off.
        let size = 500.0 * f32::from(self.scale.unit) * self.scale.step;
        let rounded = 2.0 * ROUNDING * (size + offset.abs().element_sum());
        let beyond = if is_known {
            axis.dot(offset) + rounded
        } else {
            f32::INFINITY
        };
        let level = |found: &FoundExtent| whole(found.sides[side] - beyond).saturating_sub(slack);
        let mut within = level(found);
        for &point in hull.points {
            if product(along, point) < within {
                continue;
            }
            found.add(&hull, point, camera)?;
            within = level(found);
        }
        Some(())
    }

    /// Returns bounds that contain a hull's points in spite of rounding; [`EVERYTHING`] if unknown.
    fn reached(&self, hull: &PosedHull<'_>, camera: &Camera) -> ExtentBounds {
        let place = hull.place();
        let (turn, offset) = (place.turn, place.offset);
        let squares = |axis: Vec3| axis.length_squared();
        let turned = squares(turn.x_axis) + squares(turn.y_axis) + squares(turn.z_axis);
        // A NaN fails the comparison.
        let is_tame = turned + 0.01 * squares(offset) <= MOST_SQUARES;
        if !is_tame || camera.eye().is_some() {
            return EVERYTHING;
        }
        // Half a unit, because middles and halves are sums and differences of two bounds.
        let unit = 0.5 * f32::from(self.scale.unit) * hull.step();
        let sums = hull
            .hull
            .bounds
            .map(|[least, most]| i16::from(least) + i16::from(most));
        let widths = hull
            .hull
            .bounds
            .map(|[least, most]| i16::from(most) - i16::from(least));
        let [middle, half] = [sums, widths].map(|of| unit * Vec3::from(of.map(f32::from)));
        // Twice a point's distance, at most 1.74 times 127 units, and the joint's.
        let rounded = ROUNDING * (1_000.0 * unit.y + FARTHEST_M);
        let viewpoint = camera.viewpoint();
        let [x, y] = [viewpoint.right(), viewpoint.up()].map(|axis| {
            let along = place.direction(axis);
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
    /// Adds a point of a hull; `None` if it is too near.
    fn add(&mut self, hull: &PosedHull<'_>, point: [i16; 3], camera: &Camera) -> Option<()> {
        let point = hull.place().carry(local(point, hull.step()));
        if camera.depth_m(point) < NEAR_M {
            return None;
        }
        let Vec2 { x, y } = camera.project(point);
        // Once it is not finite, it stays so.
        self.wild += x + y;
        for (side, reached) in self.sides.iter_mut().zip([x, y, -x, -y]) {
            *side = if reached > *side { reached } else { *side };
        }
        Some(())
    }
}

//! The hulls of a body before a camera: where their points appear, and which edges are their
//! outline.
//!
//! Whether a facet is visible is the sign of a product in the frame of its joint, rounded as on a
//! host. With parallel rays the order of its corners in the image mostly decides it, in integers
//! and half of the instructions: [`PointScale`] states when. Where a sign is too near 0, the
//! product itself decides. Pixels are computed for the outline's corners only.

#[cfg(test)]
mod tests;

use super::{CompactFigure, FacetCorners, PosedHull, local};
use crate::body::plane::{normal, sorted};
use crate::budget::MAX_HULL_POINTS;
use crate::camera::Camera;
use crate::facets::each_triangle;
use crate::hull::HullPoints;
use crate::raster::placement::Placement;
use core::convert::Infallible;
use core::ops::Range;
use core::slice;
use glam::{Vec2, Vec3};

/// A body in a pose before a camera.
#[derive(Clone, Copy, Debug)]
pub struct CompactSight<'a> {
    posed: &'a CompactFigure<'a>,
    camera: &'a Camera,
    /// The direction of the eye, or its position if `is_near`.
    seen_from: Vec3,
    is_near: bool,
}

/// One hull of a body in the image.
pub struct SeenHull<'a> {
    sight: CompactSight<'a>,
    scale: PointScale,
    points: SeenPoints,
    /// The corners of the outline, by number.
    corners: [OutlineCorner; MAX_HULL_POINTS],
}

/// The points of a hull in the image, by number.
type SeenPoints = [SeenPoint; MAX_HULL_POINTS];

/// A point of a hull in the image. 16 bytes, with the coordinates last: one instruction then finds
/// a point by its number, and one more loads both coordinates.
#[derive(Clone, Copy)]
#[repr(C)]
struct SeenPoint {
    /// The bit of its number.
    bit: u32,
    /// Lines of the outline: bit `b` is the line to point `b`, which has a greater number.
    lines: u32,
    /// Its place in the image, scaled by [`PointScale`], to the right and up.
    x: i32,
    y: i32,
}

/// A point of a hull's outline in the image.
#[derive(Clone, Copy)]
pub struct OutlineCorner {
    /// Its place in the image, pixels.
    pub pixel: Vec2,
    /// The first sampled row below it.
    pub row: u32,
}

impl<'a> CompactSight<'a> {
    pub fn new(posed: &'a CompactFigure<'a>, camera: &'a Camera) -> Self {
        let toward = camera.viewpoint().toward();
        let (seen_from, is_near) = match camera.eye() {
            Some((aim, distance_m)) => (aim + toward * distance_m, true),
            None => (toward, false),
        };
        Self {
            posed,
            camera,
            seen_from,
            is_near,
        }
    }
}

impl<'a> SeenHull<'a> {
    /// Makes a buffer for the hulls of a body, one at a time.
    pub fn new(sight: &CompactSight<'a>) -> Self {
        let mut points = [SeenPoint {
            bit: 1,
            lines: 0,
            x: 0,
            y: 0,
        }; MAX_HULL_POINTS];
        for (number, point) in points.iter_mut().enumerate() {
            point.bit <<= number;
        }
        let corner = OutlineCorner {
            pixel: Vec2::ZERO,
            row: 0,
        };
        Self {
            sight: *sight,
            scale: PointScale::for_reach(sight.posed.scale.reach),
            points,
            corners: [corner; MAX_HULL_POINTS],
        }
    }

    /// Calls `take` with the lines of the outline of these parts together; `row` gives the rows of
    /// corners.
    #[inline]
    pub fn trace(
        &mut self,
        parts: Range<usize>,
        placement: &Placement,
        row: impl Fn(f32) -> u32 + Copy,
        take: impl FnMut(OutlineCorner, OutlineCorner),
    ) {
        let Some(first) = self.sight.posed.hull(parts.start) else {
            return;
        };
        if first.is_draped && self.sight.posed.facets.is_some() {
            let len = self.wrap(parts, placement, row);
            self.give(len, |_, _| (), take);
        } else {
            self.find_outline(&first);
            let place = |seen: &mut Self, ends| seen.place(&first, placement, ends, row);
            self.give(first.points.len(), place, take);
        }
    }

    /// Calls `place` with the bits of the points at which lines end, then `take` with the lines
    /// that are on, and turns them off.
    #[inline]
    fn give(
        &mut self,
        len: usize,
        place: impl FnOnce(&mut Self, u32),
        mut take: impl FnMut(OutlineCorner, OutlineCorner),
    ) {
        let Some(points) = self.points.get(..len) else {
            return;
        };
        let (mut begins, mut ends, mut own) = (0, 0, 1);
        for point in points {
            if point.lines != 0 {
                begins |= own;
                ends |= point.lines;
            }
            own <<= 1;
        }
        ends |= begins;
        place(self, ends);
        while begins != 0 {
            let a = begins.trailing_zeros() as usize;
            begins &= begins - 1;
            // All lines are off for the next hull.
            let mut lines = core::mem::take(&mut self.points[a].lines);
            while lines != 0 {
                let b = lines.trailing_zeros() as usize;
                lines &= lines - 1;
                take(self.corners[a], self.corners[b]);
            }
        }
    }

    /// Finds the surface of a draped hull, the pixels of all its points and the lines of its
    /// outline, and returns the number of its points.
    ///
    /// Its facets hold for this pose only and are not kept. Not inlined, so that only clothes take
    /// their stack.
    #[inline(never)]
    fn wrap(
        &mut self,
        parts: Range<usize>,
        placement: &Placement,
        row: impl Fn(f32) -> u32,
    ) -> usize {
        let CompactSight {
            posed,
            camera,
            seen_from,
            is_near,
        } = self.sight;
        let points: HullPoints = posed.places_of(parts).take(MAX_HULL_POINTS).collect();
        let eye = if is_near {
            FacetEye::At(seen_from)
        } else {
            FacetEye::Toward(seen_from)
        };
        let seen = &mut self.points;
        let wrapped: Result<(), Infallible> = each_triangle(&points, |corners| {
            let (numbers, is_clockwise) = sorted(corners);
            let [a, b, c] = numbers.map(usize::from);
            let turn = if is_clockwise { 1 << 31 } else { 0 };
            let at = [a, b, c].map(|number| points.get(number).copied().unwrap_or_default());
            if b == c {
                // The side of a flat hull.
                seen[a].lines ^= 1 << b;
            } else if eye.is_before(at, turn) {
                toggle(seen, [a, b, c]);
            }
            Ok(())
        });
        let Ok(()) = wrapped;
        for (corner, &point) in self.corners.iter_mut().zip(&points) {
            let pixel = placement.place(camera.project(point));
            let row = row(pixel.y);
            *corner = OutlineCorner { pixel, row };
        }
        points.len()
    }

    /// Finds the pixels and rows of the points whose bits are set.
    ///
    /// Not inlined: on its own it keeps most values in registers, and checks only once which rays
    /// the camera has.
    #[inline(never)]
    fn place(
        &mut self,
        hull: &PosedHull<'_>,
        placement: &Placement,
        mut numbers: u32,
        row: impl Fn(f32) -> u32,
    ) {
        let (camera, placement) = (*self.sight.camera, *placement);
        let (place, step) = (hull.place, hull.step);
        while numbers != 0 {
            let number = numbers.trailing_zeros() as usize;
            numbers &= numbers - 1;
            let Some(&steps) = hull.points.get(number) else {
                break;
            };
            let point = place.carry(local(steps, step));
            let pixel = placement.place(camera.project(point));
            let row = row(pixel.y);
            self.corners[number] = OutlineCorner { pixel, row };
        }
    }

    /// Turns on the edges between visible facets and those that are not.
    fn find_outline(&mut self, hull: &PosedHull<'_>) {
        let sight = self.sight;
        if let [first, ..] = hull.facets
            && first.is_side()
        {
            // The sides of a flat hull are its outline from everywhere.
            for corners in hull.facets {
                let [a, b, _] = corners.numbers();
                self.points[a].lines ^= 1 << b;
            }
        } else if sight.is_near {
            let eye = FacetEye::At(hull.place.point(sight.seen_from));
            toggle_seen(&mut self.points, hull, &eye);
        } else {
            let toward = hull.place.direction(sight.seen_from);
            let eye = FacetEye::Toward(toward);
            if self.draft(hull, toward) {
                toggle_drafted(&mut self.points, hull, self.scale.tolerance, &eye);
            } else {
                toggle_seen(&mut self.points, hull, &eye);
            }
        }
    }

    /// Finds where the points of a hull appear, in whole numbers, and returns `true`; `false` if
    /// its frame is not a pure rotation.
    #[inline]
    fn draft(&mut self, hull: &PosedHull<'_>, toward: Vec3) -> bool {
        let viewpoint = self.sight.camera.viewpoint();
        let right = hull.place.direction(viewpoint.right());
        let up = hull.place.direction(viewpoint.up());
        let skew = (right.cross(up) - toward).length_squared();
        // A NaN fails all comparisons.
        let is_turned = skew <= PointScale::SKEW * PointScale::SKEW
            && right.length_squared() <= PointScale::LENGTH_SQUARED
            && up.length_squared() <= PointScale::LENGTH_SQUARED;
        if !is_turned {
            return false;
        }
        let scale = self.scale.units;
        let mirror = if hull.step.x < 0.0 { -scale } else { scale };
        let whole = |axis: Vec3| {
            let axis = axis * Vec3::new(mirror, scale, scale);
            #[expect(clippy::cast_possible_truncation, reason = "within 2^29")]
            let whole = axis.to_array().map(|number| number as i32);
            whole
        };
        let (right, up) = (whole(right), whole(up));
        draft(&mut self.points, hull.points, [right, up]);
        true
    }
}

/// Finds where points appear along two axes.
///
/// Not inlined: on its own it keeps its values in registers.
#[inline(never)]
fn draft(points: &mut SeenPoints, steps: &[[i16; 3]], [right, up]: [[i32; 3]; 2]) {
    for (point, &[x, y, z]) in points.iter_mut().zip(steps) {
        let [x, y, z] = [i32::from(x), i32::from(y), i32::from(z)];
        point.x = right[0] * x + right[1] * y + right[2] * z;
        point.y = up[0] * x + up[1] * y + up[2] * z;
    }
}

/// Toggles the edges of each visible facet: an edge between two of them is off again.
fn toggle_seen(points: &mut SeenPoints, hull: &PosedHull<'_>, eye: &FacetEye) {
    for &corners in hull.facets {
        if eye.sees(hull, corners) {
            toggle(points, corners.numbers());
        }
    }
}

/// Toggles the edges of each visible facet, by the draft wherever it is beyond its tolerance.
fn toggle_drafted(points: &mut SeenPoints, hull: &PosedHull<'_>, tolerance: i32, eye: &FacetEye) {
    let mut facets = hull.facets.iter();
    while let Some(untold) = toggle_told(points, &mut facets, tolerance) {
        if eye.sees(hull, untold) {
            toggle(points, untold.numbers());
        }
    }
}

/// Toggles the edges of visible facets up to the first one that the draft does not decide, and
/// returns that facet.
///
/// Not inlined, and calls nothing: on its own it keeps all values in registers.
#[inline(never)]
fn toggle_told(
    points: &mut SeenPoints,
    facets: &mut slice::Iter<'_, FacetCorners>,
    tolerance: i32,
) -> Option<FacetCorners> {
    let mut rest = facets.clone();
    let untold = loop {
        let Some(&corners) = rest.next() else {
            break None;
        };
        // This negates the number and is off by one, for which the tolerance has room.
        let side = turn(points, corners) ^ corners.turned();
        if side > tolerance {
            toggle(points, corners.numbers());
        } else if side + tolerance >= 0 {
            break Some(corners);
        }
    };
    *facets = rest;
    untold
}

/// Returns the high word of twice a facet's area in the image, positive if its corners turn
/// counterclockwise in the order of their numbers.
#[inline]
fn turn(points: &SeenPoints, corners: FacetCorners) -> i32 {
    let [a, b, c] = corners.numbers().map(|number| &points[number]);
    let high = |a: i32, b: i32| ((i64::from(a) * i64::from(b)) >> 32) as i32;
    high(b.x - a.x, c.y - a.y) - high(b.y - a.y, c.x - a.x)
}

/// Toggles a facet's edges.
#[inline]
fn toggle(points: &mut SeenPoints, [a, b, c]: [usize; 3]) {
    let [b_bit, c_bit] = [b, c].map(|number| points[number].bit);
    points[a].lines ^= b_bit | c_bit;
    points[b].lines ^= c_bit;
}

/// The eye's position or direction, in the frame of the facets' joint.
enum FacetEye {
    At(Vec3),
    Toward(Vec3),
}

impl FacetEye {
    /// Returns whether it is on a facet's outer side; infinitely far away only the direction
    /// counts.
    #[inline(never)]
    fn sees(&self, hull: &PosedHull<'_>, corners: FacetCorners) -> bool {
        let corners_at = corners.numbers().map(|number| hull.points.get(number));
        let [Some(a), Some(b), Some(c)] = corners_at else {
            return false;
        };
        self.is_before(
            [a, b, c].map(|&steps| local(steps, hull.step)),
            corners.turn(),
        )
    }

    /// Returns whether it is on the outer side of a facet with these corners; `turn` is the sign
    /// bit of an [`f32`] if they turn clockwise.
    #[inline]
    fn is_before(&self, points: [Vec3; 3], turn: u32) -> bool {
        let normal = normal(points);
        let side = match self {
            Self::At(eye) => eye.dot(normal) - normal.dot(points[0]),
            Self::Toward(eye) => eye.dot(normal),
        };
        // A difference is above 0 exactly where the first number is greater.
        (side.to_bits() ^ turn).cast_signed() > 0
    }
}

/// The scale of points in the image of parallel rays, as whole numbers within 2^29: their
/// differences stay below 2^30, and products of these below 2^61.
///
/// The turn of a triangle of such points, and the number whose sign [`FacetEye::sees`] computes,
/// are two roundings of one number (Binet and Cauchy: the cross product in the image is the product
/// of the facet's normal and the image's). Beyond the sum of their errors, both have its sign.
struct PointScale {
    /// Units in a step.
    units: f32,
    /// The greatest error of a turn, in units of its high word.
    tolerance: i32,
}

impl PointScale {
    /// The greatest distance of right times up from the direction of the eye, and the greatest
    /// squared length of both, for the errors below.
    const SKEW: f32 = 2e-6;
    const LENGTH_SQUARED: f32 = 1.01;

    /// Returns the scale for points whose coordinates reach this many steps.
    fn for_reach(reach: u16) -> Self {
        let reach = reach.max(1);
        Self {
            // A point is at most 1.74 times as far away as its coordinates are, and axes are at
            // most 1.005 long.
            units: (1 << 29) as f32 / (1.75 * f32::from(reach)),
            // Axes are off by less than 1.1, points by 3.3 times the reach and differences by twice
            // that: turns by 4 * 6.6 * reach * 2^30. The product in floats and the skew add 34 *
            // 2^-22 and 12 * SKEW of the reach's square, which is 2^58 / 3.
            tolerance: 8 * i32::from(reach) + 1_000,
        }
    }
}

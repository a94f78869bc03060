//! The hulls of a body before a camera: where their points appear, and which of their edges are
//! their outline.
//!
//! Whether a facet is seen is the sign of a product in the frame of its joint, rounded as on a
//! host. Seen by parallel rays that is mostly told by the order of its corners in the image, in
//! integers and in half of the instructions: [`PointScale`] says when it is, and where a sign is too
//! near to 0 the product itself decides. Pixels are computed of the outline's corners alone.

#[cfg(test)]
mod tests;

use super::{FacetCorners, LeanFigure, PosedHull, local};
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
pub struct LeanSight<'a> {
    posed: &'a LeanFigure<'a>,
    camera: &'a Camera,
    /// The direction of the eye, or where it stands.
    seen_from: Vec3,
    is_near: bool,
}

/// One hull of it in the image.
pub struct SeenHull<'a> {
    sight: LeanSight<'a>,
    scale: PointScale,
    points: SeenPoints,
    /// Those of the outline.
    corners: [OutlineCorner; MAX_HULL_POINTS],
}

/// What is known of each point of a hull.
type SeenPoints = [SeenPoint; MAX_HULL_POINTS];

/// A point of a hull. 16 bytes, and what facets ask for not in the first four: one instruction
/// then finds a point by its number, and one more both coordinates.
#[derive(Clone, Copy)]
#[repr(C)]
struct SeenPoint {
    /// That of its number.
    bit: u32,
    /// Bit `b` is the line to point `b`, of a greater number.
    lines: u32,
    /// Its [`PointScale`]d place in the image, to the right and up.
    x: i32,
    y: i32,
}

/// A point of a hull's outline in the image.
#[derive(Clone, Copy)]
pub struct OutlineCorner {
    /// Where it appears, pixels.
    pub pixel: Vec2,
    /// The first row that is sampled below it.
    pub row: u32,
}

impl<'a> LeanSight<'a> {
    pub fn new(posed: &'a LeanFigure<'a>, camera: &'a Camera) -> Self {
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
    /// None yet.
    pub fn new(sight: &LeanSight<'a>) -> Self {
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
            scale: PointScale::of(sight.posed.scale.reach),
            points,
            corners: [corner; MAX_HULL_POINTS],
        }
    }

    /// Gives `take` the lines of the outline of what these parts span, whose corners `row` says
    /// the rows of.
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

    /// Gives `take` the lines that are on, and turns them off; `place` is called before, with the
    /// bits of the points that are their ends.
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
            // The next hull finds all lines off.
            let mut lines = core::mem::take(&mut self.points[a].lines);
            while lines != 0 {
                let b = lines.trailing_zeros() as usize;
                lines &= lines - 1;
                take(self.corners[a], self.corners[b]);
            }
        }
    }

    /// Finds what the parts of a draped hull span where they are, the places of all its points,
    /// and which lines are its outline; how many points it has.
    ///
    /// Its facets are of this pose alone, and nothing keeps them. Not inlined, so that their
    /// stack is there for clothes alone.
    #[inline(never)]
    fn wrap(
        &mut self,
        parts: Range<usize>,
        placement: &Placement,
        row: impl Fn(f32) -> u32,
    ) -> usize {
        let LeanSight {
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
    /// Not inlined: alone it has most of what it works with in registers, and there the camera
    /// is asked once what its rays are like.
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

    /// Turns the edges between facets that are seen and facets that are not on.
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
                toggle_drafted(&mut self.points, (hull, self.scale.tolerance), &eye);
            } else {
                toggle_seen(&mut self.points, hull, &eye);
            }
        }
    }

    /// Finds where the points of a hull appear in whole numbers; not of one whose frame is not
    /// turned alone.
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
/// Not inlined: alone it has what it works with in registers.
#[inline(never)]
fn draft(points: &mut SeenPoints, steps: &[[i16; 3]], [right, up]: [[i32; 3]; 2]) {
    for (point, &[x, y, z]) in points.iter_mut().zip(steps) {
        let [x, y, z] = [i32::from(x), i32::from(y), i32::from(z)];
        point.x = right[0] * x + right[1] * y + right[2] * z;
        point.y = up[0] * x + up[1] * y + up[2] * z;
    }
}

/// Toggles the edges of each facet that is seen: what two of them toggled is off again.
fn toggle_seen(points: &mut SeenPoints, hull: &PosedHull<'_>, eye: &FacetEye) {
    for &corners in hull.facets {
        if eye.sees(hull, corners) {
            toggle(points, corners.numbers());
        }
    }
}

/// The same by the draft, beyond its tolerance.
fn toggle_drafted(
    points: &mut SeenPoints,
    (hull, tolerance): (&PosedHull<'_>, i32),
    eye: &FacetEye,
) {
    let mut facets = hull.facets.iter();
    while let Some(untold) = toggle_told(points, &mut facets, tolerance) {
        if eye.sees(hull, untold) {
            toggle(points, untold.numbers());
        }
    }
}

/// The same up to the first facet that the draft does not tell of: that one.
///
/// Not inlined, and calls nothing: alone it has all that it works with in registers.
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
        // A sign turned round, and one less: the tolerance has room for that.
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

/// The high word of what a facet's corners turn counterclockwise by their numbers: twice its
/// area in the image.
#[inline]
fn turn(points: &SeenPoints, corners: FacetCorners) -> i32 {
    let [a, b, c] = corners.numbers().map(|number| &points[number]);
    let high = |a: i32, b: i32| ((i64::from(a) * i64::from(b)) >> 32) as i32;
    high(b.x - a.x, c.y - a.y) - high(b.y - a.y, c.x - a.x)
}

/// Turns a facet's edges on, or off.
#[inline]
fn toggle(points: &mut SeenPoints, [a, b, c]: [usize; 3]) {
    let [b_bit, c_bit] = [b, c].map(|number| points[number].bit);
    points[a].lines ^= b_bit | c_bit;
    points[b].lines ^= c_bit;
}

/// From where facets are seen, in the frame of their joint.
enum FacetEye {
    At(Vec3),
    Toward(Vec3),
}

impl FacetEye {
    /// Whether it is on a facet's outer side; infinitely far away only the direction counts.
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

    /// The same of a facet with these corners, and with the sign of an [`f32`] if they turn
    /// clockwise.
    #[inline]
    fn is_before(&self, points: [Vec3; 3], turn: u32) -> bool {
        let normal = normal(points);
        let side = match self {
            Self::At(eye) => eye.dot(normal) - normal.dot(points[0]),
            Self::Toward(eye) => eye.dot(normal),
        };
        // A difference is above 0 where the first number is the greater.
        (side.to_bits() ^ turn).cast_signed() > 0
    }
}

/// How points that appear by parallel rays are scaled to whole numbers within 2^29: with their
/// differences below 2^30, products of these stay below 2^61.
///
/// What a triangle of such points turns, and the sign that [`FacetEye::sees`] computes, are two
/// roundings of one number (Binet and Cauchy: the cross product in the image is the product of
/// the facet's normal and the image's). Beyond the sum of their errors both have its sign.
struct PointScale {
    /// Units in a step.
    units: f32,
    /// The greatest that a turn may be off, in the unit of its high word.
    tolerance: i32,
}

impl PointScale {
    /// How far right times up may be from the direction of the eye, and how long they may be,
    /// for the errors below.
    const SKEW: f32 = 2e-6;
    const LENGTH_SQUARED: f32 = 1.01;

    /// For points whose coordinates reach so many steps.
    fn of(reach: u16) -> Self {
        let reach = reach.max(1);
        Self {
            // A point is at most 1.74 times as far away as its coordinates are, and axes are at
            // most 1.005 long.
            units: (1 << 29) as f32 / (1.75 * f32::from(reach)),
            // Axes are off by less than 1.1, points by 3.3 times the reach and differences by
            // twice that: turns by 4 * 6.6 * reach * 2^30. Of the product in floats, and of the
            // skew, 34 * 2^-22 and 12 * SKEW of the reach's square, which is 2^58 / 3.
            tolerance: 8 * i32::from(reach) + 1_000,
        }
    }
}

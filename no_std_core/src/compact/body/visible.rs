//! The hulls of a body before a camera: where their points appear, and which edges are their
//! outline.
//!
//! Whether a facet is visible is the sign of a product in the frame of its joint, rounded as on a
//! host. With parallel rays the order of its corners in the image mostly decides it, in integers
//! and a quarter of the instructions: [`DraftScale`] states when. Where a sign is too near 0, the
//! product itself decides. Pixels are computed for the outline's corners only.

#[cfg(test)]
mod tests;

use super::{CompactFigure, FacetCorners, PosedHull, local, product};
use crate::body::plane::{normal, sorted};
use crate::budget::{MAX_HULL_FACETS, MAX_HULL_POINTS};
use crate::camera::Camera;
use crate::facets::each_triangle;
use crate::hull::HullPoints;
use crate::raster::placement::Placement;
use core::convert::Infallible;
use core::ops::Range;
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
    sketch: Sketch,
    /// The corners of the outline, by number.
    corners: [OutlineCorner; MAX_HULL_POINTS],
}

/// A hull as far as it is drawn, by the numbers of points.
struct Sketch {
    places: DraftPlaces,
    lines: OutlineLines,
}

/// Where the points of a hull appear, by number: 2^16 times the number of units to the right, plus
/// the units up, modulo 2^32. One word for both, as most instructions of a silhouette load and
/// subtract them.
type DraftPlaces = [i32; MAX_HULL_POINTS];

/// The lines of the outline: bit `b` of word `a` is the line from point `a` to point `b`, which has
/// the greater number.
type OutlineLines = [u32; MAX_HULL_POINTS];

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
        let corner = OutlineCorner {
            pixel: Vec2::ZERO,
            row: 0,
        };
        Self {
            sight: *sight,
            sketch: Sketch {
                places: [0; _],
                lines: [0; _],
            },
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
        if first.hull.carrier.drape() > 0 && self.sight.posed.facets.is_some() {
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
        let Some(lines) = self.sketch.lines.get(..len) else {
            return;
        };
        let (mut begins, mut ends, mut own) = (0, 0, 1);
        for &lines in lines {
            if lines != 0 {
                begins |= own;
                ends |= lines;
            }
            own <<= 1;
        }
        ends |= begins;
        place(self, ends);
        while begins != 0 {
            let a = begins.trailing_zeros() as usize;
            begins &= begins - 1;
            // All lines are off for the next hull.
            let mut lines = core::mem::take(&mut self.sketch.lines[a]);
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
        let lines = &mut self.sketch.lines;
        let wrapped: Result<(), Infallible> = each_triangle(&points, |corners| {
            let (numbers, is_clockwise) = sorted(corners);
            let [a, b, c] = numbers.map(usize::from);
            let turn = if is_clockwise { 1 << 31 } else { 0 };
            let at = [a, b, c].map(|number| points.get(number).copied().unwrap_or_default());
            if b == c {
                // The side of a flat hull.
                lines[a] ^= 1 << b;
            } else if eye.is_before(at, turn) {
                toggle(lines, [a, b, c]);
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
        let (place, step) = (hull.place(), hull.step());
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
                self.sketch.lines[a] ^= 1 << b;
            }
        } else if sight.is_near {
            let eye = FacetEye::At(hull.place().point(sight.seen_from));
            toggle_seen(&mut self.sketch.lines, hull, hull.facets, &eye);
        } else {
            let toward = hull.place().direction(sight.seen_from);
            let eye = FacetEye::Toward(toward);
            if let Some(scale) = self.draft(hull, toward) {
                let mut untold = UntoldFacets::new();
                toggle_told(&mut self.sketch, hull.facets, scale.tolerance, &mut untold);
                toggle_untold(&mut self.sketch, hull, &untold, &scale, &eye);
            } else {
                toggle_seen(&mut self.sketch.lines, hull, hull.facets, &eye);
            }
        }
    }

    /// Finds where the points of a hull appear, in whole numbers, and returns their scale; `None` if
    /// its frame is not a pure rotation.
    #[inline]
    fn draft(&mut self, hull: &PosedHull<'_>, toward: Vec3) -> Option<DraftScale> {
        let viewpoint = self.sight.camera.viewpoint();
        let right = hull.place().direction(viewpoint.right());
        let up = hull.place().direction(viewpoint.up());
        let skew = (right.cross(up) - toward).length_squared();
        // A NaN fails all comparisons.
        let is_turned = skew <= DraftScale::SKEW * DraftScale::SKEW
            && right.length_squared() <= DraftScale::LENGTH_SQUARED
            && up.length_squared() <= DraftScale::LENGTH_SQUARED;
        if !is_turned {
            return None;
        }
        let scale = DraftScale::for_hull(hull);
        let mirror = if hull.hull.is_image {
            -scale.units
        } else {
            scale.units
        };
        let whole = |axis: Vec3| {
            let axis = axis * Vec3::new(mirror, scale.units, scale.units);
            #[expect(clippy::cast_possible_truncation, reason = "below 2^31")]
            let whole = axis.to_array().map(|number| number as i32);
            whole
        };
        draft(
            &mut self.sketch.places,
            hull.points,
            [whole(right), whole(up)],
        );
        Some(scale)
    }
}

/// Finds where points appear along two axes.
///
/// Not inlined: on its own it keeps its values in registers.
#[inline(never)]
fn draft(places: &mut DraftPlaces, steps: &[[i16; 3]], [right, up]: [[i32; 3]; 2]) {
    for (place, &point) in places.iter_mut().zip(steps) {
        // Unrolled, the loop would not keep its values in registers.
        core::hint::black_box(());
        *place = (product(right, point) & !0xffff).wrapping_add(product(up, point) >> 16);
    }
}

/// The facets of a hull that its draft does not decide.
type UntoldFacets = heapless::Vec<FacetCorners, MAX_HULL_FACETS>;

/// Toggles the edges of each visible facet: an edge between two of them is off again.
#[inline(never)]
fn toggle_seen(
    lines: &mut OutlineLines,
    hull: &PosedHull<'_>,
    facets: &[FacetCorners],
    eye: &FacetEye,
) {
    for &corners in facets {
        if eye.sees(hull, corners) {
            toggle(lines, corners.numbers());
        }
    }
}

/// Toggles the edges of each facet that is visible beyond the draft's tolerance, and adds those
/// within it to `untold`.
///
/// Not inlined, and calls nothing: on its own it keeps all values in registers.
#[inline(never)]
fn toggle_told(
    Sketch { places, lines }: &mut Sketch,
    facets: &[FacetCorners],
    tolerance: i32,
    untold: &mut UntoldFacets,
) {
    for &corners in facets {
        let turn = turn(corners.sides(places)) ^ corners.turned();
        if turn > tolerance {
            toggle(lines, corners.numbers());
        } else if turn + tolerance >= 0 {
            // As many as the hull has facets, which the capacity allows.
            let _ = untold.push(corners);
        }
    }
}

/// Toggles the edges of each visible facet, by the draft where it is beyond the error of the facet.
#[inline(never)]
fn toggle_untold(
    Sketch { places, lines }: &mut Sketch,
    hull: &PosedHull<'_>,
    untold: &UntoldFacets,
    scale: &DraftScale,
    eye: &FacetEye,
) {
    for &corners in untold {
        let sides = corners.sides(places);
        let turn = turn(sides) ^ corners.turned();
        let is_seen = if turn.abs() > scale.error(sides) {
            turn > 0
        } else {
            eye.sees(hull, corners)
        };
        if is_seen {
            toggle(lines, corners.numbers());
        }
    }
}

impl FacetCorners {
    /// Returns the sides from the first corner to the second and to the third.
    #[inline]
    fn sides(self, places: &DraftPlaces) -> [i32; 2] {
        let [a, b, c] = self.numbers().map(|number| places[number]);
        [b.wrapping_sub(a), c.wrapping_sub(a)]
    }
}

/// Returns twice the area of a triangle with these sides, positive if it lies counterclockwise
/// between them.
#[inline]
fn turn([b, c]: [i32; 2]) -> i32 {
    // A side as a whole times the number of units up of the other one. What is too much, the
    // product of both numbers up, is the same in both products.
    let product = |side: i32, other: i32| {
        #[expect(clippy::cast_possible_truncation, reason = "the low half; below 2^31")]
        let product = ((i64::from(side) * i64::from(other as i16)) >> 16) as i32;
        product
    };
    product(b, c).wrapping_sub(product(c, b))
}

/// Toggles a facet's edges.
#[inline]
fn toggle(lines: &mut OutlineLines, [a, b, c]: [usize; 3]) {
    lines[a] ^= 1 << b | 1 << c;
    lines[b] ^= 1 << c;
}

/// The eye's position or direction, in the frame of the facets' joint.
enum FacetEye {
    At(Vec3),
    Toward(Vec3),
}

impl FacetEye {
    /// Returns whether it is on a facet's outer side; infinitely far away only the direction
    /// counts.
    #[inline]
    fn sees(&self, hull: &PosedHull<'_>, corners: FacetCorners) -> bool {
        let corners_at = corners.numbers().map(|number| hull.points.get(number));
        let [Some(a), Some(b), Some(c)] = corners_at else {
            return false;
        };
        self.is_before(
            [a, b, c].map(|&steps| local(steps, hull.step())),
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

/// The scale of a hull's points in the image of parallel rays, as whole numbers of which only
/// differences count.
///
/// The turn of a triangle of such points, and the number whose sign [`FacetEye::sees`] computes,
/// are two roundings of one number (Binet and Cauchy: the cross product in the image is the product
/// of the facet's normal and the image's). Beyond the sum of their errors, both have its sign.
struct DraftScale {
    /// 65,536ths of a unit in a step.
    units: f32,
    /// The greatest error of the turn of any triangle, square units.
    tolerance: i32,
    /// The greatest error of a side to the right or up, 256ths of a unit.
    error: i32,
    /// The part of the error of a turn that does not depend on the triangle, square units.
    least: i32,
}

impl DraftScale {
    /// The greatest distance of right times up from the direction of the eye, and the greatest
    /// squared length of both, for the errors below.
    const SKEW: f32 = 2e-6;
    const LENGTH_SQUARED: f32 = 1.01;
    /// The greatest distance of a hull's points, units. As axes are at most 1.005 long, sides stay
    /// below 29,160, and turns below 2^31.
    const SIZE: f32 = 29_000.0;
    /// The greatest sum of the numbers to the right and up of two sides: 29,160 * sqrt(8).
    const LONGEST: i32 = 82_500;

    /// Returns the scale for a hull.
    #[expect(clippy::cast_possible_truncation, reason = "below 2^28")]
    fn for_hull(hull: &PosedHull<'_>) -> Self {
        let bounds = hull.hull.bounds.map(|sides| sides.map(i32::from));
        // No length is more than 0.586 times the greatest coordinate and 0.415 times the sum.
        let thousandths =
            |[x, y, z]: [i32; 3], greatest, sum| greatest * x.max(y).max(z) + sum * (x + y + z);
        let size = thousandths(bounds.map(|[least, most]| most - least), 586, 415);
        // Numbers up have to be below 2^15 themselves, or a side as a whole would be off by 1 to
        // the right: the points' distance from the joint counts 0.9 times.
        let reach = thousandths(bounds.map(|[least, most]| most.max(-least)), 528, 374);
        #[expect(clippy::cast_precision_loss, reason = "below 2^20")]
        let size = f32::from(hull.scale.unit) * 0.001 * size.max(reach).max(1_000) as f32;
        let share = 1.0 / size;
        // Sides are off by 1, and by 1.8 * size / 2^16 + 2^-8 because of the axes.
        let error = 258 + (size / 128.0) as i32;
        // The product in floats is off by 2^-22 times 4 * size * reach + 8 * size^2, and the skew
        // makes SKEW * size^2, where the size is SIZE.
        let least = 4_000 + (1_000.0 * f32::from(hull.scale.reach) * share) as i32;
        Self {
            units: Self::SIZE * 65_536.0 * share,
            tolerance: ((Self::LONGEST * error) >> 8) + least,
            error,
            least,
        }
    }

    /// Returns the greatest error of the turn of a triangle with these sides, square units.
    #[inline]
    fn error(&self, sides: [i32; 2]) -> i32 {
        #[expect(clippy::cast_possible_truncation, reason = "the low half")]
        let lengths = sides.map(|side| (side >> 16).abs() + i32::from(side as i16).abs());
        (((lengths[0] + lengths[1]) * self.error) >> 8) + self.least
    }
}

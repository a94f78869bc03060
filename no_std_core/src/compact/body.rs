//! A body in a few kilobytes, and its pose.

mod extent;
mod visible;

pub use visible::{CompactSight, SeenHull};

use crate::avatar::{Avatar, Hull};
use crate::body::plane::sorted;
use crate::body::{JointPlace, OverBudget};
use crate::budget::{MAX_HULL_POINTS, MAX_HULLS};
use crate::camera::Camera;
use crate::facets::each_triangle;
use crate::format::JOINT_BITS;
use crate::hull::mirrored;
use crate::pose::ModelPose;
use crate::raster::{DrawError, Extent, PosedHulls, framing};
use core::convert::Infallible;
use core::ops::Range;
use core::slice;
use glam::Vec3;

/// A body of at most `POINTS` points and `FACETS` facets: 6 bytes a point, 2 a facet, and 404 more.
/// A built-in body has 488 points and at most 900 facets, 2 n - 4 for each of 19 hulls (Euler);
/// [`Room::for_avatar`] counts those of any avatar. [`super::CompactRows`] needs facets. `skia` does
/// not: with room for none, none are computed.
#[derive(Clone, Debug)]
pub struct CompactBody<const POINTS: usize, const FACETS: usize> {
    scale: BodyScale,
    hulls: heapless::Vec<CompactHull, MAX_HULLS>,
    /// Points in steps, in the frame of their hull's joint.
    points: heapless::Vec<[i16; 3], POINTS>,
    facets: heapless::Vec<FacetCorners, FACETS>,
}

/// The scale and size of a body.
#[derive(Clone, Copy, Debug)]
struct BodyScale {
    /// The length of a step of all points, metres.
    step: f32,
    /// The greatest absolute coordinate of all points, steps.
    reach: u16,
    /// Steps in a unit of [`CompactHull::bounds`].
    unit: u16,
}

impl BodyScale {
    const NONE: Self = Self {
        step: 0.0,
        reach: 0,
        unit: 1,
    };
}

#[derive(Clone, Copy, Debug)]
struct CompactHull {
    carrier: CompactCarrier,
    /// Whether the x of its points has to be negated.
    is_image: bool,
    /// The ends of its points and facets.
    points_end: u16,
    facets_end: u16,
    /// The minimum and maximum coordinate of its points along each axis, in the body's units.
    bounds: [[i8; 2]; 3],
}

/// A hull's joint in the low bits, and in the high ones the number of the draped hull that it is a
/// part of, counted from 1; 0 for a separate hull.
#[derive(Clone, Copy, Debug)]
struct CompactCarrier(u8);

impl CompactCarrier {
    fn from_hull(hull: &Hull<'_>) -> Result<Self, OverBudget> {
        let drape = hull.drape().map_or(0, |drape| drape + 1);
        let bits = hull.joint().index() | drape << JOINT_BITS;
        u8::try_from(bits).map(Self).map_err(|_| OverBudget)
    }

    fn joint(self) -> usize {
        usize::from(self.0) & ((1 << JOINT_BITS) - 1)
    }

    const fn drape(self) -> u8 {
        self.0 >> JOINT_BITS
    }
}

/// The room that an avatar needs in a [`CompactBody`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Room {
    /// Hulls, and parts of draped ones.
    pub hulls: usize,
    /// Points of all hulls.
    pub points: usize,
    /// Facets of all hulls except draped ones, and sides of those that are flat.
    pub facets: usize,
}

impl Room {
    /// Returns the room that an avatar needs.
    #[must_use]
    pub fn for_avatar(avatar: &Avatar<'_>) -> Self {
        avatar.hulls().fold(Self::default(), |room, hull| Self {
            hulls: room.hulls + 1,
            points: room.points + hull.len(),
            facets: match hull.drape() {
                Some(_) => room.facets,
                None => room.facets + facets_of(&hull),
            },
        })
    }

    /// Returns the room that is enough for both.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            hulls: self.hulls.max(other.hulls),
            points: self.points.max(other.points),
            facets: self.facets.max(other.facets),
        }
    }

    /// Returns the bytes of a [`CompactBody`] of exactly this many points and facets on the current
    /// target: each list is padded to whole `usize`s.
    #[must_use]
    pub const fn bytes(self) -> usize {
        type Empty = CompactBody<0, 0>;
        let points = size_of::<[i16; 3]>() * self.points;
        let facets = size_of::<FacetCorners>() * self.facets;
        let word = align_of::<Empty>();
        size_of::<Empty>() + points.next_multiple_of(word) + facets.next_multiple_of(word)
    }
}

impl<const POINTS: usize, const FACETS: usize> CompactBody<POINTS, FACETS> {
    /// A body without hulls.
    pub const EMPTY: Self = Self {
        scale: BodyScale::NONE,
        hulls: heapless::Vec::new(),
        points: heapless::Vec::new(),
        facets: heapless::Vec::new(),
    };

    /// Replaces the body by that of an avatar and finds its facets, once for all poses. Most of the
    /// time goes into the facets.
    ///
    /// # Errors
    /// When the avatar needs more room, or has coordinates of more than 32,767 steps; the body is
    /// then empty.
    pub fn load(&mut self, avatar: &Avatar<'_>) -> Result<(), OverBudget> {
        self.clear();
        let loaded = avatar.hulls().try_for_each(|hull| self.push(&hull));
        if loaded.is_err() {
            self.clear();
        }
        self.measure();
        loaded
    }

    /// Measures how far the points reach.
    fn measure(&mut self) {
        let coordinates = self.points.as_flattened().iter();
        let reach = coordinates
            .map(|coordinate| coordinate.unsigned_abs())
            .max();
        self.scale.reach = reach.unwrap_or(0);
        // All of them are within 127 units.
        self.scale.unit = self.scale.reach / 127 + 1;
        let (unit, mut start) = (f32::from(self.scale.unit), 0);
        for hull in &mut self.hulls {
            let end = usize::from(hull.points_end);
            let points = self.points.get(start..end).unwrap_or_default();
            start = end;
            for (axis, bounds) in hull.bounds.iter_mut().enumerate() {
                let along = || points.iter().map(|point| f32::from(point[axis]) / unit);
                let (least, most) = (along().reduce(f32::min), along().reduce(f32::max));
                let (least, most) = (least.unwrap_or_default(), most.unwrap_or_default());
                #[expect(clippy::cast_possible_truncation, reason = "within 127")]
                let outwards = [libm::floorf(least) as i8, libm::ceilf(most) as i8];
                *bounds = outwards;
            }
        }
    }

    fn clear(&mut self) {
        self.hulls.clear();
        self.points.clear();
        self.facets.clear();
    }

    fn push(&mut self, hull: &Hull<'_>) -> Result<(), OverBudget> {
        for steps in hull.read_steps() {
            let mut point = [0; 3];
            for (place, steps) in point.iter_mut().zip(steps.to_array()) {
                #[expect(clippy::cast_possible_truncation, reason = "a whole number of 17 bits")]
                let steps = steps as i32;
                *place = i16::try_from(steps).map_err(|_| OverBudget)?;
            }
            self.points.push(point).map_err(|_| OverBudget)?;
        }
        if FACETS > 0 && hull.drape().is_none() {
            each_facet(hull, |corners| self.facets.push(corners)).map_err(|_| OverBudget)?;
        }
        self.scale.step = hull.step().y;
        let end = |len| u16::try_from(len).map_err(|_| OverBudget);
        let hull = CompactHull {
            carrier: CompactCarrier::from_hull(hull)?,
            points_end: end(self.points.len())?,
            facets_end: end(self.facets.len())?,
            is_image: hull.step().x < 0.0,
            bounds: [[0; 2]; 3],
        };
        self.hulls.push(hull).map_err(|_| OverBudget)
    }

    /// Returns the body in a pose.
    #[must_use]
    pub fn posed<'b>(&'b self, pose: &'b ModelPose) -> CompactFigure<'b> {
        CompactFigure {
            scale: self.scale,
            hulls: &self.hulls,
            points: &self.points,
            facets: (FACETS > 0).then_some(self.facets.as_slice()),
            pose,
        }
    }
}

/// A body in a pose, in the walker's space. Points are computed only when they are drawn.
#[derive(Clone, Copy, Debug)]
pub struct CompactFigure<'a> {
    scale: BodyScale,
    hulls: &'a [CompactHull],
    points: &'a [[i16; 3]],
    /// `None` if there is no room for facets.
    facets: Option<&'a [FacetCorners]>,
    pose: &'a ModelPose,
}

impl<'a> CompactFigure<'a> {
    /// Returns all points, hull by hull, metres.
    pub fn points(&self) -> impl Iterator<Item = Vec3> {
        self.places_of(0..self.hulls.len())
    }

    /// Returns the numbers of the parts of each hull: one, except for a draped hull.
    pub(super) fn wholes(&self) -> impl Iterator<Item = Range<usize>> + use<'a> {
        let hulls = self.hulls;
        let mut start = 0;
        core::iter::from_fn(move || {
            let drape = hulls.get(start)?.carrier.drape();
            let rest = hulls.get(start + 1..).unwrap_or_default();
            let others = rest
                .iter()
                .take_while(|hull| drape > 0 && hull.carrier.drape() == drape);
            let parts = start..start + 1 + others.count();
            start = parts.end;
            Some(parts)
        })
    }

    /// Returns the places of the points of these parts, metres.
    fn places_of(&self, parts: Range<usize>) -> PointPlaces<'_> {
        PointPlaces {
            posed: self,
            parts,
            place: JointPlace::at(0, self.pose),
            step: Vec3::ZERO,
            points: [].iter(),
        }
    }

    /// Returns its hulls and the parts of draped ones.
    pub(super) fn hull_parts(&self) -> impl Iterator<Item = PosedHull<'a>> + use<'a> {
        let posed = *self;
        (0..self.hulls.len()).filter_map(move |number| posed.hull(number))
    }

    /// Returns one hull, or part of a draped one.
    #[inline]
    fn hull(&self, number: usize) -> Option<PosedHull<'a>> {
        let hull = self.hulls.get(number)?;
        let before = number
            .checked_sub(1)
            .and_then(|before| self.hulls.get(before));
        let (points_start, facets_start) =
            before.map_or((0, 0), |before| (before.points_end, before.facets_end));
        let range = |start, end| -> Range<usize> { usize::from(start)..usize::from(end) };
        let points = range(points_start, hull.points_end);
        let facets = range(facets_start, hull.facets_end);
        Some(PosedHull {
            hull,
            pose: self.pose,
            scale: self.scale,
            points: self.points.get(points).unwrap_or_default(),
            facets: self
                .facets
                .and_then(|all| all.get(facets))
                .unwrap_or_default(),
        })
    }
}

impl PosedHulls for CompactFigure<'_> {
    fn hulls(&self) -> impl Iterator<Item = impl Iterator<Item = Vec3>> {
        self.wholes().map(|parts| self.places_of(parts))
    }

    fn extent(&self, camera: &Camera) -> Result<Extent, DrawError> {
        // The slow path finds the error of a figure that has one.
        let extent = self.known_extent(camera);
        extent.map_or_else(|| framing::extent(self.points(), camera), Ok)
    }
}

/// A hull with its place in a pose. Not copied out of the body, as hulls are many.
#[derive(Debug)]
pub struct PosedHull<'a> {
    hull: &'a CompactHull,
    pose: &'a ModelPose,
    scale: BodyScale,
    points: &'a [[i16; 3]],
    facets: &'a [FacetCorners],
}

impl PosedHull<'_> {
    #[inline]
    fn place(&self) -> JointPlace {
        JointPlace::at(self.hull.carrier.joint(), self.pose)
    }

    /// Returns the length of a step along each axis, metres.
    #[inline]
    fn step(&self) -> Vec3 {
        let steps = Vec3::splat(self.scale.step);
        if self.hull.is_image {
            mirrored(steps)
        } else {
            steps
        }
    }
}

/// An iterator over the places of the points of some parts, metres.
struct PointPlaces<'a> {
    posed: &'a CompactFigure<'a>,
    /// Parts still to come.
    parts: Range<usize>,
    place: JointPlace,
    step: Vec3,
    points: slice::Iter<'a, [i16; 3]>,
}

impl Iterator for PointPlaces<'_> {
    type Item = Vec3;

    fn next(&mut self) -> Option<Vec3> {
        loop {
            if let Some(&point) = self.points.next() {
                return Some(self.place.carry(local(point, self.step)));
            }
            let hull = self.posed.hull(self.parts.next()?)?;
            (self.place, self.step) = (hull.place(), hull.step());
            self.points = hull.points.iter();
        }
    }
}

/// Converts a point from steps to metres, in the frame of its joint.
#[inline]
fn local(point: [i16; 3], step: Vec3) -> Vec3 {
    Vec3::from(point.map(f32::from)) * step
}

/// Returns the product of a whole axis and a point, modulo 2^32.
#[inline]
fn product([u, v, w]: [i32; 3], point: [i16; 3]) -> i32 {
    let [x, y, z] = point.map(i32::from);
    let sum = u.wrapping_mul(x).wrapping_add(v.wrapping_mul(y));
    sum.wrapping_add(w.wrapping_mul(z))
}

/// The corners of a facet, or of a flat hull's side, as numbers of points in the hull, in ascending
/// order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FacetCorners(u16);

impl FacetCorners {
    /// Bits of a point's number, below [`MAX_HULL_POINTS`].
    const BITS: u32 = MAX_HULL_POINTS.ilog2();
    /// The bit that is set if they turn clockwise for a viewer outside.
    const CLOCKWISE: u16 = 1 << (3 * Self::BITS);

    fn from_numbers(numbers: [u8; 3]) -> Self {
        let (sorted, is_clockwise) = sorted(numbers);
        let [a, b, c] = sorted.map(u16::from);
        let turn = if is_clockwise { Self::CLOCKWISE } else { 0 };
        Self(turn | a | b << Self::BITS | c << (2 * Self::BITS))
    }

    /// Returns whether it is the side of a flat hull.
    fn is_side(self) -> bool {
        let [_, b, c] = self.numbers();
        b == c
    }

    #[inline]
    fn numbers(self) -> [usize; 3] {
        let bits = usize::from(self.0);
        [0, Self::BITS, 2 * Self::BITS].map(|shift| bits >> shift & (MAX_HULL_POINTS - 1))
    }

    /// Returns a word with all bits set if they turn clockwise, otherwise 0.
    #[inline]
    const fn turned(self) -> i32 {
        (self.0.cast_signed() >> (3 * Self::BITS)) as i32
    }

    /// Returns the sign bit of an [`f32`] if they turn clockwise, otherwise 0.
    #[inline]
    const fn turn(self) -> u32 {
        ((self.0 & Self::CLOCKWISE) as u32) << 16
    }
}

/// Calls `take` with the facets of a hull, or the sides of a flat one; not at all for a line or a
/// point, which have no outline.
#[inline(never)]
fn each_facet<E>(
    hull: &Hull<'_>,
    mut take: impl FnMut(FacetCorners) -> Result<(), E>,
) -> Result<(), E> {
    each_triangle(&hull.read_all(), |corners| {
        take(FacetCorners::from_numbers(corners))
    })
}

/// Returns the number of facets of a hull, or of sides of a flat one.
fn facets_of(hull: &Hull<'_>) -> usize {
    let mut count = 0;
    let _: Result<(), Infallible> = each_facet(hull, |_| {
        count += 1;
        Ok(())
    });
    count
}

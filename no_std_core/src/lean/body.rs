//! A body in a few kilobytes, and what a camera sees of it in a pose.

use crate::avatar::{Avatar, Hull};
use crate::body::plane::{normal, sorted};
use crate::body::{OverBudget, Place};
use crate::budget::{MAX_HULL_POINTS, MAX_HULLS};
use crate::camera::{Camera, NEAR_M};
use crate::facets::Facets;
use crate::hull::mirrored;
use crate::pose::ModelPose;
use crate::raster::place::{Extent, Placement};
use core::convert::Infallible;
use core::ops::Range;
use glam::{Vec2, Vec3};

/// A body of at most `POINTS` points and `FACETS` facets: 6 bytes a point, 2 a facet, and 208
/// more. A made body has 485 points and at most 894 facets, 2 n - 4 of each of 19 hulls
/// (Euler); [`Room::of`] counts those of any. [`super::Rows`] asks for facets; tiny-skia does
/// not, and where there is room for none, none are looked for.
#[derive(Clone, Debug)]
pub struct Body<const POINTS: usize, const FACETS: usize> {
    /// How long the steps of all points are, metres.
    step: f32,
    hulls: heapless::Vec<BodyHull, MAX_HULLS>,
    /// In steps of their hull, in the frame of its joint.
    points: heapless::Vec<[i16; 3], POINTS>,
    facets: heapless::Vec<Corners, FACETS>,
}

#[derive(Clone, Copy, Debug)]
struct BodyHull {
    joint: u8,
    /// Whether its points' x are to be turned round.
    is_image: bool,
    /// Behind its last point and its last facet.
    points_end: u16,
    facets_end: u16,
}

/// How much room an avatar needs in a [`Body`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Room {
    /// Hulls.
    pub hulls: usize,
    /// Points of all hulls.
    pub points: usize,
    /// Facets of all hulls, and sides of those that are flat.
    pub facets: usize,
}

impl Room {
    /// That of an avatar.
    #[must_use]
    pub fn of(avatar: &Avatar<'_>) -> Self {
        avatar.hulls().fold(Self::default(), |room, hull| Self {
            hulls: room.hulls + 1,
            points: room.points + hull.len(),
            facets: room.facets + facets_of(&hull),
        })
    }

    /// Enough for either.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            hulls: self.hulls.max(other.hulls),
            points: self.points.max(other.points),
            facets: self.facets.max(other.facets),
        }
    }

    /// Bytes of a [`Body`] of exactly so many points and facets, on the target that asks: each
    /// list is filled up to whole `usize`s.
    #[must_use]
    pub const fn bytes(self) -> usize {
        type Empty = Body<0, 0>;
        let points = size_of::<[i16; 3]>() * self.points;
        let facets = size_of::<Corners>() * self.facets;
        let word = align_of::<Empty>();
        size_of::<Empty>() + points.next_multiple_of(word) + facets.next_multiple_of(word)
    }
}

impl<const POINTS: usize, const FACETS: usize> Body<POINTS, FACETS> {
    /// No hulls.
    pub const EMPTY: Self = Self {
        step: 0.0,
        hulls: heapless::Vec::new(),
        points: heapless::Vec::new(),
        facets: heapless::Vec::new(),
    };

    /// Unpacks an avatar in the place of what there was, and finds its facets: once for all
    /// poses. Most of the time goes into the facets.
    ///
    /// # Errors
    /// When it needs more room, or has coordinates of more than 32,767 steps; the body is then
    /// empty.
    pub fn load(&mut self, avatar: &Avatar<'_>) -> Result<(), OverBudget> {
        self.clear();
        let loaded = avatar.hulls().try_for_each(|hull| self.push(&hull));
        if loaded.is_err() {
            self.clear();
        }
        loaded
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
        if FACETS > 0 {
            each_facet(hull, |corners| self.facets.push(corners)).map_err(|_| OverBudget)?;
        }
        self.step = hull.step().y;
        let end = |len| u16::try_from(len).map_err(|_| OverBudget);
        let hull = BodyHull {
            joint: u8::try_from(hull.joint().index()).map_err(|_| OverBudget)?,
            points_end: end(self.points.len())?,
            facets_end: end(self.facets.len())?,
            is_image: hull.step().x < 0.0,
        };
        self.hulls.push(hull).map_err(|_| OverBudget)
    }

    /// The body in a pose.
    #[must_use]
    pub fn posed<'b>(&'b self, pose: &'b ModelPose) -> Posed<'b> {
        Posed {
            step: self.step,
            hulls: &self.hulls,
            points: &self.points,
            facets: &self.facets,
            pose,
        }
    }
}

/// A body in a pose, in the walker's space: nothing is computed yet.
#[derive(Clone, Copy, Debug)]
pub struct Posed<'a> {
    step: f32,
    hulls: &'a [BodyHull],
    points: &'a [[i16; 3]],
    facets: &'a [Corners],
    pose: &'a ModelPose,
}

impl<'a> Posed<'a> {
    /// All points, hull by hull, metres.
    pub fn points(&self) -> impl Iterator<Item = Vec3> {
        self.hulls().flat_map(|hull| {
            let PosedHull {
                place,
                step,
                points,
                ..
            } = hull;
            let points = points.iter();
            points.map(move |&point| place.carry(local(point, step)))
        })
    }

    /// Its hulls, one after another.
    fn hulls(&self) -> impl Iterator<Item = PosedHull<'a>> + use<'a> {
        let Self {
            step,
            hulls,
            points,
            facets,
            pose,
        } = *self;
        let steps = Vec3::splat(step);
        let mut starts = [0; 2];
        hulls.iter().map(move |hull| {
            let ends = [hull.points_end, hull.facets_end].map(usize::from);
            let own = |index: usize| -> Range<usize> { starts[index]..ends[index] };
            let posed = PosedHull {
                place: Place::of(usize::from(hull.joint), pose),
                step: if hull.is_image {
                    mirrored(steps)
                } else {
                    steps
                },
                points: points.get(own(0)).unwrap_or_default(),
                facets: facets.get(own(1)).unwrap_or_default(),
            };
            starts = ends;
            posed
        })
    }

    /// The rectangle that its points take in the image; none where one has no place there, or
    /// without points.
    pub(super) fn extent(&self, camera: &Camera) -> Option<Extent> {
        let mut extent = Extent {
            min: Vec2::INFINITY,
            max: Vec2::NEG_INFINITY,
        };
        let mut wild = 0.0;
        for PosedHull {
            place,
            step,
            points,
            ..
        } in self.hulls()
        {
            for &point in points {
                let point = place.carry(local(point, step));
                if camera.depth_m(point) < NEAR_M {
                    return None;
                }
                let Vec2 { x, y } = camera.project(point);
                // Not finite, whatever is added to what is not.
                wild += x + y;
                extent.min.x = if x < extent.min.x { x } else { extent.min.x };
                extent.min.y = if y < extent.min.y { y } else { extent.min.y };
                extent.max.x = if x > extent.max.x { x } else { extent.max.x };
                extent.max.y = if y > extent.max.y { y } else { extent.max.y };
            }
        }
        (wild.is_finite() && !self.points.is_empty()).then_some(extent)
    }
}

/// A hull, and where a pose puts it.
pub struct PosedHull<'a> {
    place: Place,
    /// How long the steps of its points are, metres.
    step: Vec3,
    points: &'a [[i16; 3]],
    facets: &'a [Corners],
}

/// A point in the frame of its joint, metres.
#[inline]
fn local(point: [i16; 3], step: Vec3) -> Vec3 {
    Vec3::from(point.map(f32::from)) * step
}

/// A body in a pose before a camera.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    posed: &'a Posed<'a>,
    camera: &'a Camera,
    /// The direction of the eye, or where it stands.
    seen_from: Vec3,
    is_near: bool,
}

/// One hull of it in the image.
pub struct SeenHull<'a> {
    sight: Sight<'a>,
    /// The direction of the eye, or where it stands, in the frame of the joint.
    seen_from: Vec3,
    facets: &'a [Corners],
    len: usize,
    corners: [Corner; MAX_HULL_POINTS],
}

/// A point of it.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Where it appears, pixels.
    pub pixel: Vec2,
    /// In the frame of its joint, metres.
    point: Vec3,
}

impl Corner {
    const ZERO: Self = Self {
        pixel: Vec2::ZERO,
        point: Vec3::ZERO,
    };
}

/// Lines between the points of a hull: bit `b` of word `a` is the line between points `a` and
/// `b`, of which `a` is the lower number.
pub type Outline = [u32; MAX_HULL_POINTS];

impl<'a> Sight<'a> {
    pub fn new(posed: &'a Posed<'a>, camera: &'a Camera) -> Self {
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

    /// Its hulls, one after another.
    pub fn hulls(&self) -> impl Iterator<Item = PosedHull<'a>> + use<'a> {
        self.posed.hulls()
    }

    /// Where a hull's points appear, pixels.
    pub fn pixels(
        &self,
        hull: &PosedHull<'_>,
        placement: &Placement,
    ) -> impl Iterator<Item = Vec2> {
        let steps = hull.points.iter();
        steps.map(|&steps| {
            let point = hull.place.carry(local(steps, hull.step));
            placement.place(self.camera.project(point))
        })
    }
}

impl<'a> SeenHull<'a> {
    /// None yet.
    pub fn new(sight: &Sight<'a>) -> Self {
        Self {
            sight: *sight,
            seen_from: Vec3::ZERO,
            facets: &[],
            len: 0,
            corners: [Corner::ZERO; MAX_HULL_POINTS],
        }
    }

    /// Puts a hull in the place of what there was.
    pub fn place(&mut self, hull: &PosedHull<'a>, placement: &Placement) {
        let sight = self.sight;
        self.facets = hull.facets;
        self.seen_from = if sight.is_near {
            hull.place.point(sight.seen_from)
        } else {
            hull.place.direction(sight.seen_from)
        };
        self.len = hull.points.len();
        for (&steps, corner) in hull.points.iter().zip(&mut self.corners) {
            corner.point = local(steps, hull.step);
            let image = sight.camera.project(hull.place.carry(corner.point));
            corner.pixel = placement.place(image);
        }
    }

    /// Its points.
    pub fn corners(&self) -> &[Corner] {
        self.corners.get(..self.len).unwrap_or_default()
    }

    /// One of them.
    pub fn corner(&self, number: usize) -> &Corner {
        &self.corners[number % MAX_HULL_POINTS]
    }

    /// The edges between facets that are seen and facets that are not: each facet that is
    /// seen toggles its three, and what two of them toggled is off again.
    pub fn outline(&self) -> Outline {
        if self.sight.is_near {
            self.outline_from::<true>()
        } else {
            self.outline_from::<false>()
        }
    }

    #[inline]
    fn outline_from<const NEAR: bool>(&self) -> Outline {
        let mut outline = [0; MAX_HULL_POINTS];
        for &corners in self.facets {
            let [a, b, c] = corners.numbers();
            // What has two corners is a side of a flat hull, and its outline from everywhere.
            if b == c {
                outline[a] ^= 1 << b;
            } else if self.sees::<NEAR>(corners) {
                outline[a] ^= 1 << b | 1 << c;
                outline[b] ^= 1 << c;
            }
        }
        outline
    }

    /// Whether the eye is on a facet's outer side; infinitely far away only the direction
    /// counts.
    #[inline]
    fn sees<const NEAR: bool>(&self, corners: Corners) -> bool {
        let points = corners.numbers().map(|number| self.corners[number].point);
        let normal = normal(points);
        let mut side = self.seen_from.dot(normal);
        if NEAR {
            side -= normal.dot(points[0]);
        }
        // A difference is above 0 where the first number is the greater.
        (side.to_bits() ^ corners.turn()).cast_signed() > 0
    }
}

/// The corners of a facet, or of a flat hull's side, by their numbers in the hull, which do not
/// fall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Corners(u16);

impl Corners {
    /// Bits of a number below [`MAX_HULL_POINTS`].
    const BITS: u32 = MAX_HULL_POINTS.ilog2();
    /// Set if they turn clockwise for a viewer outside.
    const CLOCKWISE: u16 = 1 << (3 * Self::BITS);

    fn of(numbers: [u8; 3]) -> Self {
        let (sorted, is_clockwise) = sorted(numbers);
        let [a, b, c] = sorted.map(u16::from);
        let turn = if is_clockwise { Self::CLOCKWISE } else { 0 };
        Self(turn | a | b << Self::BITS | c << (2 * Self::BITS))
    }

    #[inline]
    fn numbers(self) -> [usize; 3] {
        let bits = usize::from(self.0);
        [0, Self::BITS, 2 * Self::BITS].map(|shift| bits >> shift & (MAX_HULL_POINTS - 1))
    }

    /// The sign of an [`f32`], if they turn clockwise.
    #[inline]
    const fn turn(self) -> u32 {
        ((self.0 & Self::CLOCKWISE) as u32) << 16
    }
}

/// Gives `take` the facets of a hull, or the sides of a flat one; none of a line or a point,
/// which have no outline.
#[inline(never)]
fn each_facet<E>(hull: &Hull<'_>, mut take: impl FnMut(Corners) -> Result<(), E>) -> Result<(), E> {
    let surface = Facets::of(&hull.read_all());
    for facet in &surface.facets {
        take(Corners::of(facet.corners))?;
    }
    if surface.facets.is_empty() {
        for &[a, b] in &surface.edges {
            take(Corners::of([a, b, b]))?;
        }
    }
    Ok(())
}

/// How many there are.
fn facets_of(hull: &Hull<'_>) -> usize {
    let mut count = 0;
    let _: Result<(), Infallible> = each_facet(hull, |_| {
        count += 1;
        Ok(())
    });
    count
}

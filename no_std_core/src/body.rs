//! A body ready to be posed, and a figure: the body in a pose.
//!
//! What does not depend on the pose is found once: where the points of each hull are in the
//! frame of its joint, and which facets they span. What does not depend on the viewpoint is
//! found once a frame. Coordinates lie in lanes, one array an axis.

mod drape;
mod plane;
#[cfg(test)]
mod tests;

use crate::avatar::Avatar;
use crate::budget::{LANES, MAX_DRAPED_HULLS, MAX_FACETS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use crate::facets::Facets;
use crate::pose::ModelPose;
use crate::skeleton::{JOINTS, Joint};
use core::fmt;
use core::ops::Range;
use drape::{Drape, Surface};
use glam::{Mat3, Vec3};
use plane::{Plane, border, radiate, sides};

/// Vectors by axis.
#[derive(Clone, Debug)]
pub(crate) struct Lanes<const N: usize> {
    pub x: [f32; N],
    pub y: [f32; N],
    pub z: [f32; N],
}

impl<const N: usize> Lanes<N> {
    const ZERO: Self = Self {
        x: [0.0; N],
        y: [0.0; N],
        z: [0.0; N],
    };

    fn get(&self, index: usize) -> Option<Vec3> {
        Some(Vec3::new(
            *self.x.get(index)?,
            *self.y.get(index)?,
            *self.z.get(index)?,
        ))
    }

    fn set(&mut self, index: usize, vector: Vec3) {
        let axes = [&mut self.x, &mut self.y, &mut self.z];
        for (axis, value) in axes.into_iter().zip(vector.to_array()) {
            if let Some(place) = axis.get_mut(index) {
                *place = value;
            }
        }
    }

    /// Fills a range with the same range of `from`, turned and then moved.
    fn carry(&mut self, range: Range<usize>, from: &Self, turn: Mat3, offset: Vec3) {
        let [a, b, c] = turn.to_cols_array_2d();
        let offset = offset.to_array();
        let from = (
            from.x.get(range.clone()).unwrap_or_default(),
            from.y.get(range.clone()).unwrap_or_default(),
            from.z.get(range.clone()).unwrap_or_default(),
        );
        let axes = [&mut self.x, &mut self.y, &mut self.z];
        for (axis, out) in axes.into_iter().enumerate() {
            let out = out.get_mut(range.clone()).unwrap_or_default();
            let places = out.iter_mut().zip(from.0).zip(from.1).zip(from.2);
            for (((out, x), y), z) in places {
                *out = offset[axis] + (a[axis] * x + b[axis] * y + c[axis] * z);
            }
        }
    }
}

/// What carries the points of a hull.
#[derive(Clone, Copy, Debug)]
enum Carrier {
    /// One joint carries all of them.
    Joint(usize),
    /// A joint for each: those of the body's drape of this number.
    Drape(usize),
}

/// One hull of a body.
#[derive(Clone, Debug)]
struct BodyHull {
    carrier: Carrier,
    /// Behind its last point and its last facet in the body's arrays.
    points_end: usize,
    facets_end: usize,
    edges_end: usize,
    /// Edges that are its outline from everywhere: those of a flat hull.
    border: [u64; 2],
}

impl BodyHull {
    /// Nothing, before the first hull.
    const NONE: Self = Self {
        carrier: Carrier::Joint(0),
        points_end: 0,
        facets_end: 0,
        edges_end: 0,
        border: [0; 2],
    };
}

/// The hulls of an avatar, unpacked, with their facets. 102 kB: for a host, where it is made once for
/// all frames and viewpoints.
#[derive(Clone, Debug)]
pub struct Body {
    hulls: heapless::Vec<BodyHull, MAX_HULLS>,
    drapes: heapless::Vec<Drape, MAX_DRAPED_HULLS>,
    points: Lanes<MAX_POINTS>,
    /// Facets' normals, of any length, in the frames of their joints.
    normals: Lanes<MAX_FACETS>,
    /// Normals' products with a point of the facet.
    offsets: [f32; MAX_FACETS],
    /// A normal tells a direction from its opposite if their product is beyond this.
    tolerances: [f32; MAX_FACETS],
    /// Edges of each facet, a bit each: numbers 0 to 63, then 64 to 89.
    sides: [[u64; MAX_FACETS]; 2],
    /// Edges that begin or end at each point, likewise.
    spokes: [[u64; 2]; MAX_POINTS],
    /// Points, counted within its hull, at which each edge begins and ends.
    ends: [heapless::Vec<u8, { 3 * MAX_POINTS }>; 2],
}

impl Default for Body {
    fn default() -> Self {
        Self {
            hulls: heapless::Vec::new(),
            drapes: heapless::Vec::new(),
            points: Lanes::ZERO,
            normals: Lanes::ZERO,
            offsets: [0.0; MAX_FACETS],
            tolerances: [0.0; MAX_FACETS],
            sides: [[0; MAX_FACETS]; 2],
            spokes: [[0; 2]; MAX_POINTS],
            ends: [heapless::Vec::new(), heapless::Vec::new()],
        }
    }
}

impl Body {
    /// Unpacks an avatar. Takes about 20 us a hull.
    #[must_use]
    pub fn new(avatar: &Avatar<'_>) -> Self {
        let mut body = Self::default();
        for hull in avatar.hulls() {
            let fits = body.push(hull.joint(), hull.points());
            debug_assert!(fits.is_ok(), "a parsed avatar is within the budget");
        }
        body
    }

    /// Adds a hull given by points in the frame of `joint`, metres: something that a body
    /// wears or carries, or a test's figure.
    ///
    /// # Errors
    /// When the budget is used up; nothing is added then.
    pub fn push(
        &mut self,
        joint: Joint,
        points: impl IntoIterator<Item = Vec3>,
    ) -> Result<(), OverBudget> {
        let mut hull = heapless::Vec::<Vec3, MAX_HULL_POINTS>::new();
        for point in points {
            hull.push(point).map_err(|_| OverBudget)?;
        }
        let surface = Facets::of(&hull);
        let carrier = Carrier::Joint(joint.index());
        let before = self.add(&hull, carrier, surface.facets.len(), &surface)?;
        for (index, facet) in (before.facets_end..).zip(&surface.facets) {
            let plane = Plane::of(facet, &hull);
            self.normals.set(index, plane.normal);
            if let Some(offset) = self.offsets.get_mut(index) {
                *offset = plane.offset;
            }
            if let Some(tolerance) = self.tolerances.get_mut(index) {
                *tolerance = plane.tolerance;
            }
            for (sides, half) in self.sides.iter_mut().zip(sides(facet)) {
                if let Some(place) = sides.get_mut(index) {
                    *place = half;
                }
            }
        }
        let spokes = self.spokes.get_mut(before.points_end..).unwrap_or_default();
        radiate(&surface, spokes);
        // Three for each point, which the capacity allows.
        for (side, ends) in self.ends.iter_mut().enumerate() {
            ends.extend(
                surface
                    .edges
                    .iter()
                    .filter_map(|edge| edge.get(side).copied()),
            );
        }
        Ok(())
    }

    /// Adds a hull whose points hang on a joint each, metres, in its frame: what they span in
    /// a pose is cloth that is taut between them, such as a skirt between the legs.
    ///
    /// A figure finds its facets anew in each pose: about 3 us for 16 points and 11 us for 32 (the
    /// least of 60 runs, one core of a shared AMD EPYC).
    ///
    /// # Errors
    /// When the budget is used up, of which [`MAX_DRAPED_HULLS`] is a part; nothing is added
    /// then.
    pub fn push_draped(
        &mut self,
        points: impl IntoIterator<Item = (Joint, Vec3)>,
    ) -> Result<(), OverBudget> {
        let mut hull = heapless::Vec::<Vec3, MAX_HULL_POINTS>::new();
        let mut drape = Drape::default();
        for (joint, point) in points {
            hull.push(point).map_err(|_| OverBudget)?;
            drape.push(joint).map_err(|_| OverBudget)?;
        }
        if self.drapes.is_full() {
            return Err(OverBudget);
        }
        // As many facets as a pose may show (Euler).
        let facets = (2 * hull.len()).saturating_sub(4);
        let carrier = Carrier::Drape(self.drapes.len());
        self.add(&hull, carrier, facets, &Facets::default())?;
        self.drapes.push(drape).map_err(|_| OverBudget)
    }

    /// Adds points, and room for so many facets and the edges of `surface`; the hull before.
    fn add(
        &mut self,
        points: &[Vec3],
        carrier: Carrier,
        facets: usize,
        surface: &Facets,
    ) -> Result<BodyHull, OverBudget> {
        let before = self.hulls.last().cloned().unwrap_or(BodyHull::NONE);
        let points_end = before.points_end + points.len();
        let facets_end = before.facets_end + facets.next_multiple_of(LANES);
        if points_end > MAX_POINTS || facets_end > MAX_FACETS {
            return Err(OverBudget);
        }
        let hull = BodyHull {
            carrier,
            points_end,
            facets_end,
            edges_end: before.edges_end + surface.edges.len(),
            border: border(surface),
        };
        self.hulls.push(hull).map_err(|_| OverBudget)?;
        for (index, &point) in (before.points_end..).zip(points) {
            self.points.set(index, point);
        }
        Ok(before)
    }
}

/// A body in a pose, in the walker's space: computed once a frame, seen from every
/// viewpoint. 50 kB.
#[derive(Clone, Debug)]
pub struct Figure<'a> {
    body: &'a Body,
    pub(crate) points: Lanes<MAX_POINTS>,
    pub(crate) normals: Lanes<MAX_FACETS>,
    /// Normals' products with a point of the facet.
    pub(crate) offsets: [f32; MAX_FACETS],
    /// Of the draped hulls, in the order of the body's drapes.
    surfaces: [Surface; MAX_DRAPED_HULLS],
}

/// Where one hull of a figure is in its arrays.
#[derive(Clone, Debug)]
pub(crate) struct FigureHull<'a> {
    pub points: Range<usize>,
    pub facets: Range<usize>,
    pub sides: [&'a [u64]; 2],
    /// Points at which its edges begin and end.
    pub from: &'a [u8],
    pub to: &'a [u8],
    pub border: [u64; 2],
    /// Edges that begin or end at each of its points.
    pub spokes: &'a [[u64; 2]],
    /// Of its facets, as in [`Body`].
    pub tolerances: &'a [f32],
}

impl<'a> Figure<'a> {
    /// Carries the hulls of `body` to where `pose` puts their joints.
    #[must_use]
    pub fn new(body: &'a Body, pose: &ModelPose) -> Self {
        let mut figure = Self::at_rest(body);
        figure.update(pose);
        figure
    }

    /// The hulls as they are: all joints at the origin.
    #[must_use]
    pub fn at_rest(body: &'a Body) -> Self {
        let mut figure = Self {
            body,
            points: body.points.clone(),
            normals: body.normals.clone(),
            offsets: body.offsets,
            surfaces: [const { Surface::NOTHING }; MAX_DRAPED_HULLS],
        };
        let mut before = &BodyHull::NONE;
        for hull in &body.hulls {
            if let Carrier::Drape(drape) = hull.carrier {
                figure.wrap(drape, before.points_end..hull.points_end, before.facets_end);
            }
            before = hull;
        }
        figure.fill_lanes();
        figure
    }

    /// The same in place, for the next frame.
    pub fn update(&mut self, pose: &ModelPose) {
        let body = self.body;
        let mut before = &BodyHull::NONE;
        for hull in &body.hulls {
            let points = before.points_end..hull.points_end;
            let facets = before.facets_end..hull.facets_end;
            match hull.carrier {
                Carrier::Joint(joint) => self.carry(joint, points, facets, pose),
                Carrier::Drape(drape) => {
                    self.hang(drape, points.clone(), pose);
                    self.wrap(drape, points, facets.start);
                }
            }
            before = hull;
        }
        self.fill_lanes();
    }

    /// Carries a hull with its facets to where its joint is.
    fn carry(
        &mut self,
        joint: usize,
        points: Range<usize>,
        facets: Range<usize>,
        pose: &ModelPose,
    ) {
        let (body, joint) = (self.body, joint.min(JOINTS - 1));
        let (turn, offset) = (pose.orientations[joint], pose.positions[joint]);
        self.points.carry(points, &body.points, turn, offset);
        self.normals
            .carry(facets.clone(), &body.normals, turn, Vec3::ZERO);
        for facet in facets {
            let moved = self.normals.get(facet).map(|normal| normal.dot(offset));
            let rest = body.offsets.get(facet);
            if let (Some(place), Some(moved), Some(rest)) =
                (self.offsets.get_mut(facet), moved, rest)
            {
                *place = rest + moved;
            }
        }
    }

    /// Fills the last lanes up with the last point, so that they widen nothing.
    fn fill_lanes(&mut self) {
        let len = self.len();
        if let Some(last) = len.checked_sub(1).and_then(|last| self.points.get(last)) {
            for index in len..len.next_multiple_of(LANES) {
                self.points.set(index, last);
            }
        }
    }

    /// How many points there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.body.hulls.last().map_or(0, |hull| hull.points_end)
    }

    /// Whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All points, hull by hull, metres.
    pub fn points(&self) -> impl Iterator<Item = Vec3> + Clone {
        (0..self.len()).filter_map(|index| self.points.get(index))
    }

    /// The points of each hull, metres.
    pub fn hulls(&self) -> impl Iterator<Item = impl Iterator<Item = Vec3> + Clone> {
        self.hull_parts()
            .map(|part| part.points.filter_map(|index| self.points.get(index)))
    }

    /// Where each hull is in the arrays.
    pub(crate) fn hull_parts(&self) -> impl Iterator<Item = FigureHull<'_>> {
        let body = self.body;
        let (mut points, mut facets, mut edges) = (0, 0, 0);
        body.hulls.iter().map(move |hull| {
            let own = points..hull.points_end;
            let part = match hull.carrier {
                Carrier::Joint(_) => {
                    let range = facets..hull.facets_end;
                    let ends = edges..hull.edges_end;
                    FigureHull {
                        spokes: body.spokes.get(own.clone()).unwrap_or_default(),
                        tolerances: body.tolerances.get(range.clone()).unwrap_or_default(),
                        sides: [
                            body.sides[0].get(range.clone()).unwrap_or_default(),
                            body.sides[1].get(range.clone()).unwrap_or_default(),
                        ],
                        points: own,
                        facets: range,
                        from: body.ends[0].get(ends.clone()).unwrap_or_default(),
                        to: body.ends[1].get(ends).unwrap_or_default(),
                        border: hull.border,
                    }
                }
                Carrier::Drape(drape) => {
                    self.surfaces[drape.min(MAX_DRAPED_HULLS - 1)].part(own, facets)
                }
            };
            (points, facets, edges) = (hull.points_end, hull.facets_end, hull.edges_end);
            part
        })
    }
}

/// A figure has more hulls or points than [`crate::budget`] allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OverBudget;

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "more than {MAX_HULLS} hulls, {MAX_DRAPED_HULLS} of them draped, {MAX_HULL_POINTS} points of a hull or {MAX_POINTS} points in all"
        )
    }
}

impl core::error::Error for OverBudget {}

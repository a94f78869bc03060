//! A body ready to be posed, and a figure: the body in a pose.
//!
//! What does not depend on the pose is found once: where the points of each hull are in the
//! frame of its joint, and which facets they span. What does not depend on the viewpoint is
//! found once a frame. Coordinates lie in lanes, one array an axis.

#[cfg(test)]
mod tests;

use crate::avatar::Avatar;
use crate::budget::{LANES, MAX_FACETS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use crate::facets::Facets;
use crate::pose::ModelPose;
use crate::skeleton::{JOINTS, Joint};
use core::fmt;
use core::ops::Range;
use glam::{Mat3, Vec3};

/// A facet faces a direction only if it does by more than this sine: of a sliver's normal
/// little but rounding is left. Ours: a hundred times what hulls of a few centimetres round.
const EDGE_ON: f32 = 1e-4;

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

/// One hull of a body.
#[derive(Clone, Debug, Default)]
struct BodyHull {
    joint: usize,
    /// Behind its last point and its last facet in the body's arrays.
    points_end: usize,
    facets_end: usize,
    edges_end: usize,
    /// Edges that are its outline from everywhere: those of a flat hull.
    border: [u64; 2],
}

/// The hulls of an avatar, unpacked, with their facets. 101 kB: for a host, where it is made once for
/// all frames and viewpoints.
#[derive(Clone, Debug)]
pub struct Body {
    hulls: heapless::Vec<BodyHull, MAX_HULLS>,
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
        let before = self.hulls.last().cloned().unwrap_or_default();
        let mut hull = heapless::Vec::<Vec3, MAX_HULL_POINTS>::new();
        for point in points {
            hull.push(point).map_err(|_| OverBudget)?;
        }
        let surface = Facets::of(&hull);
        let points_end = before.points_end + hull.len();
        let edges_end = before.edges_end + surface.edges.len();
        let padded = surface.facets.len().next_multiple_of(LANES);
        let facets_end = before.facets_end + padded;
        if points_end > MAX_POINTS || facets_end > MAX_FACETS || self.hulls.is_full() {
            return Err(OverBudget);
        }
        let border = if surface.facets.is_empty() {
            halves((1 << surface.edges.len()) - 1)
        } else {
            [0; 2]
        };
        for (index, &point) in hull.iter().enumerate() {
            self.points.set(before.points_end + index, point);
        }
        for (index, facet) in (before.facets_end..).zip(&surface.facets) {
            let corner = |side: usize| {
                let corner = facet.corners.get(side).copied().unwrap_or_default();
                hull.get(usize::from(corner)).copied().unwrap_or_default()
            };
            let (a, b, c) = (corner(0), corner(1), corner(2));
            // Of sides no longer than 1, whose products neither overflow nor vanish; a
            // difference of halves is finite.
            let (ab, ac) = (0.5 * b - 0.5 * a, 0.5 * c - 0.5 * a);
            let reach = ab.abs().max(ac.abs()).max_element();
            let (ab, ac) = (ab / reach, ac / reach);
            let normal = ab.cross(ac);
            self.normals.set(index, normal);
            if let Some(offset) = self.offsets.get_mut(index) {
                *offset = normal.dot(a);
            }
            if let Some(tolerance) = self.tolerances.get_mut(index) {
                let product = libm::sqrtf(ab.length_squared() * ac.length_squared());
                *tolerance = EDGE_ON * product + f32::MIN_POSITIVE;
            }
            let bits = facet
                .edges
                .iter()
                .fold(0u128, |bits, &edge| bits | 1 << edge);
            for (sides, half) in self.sides.iter_mut().zip(halves(bits)) {
                if let Some(place) = sides.get_mut(index) {
                    *place = half;
                }
            }
        }
        for (number, edge) in surface.edges.iter().enumerate() {
            let bit = halves(1 << number);
            for &end in edge {
                if let Some(spokes) = self.spokes.get_mut(before.points_end + usize::from(end)) {
                    *spokes = [spokes[0] | bit[0], spokes[1] | bit[1]];
                }
            }
        }
        // Three for each point, which the capacity allows.
        for (side, ends) in self.ends.iter_mut().enumerate() {
            ends.extend(
                surface
                    .edges
                    .iter()
                    .filter_map(|edge| edge.get(side).copied()),
            );
        }
        let hull = BodyHull {
            joint: joint.index(),
            points_end,
            facets_end,
            edges_end,
            border,
        };
        self.hulls.push(hull).map_err(|_| OverBudget)
    }
}

/// Bits 0 to 63, and bits 64 to 127.
fn halves(bits: u128) -> [u64; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "half by half")]
    let halves = [bits as u64, (bits >> 64) as u64];
    halves
}

/// A body in a pose, in the walker's space: computed once a frame, seen from every
/// viewpoint. 42 kB.
#[derive(Clone, Debug)]
pub struct Figure<'a> {
    body: &'a Body,
    pub(crate) points: Lanes<MAX_POINTS>,
    pub(crate) normals: Lanes<MAX_FACETS>,
    /// Normals' products with a point of the facet.
    pub(crate) offsets: [f32; MAX_FACETS],
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
        };
        figure.fill_lanes();
        figure
    }

    /// The same in place, for the next frame.
    pub fn update(&mut self, pose: &ModelPose) {
        let body = self.body;
        let mut before = BodyHull::default();
        for hull in &body.hulls {
            let joint = hull.joint.min(JOINTS - 1);
            let (turn, offset) = (pose.orientations[joint], pose.positions[joint]);
            let points = before.points_end..hull.points_end;
            let facets = before.facets_end..hull.facets_end;
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
            before = hull.clone();
        }
        self.fill_lanes();
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
    pub(crate) fn hull_parts(&self) -> impl Iterator<Item = FigureHull<'a>> + use<'a> {
        let body = self.body;
        let (mut points, mut facets, mut edges) = (0, 0, 0);
        body.hulls.iter().map(move |hull| {
            let range = facets..hull.facets_end;
            let ends = edges..hull.edges_end;
            let part = FigureHull {
                points: points..hull.points_end,
                spokes: body.spokes.get(points..hull.points_end).unwrap_or_default(),
                tolerances: body.tolerances.get(range.clone()).unwrap_or_default(),
                sides: [
                    body.sides[0].get(range.clone()).unwrap_or_default(),
                    body.sides[1].get(range.clone()).unwrap_or_default(),
                ],
                facets: range,
                from: body.ends[0].get(ends.clone()).unwrap_or_default(),
                to: body.ends[1].get(ends).unwrap_or_default(),
                border: hull.border,
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
            "more than {MAX_HULLS} hulls, {MAX_HULL_POINTS} points of a hull or {MAX_POINTS} points in all"
        )
    }
}

impl core::error::Error for OverBudget {}

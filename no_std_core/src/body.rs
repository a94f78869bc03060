//! A body ready to be posed, and a figure: the body in a pose.
//!
//! Whatever does not depend on the pose is computed once: where the points of each hull are in the
//! frame of its joint, and which facets they span. Whatever does not depend on the viewpoint is
//! computed once a frame. Coordinates lie in lanes, one array an axis.

pub(crate) mod clearance;
mod drape;
mod figure;
pub(crate) mod plane;
#[cfg(test)]
mod tests;

use crate::avatar::{Avatar, Hull};
use crate::budget::{LANES, MAX_DRAPED_HULLS, MAX_FACETS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use crate::facets::Facets;
use crate::pose::ModelPose;
use crate::simd::Edges;
use crate::skeleton::Joint;
use clearance::set_clearances;
use core::fmt;
use core::ops::Range;
use drape::Drape;
pub use figure::Figure;
pub(crate) use figure::{JointPlace, JointPlaces};
use glam::{Mat3, Vec3};
pub(crate) use plane::FigureHull;
use plane::{Facets16, edges_of, radiate, set_facets};

/// Vectors stored by axis.
#[derive(Clone, Debug)]
pub(crate) struct VectorLanes<const N: usize> {
    pub x: [f32; N],
    pub y: [f32; N],
    pub z: [f32; N],
}

impl<const N: usize> VectorLanes<N> {
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

    /// Fills a range with the same range of `from`, rotated and then translated.
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

/// The joint or joints that carry the points of a hull.
#[derive(Clone, Copy, Debug)]
enum HullCarrier {
    /// One joint carries all of them.
    Joint(usize),
    /// A joint for each point: those of the body's drape with this number.
    Drape(usize),
}

/// One hull of a body.
#[derive(Clone, Debug)]
struct UnpackedHull {
    carrier: HullCarrier,
    /// The ends of its points, facets and edges in the body's arrays.
    points_end: usize,
    facets_end: usize,
    edges_end: usize,
}

impl UnpackedHull {
    /// The ends of an empty body.
    const NONE: Self = Self {
        carrier: HullCarrier::Joint(0),
        points_end: 0,
        facets_end: 0,
        edges_end: 0,
    };
}

/// The hulls of an avatar, unpacked, with their facets. 89 kB: for a host, which makes it once for
/// all frames and viewpoints.
#[derive(Clone, Debug)]
pub struct UnpackedBody {
    hulls: heapless::Vec<UnpackedHull, MAX_HULLS>,
    drapes: heapless::Vec<Drape, MAX_DRAPED_HULLS>,
    points: VectorLanes<MAX_POINTS>,
    /// Facets of the hulls that are not draped, in the frames of their joints.
    facets: [Facets16; MAX_FACETS / LANES],
    clearances: [[f32; LANES]; MAX_FACETS / LANES],
    edges: heapless::Vec<Edges, { 2 * MAX_HULLS }>,
    /// The edges that begin or end at each point, as bits: numbers 0 to 63, then 64 to 89.
    spokes: [[u64; 2]; MAX_POINTS],
}

impl Default for UnpackedBody {
    fn default() -> Self {
        Self {
            hulls: heapless::Vec::new(),
            drapes: heapless::Vec::new(),
            points: VectorLanes::ZERO,
            facets: [const { Facets16::NONE }; _],
            clearances: [[-1.0; LANES]; _],
            edges: heapless::Vec::new(),
            spokes: [[0; 2]; MAX_POINTS],
        }
    }
}

impl UnpackedBody {
    /// Unpacks an avatar. Most of the time goes into facets and clear outlines: about 8 us a hull of
    /// 16 points (one core of a shared AMD EPYC).
    #[must_use]
    pub fn new(avatar: &Avatar<'_>) -> Self {
        let mut body = Self::default();
        body.push_avatar(avatar);
        body
    }

    /// Adds the hulls of an avatar, which fit into an empty body ([`UnpackedBody::new`]).
    pub fn push_avatar(&mut self, avatar: &Avatar<'_>) {
        let mut hulls = avatar.hulls().peekable();
        while let Some(hull) = hulls.next() {
            let fits = match hull.drape() {
                None => self.push(hull.joint(), hull.points()),
                drape => {
                    let others =
                        core::iter::from_fn(|| hulls.next_if(|next| next.drape() == drape));
                    let points = |part: Hull<'_>| {
                        let joint = part.joint();
                        part.points().map(move |point| (joint, point))
                    };
                    self.push_draped(core::iter::once(hull).chain(others).flat_map(points))
                }
            };
            debug_assert!(fits.is_ok(), "a parsed avatar is within the budget");
        }
    }

    /// Adds a hull given by points in the frame of `joint`, metres: something that a body wears or
    /// carries, or a hull of a test.
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
        let surface = Facets::from_points(&hull);
        let before = self.add(&hull, HullCarrier::Joint(joint.index()), &surface)?;
        let facets = self.facets.get_mut(before.facets_end..).unwrap_or_default();
        set_facets(&surface, &hull, facets);
        let room = self.clearances.get_mut(before.facets_end..);
        set_clearances(&surface, &hull, room.unwrap_or_default());
        let spokes = self.spokes.get_mut(before.points_end..).unwrap_or_default();
        radiate(&surface, spokes);
        // At most two for each hull, which the capacity allows.
        self.edges.extend(edges_of(&surface));
        Ok(())
    }

    /// Adds a hull whose points are each attached to a joint of their own and given in its frame,
    /// metres: cloth that is taut between them, such as a skirt between the legs.
    ///
    /// A figure finds its facets anew in each pose: about 2 us for 16 points and 4 us for 32 (the
    /// least of 60 runs, one core of a shared AMD EPYC).
    ///
    /// # Errors
    /// When the budget is used up, which includes [`MAX_DRAPED_HULLS`]; nothing is added then.
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
        let carrier = HullCarrier::Drape(self.drapes.len());
        self.add(&hull, carrier, &Facets::default())?;
        self.drapes.push(drape).map_err(|_| OverBudget)
    }

    /// Returns the least height in a pose over a floor that rises by `rise` metres for each metre
    /// ahead of `z`, metres; the largest f32 without points. Finds no facets of draped
    /// hulls, unlike a [`Figure`].
    #[must_use]
    pub fn lowest(&self, pose: &ModelPose, rise: f32, z: f32) -> f32 {
        let mut points = self.points.clone();
        self.carry(pose, &mut points);
        let end = self.hulls.last().map_or(0, |hull| hull.points_end);
        let mut least = [f32::MAX; LANES];
        let [heights, ahead] =
            [&points.y, &points.z].map(|axis| axis.get(..end).unwrap_or_default());
        for (heights, ahead) in heights.chunks(LANES).zip(ahead.chunks(LANES)) {
            for ((least, height), ahead) in least.iter_mut().zip(heights).zip(ahead) {
                let height = height - rise * (ahead - z);
                *least = if height < *least { height } else { *least };
            }
        }
        least.into_iter().fold(f32::MAX, f32::min)
    }

    /// Carries the points to where `pose` puts their joints.
    fn carry(&self, pose: &ModelPose, points: &mut VectorLanes<MAX_POINTS>) {
        let mut start = 0;
        for hull in &self.hulls {
            let own = start..hull.points_end;
            start = hull.points_end;
            match hull.carrier {
                HullCarrier::Joint(joint) => {
                    let place = JointPlace::at(joint, pose);
                    points.carry(own, &self.points, place.turn, place.offset);
                }
                HullCarrier::Drape(drape) => {
                    for (index, joint) in own.zip(self.drapes.get(drape).into_iter().flatten()) {
                        if let Some(point) = self.points.get(index) {
                            points.set(index, JointPlace::at(joint.index(), pose).carry(point));
                        }
                    }
                }
            }
        }
    }

    /// Adds points, and room for the facets and edges of `surface`, and returns the previous hull.
    fn add(
        &mut self,
        points: &[Vec3],
        carrier: HullCarrier,
        surface: &Facets,
    ) -> Result<UnpackedHull, OverBudget> {
        let before = self.hulls.last().cloned().unwrap_or(UnpackedHull::NONE);
        let points_end = before.points_end + points.len();
        let facets_end = before.facets_end + surface.facets.len().div_ceil(LANES);
        if points_end > MAX_POINTS || facets_end > MAX_FACETS / LANES {
            return Err(OverBudget);
        }
        let hull = UnpackedHull {
            carrier,
            points_end,
            facets_end,
            edges_end: before.edges_end + surface.edges.len().div_ceil(64),
        };
        self.hulls.push(hull).map_err(|_| OverBudget)?;
        for (index, &point) in (before.points_end..).zip(points) {
            self.points.set(index, point);
        }
        Ok(before)
    }
}

/// The error for a body with more hulls or points than [`crate::budget`] allows.
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

//! Hulls whose points hang on a joint each: what they span depends on the pose.

use super::plane::{Plane, PlaneLanes, border, radiate, scaled, sides};
use super::{Figure, FigureHull, Place};
use crate::budget::{LANES, MAX_HULL_EDGES, MAX_HULL_FACETS, MAX_HULL_POINTS};
use crate::facets::Facets;
use crate::pose::ModelPose;
use crate::skeleton::Joint;
use core::ops::Range;
use glam::Vec3;

/// The joints of a hull's points.
pub(super) type Drape = heapless::Vec<Joint, MAX_HULL_POINTS>;

/// Facets of one hull, filled up to whole [`LANES`].
const FACETS: usize = MAX_HULL_FACETS.next_multiple_of(LANES);

/// What one hull spans in one pose, as [`super::Body`] has it of hulls that keep their shape.
/// 3 kB.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Facets, filled up to whole [`LANES`].
    facets: usize,
    /// In the walker's space.
    planes: PlaneLanes<FACETS>,
    sides: [[u64; FACETS]; 2],
    spokes: [[u64; 2]; MAX_HULL_POINTS],
    ends: [heapless::Vec<u8, MAX_HULL_EDGES>; 2],
    border: [u64; 2],
}

impl Surface {
    pub const NOTHING: Self = Self {
        facets: 0,
        planes: PlaneLanes::NONE,
        sides: [[0; FACETS]; 2],
        spokes: [[0; 2]; MAX_HULL_POINTS],
        ends: [const { heapless::Vec::new() }; 2],
        border: [0; 2],
    };

    /// The hull of these points.
    pub fn part(&self, points: Range<usize>) -> FigureHull<'_> {
        FigureHull {
            spokes: self.spokes.get(..points.len()).unwrap_or_default(),
            points,
            planes: self.planes.part(0..self.facets, &Place::REST),
            sides: [
                self.sides[0].get(..self.facets).unwrap_or_default(),
                self.sides[1].get(..self.facets).unwrap_or_default(),
            ],
            from: &self.ends[0],
            to: &self.ends[1],
            border: self.border,
        }
    }
}

impl Figure<'_> {
    /// Puts the points of a drape to where their joints are.
    pub(super) fn hang(&mut self, drape: usize, points: Range<usize>, pose: &ModelPose) {
        let body = self.body;
        let Some(joints) = body.drapes.get(drape) else {
            return;
        };
        for (index, joint) in points.zip(joints) {
            if let Some(point) = body.points.get(index) {
                let place = Place::of(joint.index(), pose);
                self.points.set(index, place.carry(point));
            }
        }
    }

    /// Finds what the points of a drape span where they are.
    pub(super) fn wrap(&mut self, drape: usize, points: Range<usize>) {
        let hull: heapless::Vec<Vec3, MAX_HULL_POINTS> = points
            .take(MAX_HULL_POINTS)
            .filter_map(|index| self.points.get(index))
            .collect();
        let Some(surface) = self.surfaces.get_mut(drape) else {
            return;
        };
        let (found, scaled) = (Facets::of(&hull), scaled(&hull));
        *surface = Surface::NOTHING;
        surface.facets = found.facets.len().next_multiple_of(LANES);
        surface.border = border(&found);
        radiate(&found, &mut surface.spokes);
        for (side, ends) in surface.ends.iter_mut().enumerate() {
            ends.extend(
                found
                    .edges
                    .iter()
                    .filter_map(|edge| edge.get(side).copied()),
            );
        }
        for (index, facet) in found.facets.iter().enumerate() {
            for (places, half) in surface.sides.iter_mut().zip(sides(facet)) {
                if let Some(place) = places.get_mut(index) {
                    *place = half;
                }
            }
            let plane = Plane::of(facet.corners, &hull, &scaled);
            surface.planes.set(index, &plane);
        }
    }
}

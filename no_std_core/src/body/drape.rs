//! Hulls whose points hang on a joint each: what they span depends on the pose.

use super::plane::{Facets16, edges_of, radiate, set_facets};
use super::{Figure, FigureHull, JointPlace};
use crate::budget::{LANES, MAX_HULL_FACETS, MAX_HULL_POINTS};
use crate::facets::Facets;
use crate::pose::ModelPose;
use crate::raster::simd::Edges;
use crate::skeleton::Joint;
use core::ops::Range;
use glam::Vec3;

/// The joints of a hull's points.
pub(super) type Drape = heapless::Vec<Joint, MAX_HULL_POINTS>;

/// What one hull spans in one pose, as [`super::UnpackedBody`] has it of hulls that keep their shape.
/// 2 kB.
#[derive(Clone, Debug)]
pub(super) struct DrapedSurface {
    /// How many registers of facets there are, in the walker's space.
    facets_len: usize,
    facets: [Facets16; MAX_HULL_FACETS.div_ceil(LANES)],
    edges: heapless::Vec<Edges, 2>,
    spokes: [[u64; 2]; MAX_HULL_POINTS],
}

impl DrapedSurface {
    pub const NOTHING: Self = Self {
        facets_len: 0,
        facets: [const { Facets16::NONE }; _],
        edges: heapless::Vec::new(),
        spokes: [[0; 2]; MAX_HULL_POINTS],
    };

    /// The hull of these points.
    pub fn part(&self, points: Range<usize>) -> FigureHull<'_> {
        FigureHull {
            spokes: self.spokes.get(..points.len()).unwrap_or_default(),
            points,
            facets: self.facets.get(..self.facets_len).unwrap_or_default(),
            edges: &self.edges,
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
                let place = JointPlace::of(joint.index(), pose);
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
        let found = Facets::of(&hull);
        *surface = DrapedSurface::NOTHING;
        surface.facets_len = found.facets.len().div_ceil(LANES);
        set_facets(&found, &hull, &mut surface.facets);
        surface.edges.extend(edges_of(&found));
        radiate(&found, &mut surface.spokes);
    }
}

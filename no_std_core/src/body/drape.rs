//! Draped hulls: each point is attached to a joint of its own, so that the shape depends on the
//! pose.

use super::plane::{Facets16, FigureHull, edges_of, radiate, set_facets};
use crate::budget::{LANES, MAX_HULL_FACETS, MAX_HULL_POINTS};
use crate::facets::Facets;
use crate::simd::Edges;
use crate::skeleton::Joint;
use core::ops::Range;
use glam::Vec3;

/// The joint of each point of a hull.
pub(super) type Drape = heapless::Vec<Joint, MAX_HULL_POINTS>;

/// The surface of one draped hull in one pose, as [`super::UnpackedBody`] stores it for rigid
/// hulls. 2 kB.
#[derive(Clone, Debug)]
pub(super) struct DrapedSurface {
    /// The number of [`Facets16`] in use; facets are in the walker's space.
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

    /// Returns the hull of these points.
    pub fn part(&self, points: Range<usize>) -> FigureHull<'_> {
        FigureHull {
            spokes: self.spokes.get(..points.len()).unwrap_or_default(),
            points,
            facets: self.facets.get(..self.facets_len).unwrap_or_default(),
            // They would take longer than facets.
            clearances: &[],
            edges: &self.edges,
        }
    }

    /// Finds the surface of these points.
    pub fn enclose(&mut self, hull: &[Vec3]) {
        let found = Facets::from_points(hull);
        *self = Self::NOTHING;
        self.facets_len = found.facets.len().div_ceil(LANES);
        set_facets(&found, hull, &mut self.facets);
        self.edges.extend(edges_of(&found));
        radiate(&found, &mut self.spokes);
    }
}

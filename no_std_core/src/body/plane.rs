//! Facets and edges in the form that rasterisers use.

use crate::budget::{LANES, MAX_HULL_EDGES};
use crate::facets::Facets;
use crate::hull::HullPoints;
use crate::simd::Edges;
use core::ops::Range;
use glam::Vec3;

/// A facet faces a direction only if it does so by more than this sine: the normal of a sliver is
/// mostly rounding error. Our choice: a hundred times the rounding error of hulls of a few
/// centimetres.
const EDGE_ON: f32 = 1e-4;

/// The plane of a facet.
pub(crate) struct FacetPlane {
    pub normal: Vec3,
    /// The normal's product with a point of the facet.
    pub offset: f32,
    /// A direction is in front of or behind the facet only if its product with the normal is beyond
    /// this.
    pub tolerance: f32,
}

impl FacetPlane {
    /// Returns the plane of the facet with these corners among `points`; `scaled` are the same
    /// points, scaled.
    pub fn through(corners: [u8; 3], points: &[Vec3], scaled: &[Vec3]) -> Self {
        let (corners, is_clockwise) = sorted(corners);
        let all = |points: &[Vec3]| {
            corners.map(|corner| points.get(usize::from(corner)).copied().unwrap_or_default())
        };
        let [a, b, c] = all(scaled);
        let normal = normal([a, b, c]);
        let normal = if is_clockwise { -normal } else { normal };
        let [ab, ac] = [b - a, c - a].map(Vec3::length_squared);
        Self {
            normal,
            offset: normal.dot(all(points)[0]),
            tolerance: EDGE_ON * libm::sqrtf(ab * ac) + f32::MIN_POSITIVE,
        }
    }
}

/// Sixteen facets of one hull, in the frame of its carrier. Unused lanes hold no facet and are
/// visible from nowhere.
#[derive(Clone, Debug)]
pub(crate) struct Facets16 {
    /// The normals.
    pub x: [f32; LANES],
    pub y: [f32; LANES],
    pub z: [f32; LANES],
    /// Offsets and tolerances as in [`FacetPlane`].
    pub offsets: [f32; LANES],
    pub tolerances: [f32; LANES],
}

impl Facets16 {
    pub const NONE: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        z: [0.0; LANES],
        offsets: [0.0; LANES],
        tolerances: [0.0; LANES],
    };

    fn set(&mut self, lane: usize, plane: &FacetPlane) {
        let FacetPlane {
            normal,
            offset,
            tolerance,
        } = *plane;
        let parts = [
            (&mut self.x, normal.x),
            (&mut self.y, normal.y),
            (&mut self.z, normal.z),
            (&mut self.offsets, offset),
            (&mut self.tolerances, tolerance),
        ];
        for (part, value) in parts {
            if let Some(place) = part.get_mut(lane) {
                *place = value;
            }
        }
    }
}

/// Writes the facets of a hull of these points, sixteen at a time.
pub(super) fn set_facets(surface: &Facets, points: &[Vec3], facets: &mut [Facets16]) {
    let scaled = scaled(points);
    for (number, facet) in surface.facets.iter().enumerate() {
        if let Some(facets) = facets.get_mut(number / LANES) {
            facets.set(
                number % LANES,
                &FacetPlane::through(facet.corners, points, &scaled),
            );
        }
    }
}

/// Facet numbers that no hull reaches, for a facet that is visible from nowhere, and one that is
/// visible from everywhere.
const UNSEEN: u8 = 62;
const SEEN: u8 = 63;
/// The bit of [`SEEN`] among the bits of visible facets.
pub(crate) const ALWAYS: u64 = 1 << SEEN;

/// Returns the edges of a hull, the first 64 and then the others. Edges of a flat hull, which are
/// its outline from everywhere, lie between a facet that is always visible and one that never is.
pub(super) fn edges_of(surface: &Facets) -> impl Iterator<Item = Edges> {
    let mut sides = [[UNSEEN; 2]; MAX_HULL_EDGES];
    if surface.facets.is_empty() {
        sides = [[UNSEEN, SEEN]; MAX_HULL_EDGES];
    }
    for (number, facet) in (0..).zip(&surface.facets) {
        for &edge in &facet.edges {
            if let Some(sides) = sides.get_mut(usize::from(edge)) {
                let [first, second] = *sides;
                *sides = [second, number];
                debug_assert_eq!(first, UNSEEN, "an edge lies between two facets");
            }
        }
    }
    let both = surface.edges.chunks(64);
    both.enumerate().map(move |(half, ends)| {
        let mut edges = Edges {
            len: ends.len(),
            ..Edges::NONE
        };
        let sides = sides.iter().skip(64 * half);
        for (at, (&[from, to], &[left, right])) in ends.iter().zip(sides).enumerate() {
            (edges.from[at], edges.to[at]) = (from, to);
            (edges.sides[0][at], edges.sides[1][at]) = (left, right);
        }
        edges
    })
}

/// Returns corners in ascending order, and whether they then turn clockwise for a viewer outside.
pub(crate) fn sorted([a, b, c]: [u8; 3]) -> ([u8; 3], bool) {
    let mut sorted = [a, b, c];
    sorted.sort_unstable();
    (sorted, ![[a, b, c], [b, c, a], [c, a, b]].contains(&sorted))
}

/// Returns the normal of a facet, outwards if its corners turn counterclockwise for a viewer
/// outside. Its length is twice the facet's area.
pub(crate) fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// Scales points by the power of two that brings them within 1, so that products of their
/// differences neither overflow nor vanish. This is exact, so signs are kept.
pub(crate) fn scaled(points: &[Vec3]) -> HullPoints {
    let exponent = exponent(points);
    let scaled = |coordinate| libm::ldexpf(coordinate, -exponent);
    points
        .iter()
        .map(|point| Vec3::from(point.to_array().map(scaled)))
        .collect()
}

/// Returns the exponent of the least power of two that is greater than all coordinates.
pub(super) fn exponent(points: &[Vec3]) -> i32 {
    let reach = points
        .iter()
        .fold(0.0f32, |reach, point| reach.max(point.abs().max_element()));
    libm::frexpf(reach).1
}

/// Sets the bits of a surface's edges in the points at which they begin and end.
pub(crate) fn radiate(surface: &Facets, spokes: &mut [[u64; 2]]) {
    for (number, edge) in surface.edges.iter().enumerate() {
        let bit = halves(1 << number);
        for &end in edge {
            if let Some(spokes) = spokes.get_mut(usize::from(end)) {
                *spokes = [spokes[0] | bit[0], spokes[1] | bit[1]];
            }
        }
    }
}

/// Returns bits 0 to 63, and bits 64 to 127.
fn halves(bits: u128) -> [u64; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "half by half")]
    let halves = [bits as u64, (bits >> 64) as u64];
    halves
}

/// One hull of a figure: where its points are in the figure's arrays, and its surface.
#[derive(Clone, Debug)]
pub(crate) struct FigureHull<'a> {
    pub points: Range<usize>,
    /// Its facets: in the frame of its joint, or in the walker's space if it is draped.
    pub facets: &'a [Facets16],
    /// The facets' [clearances](super::clearance), as many as facets; none for a draped hull.
    pub clearances: &'a [[f32; LANES]],
    /// Its edges; a line or a point has none.
    pub edges: &'a [Edges],
    /// The edges that begin or end at each of its points, as bits.
    pub spokes: &'a [[u64; 2]],
}

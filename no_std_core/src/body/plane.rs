//! Facets and edges as rasterisers take them: planes, and edges a bit each.

use super::{Lanes, Place};
use crate::facets::{Facet, Facets};
use crate::hull::HullPoints;
use core::ops::Range;
use glam::Vec3;

/// A facet faces a direction only if it does by more than this sine: of a sliver's normal
/// little but rounding is left. Ours: a hundred times what hulls of a few centimetres round.
const EDGE_ON: f32 = 1e-4;

/// The plane of a facet.
pub(crate) struct Plane {
    pub normal: Vec3,
    /// The normal's product with a point of the facet.
    pub offset: f32,
    /// The normal tells a direction from its opposite if their product is beyond this.
    pub tolerance: f32,
}

impl Plane {
    /// Of the facet with these corners among `points`, which are as far out as they are
    /// together with `scaled`.
    pub fn of(corners: [u8; 3], points: &[Vec3], scaled: &[Vec3]) -> Self {
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

/// Planes, one array a number. Those that are not set are of no facet: seen from nowhere.
#[derive(Clone, Debug)]
pub(super) struct PlaneLanes<const N: usize> {
    normals: Lanes<N>,
    offsets: [f32; N],
    tolerances: [f32; N],
}

impl<const N: usize> PlaneLanes<N> {
    pub const NONE: Self = Self {
        normals: Lanes::ZERO,
        offsets: [0.0; N],
        tolerances: [0.0; N],
    };

    pub fn set(&mut self, index: usize, plane: &Plane) {
        self.normals.set(index, plane.normal);
        if let Some(offset) = self.offsets.get_mut(index) {
            *offset = plane.offset;
        }
        if let Some(tolerance) = self.tolerances.get_mut(index) {
            *tolerance = plane.tolerance;
        }
    }

    /// Some of them, which are in the frame of what is at `place`.
    #[inline(always)]
    pub fn part<'a>(&'a self, range: Range<usize>, place: &'a Place) -> Planes<'a> {
        let Lanes { x, y, z } = &self.normals;
        let [x, y, z, offsets, tolerances] = [x, y, z, &self.offsets, &self.tolerances]
            .map(|numbers| numbers.get(range.clone()).unwrap_or_default());
        Planes {
            place,
            x,
            y,
            z,
            offsets,
            tolerances,
        }
    }
}

/// The planes of a hull's facets, in whole lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planes<'a> {
    /// In whose frame they are.
    pub place: &'a Place,
    /// Normals.
    pub x: &'a [f32],
    pub y: &'a [f32],
    pub z: &'a [f32],
    /// As in [`Plane`].
    pub offsets: &'a [f32],
    pub tolerances: &'a [f32],
}

/// Corners by rising number, and whether they then turn clockwise for a viewer outside.
pub(crate) fn sorted([a, b, c]: [u8; 3]) -> ([u8; 3], bool) {
    let mut sorted = [a, b, c];
    sorted.sort_unstable();
    (sorted, ![[a, b, c], [b, c, a], [c, a, b]].contains(&sorted))
}

/// The normal of a facet, outwards if its corners turn counterclockwise for a viewer outside;
/// twice as long as the facet is large.
pub(crate) fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// Points times the power of two that brings them within 1, so that products of their
/// differences neither overflow nor vanish. Nothing is rounded: what has a sign keeps it.
pub(crate) fn scaled(points: &[Vec3]) -> HullPoints {
    let reach = points
        .iter()
        .fold(0.0f32, |reach, point| reach.max(point.abs().max_element()));
    let (_, exponent) = libm::frexpf(reach);
    let scaled = |coordinate| libm::ldexpf(coordinate, -exponent);
    points
        .iter()
        .map(|point| Vec3::from(point.to_array().map(scaled)))
        .collect()
}

/// The edges of a facet, a bit each.
pub(crate) fn sides(facet: &Facet) -> [u64; 2] {
    let bits = |bits: u128, &edge: &u8| bits | 1 << edge;
    halves(facet.edges.iter().fold(0, bits))
}

/// The edges that are the outline of a flat hull, a bit each.
pub(crate) fn border(surface: &Facets) -> [u64; 2] {
    if surface.facets.is_empty() {
        halves((1 << surface.edges.len()) - 1)
    } else {
        [0; 2]
    }
}

/// Adds its edges, a bit each, to the points at which they begin and end.
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

/// Bits 0 to 63, and bits 64 to 127.
fn halves(bits: u128) -> [u64; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "half by half")]
    let halves = [bits as u64, (bits >> 64) as u64];
    halves
}

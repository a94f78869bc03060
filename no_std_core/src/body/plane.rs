//! Facets and edges as rasterisers take them: planes, and edges a bit each.

use crate::facets::{Facet, Facets};
use glam::Vec3;

/// A facet faces a direction only if it does by more than this sine: of a sliver's normal
/// little but rounding is left. Ours: a hundred times what hulls of a few centimetres round.
const EDGE_ON: f32 = 1e-4;

/// The plane of a facet.
pub(super) struct Plane {
    pub normal: Vec3,
    /// The normal's product with a point of the facet.
    pub offset: f32,
    /// As in [`super::Body`].
    pub tolerance: f32,
}

impl Plane {
    /// Of lanes without a facet: seen from nowhere.
    pub const NOWHERE: Self = Self {
        normal: Vec3::ZERO,
        offset: 0.0,
        tolerance: 0.0,
    };

    pub fn of(facet: &Facet, points: &[Vec3]) -> Self {
        let corner = |side: usize| {
            let corner = facet.corners.get(side).copied().unwrap_or_default();
            points.get(usize::from(corner)).copied().unwrap_or_default()
        };
        let (a, b, c) = (corner(0), corner(1), corner(2));
        // Of sides no longer than 1, whose products neither overflow nor vanish; a
        // difference of halves is finite.
        let (ab, ac) = (0.5 * b - 0.5 * a, 0.5 * c - 0.5 * a);
        let reach = ab.abs().max(ac.abs()).max_element();
        let (ab, ac) = (ab / reach, ac / reach);
        let normal = ab.cross(ac);
        let product = libm::sqrtf(ab.length_squared() * ac.length_squared());
        Self {
            normal,
            offset: normal.dot(a),
            tolerance: EDGE_ON * product + f32::MIN_POSITIVE,
        }
    }
}

/// The edges of a facet, a bit each.
pub(super) fn sides(facet: &Facet) -> [u64; 2] {
    let bits = |bits: u128, &edge: &u8| bits | 1 << edge;
    halves(facet.edges.iter().fold(0, bits))
}

/// The edges that are the outline of a flat hull, a bit each.
pub(super) fn border(surface: &Facets) -> [u64; 2] {
    if surface.facets.is_empty() {
        halves((1 << surface.edges.len()) - 1)
    } else {
        [0; 2]
    }
}

/// Adds its edges, a bit each, to the points at which they begin and end.
pub(super) fn radiate(surface: &Facets, spokes: &mut [[u64; 2]]) {
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

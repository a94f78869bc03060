//! Edges of hulls, and the ends of outline edges.

use super::Wide;
use crate::budget::{LANES, MAX_HULL_POINTS};

/// Up to 64 edges of one hull.
#[derive(Clone, Debug)]
pub(crate) struct Edges {
    /// The number of edges; unused entries lie between a facet and itself.
    pub len: usize,
    /// The points at which they begin and end, by number in the hull.
    pub from: [u8; 64],
    pub to: [u8; 64],
    /// The facets on both sides, by number in the hull.
    pub sides: [[u8; 64]; 2],
}

impl Edges {
    pub const NONE: Self = Self {
        len: 0,
        from: [0; 64],
        to: [0; 64],
        sides: [[0; 64]; 2],
    };

    /// Returns the points and the facets of an edge, by number in the hull.
    pub const fn get(&self, edge: usize) -> [[u8; 2]; 2] {
        let (edge, [left, right]) = (edge % 64, &self.sides);
        [[self.from[edge], self.to[edge]], [left[edge], right[edge]]]
    }
}

/// Both ends of up to sixteen lines.
#[derive(Clone, Debug)]
pub(crate) struct LineEnds {
    /// The coordinates of the ends, by axis.
    pub from: [[f32; LANES]; 2],
    pub to: [[f32; LANES]; 2],
}

impl LineEnds {
    pub const NONE: Self = Self {
        from: [[0.0; LANES]; 2],
        to: [[0.0; LANES]; 2],
    };

    /// Writes the ends of an edge of a hull of these points, as number `at` of all.
    #[inline(always)]
    pub fn set(
        all: &mut [Self],
        at: usize,
        edges: &Edges,
        edge: usize,
        points: [&[f32; MAX_HULL_POINTS]; 2],
    ) {
        let (edge, lane) = (edge % 64, at % LANES);
        let from = usize::from(edges.from[edge]) % MAX_HULL_POINTS;
        let to = usize::from(edges.to[edge]) % MAX_HULL_POINTS;
        if let Some(ends) = all.get_mut(at / LANES) {
            (ends.from[0][lane], ends.from[1][lane]) = (points[0][from], points[1][from]);
            (ends.to[0][lane], ends.to[1][lane]) = (points[0][to], points[1][to]);
        }
    }
}

/// Implements [`Wide::ends`] for any processor.
#[inline(always)]
pub fn ends_one_by_one<L: Wide>(
    l: L,
    bits: u64,
    edges: &[Edges],
    points: [&[f32; MAX_HULL_POINTS]; 2],
    ends: &mut [LineEnds],
) -> usize {
    // An entry for each value of a byte, so that no index is out of bounds.
    let mut named = [0; 256];
    for (byte, named) in named.chunks_exact_mut(8).enumerate().take(8) {
        named.copy_from_slice(&l.spread(bits >> (8 * byte)).to_le_bytes());
    }
    let mut outline = [0; 256];
    let mut count = 0;
    for edges in edges {
        let mut len = 0u8;
        let sides = edges.sides[0].iter().zip(&edges.sides[1]);
        for (edge, (&left, &right)) in (0u8..).zip(sides).take(edges.len) {
            // Written whether it counts or not: a branch would be hard to predict.
            outline[usize::from(len)] = edge;
            len = len.wrapping_add(named[usize::from(left)] ^ named[usize::from(right)]);
        }
        for &edge in outline.iter().take(usize::from(len)) {
            LineEnds::set(ends, count, edges, usize::from(edge), points);
            count += 1;
        }
    }
    count
}

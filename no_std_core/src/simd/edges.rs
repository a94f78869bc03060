//! Edges of hulls, and the ends of outline edges.

use super::Wide;
use crate::budget::{LANES, MAX_HULL_EDGES, MAX_HULL_POINTS};
use glam::Vec2;

/// The maximum number of lines of one hull, and room for a register behind them.
const HULL_LINES: usize = (MAX_HULL_EDGES + LANES).next_multiple_of(LANES);
/// The maximum number of lines of hulls that wait to be filled.
pub(crate) const MAX_LINES: usize = 8 * LANES + HULL_LINES;

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

/// Both ends of lines; those of one hull have no gaps.
#[derive(Clone, Debug)]
pub(crate) struct LineEnds {
    /// The coordinates of the ends, by axis.
    pub from: [[f32; MAX_LINES]; 2],
    pub to: [[f32; MAX_LINES]; 2],
}

impl LineEnds {
    pub const NONE: Self = Self {
        from: [[0.0; MAX_LINES]; 2],
        to: [[0.0; MAX_LINES]; 2],
    };

    /// Returns whether there is room for the lines of one more hull after `count` of them.
    pub const fn has_room(count: usize) -> bool {
        count + HULL_LINES <= MAX_LINES
    }

    /// Returns the ends of a line.
    #[inline(always)]
    pub fn get(&self, line: usize) -> [Vec2; 2] {
        [&self.from, &self.to].map(|[x, y]| Vec2::new(x[line % MAX_LINES], y[line % MAX_LINES]))
    }

    /// Writes the ends of an edge of a hull of these points as line number `at`.
    #[inline(always)]
    pub fn set(
        &mut self,
        at: usize,
        edges: &Edges,
        edge: usize,
        points: [&[f32; MAX_HULL_POINTS]; 2],
    ) {
        let edge = edge % 64;
        let from = usize::from(edges.from[edge]) % MAX_HULL_POINTS;
        let to = usize::from(edges.to[edge]) % MAX_HULL_POINTS;
        for (axis, points) in points.into_iter().enumerate() {
            self.from[axis][at % MAX_LINES] = points[from];
            self.to[axis][at % MAX_LINES] = points[to];
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
    (ends, at): (&mut LineEnds, usize),
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
            ends.set(at + count, edges, usize::from(edge), points);
            count += 1;
        }
    }
    count
}

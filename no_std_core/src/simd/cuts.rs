//! Edges of a hull that the planes of columns cut, and where, for all processors except those that
//! can compress bytes.

use super::{Edges, LANES, Wide};
use crate::budget::{MAX_COLUMNS, MAX_HULL_POINTS};

/// Edges that columns cross, found from the points where they begin and end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeCuts {
    masks: [[u64; 2]; 2],
    /// For each number of column centres that points have passed, the edges that end at those
    /// points an odd number of times.
    turning: [[u64; 2]; MAX_COLUMNS + 1],
    /// The edges that the last column crosses.
    crossed: [u64; 2],
}

/// Implements [`Wide::cuts`].
///
/// Left of a plane, an edge with both ends counts twice, and an edge that is cut counts once: the
/// exclusive or of all edges up to the plane gives those that it cuts.
#[inline(always)]
pub(super) fn cuts(
    spokes: &[[u64; 2]],
    masks: [[u64; 2]; 2],
    passed: &[u32; MAX_HULL_POINTS],
) -> EdgeCuts {
    let mut cuts = EdgeCuts {
        masks,
        turning: [[0; 2]; MAX_COLUMNS + 1],
        crossed: [0; 2],
    };
    for (&passed, spokes) in passed.iter().zip(spokes) {
        let turning = &mut cuts.turning[passed as usize % (MAX_COLUMNS + 1)];
        *turning = [turning[0] ^ spokes[0], turning[1] ^ spokes[1]];
    }
    cuts
}

/// Implements [`Wide::crossed`].
#[inline(always)]
pub(super) fn crossed(cuts: &mut EdgeCuts, column: usize) -> [[u64; 2]; 2] {
    let turned = cuts.turning[column % (MAX_COLUMNS + 1)];
    let crossed = [cuts.crossed[0] ^ turned[0], cuts.crossed[1] ^ turned[1]];
    cuts.crossed = crossed;
    let [upper, lower] = cuts.masks;
    [
        [crossed[0] & upper[0], crossed[1] & upper[1]],
        [crossed[0] & lower[0], crossed[1] & lower[1]],
    ]
}

/// Implements [`Wide::corners`].
#[inline(always)]
pub(super) fn corners<L: Wide>(
    l: L,
    edges: &[Edges],
    masks: &mut [[u64; 2]; 2],
    points: [&[f32; MAX_HULL_POINTS]; 3],
    plane: f32,
) -> ([L::Floats; 2], usize) {
    let (mut a, mut b) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    let mut most = 0;
    for (side, masks) in masks.iter_mut().enumerate() {
        let mut count = 0;
        for (edges, mask) in edges.iter().zip(masks) {
            while *mask != 0 && count < LANES / 2 {
                let edge = mask.trailing_zeros() as usize % 64;
                *mask &= *mask - 1;
                let lane = (LANES / 2 * side + count) % LANES;
                let from = usize::from(edges.from[edge]) % MAX_HULL_POINTS;
                let to = usize::from(edges.to[edge]) % MAX_HULL_POINTS;
                for (axis, points) in points.into_iter().enumerate() {
                    (a[axis][lane], b[axis][lane]) = (points[from], points[to]);
                }
                count += 1;
            }
        }
        most = most.max(count);
    }
    let a = [l.load(&a[0]), l.load(&a[1]), l.load(&a[2])];
    let b = [l.load(&b[0]), l.load(&b[1]), l.load(&b[2])];
    (cut(l, a, b, plane), most)
}

/// Returns where lines from `a` to `b` meet the plane at `plane` to the right: upwards and towards
/// the camera.
#[inline(always)]
pub(super) fn cut<L: Wide>(
    l: L,
    a: [L::Floats; 3],
    b: [L::Floats; 3],
    plane: f32,
) -> [L::Floats; 2] {
    let share = l.div(l.sub(l.splat(plane), a[0]), l.sub(b[0], a[0]));
    [
        l.add(a[1], l.mul(share, l.sub(b[1], a[1]))),
        l.add(a[2], l.mul(share, l.sub(b[2], a[2]))),
    ]
}

/// Implements [`Wide::Cuts`] and its functions for processors that work edge by edge.
macro_rules! edge_by_edge {
    () => {
        type Cuts = crate::simd::cuts::EdgeCuts;

        #[inline(always)]
        fn cuts(
            self,
            (_, spokes): (&[crate::simd::Edges], &[[u64; 2]]),
            masks: [[u64; 2]; 2],
            passed: &[u32; crate::budget::MAX_HULL_POINTS],
        ) -> Self::Cuts {
            crate::simd::cuts::cuts(spokes, masks, passed)
        }
        #[inline(always)]
        fn crossed(self, cuts: &mut Self::Cuts, column: usize) -> [[u64; 2]; 2] {
            crate::simd::cuts::crossed(cuts, column)
        }
        #[inline(always)]
        fn corners(
            self,
            (_, edges): (&Self::Cuts, &[crate::simd::Edges]),
            masks: &mut [[u64; 2]; 2],
            points: [&[f32; crate::budget::MAX_HULL_POINTS]; 3],
            plane: f32,
        ) -> ([Self::Floats; 2], usize) {
            crate::simd::cuts::corners(self, edges, masks, points, plane)
        }
    };
}

pub(super) use edge_by_edge;

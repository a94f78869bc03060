//! Points of a hull in the window, of which it is asked whether an outline is clear.

use super::placement::{Placement, as_pixels};
use super::skia::{self, NEARLY_ZERO};
use crate::body::clearance::CLEAR;
use crate::budget::{LANES, MAX_HULL_POINTS};
use crate::simd::{Edges, Wide};
use glam::Vec2;

/// The points of a hull in the window, pixels; NaN after the last one.
pub(super) struct HullPixels {
    pub axes: [[f32; MAX_HULL_POINTS]; 2],
    len: usize,
}

impl HullPixels {
    pub fn new(points: [&[f32; MAX_HULL_POINTS]; 2], len: usize, placement: &Placement) -> Self {
        let mut axes = [[f32::NAN; MAX_HULL_POINTS]; 2];
        for (lane, (&x, &y)) in points[0].iter().zip(points[1]).enumerate().take(len) {
            let pixel = placement.place(Vec2::new(x, y));
            (axes[0][lane], axes[1][lane]) = (pixel.x, pixel.y);
        }
        Self { axes, len }
    }

    pub fn points(&self) -> impl Iterator<Item = Vec2> {
        let both = self.axes[0].iter().zip(&self.axes[1]);
        both.take(self.len).map(|(&x, &y)| Vec2::new(x, y))
    }

    /// Returns whether each line of the outline has all points but its own ends clearly on one side.
    /// That is asked of lines beside facets that are not clear.
    #[inline(always)]
    pub fn is_clear<L: Wide>(&self, l: L, [facing, unclear]: [u64; 2], edges: &[Edges]) -> bool {
        let [min, max] = skia::bounds(self.points());
        let across = max - min;
        if across.min_element() <= NEARLY_ZERO {
            return false;
        }
        let wide = CLEAR * across.element_sum();
        let sixteens = || {
            let [x, y] = self.axes.each_ref().map(|axis| axis.as_chunks::<LANES>().0);
            x.iter().zip(y)
        };
        let [xs, ys] = self.axes;
        let corner = |number: u8| {
            let number = usize::from(number) % MAX_HULL_POINTS;
            Vec2::new(xs[number], ys[number])
        };
        let others = self.len.saturating_sub(2);
        let (mut lines, mut all_clear) = (0, true);
        for edges in edges {
            let [left, right] = &edges.sides;
            let outline = l.look_up(facing, left) ^ l.look_up(facing, right);
            let mut asked = outline & (l.look_up(unclear, left) | l.look_up(unclear, right));
            lines += outline.count_ones();
            while asked != 0 {
                let [from, to] = edges.get(asked.trailing_zeros() as usize)[0].map(corner);
                asked &= asked - 1;
                let along = to - from;
                let clear = l.splat(wide * along.abs().element_sum());
                let minus = l.sub(l.splat(0.0), clear);
                let (mut left, mut right) = (0, 0);
                for (x, y) in sixteens() {
                    let x = l.sub(l.load(x), l.splat(from.x));
                    let y = l.sub(l.load(y), l.splat(from.y));
                    let area = l.sub(l.mul(l.splat(along.x), y), l.mul(l.splat(along.y), x));
                    left += l.bits(l.less(clear, area)).count_ones();
                    right += l.bits(l.less(area, minus)).count_ones();
                }
                all_clear &= left as usize == others || right as usize == others;
            }
        }
        all_clear && lines >= 3
    }

    /// Returns clear lines, each in the direction in which [`crate::outline::convex`] turns.
    pub fn turned(
        &self,
        lines: impl Iterator<Item = [Vec2; 2]>,
    ) -> impl Iterator<Item = [Vec2; 2]> {
        let sum = self.points().fold(Vec2::ZERO, |sum, point| sum + point);
        let middle = sum / as_pixels(self.len.max(1));
        lines.map(
            move |[from, to]| match (to - from).perp_dot(middle - from) > 0.0 {
                true => [from, to],
                false => [to, from],
            },
        )
    }
}

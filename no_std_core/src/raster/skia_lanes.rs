//! tiny-skia's pixels of unpacked figures, sixteen lines or rows at a time.
//!
//! Outlines are edges between visible facets and others, as in bit rows. Where each edge has all
//! other points of its hull on one side, clearly, it is an edge of the outline of
//! [`crate::outline::convex`], too, however that rounds, and the lines are those of [`Skia`]. Hulls
//! for which this is not shown, and those that a side of the window cuts, are drawn by [`Skia`].

use super::image_points::ImagePoints;
use super::moments::AreaMoments;
use super::placement::{Extent, Placement, as_pixels};
use super::rows::{VisibleFacets, look_facets as look};
use super::skia::{self, OUTSIDE, ones};
use super::window::{Fill, Pixels};
use super::{DrawError, Rasterizer, RenderView};
use crate::body::Figure;
use crate::budget::{LANES, MAX_HULL_EDGES, MAX_HULL_POINTS, MAX_ROWS, SKIA_WINDOW_COLUMNS};
use crate::camera::Camera;
use crate::silhouette::{Silhouette, Size};
use crate::simd::{LineEnds, Simd, Wide, compiled, dispatch};
use glam::Vec2;

/// Lines of one outline: a convex one has at most as many as points.
const STRIPS: usize = MAX_HULL_POINTS / LANES;
/// As many as all edges of a hull take.
const ALL_STRIPS: usize = MAX_HULL_EDGES.div_ceil(LANES) + 1;
/// The sine of the least angle at a corner between an edge and a point beside it. The chain of
/// [`crate::outline::convex`] tells 2^-21 apart.
const CLEAR: f32 = 2e-5;

/// The window of [`Rasterizer::Skia`] for unpacked figures. 14 kB.
#[derive(Clone, Debug)]
pub struct SkiaLanes {
    simd: Simd,
    size: Size,
    looks: VisibleFacets,
    points: ImagePoints,
    ends: [LineEnds; ALL_STRIPS],
    /// Bit `c` is column `c`. Rows below the window may be anything.
    rows: [u64; MAX_ROWS + LANES],
    /// Hulls drawn one by one, of all.
    pub slow: u64,
    pub all: u64,
}

impl SkiaLanes {
    pub fn new(size: Size, simd: Simd) -> Self {
        Self {
            simd,
            size,
            looks: VisibleFacets::NONE,
            points: ImagePoints::ZERO,
            ends: [const { LineEnds::NONE }; _],
            rows: [0; _],
            slow: 0,
            all: 0,
        }
    }

    fn rows(&self) -> &[u64] {
        self.rows.get(..self.size.rows()).unwrap_or_default()
    }
}

impl Pixels for SkiaLanes {
    type Image = Silhouette;

    fn blank(&self) -> Silhouette {
        Silhouette::empty(self.size)
    }

    fn rasterizer(&self) -> Rasterizer {
        Rasterizer::Skia
    }

    fn size(&self) -> Size {
        self.size
    }

    fn width(&self) -> usize {
        SKIA_WINDOW_COLUMNS
    }

    fn columns(&self, _: f32) -> usize {
        SKIA_WINDOW_COLUMNS
    }

    fn clear(&mut self) {
        self.rows = [0; _];
    }

    fn moments(&self) -> AreaMoments {
        dispatch!(self.simd, moments_of(self.rows()))
    }

    fn cut(&self, left: isize, image: &mut Silhouette) -> u64 {
        dispatch!(self.simd, cut_rows(self.rows(), left, image))
    }
}

compiled!(fn moments_of(rows: &[u64]) -> AreaMoments);
compiled!(fn cut_rows(rows: &[u64], left: isize, image: &mut Silhouette) -> u64);

#[inline(always)]
fn moments_of<L: Wide>(_: L, rows: &[u64]) -> AreaMoments {
    skia::moments(rows)
}

#[inline(always)]
fn cut_rows<L: Wide>(_: L, rows: &[u64], left: isize, image: &mut Silhouette) -> u64 {
    skia::cut(rows, left, image)
}

impl<'a> Fill<Figure<'a>> for SkiaLanes {
    fn look(&mut self, figure: &Figure<'a>, views: &[RenderView]) {
        dispatch!(self.simd, look_at(&mut self.looks, figure, views));
    }

    fn extent(&mut self, figure: &Figure<'a>, camera: &Camera) -> Result<Extent, DrawError> {
        self.points.project(figure, camera, self.simd)
    }

    fn draw(
        &mut self,
        figure: &Figure<'a>,
        _: &Camera,
        view: usize,
        placement: &Placement,
        _: usize,
    ) {
        dispatch!(self.simd, fill(self, figure, view, placement));
    }
}

compiled!(fn look_at(looks: &mut VisibleFacets, figure: &Figure<'_>, views: &[RenderView]));
compiled!(fn fill(window: &mut SkiaLanes, figure: &Figure<'_>, view: usize, placement: &Placement));

#[inline(always)]
fn look_at<L: Wide>(l: L, looks: &mut VisibleFacets, figure: &Figure<'_>, views: &[RenderView]) {
    look(l, looks, figure, views);
}

/// The points of a hull in the window, pixels; NaN after the last one.
type HullPixels = [[f32; MAX_HULL_POINTS]; 2];

#[inline(always)]
fn fill<L: Wide>(
    l: L,
    window: &mut SkiaLanes,
    figure: &Figure<'_>,
    view: usize,
    placement: &Placement,
) {
    window.rows = [0; _];
    let height = window.size.rows();
    let sides = [as_pixels(SKIA_WINDOW_COLUMNS), as_pixels(height)];
    for (number, hull) in figure.hull_parts().enumerate() {
        let start = hull.points.start;
        let [x, y] = [&window.points.x, &window.points.y].map(|axis| {
            axis.get(start..)
                .and_then(<[f32]>::first_chunk::<MAX_HULL_POINTS>)
        });
        let (Some(x), Some(y)) = (x, y) else {
            return;
        };
        let count = hull.points.len();
        let pixels = placed(x, y, count, placement);
        let (min, max) = bounds(&pixels);
        let is_inside = min[0] > -OUTSIDE
            && min[1] > -OUTSIDE
            && max[0] < sides[0] + OUTSIDE
            && max[1] < sides[1] + OUTSIDE;
        let facing = window.looks.facing(view, number);
        let lines = l.ends(facing, hull.edges, [&pixels[0], &pixels[1]], &mut window.ends);
        let across = (max[0] - min[0]).max(max[1] - min[1]);
        let ends = window.ends.get(..STRIPS).unwrap_or_default();
        window.all += 1;
        if !is_inside
            || lines < 3
            || lines > MAX_HULL_POINTS
            || !is_outline(&pixels, count, ends, lines, CLEAR * across * across)
        {
            window.slow += 1;
            let points = pixels[0].iter().zip(&pixels[1]).take(count);
            let points = points.map(|(&x, &y)| Vec2::new(x, y));
            let rows = window.rows.get_mut(..height).unwrap_or_default();
            skia::fill(&skia::outline_in_window(points, height), rows);
            continue;
        }
        // What is not wider than 1/4096 pixel is not clear.
        for (first, ends) in (0..lines).step_by(LANES).zip(ends) {
            let _ = (first, ends);
        }
        fill_lines(ends, lines, &mut window.rows);
    }
}

/// Places points as [`Placement::place`] does.
#[inline(always)]
fn placed(
    x: &[f32; MAX_HULL_POINTS],
    y: &[f32; MAX_HULL_POINTS],
    count: usize,
    placement: &Placement,
) -> HullPixels {
    let Placement { scale, origin, at } = *placement;
    let mut pixels = [[0.0; MAX_HULL_POINTS]; 2];
    for lane in 0..MAX_HULL_POINTS {
        let is_there = lane < count;
        let placed_x = (x[lane] - origin.x) * scale.x + at.x;
        let placed_y = (origin.y - y[lane]) * scale.y + at.y;
        pixels[0][lane] = if is_there { placed_x } else { f32::NAN };
        pixels[1][lane] = if is_there { placed_y } else { f32::NAN };
    }
    pixels
}

/// Returns the least and greatest coordinates.
#[inline(always)]
fn bounds(pixels: &HullPixels) -> ([f32; 2], [f32; 2]) {
    let mut ends = ([0.0; 2], [0.0; 2]);
    for axis in 0..2 {
        let mut min = [f32::INFINITY; LANES];
        let mut max = [f32::NEG_INFINITY; LANES];
        for chunk in pixels[axis].as_chunks::<LANES>().0 {
            for lane in 0..LANES {
                let at = chunk[lane];
                min[lane] = if at < min[lane] { at } else { min[lane] };
                max[lane] = if at > max[lane] { at } else { max[lane] };
            }
        }
        let mut step = LANES / 2;
        while step > 0 {
            for lane in 0..step {
                min[lane] = if min[lane + step] < min[lane] { min[lane + step] } else { min[lane] };
                max[lane] = if max[lane + step] > max[lane] { max[lane + step] } else { max[lane] };
            }
            step /= 2;
        }
        ends.0[axis] = min[0];
        ends.1[axis] = max[0];
    }
    ends
}

/// Returns whether each line has all points of its hull but its own ends on one side, further away
/// from it than rounding can tell, as twice the area of the triangle with it.
#[inline(always)]
fn is_outline(
    pixels: &HullPixels,
    count: usize,
    ends: &[LineEnds],
    lines: usize,
    clear: f32,
) -> bool {
    let mut is_clear = true;
    for line in 0..lines {
        let (strip, lane) = (&ends[line / LANES % STRIPS], line % LANES);
        let [ax, ay] = [strip.from[0][lane], strip.from[1][lane]];
        let [dx, dy] = [strip.to[0][lane] - ax, strip.to[1][lane] - ay];
        let (mut left, mut right) = (0u32, 0u32);
        for (x, y) in pixels[0].as_chunks::<LANES>().0.iter().zip(pixels[1].as_chunks::<LANES>().0) {
            let mut sides = [0u32; 2];
            for lane in 0..LANES {
                let area = dx * (y[lane] - ay) - dy * (x[lane] - ax);
                sides[0] |= u32::from(area > clear) << lane;
                sides[1] |= u32::from(area < -clear) << lane;
            }
            left += sides[0].count_ones();
            right += sides[1].count_ones();
        }
        let others = count as u32 - 2;
        is_clear &= left == others || right == others;
    }
    is_clear
}

/// Fills rows between lines of which two cross each.
#[inline(always)]
fn fill_lines(ends: &[LineEnds], lines: usize, rows: &mut [u64; MAX_ROWS + LANES]) {
    let mut firsts = [i32::MAX; MAX_HULL_POINTS];
    let mut lasts = [0; MAX_HULL_POINTS];
    let mut places = [0; MAX_HULL_POINTS];
    let mut slopes = [0; MAX_HULL_POINTS];
    for (strip, first) in ends.iter().zip((0..lines).step_by(LANES)) {
        let (Some(firsts), Some(lasts), Some(places), Some(slopes)) = (
            firsts.get_mut(first..).and_then(<[i32]>::first_chunk_mut::<LANES>),
            lasts.get_mut(first..).and_then(<[i32]>::first_chunk_mut::<LANES>),
            places.get_mut(first..).and_then(<[i32]>::first_chunk_mut::<LANES>),
            slopes.get_mut(first..).and_then(<[i32]>::first_chunk_mut::<LANES>),
        ) else {
            return;
        };
        for lane in 0..LANES {
            #[expect(clippy::cast_possible_truncation, reason = "tiny-skia cuts off, too")]
            let fixed = |coordinate: f32| (coordinate * 64.0) as i32;
            let (ax, ay) = (fixed(strip.from[0][lane]), fixed(strip.from[1][lane]));
            let (bx, by) = (fixed(strip.to[0][lane]), fixed(strip.to[1][lane]));
            let is_up = ay > by;
            let (left, top) = if is_up { (bx, by) } else { (ax, ay) };
            let (right, bottom) = if is_up { (ax, ay) } else { (bx, by) };
            let (first, end) = ((top + 32) >> 6, (bottom + 32) >> 6);
            let high = if bottom > top { bottom - top } else { 1 };
            // Exact: a quotient that is not whole is 2^-13 from a whole number or more.
            let slope = (f64::from((right - left) << 16) / f64::from(high)) as i32;
            let down = (first << 6) + 32 - top;
            let across = libm::floor(f64::from(slope) * f64::from(down) / 65_536.0) as i32;
            firsts[lane] = first;
            lasts[lane] = end;
            places[lane] = (left + across) << 10;
            slopes[lane] = slope;
        }
    }
    let (mut top, mut bottom) = (i32::MAX, 0);
    for line in 0..lines {
        top = top.min(firsts[line % MAX_HULL_POINTS]);
        bottom = bottom.max(lasts[line % MAX_HULL_POINTS]);
    }
    let mut base = top;
    while base < bottom {
        let mut left = [i32::MAX; LANES];
        let mut right = [i32::MIN; LANES];
        for line in 0..lines {
            let line = line % MAX_HULL_POINTS;
            let first = firsts[line];
            let (len, place, slope) = ((lasts[line] - first).cast_unsigned(), places[line], slopes[line]);
            for lane in 0..LANES {
                let below = base + lane as i32 - first;
                let at = place.wrapping_add(slope.wrapping_mul(below));
                let crosses = below.cast_unsigned() < len;
                left[lane] = if crosses && at < left[lane] { at } else { left[lane] };
                right[lane] = if crosses && at > right[lane] { at } else { right[lane] };
            }
        }
        let Some(rows) = rows.get_mut(base as usize..).and_then(<[u64]>::first_chunk_mut::<LANES>) else {
            return;
        };
        for lane in 0..LANES {
            let is_in = left[lane] <= right[lane];
            let from = if is_in { (left[lane] + (1 << 15)) >> 16 } else { 0 };
            let to = if is_in { (right[lane] + (1 << 15)) >> 16 } else { 0 };
            rows[lane] |= ones(to) & !ones(from);
        }
        base += LANES as i32;
    }
}

//! tiny-skia's pixels of unpacked figures, sixteen lines or rows at a time.
//!
//! Outlines are edges between visible facets and others, as in bit rows. An outline is clear if each
//! of its edges has all other points of the hull on one side by more than rounding can tell: then
//! its edges are those of [`crate::outline::convex`], too, and the fixed-point lines along them are
//! those of [`Skia`](super::Skia). Most edges are clear by what facets show
//! ([`crate::body::clearance`]), those beside unclear facets are looked at point by point. Hulls for
//! which neither shows it, and those that a side of the window cuts, are drawn by
//! [`Skia`](super::Skia)'s code.

use super::hull_pixels::HullPixels;
use super::image_points::{ImagePoints, first_numbers, part, placed};
use super::moments::AreaMoments;
use super::placement::{Extent, Placement, as_pixels};
use super::skia::{self, OUTSIDE};
use super::visible_facets::{VisibleFacets, look};
use super::window::{Fill, Pixels};
use super::{DrawError, Rasterizer, RenderView};
use crate::body::Figure;
use crate::body::clearance::{CLEAR_PLACE_M, CLEAR_SCALE};
use crate::budget::{LANES, MAX_HULL_POINTS, MAX_HULLS, MAX_ROWS, SKIA_WINDOW_COLUMNS};
use crate::camera::Camera;
use crate::silhouette::{Silhouette, Size};
use crate::simd::{Lanes, LineEnds, MAX_LINES, Simd, Wide, compiled, dispatch};
use core::ops::Range;

/// Steps of the grid in a pixel.
const UNIT: f32 = 64.0;

/// Lines in fixed point, as [`Skia`](super::Skia) steps along them.
#[derive(Clone, Debug)]
struct FixedLines {
    /// The first row that each crosses, and the last one: the one before it if it crosses none.
    first: [u32; MAX_LINES],
    last: [u32; MAX_LINES],
    /// Where it would cross row 0, 1/65,536 pixel, half a pixel to the right, and how much further
    /// right for each row below. In the rows that it crosses it is never negative, as hulls inside
    /// the window reach less than that out of it.
    place: [u32; MAX_LINES],
    slope: [u32; MAX_LINES],
}

impl FixedLines {
    const NONE: Self = Self {
        first: [0; _],
        last: [0; _],
        place: [0; _],
        slope: [0; _],
    };
}

/// The window of [`Rasterizer::Skia`] for unpacked figures. 28 kB.
#[derive(Clone, Debug)]
pub(super) struct SkiaLanes {
    simd: Simd,
    size: Size,
    looks: VisibleFacets,
    points: ImagePoints,
    extent: Extent,
    /// The points in the window, 1/64 pixel, cut off.
    grid: ImagePoints,
    /// The outlines of hulls that are not filled yet: the ends of lines on the grid, and the lines.
    ends: LineEnds,
    lines: FixedLines,
    /// Bit `c` is column `c`. Rows below the window may be anything.
    rows: [u64; MAX_ROWS + LANES],
}

impl SkiaLanes {
    pub fn new(size: Size, simd: Simd) -> Self {
        Self {
            simd,
            size,
            looks: VisibleFacets::NONE,
            points: ImagePoints::ZERO,
            extent: Extent::NONE,
            grid: ImagePoints::ZERO,
            ends: LineEnds::NONE,
            lines: FixedLines::NONE,
            rows: [0; _],
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
        self.extent = self.points.project(figure, camera, self.simd)?;
        Ok(self.extent)
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
    look::<L, true>(l, looks, figure, views);
}

/// Finds the lines of all hulls, and fills them.
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
    let Placement { scale, at, .. } = *placement;
    let may_be_clear = scale.x == scale.y
        && scale.x >= CLEAR_SCALE
        && at.abs().max_element() <= CLEAR_PLACE_M * scale.x;
    // Placing keeps the order of coordinates, and turns up into down.
    let [low, high] = [window.extent.min, window.extent.max].map(|corner| placement.place(corner));
    let is_inside = skia::is_inside(low.min(high), low.max(high), height) == Some(true);
    let (count, grid) = (figure.len(), &mut window.grid);
    if L::IS_ONE {
        place(l, &window.points, count, placement, grid);
    } else {
        place(l.half(), &window.points, count, placement, grid);
    }
    // Where the lines of each hull end.
    let mut hulls = heapless::Vec::<usize, MAX_HULLS>::new();
    let mut count = 0;
    for (number, hull) in figure.hull_parts().enumerate() {
        if !LineEnds::has_room(count) {
            fill_hulls(l, window, &hulls);
            hulls.clear();
            count = 0;
        }
        let (Some(points), Some(grid)) = (
            window.points.of_hull(hull.points.start),
            window.grid.of_hull(hull.points.start),
        ) else {
            return;
        };
        let facing = window.looks.facing(view, number);
        let ends = &mut window.ends;
        let place = match is_inside {
            true => Where::Inside,
            false => place_of(grid, hull.points.len(), height),
        };
        if place == Where::Outside {
            continue;
        }
        let unclear = match may_be_clear {
            true => window.looks.unclear(view, number),
            false => u64::MAX,
        };
        if place == Where::Across || unclear != 0 {
            let pixels = HullPixels::new(points, hull.points.len(), placement);
            let is_clear = unclear == 0 || pixels.is_clear(l, [facing, unclear], hull.edges);
            if !is_clear || place == Where::Across {
                let rows = window.rows.get_mut(..height).unwrap_or_default();
                let axes = pixels.axes.each_ref();
                let is_filled = is_clear && {
                    let lines = l.ends(facing, hull.edges, axes, (ends, count));
                    let lines = (count..count + lines).map(|line| ends.get(line));
                    skia::fill_between(pixels.turned(lines), rows)
                };
                if !is_filled {
                    skia::fill(&skia::outline_in_window(pixels.points(), height), rows);
                }
                continue;
            }
        }
        count += l.ends(facing, hull.edges, grid, (ends, count));
        // No figure has more hulls.
        let _ = hulls.push(count);
    }
    fill_hulls(l, window, &hulls);
}

/// Fills hulls whose lines end at these numbers.
#[inline(always)]
fn fill_hulls<L: Wide>(l: L, window: &mut SkiaLanes, hulls: &[usize]) {
    if L::IS_ONE {
        fill_each(l, window, hulls);
    } else {
        fill_each(l.half(), window, hulls);
    }
}

#[inline(always)]
fn fill_each<const N: usize, L: Lanes<N>>(l: L, window: &mut SkiaLanes, hulls: &[usize]) {
    let count = hulls.last().copied().unwrap_or(0);
    lay(l, &window.ends, &mut window.lines, count);
    let mut start = 0;
    for &end in hulls {
        fill_hull(l, &window.lines, start..end, &mut window.rows);
        start = end;
    }
}

/// Places points in the window, in steps of the grid, and cuts off fractions.
#[inline(always)]
fn place<const N: usize, L: Lanes<N>>(
    l: L,
    points: &ImagePoints,
    count: usize,
    placement: &Placement,
    grid: &mut ImagePoints,
) {
    let unit = l.splat(UNIT);
    let (xs, _) = points.x.as_chunks::<N>();
    let (ys, _) = points.y.as_chunks::<N>();
    let (to_xs, _) = grid.x.as_chunks_mut::<N>();
    let (to_ys, _) = grid.y.as_chunks_mut::<N>();
    let each = xs.iter().zip(ys).zip(to_xs).zip(to_ys);
    for (((x, y), to_x), to_y) in each.take(count.div_ceil(N)) {
        let [x, y] = placed(l, [l.load(x), l.load(y)], placement);
        l.store(l.whole(l.mul(x, unit)), to_x);
        l.store(l.whole(l.mul(y, unit)), to_y);
    }
}

/// Where a hull is.
#[derive(Clone, Copy, PartialEq)]
enum Where {
    /// So far inside the window that no line is cut.
    Inside,
    /// A pixel or more beside, above or below the window.
    Outside,
    /// Across one of its sides.
    Across,
}

/// Returns where a hull of `count` points is.
#[inline(always)]
fn place_of(grid: [&[f32; MAX_HULL_POINTS]; 2], count: usize, height: usize) -> Where {
    let mut place = Where::Inside;
    for (axis, side) in grid.into_iter().zip([SKIA_WINDOW_COLUMNS, height]) {
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for &at in axis.iter().take(count) {
            (least, most) = (least.min(at), most.max(at));
        }
        let side = as_pixels(side) * UNIT;
        // Less than a step is cut off, towards 0.
        let margin = OUTSIDE * UNIT - 1.0;
        if most <= -UNIT || least >= side + UNIT {
            return Where::Outside;
        }
        if least <= -margin || most >= side + margin {
            place = Where::Across;
        }
    }
    place
}

/// Computes the first `count` lines, between ends on the grid.
#[inline(always)]
fn lay<const N: usize, L: Lanes<N>>(l: L, ends: &LineEnds, lines: &mut FixedLines, count: usize) {
    let half = l.splat_word(32);
    for first in (0..count).step_by(N) {
        let (from, to) = (&ends.from, &ends.to);
        let ax = l.cut_off(part(l, &from[0], first));
        let ay = l.cut_off(part(l, &from[1], first));
        let bx = l.cut_off(part(l, &to[0], first));
        let by = l.cut_off(part(l, &to[1], first));
        let goes_up = l.less_words(by, ay);
        let (x, other) = (l.choose(goes_up, bx, ax), l.choose(goes_up, ax, bx));
        let (y, other_y) = (l.min_words(ay, by), l.max_words(ay, by));
        let start = l.down::<6>(l.add_words(y, half));
        let last = l.down::<6>(l.sub_words(other_y, half));
        let slope = l.slopes(l.sub_words(other, x), l.sub_words(other_y, y));
        let down = l.sub_words(l.add_words(l.up::<6>(start), half), y);
        // slope * down / 65,536, in two parts.
        let across = l.add_words(
            l.mul_words(l.down::<16>(slope), down),
            l.down::<16>(l.mul_words(l.and_words(slope, l.splat_word(0xffff)), down)),
        );
        let place = l.add_words(l.up::<10>(l.add_words(x, across)), l.splat_word(1 << 15));
        let all = [
            (&mut lines.first, start),
            (&mut lines.last, last),
            (
                &mut lines.place,
                l.sub_words(place, l.mul_words(slope, start)),
            ),
            (&mut lines.slope, slope),
        ];
        for (to, words) in all {
            if let Some(to) = to.get_mut(first..).and_then(<[u32]>::first_chunk_mut) {
                l.store_words(words, to);
            }
        }
    }
}

/// Fills the rows between the lines of a hull: two cross a row, or none.
#[inline(always)]
fn fill_hull<const N: usize, L: Lanes<N>>(
    l: L,
    lines: &FixedLines,
    hull: Range<usize>,
    rows: &mut [u64; MAX_ROWS + LANES],
) {
    let (mut top, mut bottom) = (
        l.splat_word(i32::MAX.cast_unsigned()),
        l.splat_word(u32::MAX),
    );
    for at in hull.clone().step_by(N) {
        let chunk = |of: &[u32; MAX_LINES]| match of.get(at..).and_then(<[u32]>::first_chunk) {
            Some(words) => l.load_words(words),
            None => l.splat_word(0),
        };
        let (first, last) = (chunk(&lines.first), chunk(&lines.last));
        #[expect(clippy::cast_possible_truncation, reason = "at most 90")]
        let is_line = l.less_words(first_numbers(l), l.splat_word((hull.end - at) as u32));
        top = l.choose(is_line, l.min_words(top, first), top);
        bottom = l.choose(is_line, l.max_words(bottom, last), bottom);
    }
    let (mut row, bottom) = l.ends_of(top, bottom);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "16 at most"
    )]
    let at_once = N as i32;
    while row <= bottom {
        // A line is loaded once for all rows that registers have room for.
        row = match (bottom - row) / at_once {
            0 => fill_rows::<1, N, L>(l, lines, hull.clone(), row, rows),
            1 => fill_rows::<2, N, L>(l, lines, hull.clone(), row, rows),
            _ => fill_rows::<3, N, L>(l, lines, hull.clone(), row, rows),
        };
    }
}

/// Fills `B` times `N` rows from `row` on, and returns the next one.
#[inline(always)]
fn fill_rows<const B: usize, const N: usize, L: Lanes<N>>(
    l: L,
    lines: &FixedLines,
    hull: Range<usize>,
    mut row: i32,
    rows: &mut [u64; MAX_ROWS + LANES],
) -> i32 {
    #[expect(
        clippy::cast_sign_loss,
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "below 128"
    )]
    let (first_row, at_once, step) = (row as u32, N as i32, N as u32);
    let step = l.splat_word(step);
    let mut here = [l.add_words(first_numbers(l), l.splat_word(first_row)); B];
    for after in 1..B {
        here[after] = l.add_words(here[after - 1], step);
    }
    let mut spans = [(l.splat_word(i32::MAX.cast_unsigned()), l.splat_word(0)); B];
    let all = [&lines.first, &lines.last, &lines.place, &lines.slope];
    let [firsts, lasts, places, slopes] = all.map(|of| of.get(hull.clone()).unwrap_or_default());
    for (((&first, &last), &place), &slope) in firsts.iter().zip(lasts).zip(places).zip(slopes) {
        let (rows, slope) = (
            [l.splat_word(first), l.splat_word(last)],
            l.splat_word(slope),
        );
        let further = l.mul_words(slope, step);
        let mut at = l.add_words(l.splat_word(place), l.mul_words(slope, here[0]));
        for (span, &here) in spans.iter_mut().zip(&here) {
            *span = l.widen(*span, at, here, rows);
            at = l.add_words(at, further);
        }
    }
    for (left, right) in spans {
        let rows = usize::try_from(row)
            .ok()
            .and_then(|row| rows.get_mut(row..));
        if let Some(rows) = rows.and_then(<[u64]>::first_chunk_mut) {
            l.fill_rows(l.down::<16>(left), l.down::<16>(right), rows);
        }
        row += at_once;
    }
    row
}

//! tiny-skia's pixels of unpacked figures, sixteen lines or rows at a time.
//!
//! Outlines are edges between visible facets and others, as in bit rows. An outline is clear if each
//! of its edges has all other points of the hull on one side by more than rounding can tell: then
//! its edges are those of [`crate::outline::convex`], too, and the fixed-point lines along them are
//! those of [`Skia`](super::Skia). Most outlines are clear by what facets show
//! ([`crate::body::clearance`]), the others are looked at point by point. Hulls for which neither
//! shows it, and those that a side of the window cuts, are drawn by [`Skia`](super::Skia)'s code.

use super::image_points::ImagePoints;
use super::moments::AreaMoments;
use super::placement::{Extent, Placement, as_pixels};
use super::rows::{VisibleFacets, look, placed};
use super::skia::{self, NEARLY_ZERO, OUTSIDE};
use super::window::{Fill, Pixels};
use super::{DrawError, Rasterizer, RenderView};
use crate::body::Figure;
use crate::body::clearance::{CLEAR, CLEAR_SCALE, CLEAR_STRETCH};
use crate::budget::{
    LANES, MAX_FIGURE_COLUMNS, MAX_HULL_EDGES, MAX_HULL_POINTS, MAX_HULLS, MAX_ROWS,
    SKIA_WINDOW_COLUMNS,
};
use crate::camera::Camera;
use crate::silhouette::{Silhouette, Size};
use crate::simd::{Lanes, LineEnds, Simd, Wide, compiled, dispatch};
use glam::Vec2;

/// A convex outline has at most as many lines as points.
const STRIPS: usize = MAX_HULL_POINTS / LANES;
/// As many as all edges of a hull take.
const ALL_STRIPS: usize = MAX_HULL_EDGES.div_ceil(LANES);
/// The numbers of lanes.
const NUMBERS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// The lines of a hull, as [`Skia`](super::Skia) steps along them.
#[derive(Clone, Debug)]
struct HullLines {
    /// The first row that each crosses, and how many.
    first: [u32; MAX_HULL_POINTS],
    rows: [u32; MAX_HULL_POINTS],
    /// Where it crosses the first row, 1/65,536 pixel, half a pixel to the right, and how much
    /// further right for each row below.
    place: [u32; MAX_HULL_POINTS],
    slope: [u32; MAX_HULL_POINTS],
    len: usize,
    /// The first row that any line crosses, and the first one below.
    top: i32,
    bottom: i32,
}

impl HullLines {
    const NONE: Self = Self {
        first: [0; _],
        rows: [0; _],
        place: [0; _],
        slope: [0; _],
        len: 0,
        top: 0,
        bottom: 0,
    };
}

/// The window of [`Rasterizer::Skia`] for unpacked figures. 34 kB.
#[derive(Clone, Debug)]
pub struct SkiaLanes {
    simd: Simd,
    size: Size,
    looks: VisibleFacets,
    points: ImagePoints,
    ends: [LineEnds; ALL_STRIPS],
    lines: [HullLines; MAX_HULLS],
    /// Bit `c` is column `c`. Rows below the window may be anything.
    rows: [u64; MAX_ROWS + LANES],
    pub causes: [u64; 6],
}

impl SkiaLanes {
    pub fn new(size: Size, simd: Simd) -> Self {
        Self {
            simd,
            size,
            looks: VisibleFacets::NONE,
            points: ImagePoints::ZERO,
            ends: [const { LineEnds::NONE }; _],
            lines: [const { HullLines::NONE }; _],
            rows: [0; _],
            causes: [0; 6],
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
    let Placement { scale, at, .. } = *placement;
    let may_be_clear = scale.min_element() >= CLEAR_SCALE
        && scale.max_element() <= CLEAR_STRETCH * scale.min_element()
        && at.abs().max_element() <= as_pixels(2 * MAX_FIGURE_COLUMNS);
    let mut hulls = 0;
    for (number, hull) in figure.hull_parts().enumerate().take(MAX_HULLS) {
        let start = hull.points.start;
        let [x, y] = [&window.points.x, &window.points.y].map(|axis| {
            axis.get(start..)
                .and_then(<[f32]>::first_chunk::<MAX_HULL_POINTS>)
        });
        let (Some(x), Some(y)) = (x, y) else {
            return;
        };
        let facing = window.looks.facing(view, number);
        let count = l.ends(facing, hull.edges, [x, y], &mut window.ends);
        let lines = &mut window.lines[hulls];
        let mut place = Where::Nowhere;
        if (3..=MAX_HULL_POINTS).contains(&count) {
            place = lay_all(l, &window.ends, count, placement, window.size, lines);
        }
        window.causes[0] += 1;
        let is_clear = match place {
            Where::Outside => { window.causes[1] += 1; continue },
            Where::Nowhere => { window.causes[2] += 1; false },
            Where::Inside if may_be_clear && !window.looks.is_doubtful(view, number) => true,
            Where::Inside => {
                window.causes[3] += 1;
                let pixels = place_all(l, [x, y], hull.points.len(), placement);
                is_clear(l, &pixels, hull.points.len(), &window.ends, count, placement)
            }
        };
        if is_clear {
            hulls += 1;
        } else {
            window.causes[4] += 1;
            let points = x.iter().zip(y).take(hull.points.len());
            let points = points.map(|(&x, &y)| placement.place(Vec2::new(x, y)));
            let rows = window.rows.get_mut(..window.size.rows()).unwrap_or_default();
            skia::fill(&skia::outline_in_window(points, window.size.rows()), rows);
        }
    }
    for lines in window.lines.iter().take(hulls) {
        if L::IS_ONE {
            fill_lines(l, lines, &mut window.rows);
        } else {
            fill_lines(l.half(), lines, &mut window.rows);
        }
    }
}

/// Where an outline is.
#[derive(Clone, Copy, PartialEq)]
enum Where {
    /// So far inside the window that no line is cut.
    Inside,
    /// Left or right of the window.
    Outside,
    /// Neither, or not known.
    Nowhere,
}

/// Computes the lines of a hull: sixteen at a time if that is one register, otherwise eight.
#[inline(always)]
fn lay_all<L: Wide>(
    l: L,
    ends: &[LineEnds],
    count: usize,
    placement: &Placement,
    size: Size,
    lines: &mut HullLines,
) -> Where {
    lines.len = count;
    (lines.top, lines.bottom) = (i32::MAX, 0);
    let mut outside = [0; 4];
    for (ends, first) in ends.iter().zip((0..count).step_by(LANES)) {
        if L::IS_ONE {
            lay(l, ends, first, 0, placement, size, lines, &mut outside);
        } else {
            for lane in (0..(count - first).min(LANES)).step_by(LANES / 2) {
                lay(l.half(), ends, first + lane, lane, placement, size, lines, &mut outside);
            }
        }
    }
    let [near, left, right, _] = outside;
    if near == 0 {
        Where::Inside
    } else if left == count || right == count {
        Where::Outside
    } else {
        Where::Nowhere
    }
}

/// Computes `N` lines of a hull, from number `first` on, whose ends begin at a lane.
#[inline(always)]
fn lay<const N: usize, L: Lanes<N>>(
    l: L,
    ends: &LineEnds,
    first: usize,
    lane: usize,
    placement: &Placement,
    size: Size,
    lines: &mut HullLines,
    outside: &mut [usize; 4],
) {
    let lanes = NUMBERS.first_chunk::<N>().map_or(l.splat_word(0), |numbers| l.load_words(numbers));
    let left = lines.len - first;
    let is_line = l.less_words(lanes, l.splat_word(left as u32));
    let [ax, ay] = placed(l, &ends.from, lane, placement);
    let [bx, by] = placed(l, &ends.to, lane, placement);
    let sides = [SKIA_WINDOW_COLUMNS, size.rows()].map(as_pixels);
    let (low, high) = (l.splat(-OUTSIDE), [l.splat(sides[0] + OUTSIDE), l.splat(sides[1] + OUTSIDE)]);
    let is_inside = l.and(
        l.and(l.less(low, l.min(ax, bx)), l.less(l.max(ax, bx), high[0])),
        l.and(l.less(low, l.min(ay, by)), l.less(l.max(ay, by), high[1])),
    );
    let all = l.bits(is_line);
    let away = all & !l.bits(is_inside);
    if away != 0 {
        outside[0] += 1;
        let is_left = l.not_less(l.splat(-1.0), l.max(ax, bx));
        let is_right = l.not_less(l.min(ax, bx), l.splat(sides[0] + 1.0));
        outside[1] += (all & l.bits(is_left)).count_ones() as usize;
        outside[2] += (all & l.bits(is_right)).count_ones() as usize;
        return;
    }
    let grid = l.splat(64.0);
    let [ax, ay, bx, by] = [ax, ay, bx, by].map(|at| l.cut_off(l.mul(at, grid)));
    let goes_up = l.less_words(by, ay);
    let (x, other) = (l.choose(goes_up, bx, ax), l.choose(goes_up, ax, bx));
    let (y, bottom) = (l.min_words(ay, by), l.max_words(ay, by));
    let half = l.splat_word(32);
    let start = l.down::<6>(l.add_words(y, half));
    let end = l.down::<6>(l.add_words(bottom, half));
    let rows = l.sub_words(end, start);
    let slope = l.slopes(l.sub_words(other, x), l.sub_words(bottom, y));
    let down = l.sub_words(l.add_words(l.up::<6>(start), half), y);
    // slope * down / 65,536, in two parts.
    let across = l.add_words(
        l.mul_words(l.down::<16>(slope), down),
        l.down::<16>(l.mul_words(l.and_words(slope, l.splat_word(0xffff)), down)),
    );
    let place = l.add_words(l.up::<10>(l.add_words(x, across)), l.splat_word(1 << 15));
    let none = l.splat_word(0);
    let crosses = l.within(lanes, l.splat_word(left as u32));
    let rows = l.choose(crosses, rows, none);
    let is_crossing = l.less_words(none, rows);
    let (top, bottom) = l.ends_of(
        l.choose(is_crossing, start, l.splat_word(i32::MAX.cast_unsigned())),
        l.choose(is_crossing, end, none),
    );
    lines.top = lines.top.min(top);
    lines.bottom = lines.bottom.max(bottom);
    let all = [
        (&mut lines.first, start),
        (&mut lines.rows, rows),
        (&mut lines.place, place),
        (&mut lines.slope, slope),
    ];
    for (to, words) in all {
        if let Some(to) = to.get_mut(first..).and_then(<[u32]>::first_chunk_mut) {
            l.store_words(words, to);
        }
    }
}

/// Fills `N` rows at a time between lines of which two cross each row or none.
#[inline(always)]
fn fill_lines<const N: usize, L: Lanes<N>>(
    l: L,
    lines: &HullLines,
    rows: &mut [u64; MAX_ROWS + LANES],
) {
    let lanes = NUMBERS.first_chunk::<N>().map_or(l.splat_word(0), |numbers| l.load_words(numbers));
    let mut row = lines.top;
    while row < lines.bottom {
        let below = l.add_words(lanes, l.splat_word(row.cast_unsigned()));
        // No columns.
        let mut left = l.splat_word(64 << 16);
        let mut right = l.splat_word(0);
        let each = lines.first.iter().zip(&lines.rows).zip(&lines.place).zip(&lines.slope);
        for (((&first, &len), &place), &slope) in each.take(lines.len) {
            let below = l.sub_words(below, l.splat_word(first));
            let is_crossed = l.within(below, l.splat_word(len));
            let at = l.add_words(l.splat_word(place), l.mul_words(l.splat_word(slope), below));
            left = l.choose(is_crossed, l.min_words(left, at), left);
            right = l.choose(is_crossed, l.max_words(right, at), right);
        }
        let left = l.max_words(left, l.splat_word(0));
        let Some(rows) = rows.get_mut(row as usize..).and_then(<[u64]>::first_chunk_mut) else {
            return;
        };
        l.fill_rows(l.down::<16>(left), l.down::<16>(right), rows);
        row += N as i32;
    }
}

/// The points of a hull in the window, pixels; NaN after the last one.
type HullPixels = [[f32; MAX_HULL_POINTS]; 2];

/// Places the points of a hull.
#[inline(always)]
fn place_all<L: Wide>(
    _: L,
    [x, y]: [&[f32; MAX_HULL_POINTS]; 2],
    count: usize,
    placement: &Placement,
) -> HullPixels {
    let mut pixels = [[f32::NAN; MAX_HULL_POINTS]; 2];
    for (lane, (&x, &y)) in x.iter().zip(y).enumerate().take(count) {
        let pixel = placement.place(Vec2::new(x, y));
        (pixels[0][lane], pixels[1][lane]) = (pixel.x, pixel.y);
    }
    pixels
}

/// Returns whether each line has all points of its hull but its own ends clearly on one side.
#[inline(always)]
fn is_clear<L: Wide>(
    l: L,
    pixels: &HullPixels,
    count: usize,
    ends: &[LineEnds],
    lines: usize,
    placement: &Placement,
) -> bool {
    let sixteens = || pixels[0].as_chunks::<LANES>().0.iter().zip(pixels[1].as_chunks::<LANES>().0);
    let (mut min, mut max) = ([l.splat(f32::INFINITY); 2], [l.splat(f32::NEG_INFINITY); 2]);
    for (x, y) in sixteens() {
        let point = [l.load(x), l.load(y)];
        min = [l.min(point[0], min[0]), l.min(point[1], min[1])];
        max = [l.max(point[0], max[0]), l.max(point[1], max[1])];
    }
    let [(left, right), (top, bottom)] = [l.bounds(min[0], max[0]), l.bounds(min[1], max[1])];
    let across = (right - left).max(bottom - top);
    // What is wider than this apart from the line is not too thin to be drawn, either.
    let wide = (CLEAR * across).max(NEARLY_ZERO);
    let others = count - 2;
    let mut all_clear = true;
    for (line, strip) in (0..lines).map(|line| (line, &ends[line / LANES % ALL_STRIPS])) {
        let lane = line % LANES;
        let from = placement.place(Vec2::new(strip.from[0][lane], strip.from[1][lane]));
        let to = placement.place(Vec2::new(strip.to[0][lane], strip.to[1][lane]));
        let along = to - from;
        let clear = l.splat(wide * (along.x.abs() + along.y.abs()));
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
    all_clear
}

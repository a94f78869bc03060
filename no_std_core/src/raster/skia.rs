//! tiny-skia's pixels without tiny-skia: outlines are filled by its fixed-point arithmetic, a row
//! of bits at a time, without a heap.
//!
//! tiny-skia 0.12 cuts coordinates off to 1/64 pixel, steps along a line in 1/65,536 pixel
//! (`edge.rs`), and turns on what an outline winds around (`scan/path.rs`). Lines cross rows in the
//! same places here, so that each pixel is the same. `TinySkia` is what tests compare with.

use super::moments::AreaMoments;
use super::placement::{Extent, Placement, as_pixels};
use super::window::{Fill, Pixels, PosedHulls};
use super::{DrawError, Rasterizer};
use crate::bit_adder::add_eight;
use crate::budget::{MAX_OUTLINE, MAX_ROWS, SKIA_WINDOW_COLUMNS};
use crate::camera::Camera;
use crate::outline::{Outline, clipped, convex, crossing};
use crate::silhouette::{Silhouette, Size};
use glam::{Vec2, Vec2Swizzles as _};

/// An outline that is not wider or not higher than this covers nothing, pixels.
pub(super) const NEARLY_ZERO: f32 = 1.0 / 4_096.0;
/// Lines are cut at the sides of the window if the outline reaches this far out of it, pixels: half
/// a pixel less 1.5/64 pixel.
pub(super) const OUTSIDE: f32 = 0.476_562_5;

/// The area of a pixel that is on: tiny-skia's, so that shares of areas are rounded alike.
const ON: u64 = 255;

/// The window of [`Rasterizer::Skia`], a bit for each pixel. Figures may be unpacked or compact.
#[derive(Clone, Debug)]
pub struct Skia {
    size: Size,
    /// Bit `c` is column `c`.
    rows: [u64; MAX_ROWS],
}

impl Skia {
    /// Makes an empty window.
    #[must_use]
    pub const fn new(size: Size) -> Self {
        Self {
            size,
            rows: [0; MAX_ROWS],
        }
    }

    fn rows(&self) -> &[u64] {
        self.rows.get(..self.size.rows()).unwrap_or_default()
    }
}

impl Pixels for Skia {
    type Image = Silhouette;
    const NEEDS_FACETS: bool = false;

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
        self.rows = [0; MAX_ROWS];
    }

    fn moments(&self) -> AreaMoments {
        moments(self.rows())
    }

    /// Cuts out columns; those outside the window are empty.
    fn cut(&self, left: isize, image: &mut Silhouette) -> u64 {
        cut(self.rows(), left, image)
    }
}

/// Returns the moments of rows.
#[inline(always)]
pub(super) fn moments(rows: &[u64]) -> AreaMoments {
    /// Columns whose number has bit 0, 1, 2, 3, 4 or 5.
    const COLUMNS: [u64; 6] = [
        0xaaaa_aaaa_aaaa_aaaa,
        0xcccc_cccc_cccc_cccc,
        0xf0f0_f0f0_f0f0_f0f0,
        0xff00_ff00_ff00_ff00,
        0xffff_0000_ffff_0000,
        0xffff_ffff_0000_0000,
    ];
    // The rows that are on in each column, as digits: up to 64.
    let (mut low, mut high) = ([0; 3], [0; 4]);
    let (eights, rest) = rows.as_chunks();
    let rest = core::array::from_fn(|row| rest.get(row).copied().unwrap_or(0));
    for &eight in eights.iter().chain([&rest]) {
        let (sum, mut carry) = add_eight(low, eight);
        low = sum;
        for digit in &mut high {
            (*digit, carry) = (*digit ^ carry, *digit & carry);
        }
    }
    let (mut area, mut columns) = (0, 0);
    for (worth, digit) in low.into_iter().chain(high).enumerate() {
        area += u64::from(digit.count_ones()) << worth;
        for (bit, those) in COLUMNS.into_iter().enumerate() {
            columns += u64::from((digit & those).count_ones()) << (worth + bit);
        }
    }
    AreaMoments {
        area: ON * area,
        doubled: ON * (2 * columns + area),
    }
}

/// Cuts the columns from `left` on out of rows, and returns their area.
#[inline(always)]
pub(super) fn cut(rows: &[u64], left: isize, image: &mut Silhouette) -> u64 {
    let kept = ones(i32::try_from(image.size().columns()).unwrap_or(0));
    let shift = u32::try_from(left.unsigned_abs()).unwrap_or(u32::MAX);
    let mut area = 0;
    for (row, out) in rows.iter().zip(image.all_rows_mut()) {
        let moved = if left < 0 {
            row.checked_shl(shift)
        } else {
            row.checked_shr(shift)
        };
        *out = moved.unwrap_or(0) & kept;
        area += u64::from(out.count_ones());
    }
    ON * area
}

impl<F: PosedHulls> Fill<F> for Skia {
    fn extent(&mut self, figure: &F, camera: &Camera) -> Result<Extent, DrawError> {
        figure.extent(camera)
    }

    fn draw(&mut self, figure: &F, camera: &Camera, _: usize, placement: &Placement, _: usize) {
        self.clear();
        let count = self.size.rows();
        let rows = self.rows.get_mut(..count).unwrap_or_default();
        for hull in figure.hulls() {
            let pixels = hull.map(|point| placement.place(camera.project(point)));
            fill(&outline_in_window(pixels, count), rows);
        }
    }
}

/// Returns the outline of a hull, clipped to the window. A separate function, so that its stack is
/// free again before the outline is filled.
#[inline(never)]
pub(super) fn outline_in_window(pixels: impl Iterator<Item = Vec2>, rows: usize) -> Outline {
    // One pixel of margin, so that the cut itself is never visible.
    let min = Vec2::splat(-1.0);
    let max = Vec2::new(as_pixels(SKIA_WINDOW_COLUMNS + 1), as_pixels(rows + 1));
    clipped(&convex(pixels), min, max)
}

/// Returns a row whose leftmost `columns` are on.
#[inline(always)]
pub(super) fn ones(columns: i32) -> u64 {
    let off = (64 - columns.clamp(0, 64)).cast_unsigned();
    u64::MAX.checked_shr(off).unwrap_or(0)
}

/// Turns on what an outline winds around, whose corners lie within a pixel of the window.
pub(super) fn fill(outline: &[Vec2], rows: &mut [u64]) {
    if outline.len() < 3 {
        return;
    }
    let [min, max] = bounds(outline.iter().copied());
    let Some(is_inside) = is_inside(min, max, rows.len()) else {
        return;
    };
    // Two lines cross each row if lines turn twice, from going down to going up and back: what is
    // left of one of them only lies between them.
    let mut between = [0; MAX_ROWS];
    let (mut turns, mut went_up) = (0, None);
    each_line(outline, is_inside, rows.len(), |line| {
        turns += usize::from(went_up.is_some_and(|up| up != line.goes_up));
        went_up = Some(line.goes_up);
        line.turn(&mut between);
    });
    if turns > 2 {
        fill_crossing(outline, is_inside, rows);
    } else {
        for (row, between) in rows.iter_mut().zip(between) {
            *row |= between;
        }
    }
}

/// Returns the least and the greatest coordinates of points.
pub(super) fn bounds(points: impl Iterator<Item = Vec2>) -> [Vec2; 2] {
    points.fold([Vec2::INFINITY, Vec2::NEG_INFINITY], |[min, max], point| {
        [min.min(point), max.max(point)]
    })
}

/// Returns whether no line of an outline between these corners is cut at the sides of the window;
/// `None` if it covers nothing.
pub(super) fn is_inside(min: Vec2, max: Vec2, rows: usize) -> Option<bool> {
    if !(max - min).cmpgt(Vec2::splat(NEARLY_ZERO)).all() {
        return None;
    }
    let sides = Vec2::new(as_pixels(SKIA_WINDOW_COLUMNS), as_pixels(rows));
    let outside = Vec2::splat(OUTSIDE);
    Some(min.cmpgt(-outside).all() && max.cmplt(sides + outside).all())
}

/// Turns on what lies between the lines of a convex outline, in any order, that turn the same way
/// around it. Returns whether it could: not if the outline reaches a pixel above or below the window.
pub(super) fn fill_between(lines: impl Iterator<Item = [Vec2; 2]>, rows: &mut [u64]) -> bool {
    // The window and a pixel on either side, as `outline_in_window` cuts.
    let planes = [
        (Vec2::X, -1.0),
        (Vec2::NEG_X, -as_pixels(SKIA_WINDOW_COLUMNS + 1)),
    ];
    let mut cuts = [[None; 2]; 2];
    let mut kept = heapless::Vec::<[Vec2; 2], { MAX_OUTLINE + 2 }>::new();
    'lines: for mut line in lines {
        for ((normal, limit), [leaves, enters]) in planes.into_iter().zip(&mut cuts) {
            let is_out = line.map(|end| normal.dot(end) - limit < 0.0);
            let at = || crossing(line, normal, limit);
            match is_out {
                [true, true] => continue 'lines,
                [true, false] => line = [*enters.insert(at()), line[1]],
                [false, true] => line = [line[0], *leaves.insert(at())],
                [false, false] => {}
            }
        }
        // As many lines as corners, and one along each side.
        let _ = kept.push(line);
    }
    let [min, max] = bounds(kept.iter().flatten().copied());
    if !(min.y >= -1.0 && max.y <= as_pixels(rows.len() + 1)) {
        return false;
    }
    for cut in cuts {
        if let [Some(leaves), Some(enters)] = cut {
            let _ = kept.push([leaves, enters]);
        }
    }
    let Some(is_inside) = is_inside(min, max, rows.len()) else {
        return true;
    };
    let mut between = [0; MAX_ROWS];
    for [from, to] in kept {
        each_line_between(from, to, is_inside, rows.len(), &mut |line: Line| {
            line.turn(&mut between);
        });
    }
    for (row, between) in rows.iter_mut().zip(between) {
        *row |= between;
    }
    true
}

/// Turns on what an outline winds around whose lines cross each other, since its corners were cut
/// off to a grid: row by row, from the left.
#[cold]
fn fill_crossing(outline: &[Vec2], is_inside: bool, rows: &mut [u64]) {
    let height = rows.len();
    for (number, row) in rows.iter_mut().enumerate() {
        let mut crossings = heapless::Vec::<(i32, i32), MAX_OUTLINE>::new();
        each_line(outline, is_inside, height, |line| {
            if line.rows().contains(&number) {
                let below = (number - line.rows().start).try_into().unwrap_or(0);
                let way = if line.goes_up { -1 } else { 1 };
                // One part of each of at most as many lines as corners.
                let _ = crossings.push((line.place + line.slope * below, way));
            }
        });
        crossings.sort_unstable();
        let (mut winding, mut left) = (0, 0);
        for (place, way) in crossings {
            if winding == 0 {
                left = column(place);
            }
            winding += way;
            if winding == 0 {
                *row |= ones(column(place)) & !ones(left);
            }
        }
    }
}

/// Returns the column whose middle is the first one at a place or right of it.
const fn column(place: i32) -> i32 {
    (place + (1 << 15)) >> 16
}

/// A line between two corners, as tiny-skia steps along it.
#[derive(Clone, Copy)]
struct Line {
    /// The first row whose middle it crosses, and the first one below it.
    first: i32,
    end: i32,
    /// Where it crosses the middle of the first row, 1/65,536 pixel, and how much further right for
    /// each row below.
    place: i32,
    slope: i32,
    goes_up: bool,
}

impl Line {
    /// Returns the line between two corners within a pixel of the window, or `None` if it crosses
    /// no row.
    fn new(from: Vec2, to: Vec2) -> Option<Self> {
        #[expect(clippy::cast_possible_truncation, reason = "tiny-skia cuts off, too")]
        let [from, to] =
            [from, to].map(|corner| ((corner.x * 64.0) as i32, (corner.y * 64.0) as i32));
        let goes_up = from.1 > to.1;
        let ((left, top), (right, bottom)) = if goes_up { (to, from) } else { (from, to) };
        let [first, end] = [top, bottom].map(|y| (y + 32) >> 6);
        if first == end {
            return None;
        }
        // Less than 2^13 across, so that nothing here overflows.
        let slope = ((right - left) << 16) / (bottom - top);
        let down = (first << 6) + 32 - top;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "less than a row's part of the way"
        )]
        let across = ((i64::from(slope) * i64::from(down)) >> 16) as i32;
        Some(Self {
            first,
            end,
            place: (left + across) << 10,
            slope,
            goes_up,
        })
    }

    /// Turns the pixels left of the line.
    fn turn(&self, rows: &mut [u64; MAX_ROWS]) {
        let rows = rows.get_mut(self.rows()).unwrap_or_default();
        for (row, column) in rows.iter_mut().zip(self.columns()) {
            *row ^= ones(column);
        }
    }

    fn rows(&self) -> core::ops::Range<usize> {
        let [first, end] = [self.first, self.end].map(|row| usize::try_from(row).unwrap_or(0));
        first..end
    }

    /// Returns the first column right of the line in each of its rows.
    fn columns(&self) -> impl Iterator<Item = i32> {
        let mut place = self.place;
        core::iter::repeat_with(move || {
            let here = place;
            place = place.wrapping_add(self.slope);
            column(here)
        })
    }
}

/// Passes on the lines between corners, cut at the sides of the window unless the outline is inside.
fn each_line(outline: &[Vec2], is_inside: bool, height: usize, mut take: impl FnMut(Line)) {
    let next = outline.iter().skip(1).chain(outline.first());
    for (&from, &to) in outline.iter().zip(next) {
        each_line_between(from, to, is_inside, height, &mut take);
    }
}

/// Passes on the line between two corners, cut at the sides of the window unless it is inside.
fn each_line_between(
    from: Vec2,
    to: Vec2,
    is_inside: bool,
    height: usize,
    take: &mut impl FnMut(Line),
) {
    let mut draw = |from, to| {
        if let Some(line) = Line::new(from, to) {
            take(line);
        }
    };
    if is_inside {
        draw(from, to);
    } else {
        let sides = Vec2::new(as_pixels(SKIA_WINDOW_COLUMNS), as_pixels(height));
        each_part(from, to, sides, &mut draw);
    }
}

/// Passes on the part of a line inside the window, and what is left or right of it as a line along
/// that side (`line_clipper.rs`).
#[cold]
fn each_part(from: Vec2, to: Vec2, sides: Vec2, draw: &mut impl FnMut(Vec2, Vec2)) {
    if from.y.max(to.y) <= 0.0 || from.y.min(to.y) >= sides.y {
        return;
    }
    let in_rows = |corner: Vec2| {
        let y = corner.y.clamp(0.0, sides.y);
        if y == corner.y {
            corner
        } else {
            Vec2::new(between(from, to, y), y)
        }
    };
    let (start, end) = (in_rows(from), in_rows(to));
    let along = |x: f32, draw: &mut dyn FnMut(Vec2, Vec2)| {
        draw(Vec2::new(x, start.y), Vec2::new(x, end.y));
    };
    if start.x.max(end.x) <= 0.0 {
        return along(0.0, draw);
    }
    if start.x.min(end.x) >= sides.x {
        return along(sides.x, draw);
    }
    let in_columns = |corner: Vec2| {
        let x = corner.x.clamp(0.0, sides.x);
        if x == corner.x {
            corner
        } else {
            Vec2::new(x, between(start.yx(), end.yx(), x))
        }
    };
    let (inner_start, inner_end) = (in_columns(start), in_columns(end));
    draw(Vec2::new(inner_start.x, start.y), inner_start);
    draw(inner_start, inner_end);
    draw(inner_end, Vec2::new(inner_end.x, end.y));
}

/// Returns the x of a line at the height y.
fn between(from: Vec2, to: Vec2, y: f32) -> f32 {
    if (to.y - from.y).abs() <= NEARLY_ZERO {
        return (from.x + to.x) * 0.5;
    }
    let [x0, y0, x1, y1] = [from.x, from.y, to.x, to.y].map(f64::from);
    #[expect(clippy::cast_possible_truncation, reason = "between two f32")]
    let x = (x0 + (f64::from(y) - y0) * (x1 - x0) / (y1 - y0)) as f32;
    x.clamp(from.x.min(to.x), from.x.max(to.x))
}

#[cfg(all(test, feature = "tiny-skia"))]
mod tests {
    use super::super::tiny_skia::TinySkia;
    use super::*;

    /// Knuth's generator: numbers from 0 to 1.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f32 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            #[expect(clippy::cast_possible_truncation, reason = "24 bits")]
            let bits = (self.0 >> 40) as u16;
            f32::from(bits) / 65_536.0
        }

        fn below(&mut self, count: usize) -> usize {
            let count = u16::try_from(count).expect("a small number");
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "small"
            )]
            let number = (self.next() * f32::from(count)) as usize;
            number
        }
    }

    /// Compares an outline, and returns the number of pixels that are on.
    fn compare(outline: &Outline, size: Size, oracle: &mut TinySkia) -> u32 {
        let mut rows = [0; MAX_ROWS];
        let rows = &mut rows[..size.rows()];
        fill(outline, rows);
        oracle.clear();
        oracle.fill(outline);
        let mut on = 0;
        for (row, expected) in rows.iter().zip(oracle.rows()) {
            let expected = { expected.iter().enumerate() }.fold(0, |row, (column, &pixel)| {
                row | u64::from(pixel == 255) << column
            });
            assert_eq!(*row, expected, "{outline:?}");
            on += row.count_ones();
        }
        on
    }

    #[test]
    fn outlines_of_any_shape_have_the_pixels_of_tiny_skia() {
        let mut random = Numbers(7);
        let mut on = 0;
        for size in [Size::S50x30, Size::S64x64] {
            let mut oracle = TinySkia::new(size);
            for _ in 0..20_000 {
                let corners = 3 + random.below(12);
                // From smaller than a pixel to larger than the window; on the grid, too.
                let scale = [0.05, 1.0, 8.0, 30.0, 80.0][random.below(5)];
                let grid = [0.0, 1.0, 64.0][random.below(3)];
                let place = Vec2::new(random.next() * 66.0 - 1.0, random.next() * 66.0 - 1.0);
                let is_convex = random.below(3) > 0;
                let points = (0..corners).map(|_| {
                    let offset = Vec2::new(random.next() - 0.5, random.next() - 0.5);
                    let point = place + offset * scale;
                    match grid > 0.0 {
                        true => (point * grid).map(libm::roundf) / grid,
                        false => point,
                    }
                });
                let points: Outline = points.collect();
                let outline = match is_convex {
                    true => outline_in_window(points.iter().copied(), size.rows()),
                    false => clipped(
                        &points,
                        Vec2::splat(-1.0),
                        Vec2::new(65.0, as_pixels(size.rows() + 1)),
                    ),
                };
                on += compare(&outline, size, &mut oracle);
            }
        }
        assert!(on > 1_000_000, "{on}");
    }
}

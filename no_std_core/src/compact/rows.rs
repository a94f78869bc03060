//! A window of bit rows that processes one number at a time, where `raster/rows` processes sixteen.

use super::CompactFigure;
use super::body::{CompactSight, SeenHull};
use crate::budget::{MAX_ROWS, WINDOW_COLUMNS};
use crate::camera::Camera;
use crate::raster::moments::AreaMoments;
use crate::raster::placement::{Placement, as_pixels, row_columns};
use crate::raster::{DrawError, Extent, Fill, Pixels, PosedHulls, Rasterizer};
use crate::silhouette::{Silhouette, Size};
use core::ops::Range;

/// Columns of a word.
const WORD: usize = 32;
const MAX_WORDS: usize = WINDOW_COLUMNS / WORD;

/// A window of bit rows, with one sample in the middle of a pixel; no heap. 1,552 bytes.
#[derive(Clone, Debug)]
pub struct CompactRows {
    size: Size,
    /// Words of a row in use.
    words: usize,
    /// The samples, by row and word. Bit `c` is column `c` of the word.
    bits: [[u32; MAX_WORDS]; MAX_ROWS],
    /// The part of each row that the current hull covers.
    spans: [RowSpan; MAX_ROWS],
}

/// The part of a row that a hull covers: its first column, and the one after its last. In a
/// `NARROW` window, of one word, it is instead the bits from the first column on, and those after
/// the last one: fewer instructions.
#[derive(Clone, Copy, Debug)]
struct RowSpan([u32; 2]);

impl RowSpan {
    const fn empty(narrow: bool) -> Self {
        Self(if narrow { [0, u32::MAX] } else { [u32::MAX, 0] })
    }

    /// Widens the span to reach `x`.
    #[inline]
    fn widen<const NARROW: bool>(&mut self, x: f32) {
        let (Self([left, right]), column) = (self, first_column(x));
        if NARROW {
            let bits = bits_from(column);
            *left |= bits;
            *right &= bits;
        } else {
            *left = column.min(*left);
            *right = column.max(*right);
        }
    }

    /// Returns the bits that it covers in a `NARROW` window.
    #[inline]
    const fn bits(self) -> u32 {
        let Self([left, right]) = self;
        left & !right
    }

    /// Turns on the bits that it covers in a row of a window that is not `NARROW`, up to this
    /// column.
    #[inline]
    fn fill(self, row: &mut [u32; MAX_WORDS], columns: usize) {
        let [left, right] = self.0.map(|column| column as usize);
        let right = right.min(columns);
        if left >= right {
            return;
        }
        let last = right - 1;
        let (from, to) = (
            u32::MAX << (left % WORD),
            u32::MAX >> (WORD - 1 - last % WORD),
        );
        let (first, last) = (left / WORD % MAX_WORDS, last / WORD % MAX_WORDS);
        if first == last {
            row[first] |= from & to;
            return;
        }
        row[first] |= from;
        row[last] |= to;
        if let Some(between) = row.get_mut(first + 1..last) {
            between.fill(u32::MAX);
        }
    }
}

impl Fill<CompactFigure<'_>> for CompactRows {
    fn extent(&mut self, posed: &CompactFigure<'_>, camera: &Camera) -> Result<Extent, DrawError> {
        posed.extent(camera)
    }

    fn draw(
        &mut self,
        posed: &CompactFigure<'_>,
        camera: &Camera,
        _: usize,
        placement: &Placement,
        columns: usize,
    ) {
        self.empty(columns.div_ceil(WORD).min(MAX_WORDS));
        let sight = CompactSight::new(posed, camera);
        if self.is_narrow() {
            self.draw_hulls::<true>(&sight, posed, placement);
        } else {
            self.draw_hulls::<false>(&sight, posed, placement);
        }
    }
}

impl Pixels for CompactRows {
    type Image = Silhouette;
    const IS_GREY: bool = false;

    fn blank(&self) -> Silhouette {
        Silhouette::empty(self.size)
    }

    fn rasterizer(&self) -> Rasterizer {
        Rasterizer::Rows
    }

    fn size(&self) -> Size {
        self.size
    }

    fn width(&self) -> usize {
        WINDOW_COLUMNS
    }

    fn columns(&self, columns: f32) -> usize {
        row_columns(columns)
    }

    fn clear(&mut self) {
        self.empty(MAX_WORDS);
    }

    fn moments(&self) -> AreaMoments {
        let (mut area, mut doubled) = (0, 0);
        let words = self.words.min(MAX_WORDS);
        for row in self.bits.iter().take(self.size.rows()) {
            for (word, &bits) in (0..).zip(&row[..words]) {
                let mut bits = bits;
                while bits != 0 {
                    let from = bits.trailing_zeros();
                    let run = (bits >> from).trailing_ones();
                    area += run;
                    doubled += run * (2 * (32 * word + from) + run);
                    // The carry passes through the run and ends after it.
                    bits &= bits.wrapping_add(1 << from);
                }
            }
        }
        let (area, doubled) = (u64::from(area), u64::from(doubled));
        AreaMoments { area, doubled }
    }

    /// Copies the columns from `left` on, and returns the number of pixels that are on.
    fn cut(&self, left: isize, silhouette: &mut Silhouette) -> u64 {
        *silhouette = Silhouette::empty(self.size);
        for word in 0..self.words {
            let first = (WORD * word).cast_signed() - left;
            let bits = self.bits.iter();
            silhouette.add_columns(bits.map(|row| row[word % MAX_WORDS]), first);
        }
        let rows = silhouette.rows().iter();
        let area: u32 = if self.size.columns() <= WORD {
            // The upper halves are empty.
            #[expect(clippy::cast_possible_truncation, reason = "the lower half")]
            rows.map(|&row| (row as u32).count_ones()).sum()
        } else {
            rows.map(|row| row.count_ones()).sum()
        };
        u64::from(area)
    }
}

impl CompactRows {
    /// Makes an empty window.
    #[must_use]
    pub const fn new(size: Size) -> Self {
        Self {
            size,
            words: 0,
            bits: [[0; MAX_WORDS]; MAX_ROWS],
            spans: [RowSpan::empty(false); MAX_ROWS],
        }
    }

    const fn is_narrow(&self) -> bool {
        self.words == 1
    }

    /// Sets the number of words in use, which alone are read, and empties them.
    fn empty(&mut self, words: usize) {
        if words != self.words {
            self.words = words;
            self.spans = [RowSpan::empty(self.is_narrow()); MAX_ROWS];
        }
        let is_narrow = self.is_narrow();
        let rows = self.bits.iter_mut().take(self.size.rows());
        if is_narrow {
            rows.for_each(|row| row[0] = 0);
        } else {
            rows.for_each(|row| *row = [0; MAX_WORDS]);
        }
    }

    fn draw_hulls<const NARROW: bool>(
        &mut self,
        sight: &CompactSight<'_>,
        posed: &CompactFigure<'_>,
        placement: &Placement,
    ) {
        let mut seen = SeenHull::new(sight);
        for parts in posed.wholes() {
            let rows = self.cross::<NARROW>(&mut seen, parts, placement);
            self.fill::<NARROW>(rows);
        }
    }

    /// Widens the spans of the rows whose middles the lines of a hull's outline cross, and
    /// returns a range of rows that contains them.
    fn cross<const NARROW: bool>(
        &mut self,
        seen: &mut SeenHull<'_>,
        parts: Range<usize>,
        placement: &Placement,
    ) -> Range<usize> {
        let most = u32::try_from(self.size.rows()).unwrap_or(0);
        let row = |y| first_row(y).min(most);
        let (spans, mut start, mut end) = (&mut self.spans, most, 0);
        seen.trace(parts, placement, row, |a, b| {
            // Most lines of a small hull cross no row.
            if a.row == b.row {
                return;
            }
            let (from, to) = (a.row.min(b.row), a.row.max(b.row));
            (start, end) = (from.min(start), to.max(end));
            let slope = (b.pixel.x - a.pixel.x) / (b.pixel.y - a.pixel.y);
            let Some(crossed) = spans.get_mut(from as usize..to as usize) else {
                return;
            };
            let mut y = as_pixels(from as usize) + 0.5;
            for span in crossed {
                span.widen::<NARROW>(a.pixel.x + slope * (y - a.pixel.y));
                // Exact, as halves are.
                y += 1.0;
            }
        });
        start.min(end) as usize..end as usize
    }

    /// Fills the spans of these rows, and empties them.
    ///
    /// Not inlined: on its own it keeps its values in registers.
    #[inline(never)]
    fn fill<const NARROW: bool>(&mut self, rows: Range<usize>) {
        let (Some(spans), Some(bits)) = (self.spans.get_mut(rows.clone()), self.bits.get_mut(rows))
        else {
            return;
        };
        let columns = self.words * WORD;
        for (span, row) in spans.iter_mut().zip(bits) {
            let span = core::mem::replace(span, RowSpan::empty(NARROW));
            if NARROW {
                row[0] |= span.bits();
            } else {
                span.fill(row, columns);
            }
        }
    }
}

/// Returns the first row whose middle is below `y`.
fn first_row(y: f32) -> u32 {
    // With the greatest number below a half, the sum reaches the next whole number exactly from a
    // half on.
    whole(y + 0.5f32.next_down())
}

/// Returns the first column whose middle is right of an edge at `x`, which may be beyond the
/// window's sides.
fn first_column(x: f32) -> u32 {
    whole(x + 0.5)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and drops the fraction on purpose"
)]
const fn whole(pixels: f32) -> u32 {
    pixels as u32
}

/// Returns the bits of a word from this column on.
fn bits_from(column: u32) -> u32 {
    u32::MAX.checked_shl(column).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_row_is_that_of_the_first_middle_that_is_not_above() {
        // All floats around each whole number, half and quarter.
        for quarters in 0..=4 * MAX_ROWS {
            let at = quarters as f32 / 4.0;
            let (mut below, mut above) = (at, at);
            for _ in 0..100 {
                for y in [below, above] {
                    let exact = libm::floor(f64::from(y) + 0.5).max(0.0);
                    assert_eq!(f64::from(first_row(y)), exact, "{y}");
                }
                (below, above) = (below.next_down(), above.next_up());
            }
        }
        assert_eq!(first_row(-1e30), 0);
        assert_eq!(first_row(0.5f32.next_down()), 0);
    }

    #[test]
    fn a_narrow_span_covers_the_columns_of_a_wide_one() {
        let xs = [-1e9, -0.5, 0.0, 0.5, 3.49, 3.5, 17.2, 31.4, 31.5, 32.0, 1e9];
        for a in xs {
            for b in xs {
                let (mut narrow, mut wide) = (RowSpan::empty(true), RowSpan::empty(false));
                for x in [a, b] {
                    narrow.widen::<true>(x);
                    wide.widen::<false>(x);
                }
                let mut row = [0; MAX_WORDS];
                wide.fill(&mut row, WORD);
                let found = narrow.bits();
                assert_eq!([found, 0, 0, 0], row, "{a} {b}");
                let is_on = |column: u32| {
                    let middle = f64::from(column) + 0.5;
                    f64::from(a.min(b)) < middle && middle <= f64::from(a.max(b))
                };
                let expected = (0..32).filter(|&column| is_on(column));
                assert_eq!(
                    found,
                    expected.fold(0, |bits, column| bits | 1 << column),
                    "{a} {b}"
                );
            }
        }
        assert_eq!(RowSpan::empty(true).bits(), 0);
    }

    #[test]
    fn a_wide_span_covers_the_columns_whose_middles_are_inside() {
        let xs = [
            -1e9, 0.0, 0.5, 31.4, 31.5, 31.6, 63.5, 64.0, 70.2, 127.4, 127.5, 1e9,
        ];
        for columns in [2 * WORD, 4 * WORD] {
            for a in xs {
                for b in xs {
                    let mut span = RowSpan::empty(false);
                    span.widen::<false>(a);
                    span.widen::<false>(b);
                    let mut row = [0; MAX_WORDS];
                    row[0] = 1;
                    span.fill(&mut row, columns);
                    for column in 1..WINDOW_COLUMNS {
                        let middle = column as f32 + 0.5;
                        let is_on = a.min(b) < middle && middle <= a.max(b) && column < columns;
                        let found = row[column / WORD] >> (column % WORD) & 1 == 1;
                        assert_eq!(found, is_on, "{a} {b} {column}");
                    }
                }
            }
        }
        let mut row = [0; MAX_WORDS];
        RowSpan::empty(false).fill(&mut row, WINDOW_COLUMNS);
        assert_eq!(row, [0; MAX_WORDS]);
    }
}

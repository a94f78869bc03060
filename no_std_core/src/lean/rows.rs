//! A window of bit rows for one number at a time: what `raster/rows.rs` does for sixteen.

use super::Posed;
use super::body::{PosedHull, SeenHull, Sight};
use crate::budget::{MAX_COLUMNS, MAX_ROWS, WINDOW_COLUMNS};
use crate::camera::Camera;
use crate::raster::framing::Moments;
use crate::raster::place::{Placement, as_pixels, row_columns};
use crate::raster::{DrawError, Extent, Fill, Hulls, Pixels, Rasterizer};
use crate::silhouette::{Silhouette, Size};
use core::ops::Range;

/// Columns of a word.
const WORD: usize = 32;
const MAX_WORDS: usize = WINDOW_COLUMNS / WORD;
/// Where a row is sampled, and each of its pixels.
const MIDDLE: f32 = 0.5;

/// Bit rows: one sample at the pixel's centre, exactly; no heap. 1,536 bytes.
#[derive(Clone, Debug)]
pub struct Rows {
    size: Size,
    /// Words of a row in use.
    words: usize,
    /// The samples by row, by word. Bit `c` is column `c` of the word.
    bits: [[u32; MAX_WORDS]; MAX_ROWS],
    /// Between which columns the hull at hand covers each row.
    spans: [Span; MAX_ROWS],
}

/// What lies between two columns, pixels.
#[derive(Clone, Copy, Debug)]
struct Span {
    left: f32,
    right: f32,
}

impl Span {
    const EMPTY: Self = Self {
        left: f32::INFINITY,
        right: f32::NEG_INFINITY,
    };
}

impl Fill<Posed<'_>> for Rows {
    fn extent(&mut self, posed: &Posed<'_>, camera: &Camera) -> Result<Extent, DrawError> {
        posed.extent(camera)
    }

    fn draw(
        &mut self,
        posed: &Posed<'_>,
        (camera, _): (&Camera, usize),
        placement: &Placement,
        columns: usize,
    ) {
        self.words = columns.div_ceil(WORD).min(MAX_WORDS);
        self.empty();
        let mut seen = SeenHull::new(&Sight::new(posed, camera));
        for hull in posed.hull_parts() {
            let rows = self.cross(&mut seen, &hull, placement);
            if self.words == 1 {
                self.fill::<1>(rows);
            } else {
                self.fill::<MAX_WORDS>(rows);
            }
        }
    }
}

impl Pixels for Rows {
    type Image = Silhouette;

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
        self.words = MAX_WORDS;
        self.empty();
    }

    fn moments(&self) -> Moments {
        let (mut area, mut doubled) = (0, 0);
        for row in self.bits.iter().take(self.size.rows()) {
            for (word, &bits) in (0..).zip(row.iter().take(self.words)) {
                let mut bits = bits;
                while bits != 0 {
                    let from = bits.trailing_zeros();
                    let run = (bits >> from).trailing_ones();
                    area += run;
                    // The sum of 2 c + 1 over the run's columns.
                    doubled += run * (2 * (32 * word + from) + run);
                    // A carry runs through the run and ends behind it.
                    bits &= bits.wrapping_add(1 << from);
                }
            }
        }
        Moments {
            area: u64::from(area),
            doubled: u64::from(doubled),
        }
    }

    fn cut(&self, left: isize, silhouette: &mut Silhouette) -> u64 {
        let mask = u64::MAX >> (MAX_COLUMNS - self.size.columns());
        let rows = silhouette.all_rows_mut();
        rows.fill(0);
        for word in 0..self.words {
            // By how many columns the word is moved to the right, or to the left.
            let shift = (WORD * word).cast_signed() - left;
            let by = u32::try_from(shift.unsigned_abs()).unwrap_or(u32::MAX);
            let rows = rows.iter_mut().zip(&self.bits).take(self.size.rows());
            let moves = rows.map(|(out, row)| (out, row.get(word).copied().unwrap_or_default()));
            // Otherwise nothing of it is left.
            if shift < 0 && by < u32::BITS {
                moves.for_each(|(out, bits)| *out |= u64::from(bits >> by) & mask);
            } else if shift >= 0 && by < u64::BITS {
                moves.for_each(|(out, bits)| *out |= u64::from(bits) << by & mask);
            }
        }
        let area: u32 = silhouette.rows().iter().map(|&row| ones(row)).sum();
        u64::from(area)
    }
}

impl Rows {
    /// An empty window.
    #[must_use]
    pub const fn new(size: Size) -> Self {
        Self {
            size,
            words: 0,
            bits: [[0; MAX_WORDS]; MAX_ROWS],
            spans: [Span::EMPTY; MAX_ROWS],
        }
    }

    /// Empties the words in use, which alone are read.
    fn empty(&mut self) {
        let rows = self.bits.iter_mut().take(self.size.rows());
        if self.words == 1 {
            rows.for_each(|row| row[0] = 0);
        } else {
            rows.for_each(|row| *row = [0; MAX_WORDS]);
        }
    }

    /// Widens the spans of the rows that the lines of a hull's outline cross, which are among
    /// those that are returned.
    fn cross(
        &mut self,
        seen: &mut SeenHull<'_>,
        hull: &PosedHull<'_>,
        placement: &Placement,
    ) -> Range<usize> {
        let most = u32::try_from(self.size.rows()).unwrap_or(0);
        let row = |y| first_row(y).min(most);
        let (spans, mut start, mut end) = (&mut self.spans, most, 0);
        seen.trace(hull, placement, row, |a, b| {
            // Most lines of a small hull cross no row.
            if a.row == b.row {
                return;
            }
            let (from, to) = (a.row.min(b.row), a.row.max(b.row));
            (start, end) = (from.min(start), to.max(end));
            let slope = (b.pixel.x - a.pixel.x) / (b.pixel.y - a.pixel.y);
            let mut y = as_pixels(from as usize) + MIDDLE;
            for span in spans
                .get_mut(from as usize..to as usize)
                .unwrap_or_default()
            {
                let x = a.pixel.x + slope * (y - a.pixel.y);
                if x < span.left {
                    span.left = x;
                }
                if x > span.right {
                    span.right = x;
                }
                // Exact, as halves are.
                y += 1.0;
            }
        });
        start.min(end) as usize..end as usize
    }

    /// Fills the spans of these rows, in the first of so many words.
    fn fill<const WORDS: usize>(&mut self, rows: Range<usize>) {
        let width = WORD * self.words;
        let spans = self.spans.get_mut(rows.clone()).unwrap_or_default();
        let bits = self.bits.get_mut(rows).unwrap_or_default();
        for (span, row) in spans.iter_mut().zip(bits) {
            let Span { left, right } = core::mem::replace(span, Span::EMPTY);
            let from = first_column(left, width);
            let to = first_column(right, width).max(from);
            for (word, bits) in row.iter_mut().enumerate().take(WORDS) {
                let [from, to] = [from, to].map(|column| column.saturating_sub(WORD * word));
                *bits |= bits_below(to) & !bits_below(from);
            }
        }
    }
}

/// The first row that is sampled below `y`.
fn first_row(y: f32) -> u32 {
    // Exact from 0.5 on.
    let rows = y - MIDDLE;
    if rows < 0.0 {
        return 0;
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "saturates, and the fraction is meant to go"
    )]
    let rows = rows as i32;
    rows.cast_unsigned() + 1
}

/// How many bits are on; mostly there are none in the upper half.
fn ones(row: u64) -> u32 {
    #[expect(clippy::cast_possible_truncation, reason = "half by half")]
    let [low, high] = [row as u32, (row >> 32) as u32];
    let above = if high == 0 { 0 } else { high.count_ones() };
    low.count_ones() + above
}

/// The first column whose sample is right of an edge at `x`, which may be beyond the window's
/// sides.
fn first_column(x: f32, width: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and the fraction is meant to go"
    )]
    let column = (x + MIDDLE) as usize;
    column.min(width)
}

/// So many of a word's lowest bits.
fn bits_below(column: usize) -> u32 {
    let column = u32::try_from(column).unwrap_or(u32::MAX);
    1u32.checked_shl(column).map_or(u32::MAX, |bit| bit - 1)
}

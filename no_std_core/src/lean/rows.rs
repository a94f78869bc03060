//! A window of bit rows for one number at a time: what `raster/rows.rs` does for sixteen.

use super::Posed;
use super::body::{PosedHull, SeenHull, Sight};
use crate::budget::{MAX_ROWS, WINDOW_COLUMNS};
use crate::camera::Camera;
use crate::raster::framing::Moments;
use crate::raster::place::{Placement, as_pixels, places, row_columns};
use crate::raster::{DrawError, Extent, Fill, Hulls, Pixels, Rasterizer};
use crate::silhouette::{Ninths, Silhouette, Size};
use core::ops::Range;

/// Columns of a word.
const WORD: usize = 32;
const MAX_WORDS: usize = WINDOW_COLUMNS / WORD;
/// The samples of one place in their pixels by row, by word. Bit `c` is column `c` of the word.
type Bits = [[u32; MAX_WORDS]; MAX_ROWS];

/// Bit rows of `N` by `N` samples a pixel, 1 or 3; no heap. 1,552 bytes, or 10,768.
#[derive(Clone, Debug)]
pub struct Rows<const N: usize = 1> {
    size: Size,
    /// Words of a row in use.
    words: usize,
    /// By place in the pixel, to the right and then down.
    bits: [[Bits; N]; N],
    /// Between which columns the hull at hand covers each row of samples.
    spans: [[Span; N]; MAX_ROWS],
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

impl<const N: usize> Fill<Posed<'_>> for Rows<N>
where
    Self: Pixels,
{
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

/// What is drawn, of which samples.
pub trait Sampled {
    type Image;
    const RASTERIZER: Rasterizer;

    fn blank(&self) -> Self::Image;
    fn cut_image(&self, left: isize, image: &mut Self::Image) -> u64;
}

impl Sampled for Rows {
    type Image = Silhouette;
    const RASTERIZER: Rasterizer = Rasterizer::Rows;

    fn blank(&self) -> Silhouette {
        Silhouette::empty(self.size)
    }

    fn cut_image(&self, left: isize, silhouette: &mut Silhouette) -> u64 {
        self.cut_samples(&self.bits[0][0], left, silhouette)
    }
}

impl Sampled for Rows<3> {
    type Image = Ninths;
    const RASTERIZER: Rasterizer = Rasterizer::Rows3x3;

    fn blank(&self) -> Ninths {
        Ninths::of(&[Silhouette::empty(self.size); 9])
    }

    fn cut_image(&self, left: isize, ninths: &mut Ninths) -> u64 {
        let mut images = [Silhouette::empty(self.size); 9];
        for (image, bits) in images.iter_mut().zip(self.bits.as_flattened()) {
            self.cut_samples(bits, left, image);
        }
        *ninths = Ninths::of(&images);
        3 * u64::from(ninths.samples())
    }
}

impl<const N: usize> Pixels for Rows<N>
where
    Self: Sampled,
{
    type Image = <Self as Sampled>::Image;
    const IS_GREY: bool = N > 1;

    fn blank(&self) -> Self::Image {
        Sampled::blank(self)
    }

    fn rasterizer(&self) -> Rasterizer {
        Self::RASTERIZER
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

    /// A sample counts `N`, so that places in a pixel do.
    fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        for (across, images) in self.bits.iter().enumerate() {
            for bits in images {
                let (area, doubled) = self.moments_of(bits);
                // N times twice the centre of a pixel's N-th is 2 N c + 2 across + 1.
                moments.area += N as u64 * area;
                moments.doubled += N as u64 * (doubled - area) + (2 * across + 1) as u64 * area;
            }
        }
        moments
    }

    fn cut(&self, left: isize, image: &mut Self::Image) -> u64 {
        self.cut_image(left, image)
    }
}

impl Rows {
    /// An empty window of one sample a pixel, at its centre.
    #[must_use]
    pub const fn new(size: Size) -> Self {
        Self::empty_of(size)
    }
}

impl Rows<3> {
    /// An empty window of three by three samples a pixel, a third of a pixel apart.
    #[must_use]
    pub const fn three_by_three(size: Size) -> Self {
        Self::empty_of(size)
    }
}

impl<const N: usize> Rows<N> {
    const fn empty_of(size: Size) -> Self {
        Self {
            size,
            words: 0,
            bits: [[[[0; MAX_WORDS]; MAX_ROWS]; N]; N],
            spans: [[Span::EMPTY; N]; MAX_ROWS],
        }
    }

    /// Empties the words in use, which alone are read.
    fn empty(&mut self) {
        for bits in self.bits.as_flattened_mut() {
            let rows = bits.iter_mut().take(self.size.rows());
            if self.words == 1 {
                rows.for_each(|row| row[0] = 0);
            } else {
                rows.for_each(|row| *row = [0; MAX_WORDS]);
            }
        }
    }

    /// How many samples are on, and the sum of 2 c + 1 over their columns.
    fn moments_of(&self, bits: &Bits) -> (u64, u64) {
        let (mut area, mut doubled) = (0, 0);
        for row in bits.iter().take(self.size.rows()) {
            for (word, &bits) in (0..).zip(row.iter().take(self.words)) {
                let mut bits = bits;
                while bits != 0 {
                    let from = bits.trailing_zeros();
                    let run = (bits >> from).trailing_ones();
                    area += run;
                    doubled += run * (2 * (32 * word + from) + run);
                    // A carry runs through the run and ends behind it.
                    bits &= bits.wrapping_add(1 << from);
                }
            }
        }
        (u64::from(area), u64::from(doubled))
    }

    /// The columns from `left` on; how many of them are on.
    fn cut_samples(&self, bits: &Bits, left: isize, silhouette: &mut Silhouette) -> u64 {
        *silhouette = Silhouette::empty(self.size);
        for word in 0..self.words {
            let first = (WORD * word).cast_signed() - left;
            let bits = bits.iter().map(|row| row.get(word).copied().unwrap_or(0));
            silhouette.add_columns(bits, first);
        }
        let area: u32 = silhouette.rows().iter().map(|&row| ones(row)).sum();
        u64::from(area)
    }

    /// Widens the spans of the rows of samples that the lines of a hull's outline cross, which
    /// are among those that are returned.
    fn cross(
        &mut self,
        seen: &mut SeenHull<'_>,
        hull: &PosedHull<'_>,
        placement: &Placement,
    ) -> Range<usize> {
        let most = u32::try_from(N * self.size.rows()).unwrap_or(0);
        let row = |y| first_row::<N>(y).min(most);
        let (spans, mut start, mut end) = (self.spans.as_flattened_mut(), most, 0);
        seen.trace(hull, placement, row, |a, b| {
            // Most lines of a small hull cross no row.
            if a.row == b.row {
                return;
            }
            let (from, to) = (a.row.min(b.row), a.row.max(b.row));
            (start, end) = (from.min(start), to.max(end));
            let slope = (b.pixel.x - a.pixel.x) / (b.pixel.y - a.pixel.y);
            let range = from as usize..to as usize;
            let mut next = as_pixels(from as usize) + 0.5;
            let crossed = spans.get_mut(range.clone()).unwrap_or_default();
            for (row, span) in range.zip(crossed) {
                let y = if N == 1 { next } else { sample::<N>(row) };
                // Exact, as halves are.
                next += 1.0;
                let x = a.pixel.x + slope * (y - a.pixel.y);
                if x < span.left {
                    span.left = x;
                }
                if x > span.right {
                    span.right = x;
                }
            }
        });
        start.min(end) as usize..end as usize
    }

    /// Fills the spans of these rows of samples, in the first of so many words.
    fn fill<const WORDS: usize>(&mut self, rows: Range<usize>) {
        let width = WORD * self.words;
        let spans = self.spans.as_flattened_mut().get_mut(rows.clone());
        for (number, span) in rows.zip(spans.unwrap_or_default()) {
            let Span { left, right } = core::mem::replace(span, Span::EMPTY);
            for (images, place) in self.bits.iter_mut().zip(const { places::<N>() }) {
                let row = &mut images[number % N][number / N % MAX_ROWS];
                let from = first_column(left, place, width);
                let to = first_column(right, place, width).max(from);
                for (word, bits) in row.iter_mut().enumerate().take(WORDS) {
                    let [from, to] = [from, to].map(|column| column.saturating_sub(WORD * word));
                    *bits |= bits_below(to) & !bits_below(from);
                }
            }
        }
    }
}

/// The first row of samples that lies below `y`, `N` a pixel.
fn first_row<const N: usize>(y: f32) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and the fraction is meant to go"
    )]
    let whole = |rows: f32| rows as usize;
    let row = if N == 1 {
        // Exact from 0.5 on.
        if y < 0.5 { 0 } else { whole(y - 0.5) + 1 }
    } else {
        let first = N * whole(y).min(MAX_ROWS);
        let passed = (first..first + N).filter(|&row| sample::<N>(row) <= y);
        first + passed.count()
    };
    u32::try_from(row).unwrap_or(u32::MAX)
}

/// Where a row of samples lies, pixels.
fn sample<const N: usize>(row: usize) -> f32 {
    as_pixels(row / N) + const { places::<N>() }[row % N]
}

/// How many bits are on; mostly there are none in the upper half.
fn ones(row: u64) -> u32 {
    #[expect(clippy::cast_possible_truncation, reason = "half by half")]
    let [low, high] = [row as u32, (row >> 32) as u32];
    let above = if high == 0 { 0 } else { high.count_ones() };
    low.count_ones() + above
}

/// The first column whose sample at this place is right of an edge at `x`, which may be beyond the
/// window's sides.
fn first_column(x: f32, place: f32, width: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and the fraction is meant to go"
    )]
    let column = (x + (1.0 - place)) as usize;
    column.min(width)
}

/// So many of a word's lowest bits.
fn bits_below(column: usize) -> u32 {
    let column = u32::try_from(column).unwrap_or(u32::MAX);
    1u32.checked_shl(column).map_or(u32::MAX, |bit| bit - 1)
}

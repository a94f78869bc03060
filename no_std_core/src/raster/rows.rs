//! The bit-row rasteriser: an integer a row, exact samples, no heap, no 2-D hull.
//!
//! The outline of a hull is the projection of the edges between its facets that are seen and
//! those that are not. Each row of samples is crossed by two of them or by none, and the
//! samples between are on. Sixteen rows are filled at once, whatever the height of a hull, so
//! that little depends on branches which a processor could only guess.
//!
//! A sample is on where `left < x <= right` and `top < y <= bottom`: tiny-skia's rule for
//! samples that lie on an edge. Coordinates are f32 pixels, not rounded further.

use super::framing::Moments;
use super::place::Placement;
use super::seen::{Seen, dot, splat};
use super::simd::{Edges, LANES, Lanes, Lines, Simd, compiled, dispatch};
use crate::body::FigureHull;
use crate::body::plane::Planes;
use crate::budget::{MAX_COLUMNS, MAX_HULL_POINTS, MAX_POINTS, MAX_ROWS, WINDOW_COLUMNS};
use crate::silhouette::{Frame, Ninths, Silhouette, Size};
use glam::Vec3;

/// Points of a figure, and behind them what is read together with a hull's last one.
const POINTS: usize = MAX_POINTS + MAX_HULL_POINTS;
/// Rows of a window, and below them what is filled together with its last one.
const HEIGHT: usize = MAX_ROWS + LANES;
/// Columns of a word.
const WORD: usize = 32;
const MAX_WORDS: usize = WINDOW_COLUMNS / WORD;
/// Samples of one pixel, at most.
const MAX_SAMPLES: usize = 9;
/// Rows that are never parted: what was written in halves of sixteen is read so, too, since
/// processors wait for what they have to put together from two writes.
const HALF: usize = LANES / 2;

/// One sample in the middle of each pixel, or three by three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sampling {
    Once,
    ThreeByThree,
}

impl Sampling {
    /// Where the samples of a pixel lie along an axis.
    const fn places(self) -> &'static [f32] {
        match self {
            Self::Once => &[0.5],
            Self::ThreeByThree => &[1.0 / 6.0, 0.5, 5.0 / 6.0],
        }
    }
}

/// A window of bits to draw into. 20 kB.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    simd: Simd,
    sampling: Sampling,
    size: Size,
    /// Words of a row in use.
    words: usize,
    /// The figure's points in pixels.
    columns: [f32; POINTS],
    rows: [f32; POINTS],
    /// The outlines of its hulls.
    lines: Lines,
    /// The samples by their place in the pixel (all of the leftmost places first), by word, by
    /// row. Bit `c` is column `c` of the word.
    bits: [[[u32; HEIGHT]; MAX_WORDS]; MAX_SAMPLES],
}

impl Window {
    pub fn new(size: Size, sampling: Sampling, simd: Simd) -> Self {
        Self {
            simd,
            sampling,
            size,
            words: 0,
            columns: [0.0; POINTS],
            rows: [0.0; POINTS],
            lines: Lines::EMPTY,
            bits: [[[0; HEIGHT]; MAX_WORDS]; MAX_SAMPLES],
        }
    }

    /// Draws a figure into the leftmost `columns` of the window, and nothing else.
    pub fn draw(&mut self, seen: &Seen<'_>, placement: &Placement, columns: usize) {
        self.words = columns.div_ceil(WORD).min(MAX_WORDS);
        dispatch!(self.simd, fill(self, seen, placement));
    }

    /// Empties the window.
    pub fn clear(&mut self) {
        self.words = MAX_WORDS;
        self.empty();
    }

    fn empty(&mut self) {
        let words = self.words;
        let samples = self.sampling.places().len().pow(2);
        for words in self
            .bits
            .iter_mut()
            .take(samples)
            .map(|image| image.iter_mut().take(words))
        {
            for rows in words {
                *rows = [0; HEIGHT];
            }
        }
    }

    /// Area and first moment of what was drawn.
    pub fn moments(&self) -> Moments {
        dispatch!(self.simd, moments(self))
    }

    /// Makes a frame of the columns from `left` on; their area in the unit of
    /// [`Self::moments`].
    pub fn cut(&self, left: isize, frame: &mut Frame) -> u64 {
        dispatch!(self.simd, cut(self, left, frame))
    }
}

compiled!(fn fill(window: &mut Window, seen: &Seen<'_>, placement: &Placement));
compiled!(fn moments(window: &Window) -> Moments);
compiled!(fn cut(window: &Window, left: isize, frame: &mut Frame) -> u64);

/// Places the projected points, and fills hull by hull.
#[inline(always)]
fn fill<L: Lanes>(l: L, window: &mut Window, seen: &Seen<'_>, placement: &Placement) {
    let (figure, camera) = (seen.figure, seen.camera);
    window.empty();
    place(l, window, seen, placement);
    // A facet is seen if the eye is on its outer side; infinitely far away only the direction
    // counts.
    let (seen_from, is_near) = match camera.eye() {
        Some((aim, distance_m)) => (aim + camera.viewpoint().toward() * distance_m, true),
        None => (camera.viewpoint().toward(), false),
    };
    for hull in figure.hull_parts() {
        let outline = outline(l, &hull, (seen_from, is_near));
        let start = hull.points.start;
        let (Some(x), Some(y)) = (
            window.columns.get(start..).and_then(<[f32]>::first_chunk),
            window.rows.get(start..).and_then(<[f32]>::first_chunk),
        ) else {
            return;
        };
        let edges = Edges {
            x,
            y,
            from: hull.from,
            to: hull.to,
            outline,
        };
        let (count, top, bottom) = l.lines(edges, &mut window.lines);
        if count > 0 {
            fill_hull(l, window, count, (top, bottom));
        }
    }
}

/// [`Placement::place`] of all points.
#[inline(always)]
fn place<L: Lanes>(l: L, window: &mut Window, seen: &Seen<'_>, placement: &Placement) {
    let scale = [l.splat(placement.scale.x), l.splat(placement.scale.y)];
    let origin = [l.splat(placement.origin.x), l.splat(placement.origin.y)];
    let at = [l.splat(placement.at.x), l.splat(placement.at.y)];
    let (xs, _) = seen.points.x.as_chunks::<LANES>();
    let (ys, _) = seen.points.y.as_chunks::<LANES>();
    let (columns, _) = window.columns.as_chunks_mut::<LANES>();
    let (rows, _) = window.rows.as_chunks_mut::<LANES>();
    let places = xs.iter().zip(ys).zip(columns).zip(rows);
    for (((x, y), column), row) in places.take(seen.figure.len().div_ceil(LANES)) {
        let x = l.mul(l.sub(l.load(x), origin[0]), scale[0]);
        l.store(l.add(x, at[0]), column);
        let y = l.mul(l.sub(origin[1], l.load(y)), scale[1]);
        l.store(l.add(y, at[1]), row);
    }
}

/// The edges between facets that are seen and facets that are not: each facet that is seen
/// toggles its three, and what two of them toggled is off again.
#[inline(always)]
fn outline<L: Lanes>(l: L, hull: &FigureHull<'_>, (seen_from, is_near): (Vec3, bool)) -> [u64; 2] {
    let Planes {
        place,
        x,
        y,
        z,
        offsets,
        ..
    } = hull.planes;
    let seen_from = if is_near {
        place.point(seen_from)
    } else {
        place.direction(seen_from)
    };
    let seen_from = splat(l, seen_from);
    let (low, high) = (hull.sides[0].as_chunks().0, hull.sides[1].as_chunks().0);
    let has_high = hull.from.len() > 64;
    let mut parities = [l.no_parity(); 2];
    let normals = x.as_chunks().0.iter().zip(y.as_chunks().0);
    let normals = normals.zip(z.as_chunks().0).zip(offsets.as_chunks().0);
    for ((((x, y), z), offset), (low, high)) in normals.zip(low.iter().zip(high)) {
        let facing = dot(l, seen_from, [l.load(x), l.load(y), l.load(z)]);
        let threshold = if is_near {
            l.load(offset)
        } else {
            l.splat(0.0)
        };
        let is_seen = l.less(threshold, facing);
        parities[0] = l.toggle(parities[0], is_seen, low);
        if has_high {
            parities[1] = l.toggle(parities[1], is_seen, high);
        }
    }
    let [border_low, border_high] = hull.border;
    let high = if has_high { l.parity(parities[1]) } else { 0 };
    [l.parity(parities[0]) ^ border_low, high ^ border_high]
}

/// Fills the rows between two edges of the lines at hand.
#[inline(always)]
fn fill_hull<L: Lanes>(l: L, window: &mut Window, count: usize, (top, bottom): (f32, f32)) {
    let end = row_below(bottom, window.size.rows());
    let start = row_below(top, window.size.rows()).saturating_sub(1) / HALF * HALF;
    for row in (start..end).step_by(LANES) {
        match window.sampling {
            Sampling::Once => fill_rows::<L, 1>(l, window, count, row),
            Sampling::ThreeByThree => fill_rows::<L, 3>(l, window, count, row),
        }
    }
}

/// The first row that begins below `y`, within `0..=limit`.
fn row_below(y: f32, limit: usize) -> usize {
    // A NaN becomes 0.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 64, and the fraction is meant to go"
    )]
    let row = (y.max(0.0).min(MAX_ROWS as f32) as usize + 1).min(limit);
    row
}

/// Fills sixteen rows from `row` on with `N` by `N` samples a pixel.
#[inline(always)]
fn fill_rows<L: Lanes, const N: usize>(l: L, window: &mut Window, count: usize, row: usize) {
    const LANE: [f32; LANES] = [
        0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
    ];
    #[expect(clippy::cast_precision_loss, reason = "at most 128")]
    let (first, width) = (l.splat(row as f32), l.splat((WORD * window.words) as f32));
    let zero = l.splat(0.0);
    let places = window.sampling.places();
    for (down, &place) in places.iter().enumerate().take(N) {
        let y = l.add(l.add(first, l.load(&LANE)), l.splat(place));
        let (mut left, mut right) = (width, zero);
        for line in window.lines.iter().take(count) {
            let crosses = l.within(l.splat(line.top), y, l.splat(line.bottom));
            let along = l.mul(l.splat(line.slope), l.sub(y, l.splat(line.y)));
            let x = l.add(l.splat(line.x), along);
            (left, right) = l.widen((left, right), x, crosses);
        }
        // They began at the window's sides: one may be beyond its own only.
        left = l.max(left, zero);
        right = l.min(right, width);
        for (across, &place) in places.iter().enumerate().take(N) {
            // The first column whose sample is right of an edge.
            let past = l.splat(1.0 - place);
            let from = l.truncate(l.add(left, past));
            let to = l.max_words(from, l.truncate(l.add(right, past)));
            let Some(image) = window.bits.get_mut(across * N + down) else {
                return;
            };
            for (word, rows) in image.iter_mut().take(window.words).enumerate() {
                if let Some(rows) = rows.get_mut(row..).and_then(<[u32]>::first_chunk_mut) {
                    l.merge(span(l, from, to, word), rows);
                }
            }
        }
    }
}

/// The bits of one word from column `from` on and before column `to`.
#[inline(always)]
fn span<L: Lanes>(l: L, from: L::Words, to: L::Words, word: usize) -> L::Words {
    #[expect(clippy::cast_possible_truncation, reason = "at most 128")]
    let start = l.splat_word((WORD * word) as u32);
    let (mut from, mut to) = (from, to);
    if word > 0 {
        let none = l.splat_word(0);
        from = l.max_words(l.sub_words(from, start), none);
        to = l.max_words(l.sub_words(to, start), none);
    }
    // From 32 on there is no bit.
    l.sub_words(l.power_of_two(to), l.power_of_two(from))
}

/// Sums over the images in whole numbers: a sample counts `N`, so that places in a pixel do.
#[inline(always)]
fn moments<L: Lanes>(l: L, window: &Window) -> Moments {
    let n = window.sampling.places().len();
    // What was filled below the last row, together with it, does not count.
    let height = window.size.rows();
    let kept = core::array::from_fn(|row| if row < height { u32::MAX } else { 0 });
    let mut moments = Moments::default();
    for (image, words) in window.bits.iter().take(n * n).enumerate() {
        for (word, rows) in words.iter().take(window.words).enumerate() {
            let (area, columns) = word_moments(l, rows, &kept);
            // Three times twice the centre of a pixel's third is 6 columns + 1, 3 or 5.
            let first = (2 * n * WORD * word + 2 * (image / n) + 1) as u64;
            moments.area += n as u64 * u64::from(area);
            moments.doubled += (2 * n) as u64 * u64::from(columns) + first * u64::from(area);
        }
    }
    moments
}

/// How many bits of a word that are `kept` are on, and the sum of their columns.
#[inline(always)]
fn word_moments<L: Lanes>(l: L, rows: &[u32; HEIGHT], kept: &[u32; MAX_ROWS]) -> (u32, u32) {
    /// Columns whose number has bit 0, 1, 2, 3 or 4.
    const COLUMNS: [u32; 5] = [
        0xaaaa_aaaa,
        0xcccc_cccc,
        0xf0f0_f0f0,
        0xff00_ff00,
        0xffff_0000,
    ];
    let mut area = l.splat_word(0);
    let mut counts = [area; COLUMNS.len()];
    let (rows, _) = rows.as_chunks::<LANES>();
    let (kept, _) = kept.as_chunks::<LANES>();
    for (rows, kept) in rows.iter().zip(kept) {
        let rows = l.and_words(l.load_words(rows), l.load_words(kept));
        area = l.add_words(area, l.count_ones(rows));
        for (count, columns) in counts.iter_mut().zip(COLUMNS) {
            let some = l.and_words(rows, l.splat_word(columns));
            *count = l.add_words(*count, l.count_ones(some));
        }
    }
    let mut columns = 0;
    for (bit, count) in counts.into_iter().enumerate() {
        columns += l.sum(count) << bit;
    }
    (l.sum(area), columns)
}

/// An image's columns from `left` on, without a copy of what is not used of a frame.
#[inline(always)]
fn cut<L: Lanes>(_: L, window: &Window, left: isize, frame: &mut Frame) -> u64 {
    match window.sampling {
        Sampling::Once => {
            if !matches!(frame, Frame::Binary(_)) {
                *frame = Frame::Binary(Silhouette::empty(window.size));
            }
            if let Frame::Binary(silhouette) = frame {
                cut_image(window, 0, left, silhouette);
                return u64::from(silhouette.area());
            }
            0
        }
        Sampling::ThreeByThree => {
            let mut images = [Silhouette::empty(window.size); MAX_SAMPLES];
            let mut area = 0;
            for (image, silhouette) in images.iter_mut().enumerate() {
                cut_image(window, image, left, silhouette);
                area += 3 * u64::from(silhouette.area());
            }
            *frame = Frame::Ninths(Ninths::of(&images));
            area
        }
    }
}

/// One image's columns from `left` on.
#[inline(always)]
fn cut_image(window: &Window, image: usize, left: isize, silhouette: &mut Silhouette) {
    let mask = u64::MAX >> (MAX_COLUMNS - window.size.columns());
    let rows = silhouette.all_rows_mut();
    rows.fill(0);
    let Some(image) = window.bits.get(image) else {
        return;
    };
    for (word, bits) in image.iter().take(window.words).enumerate() {
        // By how many columns the word is moved to the right.
        let shift = (WORD * word).cast_signed() - left;
        for (row, &bits) in rows.iter_mut().zip(bits).take(window.size.rows()) {
            *row |= moved(u64::from(bits), shift) & mask;
        }
    }
}

/// Bits moved to higher columns, or to lower ones by a negative shift.
#[inline(always)]
fn moved(bits: u64, shift: isize) -> u64 {
    let by = u32::try_from(shift.unsigned_abs()).unwrap_or(u32::MAX);
    if shift < 0 {
        bits.checked_shr(by).unwrap_or(0)
    } else {
        bits.checked_shl(by).unwrap_or(0)
    }
}

//! The bit-row rasteriser: an integer a row, exact samples, no heap, no 2-D hull.
//!
//! The outline of a hull is the projection of the edges between its facets that are seen and
//! those that are not. Each row of samples is crossed by two of them or by none, and the
//! samples between are on. What can be done without a branch is done for all hulls first: which
//! facets are seen, sixteen at once, and lines along the outline, sixteen at once. Then rows are
//! filled, eight at once, by the lines that cross one of them.
//!
//! A sample is on where `left < x <= right` and `top < y <= bottom`: tiny-skia's rule for
//! samples that lie on an edge. Coordinates are f32 pixels, not rounded further.

use super::framing::Moments;
use super::place::{Placement, as_pixels};
use super::seen::{Seen, dot, splat};
use super::simd::{Ends, LANES, Lanes, Simd, Wide, compiled, dispatch};
use crate::body::plane::{ALWAYS, Facets16};
use crate::body::{Figure, Places};
use crate::budget::{
    MAX_COLUMNS, MAX_HULL_EDGES, MAX_HULL_POINTS, MAX_HULLS, MAX_ROWS, VIEWS_AT_ONCE,
    WINDOW_COLUMNS,
};
use crate::camera::Camera;
use crate::silhouette::{Frame, Ninths, Silhouette, Size};

/// Columns of a word.
const WORD: usize = 32;
const MAX_WORDS: usize = WINDOW_COLUMNS / WORD;
/// Samples of one pixel, at most.
const MAX_SAMPLES: usize = 9;
/// Rows that are filled at once.
const BLOCK: usize = LANES / 2;
const BLOCKS: usize = MAX_ROWS / BLOCK;
/// Strips of one hull, at most, and of all that wait to be filled.
const MOST_STRIPS: usize = MAX_HULL_EDGES.div_ceil(LANES);
const MAX_STRIPS: usize = MAX_HULLS + MOST_STRIPS;
/// More than what rounding adds to a row's number, and far less than a row.
const SLACK: f32 = 2e-5;

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

/// Up to sixteen lines of one hull's outline: `x + slope * (row - y)` for rows in
/// `top..=bottom`, the top left out.
#[derive(Clone, Debug)]
struct Strip {
    x: [f32; LANES],
    y: [f32; LANES],
    slope: [f32; LANES],
    top: [f32; LANES],
    bottom: [f32; LANES],
    /// The lines that cross each block of rows, a byte a block: the first eight and the others.
    /// One may be among them that crosses no sample, by [`SLACK`].
    crossing: [u64; 2],
    /// How many lines there are.
    len: usize,
    /// Whether the next strip is another hull's.
    is_last: bool,
}

impl Strip {
    const EMPTY: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        slope: [0.0; LANES],
        top: [0.0; LANES],
        bottom: [0.0; LANES],
        crossing: [0; 2],
        len: 0,
        is_last: true,
    };

    /// The lines that cross a block, a bit each.
    #[inline(always)]
    const fn lines(&self, block: u32) -> u64 {
        let [first, last] = self.crossing;
        (first >> (8 * block) & 0xff) | (last >> (8 * block) & 0xff) << 8
    }
}

/// A window of bits to draw into. 36 kB.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    simd: Simd,
    sampling: Sampling,
    size: Size,
    /// Words of a row in use.
    words: usize,
    /// Which facets of hulls are seen, a bit each, by view.
    facing: [[u64; MAX_HULLS]; VIEWS_AT_ONCE],
    /// The outlines of hulls that are not filled yet: ends of lines in the image, metres, and
    /// the lines.
    ends: [Ends; MAX_STRIPS],
    strips: [Strip; MAX_STRIPS],
    /// The samples by their place in the pixel (all of the leftmost places first), by word, by
    /// row. Bit `c` is column `c` of the word.
    bits: [[[u32; MAX_ROWS]; MAX_WORDS]; MAX_SAMPLES],
}

impl Window {
    pub fn new(size: Size, sampling: Sampling, simd: Simd) -> Self {
        Self {
            simd,
            sampling,
            size,
            words: 0,
            facing: [[0; MAX_HULLS]; VIEWS_AT_ONCE],
            ends: [const { Ends::NONE }; _],
            strips: [const { Strip::EMPTY }; _],
            bits: [[[0; MAX_ROWS]; MAX_WORDS]; MAX_SAMPLES],
        }
    }

    /// Finds which facets of a figure are seen by each of at most [`VIEWS_AT_ONCE`] cameras.
    pub fn look(&mut self, figure: &Figure<'_>, cameras: &[Camera]) {
        dispatch!(self.simd, look(self, figure, cameras));
    }

    /// Draws a figure that was looked at into the leftmost `columns` of the window, and nothing
    /// else.
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
                *rows = [0; MAX_ROWS];
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

compiled!(fn look(window: &mut Window, figure: &Figure<'_>, cameras: &[Camera]));
compiled!(fn fill(window: &mut Window, seen: &Seen<'_>, placement: &Placement));
compiled!(fn moments(window: &Window) -> Moments);
compiled!(fn cut(window: &Window, left: isize, frame: &mut Frame) -> u64);

/// The eyes of cameras in the frames of hulls: where they are, or of such as are infinitely far
/// away their direction.
type Eyes = [[[f32; MAX_HULLS]; 3]; VIEWS_AT_ONCE];

/// Finds which facets are seen: those whose outer side an eye is on; infinitely far away only its
/// direction counts.
#[inline(always)]
fn look<L: Wide>(l: L, window: &mut Window, figure: &Figure<'_>, cameras: &[Camera]) {
    let mut eyes: Eyes = [[[0.0; MAX_HULLS]; 3]; VIEWS_AT_ONCE];
    let cameras = cameras.get(..VIEWS_AT_ONCE).unwrap_or(cameras);
    for (camera, eyes) in cameras.iter().zip(&mut eyes) {
        turn_eye(l, &figure.places, camera, eyes);
    }
    let zero = l.splat(0.0);
    for (number, hull) in figure.hull_parts().enumerate() {
        let number = number % MAX_HULLS;
        for facing in window.facing.iter_mut().take(cameras.len()) {
            facing[number] = ALWAYS;
        }
        for (chunk, facets) in hull.facets.iter().enumerate() {
            let Facets16 {
                x, y, z, offsets, ..
            } = facets;
            let normals = [l.load(x), l.load(y), l.load(z)];
            let offsets = l.load(offsets);
            let views = cameras.iter().zip(&eyes).zip(&mut window.facing);
            for ((camera, [x, y, z]), facing) in views {
                let eye = [l.splat(x[number]), l.splat(y[number]), l.splat(z[number])];
                let is_near = camera.eye().is_some();
                let threshold = if is_near { offsets } else { zero };
                let seen = l.bits(l.less(threshold, dot(l, eye, normals)));
                facing[number] |= u64::from(seen) << (LANES * chunk);
            }
        }
    }
}

/// Puts an eye into the frames of all hulls.
#[inline(always)]
fn turn_eye<L: Wide>(l: L, places: &Places, camera: &Camera, eyes: &mut [[f32; MAX_HULLS]; 3]) {
    let toward = camera.viewpoint().toward();
    let (eye, is_near) = match camera.eye() {
        Some((aim, distance_m)) => (aim + toward * distance_m, true),
        None => (toward, false),
    };
    for hulls in (0..MAX_HULLS).step_by(LANES) {
        let mut eye = splat(l, eye);
        if is_near {
            for (eye, offsets) in eye.iter_mut().zip(&places.offsets) {
                *eye = l.sub(*eye, part(l, offsets, hulls));
            }
        }
        for (eyes, [x, y, z]) in eyes.iter_mut().zip(places.turns.as_chunks().0) {
            let axis = [part(l, x, hulls), part(l, y, hulls), part(l, z, hulls)];
            store(l, dot(l, axis, eye), eyes, hulls);
        }
    }
}

/// Finds the outlines of hulls, and fills them.
#[inline(always)]
fn fill<L: Wide>(l: L, window: &mut Window, seen: &Seen<'_>, placement: &Placement) {
    window.empty();
    let mut strips = 0;
    for (number, hull) in seen.figure.hull_parts().enumerate() {
        let start = hull.points.start;
        let [x, y] = [&seen.points.x, &seen.points.y].map(|axis| {
            axis.get(start..)
                .and_then(<[f32]>::first_chunk::<MAX_HULL_POINTS>)
        });
        let (Some(x), Some(y)) = (x, y) else {
            return;
        };
        if strips + MOST_STRIPS > MAX_STRIPS {
            fill_strips(l, window, strips, placement);
            strips = 0;
        }
        let facing = window.facing[seen.view % VIEWS_AT_ONCE][number % MAX_HULLS];
        let ends = window.ends.get_mut(strips..).unwrap_or_default();
        let count = l.ends(facing, hull.edges, [x, y], ends);
        for first in (0..count).step_by(LANES) {
            if let Some(strip) = window.strips.get_mut(strips) {
                strip.len = (count - first).min(LANES);
                strip.is_last = count - first <= LANES;
            }
            strips += 1;
        }
    }
    fill_strips(l, window, strips, placement);
}

/// `N` of some numbers.
#[inline(always)]
fn part<const N: usize, L: Lanes<N>>(l: L, numbers: &[f32], first: usize) -> L::Floats {
    match numbers.get(first..).and_then(<[f32]>::first_chunk) {
        Some(lanes) => l.load(lanes),
        None => l.splat(0.0),
    }
}

/// Places the ends of `N` lines in the image, and finds which rows the lines between them cross.
#[inline(always)]
fn lay<const N: usize, L: Lanes<N>>(
    l: L,
    (strip, ends, first): (&mut Strip, &Ends, usize),
    placement: &Placement,
    (sampling, size): (Sampling, Size),
) {
    let [ax, ay] = placed(l, &ends.from, first, placement);
    let [bx, by] = placed(l, &ends.to, first, placement);
    let (top, bottom) = (l.min(ay, by), l.max(ay, by));
    store(l, ax, &mut strip.x, first);
    store(l, ay, &mut strip.y, first);
    store(
        l,
        l.div(l.sub(bx, ax), l.sub(by, ay)),
        &mut strip.slope,
        first,
    );
    store(l, top, &mut strip.top, first);
    store(l, bottom, &mut strip.bottom, first);

    // Rows that have a sample below the top, and rows that have one not below the bottom: half a
    // row less, since what is rounded is rounded to the nearest.
    let places = sampling.places();
    let (Some(&upmost), Some(&lowest)) = (places.first(), places.last()) else {
        return;
    };
    let (zero, rows) = (l.splat(0.0), l.splat(as_pixels(size.rows())));
    let from = l.add(top, l.splat(0.5 - lowest - SLACK));
    let from = l.min(l.max(from, zero), rows);
    let to = l.add(bottom, l.splat(0.5 - upmost + SLACK));
    let to = l.min(l.max(to, zero), rows);
    let crosses = l.bits(l.less_words(l.round(from), l.round(to)));
    // The same for blocks: (from + 1/2) / 8 and (to + 1/2 + 7) / 8, half a block less.
    let (share, margin) = (l.splat(0.125), l.splat(0.4375));
    let from = l.max(l.sub(l.mul(from, share), margin), zero);
    let to = l.add(l.mul(to, share), margin);
    let crossing = l.ranges(l.round(from), l.round(to));
    // Lanes behind the last line hold what was there before.
    let lines = crosses & !(u32::MAX << (strip.len - first).min(LANES));
    for (half, (blocks, crossing)) in strip
        .crossing
        .iter_mut()
        .skip(first / BLOCK)
        .zip(crossing)
        .enumerate()
    {
        *blocks = crossing & (u64::from(lines >> (BLOCK * half) & 0xff) * 0x0101_0101_0101_0101);
    }
}

#[inline(always)]
fn store<const N: usize, L: Lanes<N>>(l: L, lanes: L::Floats, to: &mut [f32], first: usize) {
    if let Some(to) = to.get_mut(first..).and_then(<[f32]>::first_chunk_mut) {
        l.store(lanes, to);
    }
}

/// [`Placement::place`] of `N` points.
#[inline(always)]
fn placed<const N: usize, L: Lanes<N>>(
    l: L,
    [x, y]: &[[f32; LANES]; 2],
    first: usize,
    placement: &Placement,
) -> [L::Floats; 2] {
    let Placement { scale, origin, at } = placement;
    let x = l.sub(part(l, x, first), l.splat(origin.x));
    let y = l.sub(l.splat(origin.y), part(l, y, first));
    [
        l.add(l.mul(x, l.splat(scale.x)), l.splat(at.x)),
        l.add(l.mul(y, l.splat(scale.y)), l.splat(at.y)),
    ]
}

/// Fills the hulls of so many strips.
#[inline(always)]
fn fill_strips<L: Wide>(l: L, window: &mut Window, count: usize, placement: &Placement) {
    let drawn = (window.sampling, window.size);
    for (strip, ends) in window.strips.iter_mut().zip(&window.ends).take(count) {
        strip.crossing = [0; 2];
        if L::IS_ONE {
            lay(l, (strip, ends, 0), placement, drawn);
        } else {
            for first in (0..strip.len).step_by(BLOCK) {
                lay(l.half(), (strip, ends, first), placement, drawn);
            }
        }
    }
    match window.sampling {
        Sampling::Once => fill_hulls::<L, 1>(l, window, count),
        Sampling::ThreeByThree => fill_hulls::<L, 3>(l, window, count),
    }
}

#[inline(always)]
fn fill_hulls<L: Wide, const N: usize>(l: L, window: &mut Window, count: usize) {
    let Window {
        strips,
        sampling,
        words,
        bits,
        ..
    } = window;
    let strips = strips.get(..count).unwrap_or_default();
    for hull in strips.split_inclusive(|strip| strip.is_last) {
        let all = |blocks, strip: &Strip| blocks | strip.crossing[0] | strip.crossing[1];
        let mut blocks = hull.iter().fold(0, all);
        while blocks != 0 {
            let block = blocks.trailing_zeros() / 8;
            blocks &= !(0xff << (8 * block));
            fill_block::<L::Half, N>(l.half(), (hull, block), sampling.places(), (bits, *words));
        }
    }
}

/// Fills eight rows with `N` by `N` samples a pixel.
#[inline(always)]
fn fill_block<L: Lanes<BLOCK>, const N: usize>(
    l: L,
    (hull, block): (&[Strip], u32),
    places: &[f32],
    (bits, words): (&mut [[[u32; MAX_ROWS]; MAX_WORDS]; MAX_SAMPLES], usize),
) {
    let block = block as usize % BLOCKS;
    #[expect(clippy::cast_precision_loss, reason = "at most 128")]
    let width = l.splat((WORD * words) as f32);
    let zero = l.splat(0.0);
    let first = l.add(l.splat(as_pixels(BLOCK * block)), l.load(&ROW));
    let mut y = [zero; N];
    for (y, &place) in y.iter_mut().zip(places) {
        *y = l.add(first, l.splat(place));
    }
    let mut spans = [(width, zero); N];
    for strip in hull {
        let mut lines = strip.lines(block as u32);
        while lines != 0 {
            let line = lines.trailing_zeros() as usize % LANES;
            lines &= lines - 1;
            let (top, bottom) = (l.splat(strip.top[line]), l.splat(strip.bottom[line]));
            let (start, slope) = (l.splat(strip.y[line]), l.splat(strip.slope[line]));
            let x = l.splat(strip.x[line]);
            for (span, &y) in spans.iter_mut().zip(&y) {
                let crosses = l.within(top, y, bottom);
                let x = l.add(x, l.mul(slope, l.sub(y, start)));
                *span = l.widen(*span, x, crosses);
            }
        }
    }
    for (down, (left, right)) in spans.into_iter().enumerate() {
        // They began at the window's sides: one may be beyond its own only.
        let left = l.max(left, zero);
        let right = l.min(right, width);
        for (across, &place) in places.iter().enumerate().take(N) {
            // The first column whose sample is right of an edge.
            let past = l.splat(1.0 - place);
            let from = l.truncate(l.add(left, past));
            let to = l.truncate(l.add(right, past));
            let Some(image) = bits.get_mut(across * N + down) else {
                return;
            };
            for (word, rows) in image.iter_mut().take(words).enumerate() {
                let (rows, _) = rows.as_chunks_mut();
                if let Some(rows) = rows.get_mut(block) {
                    let filled = l.or_words(l.load_words(rows), span(l, from, to, word));
                    l.store_words(filled, rows);
                }
            }
        }
    }
}

const ROW: [f32; BLOCK] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// The bits of one word from column `from` on and before column `to`.
#[inline(always)]
fn span<L: Lanes<BLOCK>>(l: L, from: L::Words, to: L::Words, word: usize) -> L::Words {
    let (mut from, mut to) = (from, to);
    if word > 0 {
        #[expect(clippy::cast_possible_truncation, reason = "at most 128")]
        let start = l.splat_word((WORD * word) as u32);
        let none = l.splat_word(0);
        from = l.max_words(l.sub_words(from, start), none);
        to = l.max_words(l.sub_words(to, start), none);
    }
    // From 32 on there is no bit.
    l.without(l.bits_from(from), l.bits_from(to))
}

/// Sums over the images in whole numbers: a sample counts `N`, so that places in a pixel do.
#[inline(always)]
fn moments<L: Wide>(l: L, window: &Window) -> Moments {
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
fn word_moments<L: Wide>(l: L, rows: &[u32; MAX_ROWS], kept: &[u32; MAX_ROWS]) -> (u32, u32) {
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
fn cut<L: Wide>(_: L, window: &Window, left: isize, frame: &mut Frame) -> u64 {
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

//! The bit-row rasteriser: an integer a row, exact samples, no heap, no 2-D hull.
//!
//! The outline of a hull is the projection of the edges between its visible facets and the others.
//! Two of them or none cross each row of samples, and the samples between are on. Work without
//! branches is done for all hulls first: visible facets, sixteen at a time, and lines along the
//! outline, sixteen at a time. Then the rows of each hull are filled, sixteen or eight at a time,
//! from all its lines: to ask which ones cross any of these rows takes longer.
//!
//! A sample is on where `left < x <= right` and `top < y <= bottom`: tiny-skia's rule for
//! samples that lie on an edge. Coordinates are f32 pixels, not rounded further.

mod block;
mod outline;
mod read;
mod samples;

use super::image_points::ImagePoints;
use super::moments::AreaMoments;
use super::placement::{Extent, Placement, places, row_columns};
use super::visible_facets::{VisibleFacets, look};
use super::window::{Fill, Pixels};
use super::{DrawError, Rasterizer, RenderView};
use crate::body::Figure;
use crate::budget::{MAX_ROWS, WINDOW_COLUMNS};
use crate::camera::Camera;
use crate::silhouette::{AnySilhouette, Silhouette, Size};
use crate::simd::{LANES, LineEnds, MAX_LINES, Simd, Wide, compiled, dispatch};
use block::fill_hull;
use outline::{Strip, lay};
use read::{cut, moments};
pub use samples::SampleImages;

/// Columns of a word.
const WORD: usize = 32;
const MAX_WORDS: usize = WINDOW_COLUMNS / WORD;
/// The maximum number of samples in one pixel.
const MAX_SAMPLES: usize = 9;
/// The maximum number of strips of all hulls that wait to be filled.
const MAX_STRIPS: usize = MAX_LINES / LANES;

/// The samples of a pixel: one in its middle, or three by three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sampling {
    Once,
    ThreeByThree,
}

impl Sampling {
    /// Returns where the samples of a pixel lie along an axis.
    const fn places(self) -> &'static [f32] {
        match self {
            Self::Once => const { &places::<1>() },
            Self::ThreeByThree => const { &places::<3>() },
        }
    }
}

/// The samples by their place in the pixel (all of the leftmost places first), word and row. Bit
/// `c` is column `c` of the word. Rows below the window may be anything.
type SampleBits = [[[u32; MAX_ROWS + LANES]; MAX_WORDS]; MAX_SAMPLES];

/// A window of bits to draw into. 34 kB.
#[derive(Clone, Debug)]
pub(crate) struct BitWindow {
    simd: Simd,
    sampling: Sampling,
    size: Size,
    /// Words of a row in use.
    words: usize,
    looks: VisibleFacets,
    points: ImagePoints,
    /// The outlines of hulls that are not filled yet: the ends of lines in the image, metres, and
    /// the lines.
    ends: LineEnds,
    strips: [Strip; MAX_STRIPS],
    bits: SampleBits,
}

impl BitWindow {
    pub fn new(size: Size, sampling: Sampling, simd: Simd) -> Self {
        Self {
            simd,
            sampling,
            size,
            words: 0,
            looks: VisibleFacets::NONE,
            points: ImagePoints::ZERO,
            ends: LineEnds::NONE,
            strips: [const { Strip::EMPTY }; _],
            bits: [[[0; _]; MAX_WORDS]; MAX_SAMPLES],
        }
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
                *rows = [0; _];
            }
        }
    }
}

impl Pixels for BitWindow {
    type Image = AnySilhouette;

    fn blank(&self) -> AnySilhouette {
        AnySilhouette::Binary(Silhouette::empty(self.size))
    }

    fn rasterizer(&self) -> Rasterizer {
        match self.sampling {
            Sampling::Once => Rasterizer::Rows,
            Sampling::ThreeByThree => Rasterizer::Rows3x3,
        }
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

    fn moments(&self) -> AreaMoments {
        dispatch!(self.simd, moments(self))
    }

    fn cut(&self, left: isize, frame: &mut AnySilhouette) -> u64 {
        dispatch!(self.simd, cut(self, left, frame))
    }
}

impl<'a> Fill<Figure<'a>> for BitWindow {
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
        columns: usize,
    ) {
        self.words = columns.div_ceil(WORD).min(MAX_WORDS);
        dispatch!(self.simd, fill(self, figure, view, placement));
    }
}

compiled!(fn look_at(looks: &mut VisibleFacets, figure: &Figure<'_>, views: &[RenderView]));
compiled!(fn fill(window: &mut BitWindow, figure: &Figure<'_>, view: usize, placement: &Placement));
compiled!(fn moments(window: &BitWindow) -> AreaMoments);
compiled!(fn cut(window: &BitWindow, left: isize, frame: &mut AnySilhouette) -> u64);

#[inline(always)]
fn look_at<L: Wide>(l: L, looks: &mut VisibleFacets, figure: &Figure<'_>, views: &[RenderView]) {
    look::<L, false>(l, looks, figure, views);
}

/// Finds the outlines of hulls, and fills them.
#[inline(always)]
fn fill<L: Wide>(
    l: L,
    window: &mut BitWindow,
    figure: &Figure<'_>,
    view: usize,
    placement: &Placement,
) {
    window.empty();
    let mut strips = 0;
    for (number, hull) in figure.hull_parts().enumerate() {
        if !LineEnds::has_room(LANES * strips) {
            fill_strips(l, window, strips, placement);
            strips = 0;
        }
        let Some(points) = window.points.of_hull(hull.points.start) else {
            return;
        };
        let facing = window.looks.facing(view, number);
        let ends = (&mut window.ends, LANES * strips);
        let count = l.ends(facing, hull.edges, points, ends);
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

/// Fills the hulls of the first `count` strips.
#[inline(always)]
fn fill_strips<L: Wide>(l: L, window: &mut BitWindow, count: usize, placement: &Placement) {
    let (sampling, size) = (window.sampling, window.size);
    for (number, strip) in window.strips.iter_mut().enumerate().take(count) {
        let ends = (&window.ends, LANES * number);
        if L::IS_ONE {
            lay(l, strip, ends, placement, sampling, size);
        } else {
            lay(l.half(), strip, ends, placement, sampling, size);
        }
    }
    match sampling {
        Sampling::Once => fill_hulls::<1, L>(l, window, count),
        Sampling::ThreeByThree => fill_hulls::<3, L>(l, window, count),
    }
}

/// Fills the hulls of the first `count` strips, whose lines are known, with `S` by `S` samples a
/// pixel.
#[inline(always)]
fn fill_hulls<const S: usize, L: Wide>(l: L, window: &mut BitWindow, count: usize) {
    let (bits, words) = (&mut window.bits, window.words);
    let places = window.sampling.places();
    let strips = window.strips.get(..count).unwrap_or_default();
    for hull in strips.split_inclusive(|strip| strip.is_last) {
        if L::IS_ONE {
            fill_hull::<S, LANES, L>(l, hull, places, bits, words);
        } else {
            fill_hull::<S, { LANES / 2 }, L::Half>(l.half(), hull, places, bits, words);
        }
    }
}

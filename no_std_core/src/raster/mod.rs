//! From posed hulls to a silhouette: framing, outlines, rasteriser.
//!
//! Framing is part of the projection: the figure is drawn once, at the size of
//! the silhouette, and nothing is resampled. What is framing here knows nothing of how
//! pixels are filled: a rasteriser has a window that draws hulls with a placement, tells
//! their moments, and cuts columns out.

pub mod columns;
mod error;
pub(crate) mod framing;
pub(crate) mod place;
mod rows;
mod seen;
pub(crate) mod simd;
#[cfg(feature = "skia")]
pub(crate) mod skia;
#[cfg(test)]
mod tests;

use crate::body::Figure;
#[cfg(feature = "skia")]
use crate::budget::SKIA_WINDOW_COLUMNS;
use crate::budget::{VIEWS_AT_ONCE, WINDOW_COLUMNS};
use crate::camera::{Camera, Framing};
use crate::silhouette::{Frame, Silhouette, Size};
use core::{fmt, slice};
pub use error::DrawError;
use framing::{Canvas, Moments, check_jitter};
use glam::Vec2;
use place::Placement;
use rows::Sampling;
use seen::{Points, Seen};
pub use simd::Simd;

/// How pixels are decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rasterizer {
    /// tiny-skia without anti-aliasing: one sample at the pixel's centre, after
    /// coordinates were cut to 1/64 pixel (0.6-0.8 % of on-pixels differ from exact
    /// sampling).
    #[cfg(feature = "skia")]
    Skia,
    /// tiny-skia with anti-aliasing: 4x4 samples a pixel, hull by hull, so that
    /// two hulls which cover parts of one pixel blend instead of adding up.
    #[cfg(feature = "skia")]
    SkiaAa,
    /// Bit rows: one sample at the pixel's centre, exactly; no heap.
    Rows,
    /// Bit rows with three by three samples a pixel, a third of a pixel apart.
    Rows3x3,
}

impl Rasterizer {
    /// All rasterisers.
    pub const ALL: &[Self] = &[
        #[cfg(feature = "skia")]
        Self::Skia,
        #[cfg(feature = "skia")]
        Self::SkiaAa,
        Self::Rows,
        Self::Rows3x3,
    ];

    /// How far apart its samples are, pixels: jitter within half of it fills the gaps between
    /// them, and more would blur.
    #[must_use]
    pub const fn spacing(self) -> f32 {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia => 1.0,
            #[cfg(feature = "skia")]
            Self::SkiaAa => 0.25,
            Self::Rows => 1.0,
            Self::Rows3x3 => 1.0 / 3.0,
        }
    }

    /// The name under which results state it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia => "skia",
            #[cfg(feature = "skia")]
            Self::SkiaAa => "skia-aa",
            Self::Rows => "rows",
            Self::Rows3x3 => "rows-3x3",
        }
    }
}

impl fmt::Display for Rasterizer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A drawn figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing<'a> {
    /// The silhouette, which its renderer keeps until it draws the next one.
    pub frame: &'a Frame,
    /// The share of the figure's area that lies outside of the image, 0..=1.
    ///
    /// Of [`Framing::Height`] it is counted in samples; of [`Framing::Box`] it is 0. Of
    /// [`Framing::Fixed`] it is 0 or 1 where the figure's rectangle lies inside or outside of
    /// the image, and otherwise measured with two more drawings, the whole figure and its part
    /// inside each stretched to the window: within 0.03 of exact areas of random bodies
    /// (`tests/framing.rs`).
    pub clipped_share: f32,
}

/// How a figure is seen and fitted into the image: what [`Renderer::draw`] takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where it is seen from.
    pub camera: Camera,
    /// How it is fitted into the image.
    pub framing: Framing,
    /// Where pixels are sampled: x to the right and y down, each within half a pixel of their
    /// centres.
    pub jitter: Vec2,
}

/// Draws figures with one rasteriser in one size, reusing its memory.
///
/// Bit rows are held inline and take no heap. tiny-skia holds
/// [`crate::budget::SKIA_RESIDENT_BYTES`] of it from the first figure on (its window of
/// 64 bytes a row from the start), and takes and gives back at most
/// [`crate::budget::SKIA_TRANSIENT_BYTES`] while it draws.
#[derive(Debug)]
pub struct Renderer {
    rasterizer: Rasterizer,
    simd: Simd,
    points: Points,
    sheet: Sheet,
}

/// What is drawn on.
#[derive(Debug)]
struct Sheet {
    size: Size,
    window: Window,
    frame: Frame,
}

/// What fills pixels.
#[derive(Debug)]
#[cfg_attr(
    feature = "skia",
    expect(
        clippy::large_enum_variant,
        reason = "37 kB once for a renderer; a box would need a heap"
    )
)]
enum Window {
    #[cfg(feature = "skia")]
    Skia(skia::Window),
    Rows(rows::Window),
}

impl Window {
    /// How many columns it has.
    fn width(&self) -> usize {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia(_) => SKIA_WINDOW_COLUMNS,
            Self::Rows(_) => WINDOW_COLUMNS,
        }
    }

    /// In how many of its columns a figure of so many is drawn.
    fn columns(&self, columns: f32) -> usize {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia(_) => SKIA_WINDOW_COLUMNS,
            Self::Rows(_) => place::row_columns(columns),
        }
    }

    /// Finds out what does not depend on where figures are drawn.
    fn look(&mut self, figure: &Figure<'_>, cameras: &[Camera]) {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia(_) => {}
            Self::Rows(window) => window.look(figure, cameras),
        }
    }

    /// Draws a figure into the leftmost `columns`, and nothing else.
    fn draw(&mut self, seen: &Seen<'_>, placement: &Placement, columns: usize) {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia(window) => window.draw(seen, placement),
            Self::Rows(window) => window.draw(seen, placement, columns),
        }
    }

    /// Empties the window.
    fn clear(&mut self) {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia(window) => window.clear(),
            Self::Rows(window) => window.clear(),
        }
    }

    /// Area and first moment of what was drawn.
    fn moments(&self) -> Moments {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia(window) => window.moments(),
            Self::Rows(window) => window.moments(),
        }
    }

    /// Makes a frame of the image's columns from `left` on; their area in the unit of
    /// [`Self::moments`].
    fn cut(&self, left: isize, frame: &mut Frame) -> u64 {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia(window) => window.cut(left, frame),
            Self::Rows(window) => window.cut(left, frame),
        }
    }
}

impl Renderer {
    /// A renderer; tiny-skia allocates its window. Bit rows use the widest registers that the
    /// processor has.
    #[must_use]
    pub fn new(rasterizer: Rasterizer, size: Size) -> Self {
        Self::with_simd(rasterizer, size, Simd::widest())
    }

    /// A renderer whose bit rows use these registers. Pictures do not depend on it.
    #[must_use]
    pub fn with_simd(rasterizer: Rasterizer, size: Size, simd: Simd) -> Self {
        let rows = |sampling| Window::Rows(rows::Window::new(size, sampling, simd));
        let window = match rasterizer {
            #[cfg(feature = "skia")]
            Rasterizer::Skia => Window::Skia(skia::Window::new(size, false)),
            #[cfg(feature = "skia")]
            Rasterizer::SkiaAa => Window::Skia(skia::Window::new(size, true)),
            Rasterizer::Rows => rows(Sampling::Once),
            Rasterizer::Rows3x3 => rows(Sampling::ThreeByThree),
        };
        Self {
            rasterizer,
            simd,
            points: Points::ZERO,
            sheet: Sheet {
                size,
                window,
                frame: Frame::Binary(Silhouette::empty(size)),
            },
        }
    }

    /// The rasteriser in use.
    #[must_use]
    pub const fn rasterizer(&self) -> Rasterizer {
        self.rasterizer
    }

    /// Rows and columns of what is drawn.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.sheet.size
    }

    /// Draws `figure` as `camera` sees it, fitted into the image by `framing`.
    ///
    /// `jitter` moves the points at which pixels are sampled, x to the right and y down, each
    /// within half a pixel: `Vec2::ZERO` samples their centres. A template of frames of
    /// different jitter is closer to exact coverage.
    ///
    /// - [`Framing::Height`] fills the rows, and puts the centroid (of the sampled points,
    ///   rounded half up) on the middle column's left side: x = 15 of 30.
    /// - [`Framing::Box`] fills rows and columns.
    /// - [`Framing::Fixed`] draws an empty frame of a figure that is wholly outside.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub fn draw(
        &mut self,
        figure: &Figure<'_>,
        camera: &Camera,
        framing: Framing,
        jitter: Vec2,
    ) -> Result<Drawing<'_>, DrawError> {
        self.sheet.window.look(figure, slice::from_ref(camera));
        let view = View {
            camera: *camera,
            framing,
            jitter,
        };
        self.draw_view(figure, &view, 0)
    }

    /// Draws `figure` from several views, and gives each drawing to `take` with the number of its
    /// view: the same drawings as [`Self::draw`] makes one by one, in less time.
    ///
    /// # Errors
    /// The first of `take`, which is given those of [`Self::draw`].
    pub fn draw_views<E>(
        &mut self,
        figure: &Figure<'_>,
        views: &[View],
        mut take: impl FnMut(usize, Result<Drawing<'_>, DrawError>) -> Result<(), E>,
    ) -> Result<(), E> {
        for (batch, views) in views.chunks(VIEWS_AT_ONCE).enumerate() {
            let cameras: heapless::Vec<Camera, VIEWS_AT_ONCE> =
                views.iter().map(|view| view.camera).collect();
            self.sheet.window.look(figure, &cameras);
            for (number, view) in views.iter().enumerate() {
                let drawing = self.draw_view(figure, view, number);
                take(batch * VIEWS_AT_ONCE + number, drawing)?;
            }
        }
        Ok(())
    }

    /// Draws a figure from one of the views that it was looked at from.
    fn draw_view(
        &mut self,
        figure: &Figure<'_>,
        view: &View,
        number: usize,
    ) -> Result<Drawing<'_>, DrawError> {
        let View {
            camera,
            framing,
            jitter,
        } = view;
        check_jitter(*jitter)?;
        if figure.is_empty() {
            return Err(DrawError::Empty);
        }
        // What is wrong with a figure is found out one point after another.
        let extent = self.points.project(figure, camera, self.simd);
        let extent = extent.map_or_else(|| framing::extent(figure.points(), camera), Ok)?;
        let mut sitting = Sitting {
            sheet: &mut self.sheet,
            seen: Seen {
                figure,
                view: number,
                points: &self.points,
            },
        };
        let clipped_share = framing::draw(&mut sitting, (camera, &extent), *framing, *jitter)?;
        Ok(Drawing {
            frame: &self.sheet.frame,
            clipped_share,
        })
    }
}

/// A figure before a camera, with what it is drawn on.
struct Sitting<'a> {
    sheet: &'a mut Sheet,
    seen: Seen<'a>,
}

impl Canvas for Sitting<'_> {
    fn size(&self) -> Size {
        self.sheet.size
    }
    fn width(&self) -> usize {
        self.sheet.window.width()
    }
    fn columns(&self, columns: f32) -> usize {
        self.sheet.window.columns(columns)
    }
    fn draw(&mut self, placement: &Placement, columns: usize) {
        self.sheet.window.draw(&self.seen, placement, columns);
    }
    fn clear(&mut self) {
        self.sheet.window.clear();
    }
    fn moments(&self) -> Moments {
        self.sheet.window.moments()
    }
    fn cut(&mut self, left: isize) -> u64 {
        self.sheet.window.cut(left, &mut self.sheet.frame)
    }
}

/// Refuses what is no scale.
fn check_scale(pixels_per_metre: f32) -> Result<(), DrawError> {
    // A NaN fails the comparison.
    if pixels_per_metre > 0.0 && pixels_per_metre.is_finite() {
        Ok(())
    } else {
        Err(DrawError::Scale(pixels_per_metre))
    }
}

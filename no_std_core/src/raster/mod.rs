//! Rendering of posed hulls to silhouettes: framing, outlines and rasterisers.
//!
//! Framing is part of the projection: the figure is drawn once, at the size of the silhouette, and
//! nothing is resampled. A [`Renderer`] frames figures for any [`Window`], which fills pixels with
//! hulls, computes their moments, and cuts columns out.
//!
//! | window | figures | draws | RAM |
//! |---|---|---|--:|
//! | [`AnyWindow`] | [`crate::body::Figure`] | any [`Rasterizer`], chosen at run time | 34 kB |
//! | [`SampleImages`] | [`crate::body::Figure`] | `rows-3x3`, the samples kept apart | 34 kB |
//! | [`Skia`] | both | `skia` | 0.5 kB |
//! | `TinySkia` | both | tiny-skia itself, also anti-aliased | 100 B, and a heap |
//! | [`crate::compact::CompactRows`] | [`crate::compact::CompactFigure`] | `rows` | 1.5 kB |

mod any;
pub mod columns;
mod error;
pub(crate) mod framing;
mod hull_pixels;
mod image_points;
pub(crate) mod moments;
pub(crate) mod placement;
mod rows;
mod skia;
mod skia_lanes;
#[cfg(test)]
mod tests;
#[cfg(feature = "tiny-skia")]
mod tiny_skia;
mod visible_facets;
mod window;

use crate::budget::VIEWS_AT_ONCE;
use crate::camera::{Camera, Framing};
use crate::silhouette::{AnySilhouette, Size};
pub use crate::simd::Simd;
pub use any::AnyWindow;
use core::{fmt, slice};
pub use error::DrawError;
pub use framing::projected;
use framing::{FramedFigure, check_jitter};
use glam::Vec2;
pub use placement::{Extent, Placement};
pub use rows::SampleImages;
pub use skia::Skia;
#[cfg(feature = "tiny-skia")]
pub use tiny_skia::TinySkia;
pub use window::PosedHulls;
pub(crate) use window::{Fill, Pixels};

/// The method that decides which pixels are on.
///
/// `skia` is the default of the `edgegait` program because the project was specified with
/// tiny-skia, and the shipped models are trained on its images. It is neither the fastest nor the
/// most exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rasterizer {
    /// The pixels of tiny-skia without anti-aliasing, in a fraction of its time and without a heap:
    /// one sample at the pixel's centre, with coordinates truncated to 1/64 pixel (0.3-0.4 % of
    /// on-pixels differ from exact sampling).
    Skia,
    /// tiny-skia itself without anti-aliasing, for comparison with [`Self::Skia`].
    #[cfg(feature = "tiny-skia")]
    TinySkia,
    /// tiny-skia with anti-aliasing: 4x4 samples a pixel, hull by hull, so that
    /// two hulls which cover parts of one pixel blend instead of adding up.
    #[cfg(feature = "tiny-skia")]
    SkiaAa,
    /// Bit rows: one sample at the pixel's centre, exactly; no heap.
    Rows,
    /// Bit rows with three by three samples a pixel, a third of a pixel apart.
    Rows3x3,
}

impl Rasterizer {
    /// All rasterisers but `TinySkia`, which draws as [`Self::Skia`].
    pub const ALL: &[Self] = &[
        Self::Skia,
        #[cfg(feature = "tiny-skia")]
        Self::SkiaAa,
        Self::Rows,
        Self::Rows3x3,
    ];

    /// Returns the distance between its samples, pixels: jitter within half of it fills the gaps
    /// between them, and more would blur.
    #[must_use]
    pub const fn spacing(self) -> f32 {
        match self {
            Self::Skia => 1.0,
            #[cfg(feature = "tiny-skia")]
            Self::TinySkia => 1.0,
            #[cfg(feature = "tiny-skia")]
            Self::SkiaAa => 0.25,
            Self::Rows => 1.0,
            Self::Rows3x3 => 1.0 / 3.0,
        }
    }

    /// Returns the name that results use for it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Skia => "skia",
            #[cfg(feature = "tiny-skia")]
            Self::TinySkia => "tiny-skia",
            #[cfg(feature = "tiny-skia")]
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
pub struct Drawing<'a, I = AnySilhouette> {
    /// The image, which the renderer keeps until it draws the next one.
    pub frame: &'a I,
    /// The share of the figure's area outside the image, 0..=1.
    ///
    /// With [`Framing::Height`] it is counted in samples; with [`Framing::Box`] it is 0. With
    /// [`Framing::Fixed`] it is 0 or 1 if the figure's rectangle lies inside or outside the image,
    /// and otherwise measured with two more drawings, of the whole figure and of its part inside,
    /// each stretched to the window: within 0.03 of exact areas of random bodies
    /// (`tests/drawing/framing.rs`).
    pub clipped_share: f32,
    /// The placement of image points in [`Self::frame`].
    pub placement: Placement,
}

/// A camera, a framing and a jitter: the view of a figure that [`Renderer::draw_views`] takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderView {
    /// The camera.
    pub camera: Camera,
    /// The framing.
    pub framing: Framing,
    /// The offset of samples from the pixels' centres: x to the right and y down, each within half
    /// a pixel.
    pub jitter: Vec2,
}

/// A window into which figures of the type `F` are drawn: [`AnyWindow`], [`SampleImages`], [`Skia`],
/// `TinySkia` or [`crate::compact::CompactRows`].
pub trait Window<F>: Fill<F> {}

impl<F, W: Fill<F>> Window<F> for W {}

/// A renderer that draws figures with one rasteriser in one size and reuses its memory.
///
/// Windows are held inline and take no heap, except for tiny-skia's own, which holds
/// [`crate::budget::SKIA_RESIDENT_BYTES`] from the first figure on (64 bytes a row from the start),
/// and allocates and frees at most [`crate::budget::SKIA_TRANSIENT_BYTES`] while it draws.
#[derive(Debug)]
pub struct Renderer<W: Pixels = AnyWindow> {
    window: W,
    image: W::Image,
}

impl Renderer {
    /// Makes a renderer for figures of unpacked bodies, which uses the widest registers of the
    /// processor.
    #[must_use]
    pub fn new(rasterizer: Rasterizer, size: Size) -> Self {
        Self::with_simd(rasterizer, size, Simd::widest())
    }

    /// Makes a renderer that uses these registers. Images do not depend on them.
    #[must_use]
    pub fn with_simd(rasterizer: Rasterizer, size: Size, simd: Simd) -> Self {
        Self::with_window(AnyWindow::new(rasterizer, size, simd))
    }
}

impl<W: Pixels> Renderer<W> {
    /// Makes a renderer that draws into this window.
    #[must_use]
    pub fn with_window(window: W) -> Self {
        let image = window.blank();
        Self { window, image }
    }

    /// Returns the rasteriser in use.
    #[must_use]
    pub fn rasterizer(&self) -> Rasterizer {
        self.window.rasterizer()
    }

    /// Returns the size of the images.
    #[must_use]
    pub fn size(&self) -> Size {
        self.window.size()
    }

    /// Draws `figure` as `camera` sees it, placed and scaled by `framing`.
    ///
    /// `jitter` moves the points at which pixels are sampled, x to the right and y down, each
    /// within half a pixel: `Vec2::ZERO` samples their centres. A template of frames with different
    /// jitter is closer to exact coverage.
    ///
    /// - [`Framing::Height`] fills the rows, and puts the centroid (of the sampled points,
    ///   rounded half up) on the middle column's left side: x = 15 of 30.
    /// - [`Framing::Box`] fills rows and columns.
    /// - [`Framing::Fixed`] draws an empty frame for a figure that is wholly outside.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub fn draw<F>(
        &mut self,
        figure: &F,
        camera: &Camera,
        framing: Framing,
        jitter: Vec2,
    ) -> Result<Drawing<'_, W::Image>, DrawError>
    where
        W: Window<F>,
    {
        let view = RenderView {
            camera: *camera,
            framing,
            jitter,
        };
        self.window.look(figure, slice::from_ref(&view));
        self.draw_view(figure, &view, 0)
    }

    /// Draws `figure` from several views, and calls `take` with the number of each view and its
    /// drawing. The drawings are those of [`Self::draw`], in less time.
    ///
    /// # Errors
    /// The first error of `take`, which also receives the errors of [`Self::draw`].
    pub fn draw_views<F, E>(
        &mut self,
        figure: &F,
        views: &[RenderView],
        mut take: impl FnMut(usize, Result<Drawing<'_, W::Image>, DrawError>) -> Result<(), E>,
    ) -> Result<(), E>
    where
        W: Window<F>,
    {
        for (batch, views) in views.chunks(VIEWS_AT_ONCE).enumerate() {
            self.window.look(figure, views);
            for (number, view) in views.iter().enumerate() {
                let drawing = self.draw_view(figure, view, number);
                take(batch * VIEWS_AT_ONCE + number, drawing)?;
            }
        }
        Ok(())
    }

    /// Draws a figure from one of the views that the window has looked at.
    fn draw_view<F>(
        &mut self,
        figure: &F,
        view: &RenderView,
        number: usize,
    ) -> Result<Drawing<'_, W::Image>, DrawError>
    where
        W: Window<F>,
    {
        let RenderView {
            camera,
            framing,
            jitter,
        } = view;
        check_jitter(*jitter)?;
        let extent = self.window.extent(figure, camera)?;
        let mut sitting = FramedFigure {
            figure,
            camera,
            view: number,
            window: &mut self.window,
            image: &mut self.image,
        };
        let (placement, clipped_share) = sitting.draw(&extent, *framing, *jitter)?;
        Ok(Drawing {
            frame: &self.image,
            clipped_share,
            placement,
        })
    }
}

/// Checks that a scale is finite and above 0.
fn check_scale(pixels_per_metre: f32) -> Result<(), DrawError> {
    // A NaN fails the comparison.
    if pixels_per_metre > 0.0 && pixels_per_metre.is_finite() {
        Ok(())
    } else {
        Err(DrawError::Scale(pixels_per_metre))
    }
}

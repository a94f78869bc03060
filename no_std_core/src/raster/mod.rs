//! From posed hulls to a silhouette: framing, outlines, rasteriser.
//!
//! Framing is part of the projection: the figure is drawn once, at the size of
//! the silhouette, and nothing is resampled. What is framing here knows nothing of how
//! pixels are filled: a rasteriser has a window that draws hulls with a placement, tells
//! their moments, and cuts columns out.

pub mod columns;
mod error;
mod place;
mod rows;
mod seen;
pub(crate) mod simd;
#[cfg(feature = "skia")]
mod skia;
#[cfg(test)]
mod tests;

use crate::body::Figure;
use crate::budget::WINDOW_COLUMNS;
use crate::camera::{Camera, Framing, NEAR_M};
use crate::silhouette::{Frame, Silhouette, Size};
use core::fmt;
pub use error::DrawError;
use glam::{Vec2, Vec3};
use place::{Extent, Placement, Spread, as_pixels};
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

/// Draws figures with one rasteriser in one size, reusing its memory.
///
/// Bit rows are held inline and take no heap. tiny-skia holds
/// [`crate::budget::SKIA_RESIDENT_BYTES`] of it from the first figure on (its window of
/// 128 bytes a row from the start), and takes and gives back at most
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
        reason = "26 kB once for a renderer; a box would need a heap"
    )
)]
enum Window {
    #[cfg(feature = "skia")]
    Skia(skia::Window),
    Rows(rows::Window),
}

impl Window {
    /// In how many of the window's columns a figure of so many is drawn.
    fn columns(&self, columns: f32) -> usize {
        match self {
            #[cfg(feature = "skia")]
            Self::Skia(_) => WINDOW_COLUMNS,
            Self::Rows(_) => rows::Window::columns(columns),
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
        check_jitter(jitter)?;
        if figure.is_empty() {
            return Err(DrawError::Empty);
        }
        // What is wrong with a figure is found out one point after another.
        let extent = self.points.project(figure, camera, self.simd);
        let extent = extent.map_or_else(|| extent_by_point(figure, camera), Ok)?;
        let seen = Seen {
            figure,
            camera,
            points: &self.points,
        };
        let clipped_share = self.sheet.draw(&seen, &extent, framing, jitter)?;
        Ok(Drawing {
            frame: &self.sheet.frame,
            clipped_share,
        })
    }
}

impl Sheet {
    /// Draws a figure of this extent; the share of it that does not show.
    fn draw(
        &mut self,
        seen: &Seen<'_>,
        extent: &Extent,
        framing: Framing,
        jitter: Vec2,
    ) -> Result<f32, DrawError> {
        match framing {
            Framing::Height => self.by_height(seen, extent, jitter),
            Framing::Box => {
                let placement = place::stretched(extent, self.image())?.moved(jitter);
                self.window.draw(seen, &placement, self.size.columns());
                if self.window.cut(0, &mut self.frame) == 0 {
                    return Err(DrawError::Vanished);
                }
                Ok(0.0)
            }
            Framing::Fixed {
                centre,
                pixels_per_metre,
            } => {
                let centre = projected(seen.camera, centre)?;
                let placement = place::fixed(centre, pixels_per_metre, self.image())?;
                self.at(seen, extent, placement, jitter)
            }
        }
    }

    /// Draws a figure that fills the rows; the share of it that is cut off.
    fn by_height(
        &mut self,
        seen: &Seen<'_>,
        extent: &Extent,
        jitter: Vec2,
    ) -> Result<f32, DrawError> {
        let columns = |columns| self.window.columns(columns);
        let (placement, windows, columns) = place::by_height(extent, self.size, columns)?;
        let placement = placement.moved(jitter);
        let mut whole = Moments::default();
        for index in 0..windows {
            let left = index * WINDOW_COLUMNS;
            let shifted = placement.moved(Vec2::new(as_pixels(left), 0.0));
            self.window.draw(seen, &shifted, columns);
            whole.add(self.window.moments(), left);
        }
        if whole.area == 0 {
            return Err(DrawError::Vanished);
        }
        let middle = (self.size.columns() / 2).cast_signed();
        let mut left = whole.centroid_column(jitter.x) - middle;
        if windows > 1 {
            #[expect(clippy::cast_precision_loss, reason = "a few thousand columns")]
            let shifted = placement.moved(Vec2::new(left as f32, 0.0));
            self.window.draw(seen, &shifted, columns);
            left = 0;
        }
        let area = self.window.cut(left, &mut self.frame);
        #[expect(clippy::cast_precision_loss, reason = "a share")]
        let clipped_share = 1.0 - (area as f32 / whole.area as f32).min(1.0);
        Ok(clipped_share)
    }

    /// Draws a figure where `placement` says, whatever of it that shows; the share that does
    /// not.
    fn at(
        &mut self,
        seen: &Seen<'_>,
        extent: &Extent,
        placement: Placement,
        jitter: Vec2,
    ) -> Result<f32, DrawError> {
        let spread = place::spread(extent, &placement, self.image())?;
        if spread == Spread::Outside {
            self.window.clear();
            self.window.cut(0, &mut self.frame);
            return Ok(1.0);
        }
        let columns = self.size.columns();
        self.window.draw(seen, &placement.moved(jitter), columns);
        self.window.cut(0, &mut self.frame);
        if spread == Spread::Inside {
            return Ok(0.0);
        }
        let whole = self.area(seen, extent, &placement);
        if whole == 0.0 {
            return Err(DrawError::Vanished);
        }
        let shown = placement.shown(extent, self.image());
        let inside = self.area(seen, &shown, &placement);
        Ok(1.0 - (inside / whole).min(1.0))
    }

    /// The area of a placed figure within a part of the image: the part is stretched to the
    /// whole window, so that small ones are measured with as many samples.
    fn area(&mut self, seen: &Seen<'_>, part: &Extent, placement: &Placement) -> f32 {
        let window = Vec2::new(as_pixels(WINDOW_COLUMNS), self.image().y);
        let stretched = place::enlarged(part, placement, window);
        self.window.draw(seen, &stretched, WINDOW_COLUMNS);
        let growth = stretched.scale / placement.scale;
        #[expect(clippy::cast_precision_loss, reason = "an area")]
        let area = self.window.moments().area as f32;
        area / growth.x / growth.y
    }

    /// Columns and rows of the image, pixels.
    fn image(&self) -> Vec2 {
        Vec2::new(as_pixels(self.size.columns()), as_pixels(self.size.rows()))
    }
}

/// Refuses samples outside of their pixel.
fn check_jitter(jitter: Vec2) -> Result<(), DrawError> {
    // A NaN fails the comparison.
    if jitter.abs().cmple(Vec2::splat(0.5)).all() {
        Ok(())
    } else {
        Err(DrawError::Jitter(jitter))
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

/// Where a point appears, if it is far enough in front of the camera.
fn projected(camera: &Camera, point: Vec3) -> Result<Vec2, DrawError> {
    let depth_m = camera.depth_m(point);
    if !point.is_finite() || depth_m.is_nan() {
        return Err(DrawError::NotFinite);
    }
    if depth_m < NEAR_M {
        return Err(DrawError::TooNear(depth_m));
    }
    let image = camera.project(point);
    if image.is_finite() {
        Ok(image)
    } else {
        Err(DrawError::NotFinite)
    }
}

/// The rectangle that a figure takes in the image.
fn extent_by_point(figure: &Figure<'_>, camera: &Camera) -> Result<Extent, DrawError> {
    let mut points = figure.points();
    let first = projected(camera, points.next().ok_or(DrawError::Empty)?)?;
    let mut extent = Extent {
        min: first,
        max: first,
    };
    for point in points {
        let image = projected(camera, point)?;
        extent.min = extent.min.min(image);
        extent.max = extent.max.max(image);
    }
    Ok(extent)
}

/// Area and first moment of a figure over columns.
#[derive(Clone, Copy, Default)]
struct Moments {
    /// The sum of all pixels, in a unit that the window chooses.
    area: u64,
    /// The sum of pixels times (2 * column + 1): twice the pixel centres, in integers.
    doubled: u64,
}

impl Moments {
    /// Adds those of a window whose first column is column `left` of the row of windows.
    fn add(&mut self, window: Self, left: usize) {
        self.area += window.area;
        self.doubled += window.doubled + 2 * left as u64 * window.area;
    }

    /// The x of the centroid of sampled points, `jitter` right of the pixel centres, rounded
    /// half up.
    fn centroid_column(&self, jitter: f32) -> isize {
        // Both are whole numbers below 2^40, so that a tie is exact and nothing else is.
        #[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
        let (area, doubled) = (self.area as f64, self.doubled as f64);
        let rounded =
            libm::floor((doubled + area * (1.0 + 2.0 * f64::from(jitter))) / (2.0 * area));
        #[expect(clippy::cast_possible_truncation, reason = "a few thousand columns")]
        let column = rounded as isize;
        column
    }
}

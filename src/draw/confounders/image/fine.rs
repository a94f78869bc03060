//! Fine pictures: their layout, and how the core renders figures into them.
//!
//! A fine picture has 3x3 samples for each pixel of the silhouette. The middle one of them is the
//! sample that the core takes.

use super::exposure::exposed;
use super::phases::{FINE, WINDOW, interleaved, merge, tiles};
use super::picture::{BitPicture, FigureSamples};
use crate::draw::registers::registers;
use crate::error::{Result, SettingError};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::budget::MAX_FIGURE_COLUMNS;
use edgegait_core::camera::Framing;
use edgegait_core::raster::{
    DrawError, Extent, PosedHulls, Rasterizer, RenderView, Renderer, SampleImages, Simd, projected,
};
use edgegait_core::silhouette::{AnySilhouette, Size};
use edgegait_core::skeleton::Joint;
use glam::{DVec2, Vec2, Vec3};

/// Margins above and below, and on each side, in pixels, for effects that widen the figure: 16 %
/// and 28 % of a figure of 50 rows. Our choice: enough for lens distortion.
const ABOVE: usize = 8;
const BESIDE: usize = 14;

/// The maximum number of pixels from the image's corner to any point along an axis; the core has
/// the same limit for columns.
const MAX_REACH: f64 = MAX_FIGURE_COLUMNS as f64;

/// A rectangle in a fine picture, in samples; y runs down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rectangle {
    /// The upper left corner.
    pub corner: DVec2,
    /// The width and height.
    pub size: DVec2,
}

/// The renderer of fine pictures.
#[derive(Debug)]
pub(crate) struct FineRenderer {
    simd: Simd,
    /// Renders silhouettes as the core does.
    silhouettes: Renderer,
    /// Renders the samples on which effects act, exactly.
    samples: Renderer<SampleImages>,
}

impl FineRenderer {
    /// Creates a renderer for silhouettes of this size.
    ///
    /// # Errors
    /// For rasterisers that draw grey: segmented silhouettes are binary. Otherwise as [`registers`].
    pub(crate) fn new(rasterizer: Rasterizer, size: Size) -> Result<Self> {
        match rasterizer {
            Rasterizer::Skia | Rasterizer::TinySkia | Rasterizer::Rows => {
                let simd = registers()?;
                Ok(Self {
                    simd,
                    silhouettes: Renderer::with_simd(rasterizer, size, simd),
                    samples: Renderer::with_window(SampleImages::new(Size::S64x64, simd)),
                })
            }
            grey => Err(SettingError::GreyRaster.refuses("raster", grey)),
        }
    }
}

/// The layout of a fine picture, and its relation to the silhouette.
#[derive(Clone, Debug)]
pub(crate) struct Fine {
    pub(super) view: RenderView,
    /// Rows and columns of the silhouette.
    pub(super) size: Size,
    /// The bounding box of the figure's projected points, metres in the image.
    extent: Extent,
    /// Image pixels a metre, to the right and down; each pixel is three samples.
    scale: DVec2,
    /// An image point, metres, and the silhouette's pixel coordinates of that point.
    anchor: DVec2,
    at: DVec2,
    /// The number of pixels left of and above pixel (0, 0).
    pub(super) left: usize,
    pub(super) above: usize,
    rows: usize,
    words: usize,
    /// A point in front of the camera.
    reference: Vec3,
}

impl Fine {
    /// Lays out the picture of `figure`, large enough for `others` too, such as its shadow.
    ///
    /// [`Framing::Height`] and [`Framing::Box`] frame the figure alone, as in the core.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub(crate) fn lay_out(
        figure: &Figure<'_>,
        others: &[&Figure<'_>],
        view: RenderView,
        size: Size,
    ) -> std::result::Result<Self, DrawError> {
        // NaN fails the comparison.
        if !view.jitter.abs().cmple(Vec2::splat(0.5)).all() {
            return Err(DrawError::Jitter(view.jitter));
        }
        let reference = figure.points().next().ok_or(DrawError::Empty)?;
        let extent = figure.extent(&view.camera)?;
        let image = pixels(size);
        // The same arithmetic as in the core.
        let full = (image.as_vec2() / (extent.max - extent.min)).as_dvec2();
        let (scale, anchor, at) = match view.framing {
            Framing::Height => {
                let middle = 0.5 * (extent.min.x + extent.max.x);
                let anchor = Vec2::new(middle, extent.max.y).as_dvec2();
                (DVec2::splat(full.y), anchor, DVec2::ZERO)
            }
            Framing::Box => {
                let anchor = Vec2::new(extent.min.x, extent.max.y).as_dvec2();
                (full, anchor, DVec2::ZERO)
            }
            Framing::Fixed {
                centre,
                pixels_per_metre,
            } => {
                // NaN fails the comparison.
                if !(pixels_per_metre > 0.0 && pixels_per_metre.is_finite()) {
                    return Err(DrawError::Scale(pixels_per_metre));
                }
                let anchor = projected(&view.camera, centre)?.as_dvec2();
                (DVec2::splat(pixels_per_metre.into()), anchor, 0.5 * image)
            }
        };
        if !scale.is_finite() {
            return Err(DrawError::Flat);
        }
        let mut fine = Self {
            view,
            size,
            extent,
            scale,
            anchor,
            at,
            left: 0,
            above: 0,
            rows: 0,
            words: 0,
            reference,
        };
        let (mut min, mut max) = fine.pixels_of(&extent);
        for other in others {
            let (from, to) = fine.pixels_of(&other.extent(&view.camera)?);
            (min, max) = (min.min(from), max.max(to));
        }
        if view.framing != Framing::Height {
            (min, max) = (min.min(DVec2::ZERO), max.max(image));
        }
        let reach = min.abs().max(max.abs()).max_element();
        if reach > MAX_REACH {
            #[expect(clippy::cast_possible_truncation, reason = "for a message")]
            return Err(DrawError::TooWide(reach as f32));
        }
        let (before, behind) = ((-min).max(DVec2::ZERO), max.max(DVec2::ZERO));
        fine.left = whole(before.x.ceil()) + BESIDE;
        fine.above = whole(before.y.ceil()) + ABOVE;
        fine.rows = FINE * (fine.above + whole(behind.y.ceil()) + ABOVE);
        fine.words = (FINE * (fine.left + whole(behind.x.ceil()) + BESIDE)).div_ceil(64);
        Ok(fine)
    }

    /// Returns an empty picture of this layout.
    #[must_use]
    pub(crate) fn blank(&self) -> BitPicture {
        BitPicture::empty(self.rows, self.words)
    }

    /// Returns the bounding box of the figure's projected points.
    #[must_use]
    pub(crate) fn figure(&self) -> Rectangle {
        let (min, max) = self.pixels_of(&self.extent);
        let corner = min + DVec2::new(self.left as f64, self.above as f64);
        Rectangle {
            corner: FINE as f64 * corner,
            size: FINE as f64 * (max - min),
        }
    }

    /// Returns samples a metre, to the right and down.
    #[must_use]
    pub(crate) fn samples_per_metre(&self) -> DVec2 {
        FINE as f64 * self.scale
    }

    /// Returns the sample at which a point appears, if it is in front of the camera.
    #[must_use]
    pub(super) fn sample_of(&self, point: Vec3) -> Option<DVec2> {
        let from = projected(&self.view.camera, point).ok()?.as_dvec2() - self.anchor;
        let (scale, at) = self.samples();
        Some(at + DVec2::new(from.x, -from.y) * scale)
    }

    /// Returns the image point from which samples are counted, metres.
    pub(super) const fn anchor(&self) -> DVec2 {
        self.anchor
    }

    /// Returns samples a metre, to the right and down, and the sample at [`Self::anchor`].
    pub(super) fn samples(&self) -> (DVec2, DVec2) {
        let corner = DVec2::new(self.left as f64, self.above as f64);
        let at = self.at + corner - self.view.jitter.as_dvec2();
        (self.samples_per_metre(), FINE as f64 * at)
    }

    /// Renders the figure for which the picture was laid out, and returns where it is. Framed,
    /// it is the silhouette that the core renders.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub(crate) fn draw_figure(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
    ) -> std::result::Result<(BitPicture, FigureSamples), DrawError> {
        let mut picture = self.drawn(renderer, figure, &self.extent)?;
        let bounds = self.settled(renderer, figure, &mut picture)?;
        Ok((picture, bounds))
    }

    /// Renders the exposure of the figure at these moments, and returns where the figure is at its
    /// own moment, which is rendered only once if it is among them.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub(crate) fn draw_exposed(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
        moments: &[Figure<'_>],
    ) -> std::result::Result<(BitPicture, FigureSamples), DrawError> {
        let drawn = self.drawn(renderer, figure, &self.extent)?;
        let mut picture = drawn.clone();
        let bounds = self.settled(renderer, figure, &mut picture)?;
        let moments = moments.iter().map(|moment| {
            if is_same(figure, moment) {
                Ok(drawn.clone())
            } else {
                self.draw(renderer, moment)
            }
        });
        let moments = moments.collect::<std::result::Result<Vec<BitPicture>, _>>()?;
        Ok((exposed(&moments).unwrap_or(picture), bounds))
    }

    /// Makes a picture of the figure agree with the core's silhouette, and returns where it is.
    fn settled(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
        picture: &mut BitPicture,
    ) -> std::result::Result<FigureSamples, DrawError> {
        let (
            RenderView {
                camera,
                framing,
                jitter,
            },
            size,
        ) = (self.view, self.size);
        if renderer.silhouettes.size() != size {
            let rasterizer = renderer.silhouettes.rasterizer();
            renderer.silhouettes = Renderer::with_simd(rasterizer, size, renderer.simd);
        }
        let drawing = renderer
            .silhouettes
            .draw(figure, &camera, framing, jitter)?;
        let AnySilhouette::Binary(silhouette) = drawing.frame else {
            unreachable!("a fine renderer refuses rasterisers of grey values");
        };
        self.settle(picture, silhouette).ok_or(DrawError::Vanished)
    }

    /// Renders another figure, such as a shadow or an occluder, clipped to the picture.
    ///
    /// Under [`Framing::Box`], if rows and columns differ in scale, the hulls are stretched before
    /// they are rendered, about 0.5 ms.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub(crate) fn draw(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
    ) -> std::result::Result<BitPicture, DrawError> {
        let extent = figure.extent(&self.view.camera)?;
        self.drawn(renderer, figure, &extent)
    }

    /// Renders a figure whose extent is known.
    fn drawn(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
        extent: &Extent,
    ) -> std::result::Result<BitPicture, DrawError> {
        let mut picture = self.blank();
        let (min, max) = self.pixels_of(extent);
        let jitter = self.view.jitter.as_dvec2();
        let columns = tiles(
            (min.x - jitter.x, max.x - jitter.x),
            self.left,
            picture.columns() / FINE,
        );
        let rows = tiles(
            (min.y - jitter.y, max.y - jitter.y),
            self.above,
            self.rows / FINE,
        );
        if columns.is_empty() || rows.is_empty() {
            return Ok(picture);
        }
        let stretch = self.stretch();
        let stretched = if stretch == 1.0 {
            None
        } else {
            Some(self.stretched(figure, stretch)?)
        };
        let stretched = stretched.as_deref().map(Figure::at_rest);
        let figure = stretched.as_ref().unwrap_or(figure);
        for &row in &rows {
            for &column in &columns {
                self.draw_tile(renderer, figure, (column, row), &mut picture)?;
            }
        }
        Ok(picture)
    }

    /// Renders the part of a figure in the window with this upper left pixel.
    fn draw_tile(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
        (column, row): (isize, isize),
        picture: &mut BitPicture,
    ) -> std::result::Result<(), DrawError> {
        let offset = FINE.cast_signed() * (column + self.left.cast_signed());
        let first = FINE.cast_signed() * (row + self.above.cast_signed());
        let middle = DVec2::new(column as f64, row as f64) + DVec2::splat(0.5 * WINDOW as f64);
        let RenderView { camera, jitter, .. } = &self.view;
        let framing = self.window(middle);
        let images = match renderer.samples.draw(figure, camera, framing, *jitter) {
            Ok(drawing) => drawing.frame,
            // A shadow seen edge-on has no area.
            Err(DrawError::Vanished) => return Ok(()),
            Err(error) => return Err(error),
        };
        for row in 0..WINDOW {
            for down in 0..FINE {
                let [left, middle, right] =
                    [down, FINE + down, 2 * FINE + down].map(|image| images[image].rows()[row]);
                if left | middle | right == 0 {
                    continue;
                }
                let at = first + (FINE * row + down).cast_signed();
                if let Some(at) = usize::try_from(at).ok().filter(|&at| at < picture.rows()) {
                    let bits = interleaved([left, middle, right]);
                    merge(picture.row_mut(at), bits, offset);
                }
            }
        }
        Ok(())
    }

    /// Returns the framing that centres a window on these pixel coordinates.
    fn window(&self, middle: DVec2) -> Framing {
        let metres = (middle - self.at) / self.scale;
        let target = self.anchor + DVec2::new(metres.x, -metres.y);
        let target = DVec2::new(self.stretch() * target.x, target.y);
        #[expect(clippy::cast_possible_truncation, reason = "pixels a metre")]
        let pixels_per_metre = self.scale.y as f32;
        Framing::Fixed {
            centre: self.seen_at(target),
            pixels_per_metre,
        }
    }

    /// Returns the point at the depth of the reference point that appears at an image point.
    fn seen_at(&self, target: DVec2) -> Vec3 {
        let camera = &self.view.camera;
        let right = camera.viewpoint().right();
        let up = camera.viewpoint().up();
        let growth = self.growth(self.reference);
        let mut point = self.reference;
        // The second step corrects the rounding of the first.
        for _ in 0..2 {
            let away = (target - camera.project(point).as_dvec2()) / growth;
            point =
                (point.as_dvec3() + right.as_dvec3() * away.x + up.as_dvec3() * away.y).as_vec3();
        }
        point
    }

    /// Returns image metres for each metre at the depth of a point: 1 with parallel rays.
    fn growth(&self, point: Vec3) -> f64 {
        let camera = &self.view.camera;
        let right = camera.viewpoint().right();
        f64::from(camera.project(point + right).x) - f64::from(camera.project(point).x)
    }

    /// Returns the ratio of horizontal to vertical pixels a metre.
    fn stretch(&self) -> f64 {
        self.scale.x / self.scale.y
    }

    /// Returns the figure stretched by `stretch` from the image's line x = 0.
    ///
    /// Depths stay the same, so that the image is stretched under any lens.
    fn stretched(
        &self,
        figure: &Figure<'_>,
        stretch: f64,
    ) -> std::result::Result<Box<UnpackedBody>, DrawError> {
        let camera = &self.view.camera;
        let right = camera.viewpoint().right().as_dvec3();
        let mut body = Box::<UnpackedBody>::default();
        for hull in figure.hulls() {
            let points = hull.map(|point| {
                let from_line = f64::from(camera.project(point).x) / self.growth(point);
                (point.as_dvec3() + right * ((stretch - 1.0) * from_line)).as_vec3()
            });
            // The figure's own hulls are within the budget.
            let fits = body.push(Joint::Pelvis, points);
            debug_assert!(fits.is_ok(), "a figure is within the budget");
        }
        Ok(body)
    }

    /// Returns the silhouette's pixel coordinates of a rectangle in the image.
    fn pixels_of(&self, extent: &Extent) -> (DVec2, DVec2) {
        let place = |x: f32, y: f32| {
            let from = Vec2::new(x, y).as_dvec2() - self.anchor;
            DVec2::new(from.x, -from.y) * self.scale + self.at
        };
        (
            place(extent.min.x, extent.max.y),
            place(extent.max.x, extent.min.y),
        )
    }
}

/// Returns whether two figures of one body have the same points.
fn is_same(one: &Figure<'_>, other: &Figure<'_>) -> bool {
    one.len() == other.len() && one.points().eq(other.points())
}

/// Returns columns and rows of a silhouette.
fn pixels(size: Size) -> DVec2 {
    DVec2::new(size.columns() as f64, size.rows() as f64)
}

/// Converts a count of pixels.
fn whole(pixels: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few thousand"
    )]
    let count = pixels as usize;
    count
}

//! Where a fine picture lies, and how the core draws figures into it.
//!
//! A fine picture has three by three samples for each pixel that the silhouette would have, at
//! the same places: the middle one of each three by three is the sample that the core would
//! take.

use super::exposure::exposed;
use super::phases::{FINE, WINDOW, interleaved, merge, tiles};
use super::picture::{BitPicture, SampleBounds};
use crate::error::{ChoiceError, Result};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::budget::MAX_FIGURE_COLUMNS;
use edgegait_core::camera::Framing;
use edgegait_core::raster::{
    DrawError, Extent, PosedHulls, Rasterizer, RenderView, Renderer, SampleImages, projected,
};
use edgegait_core::silhouette::{AnySilhouette, Size};
use edgegait_core::skeleton::Joint;
use glam::{DVec2, Vec2, Vec3};

/// Pixels above and below, and on each side of, what is drawn, for effects that widen it: 16
/// and 28 % of a figure of 50 rows. Ours: what a lens stretches stays inside.
const ABOVE: usize = 8;
const BESIDE: usize = 14;

/// Most pixels along an axis from the image's corner to something drawn, as the core has it of
/// columns.
const MAX_REACH: f64 = MAX_FIGURE_COLUMNS as f64;

/// A rectangle of a fine picture, samples; y runs down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rectangle {
    /// Upper left corner.
    pub corner: DVec2,
    /// Width and height.
    pub size: DVec2,
}

/// Draws fine pictures.
#[derive(Debug)]
pub(crate) struct FineRenderer {
    /// Draws whole silhouettes.
    silhouettes: Renderer,
    /// Draws what effects act on, exactly.
    samples: Renderer<SampleImages>,
}

impl FineRenderer {
    /// A renderer of one sample a pixel, for silhouettes of this size.
    ///
    /// # Errors
    /// For rasterisers that draw grey: what is segmented is on or off.
    pub(crate) fn new(rasterizer: Rasterizer, size: Size) -> Result<Self> {
        match rasterizer {
            Rasterizer::Skia | Rasterizer::Rows => Ok(Self {
                silhouettes: Renderer::new(rasterizer, size),
                samples: Renderer::of(SampleImages::new(Size::S64x64)),
            }),
            grey => Err(ChoiceError::GreyRaster(grey).into()),
        }
    }
}

/// Where a fine picture lies, and what of it the silhouette shows.
#[derive(Clone, Debug)]
pub(crate) struct Fine {
    pub(super) view: RenderView,
    /// Rows and columns of the silhouette.
    pub(super) size: Size,
    /// The rectangle of the figure's projected points, metres in the image.
    extent: Extent,
    /// Image pixels a metre, to the right and down: three samples each.
    scale: DVec2,
    /// An image point, metres, and on which of the silhouette's pixel coordinates it falls.
    anchor: DVec2,
    at: DVec2,
    /// Pixels of the picture left of and above pixel (0, 0).
    pub(super) left: usize,
    pub(super) above: usize,
    rows: usize,
    words: usize,
    /// A point in front of the camera.
    reference: Vec3,
}

impl Fine {
    /// The picture of `figure`, large enough for `others` too: its shadow.
    ///
    /// [`Framing::Height`] and [`Framing::Box`] are as the core has them of the figure alone,
    /// [`Framing::Fixed`] is what it says.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub(crate) fn of(
        figure: &Figure<'_>,
        others: &[&Figure<'_>],
        view: RenderView,
        size: Size,
    ) -> std::result::Result<Self, DrawError> {
        // A NaN fails the comparison.
        if !view.jitter.abs().cmple(Vec2::splat(0.5)).all() {
            return Err(DrawError::Jitter(view.jitter));
        }
        let reference = figure.points().next().ok_or(DrawError::Empty)?;
        let extent = figure.extent(&view.camera)?;
        let image = pixels(size);
        // Scales in the core's arithmetic.
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
                // A NaN fails the comparison.
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

    /// A picture of this layout, nothing on.
    #[must_use]
    pub(crate) fn blank(&self) -> BitPicture {
        BitPicture::empty(self.rows, self.words)
    }

    /// The rectangle of the figure's projected points.
    #[must_use]
    pub(crate) fn figure(&self) -> Rectangle {
        let (min, max) = self.pixels_of(&self.extent);
        let corner = min + DVec2::new(self.left as f64, self.above as f64);
        Rectangle {
            corner: FINE as f64 * corner,
            size: FINE as f64 * (max - min),
        }
    }

    /// Samples for each metre, to the right and down.
    #[must_use]
    pub(crate) fn samples_per_metre(&self) -> DVec2 {
        FINE as f64 * self.scale
    }

    /// The image point from which samples are counted, metres.
    pub(super) const fn anchor(&self) -> DVec2 {
        self.anchor
    }

    /// Samples for each metre, to the right and down, and the sample on which
    /// [`Self::anchor`] falls.
    pub(super) fn samples(&self) -> (DVec2, DVec2) {
        let corner = DVec2::new(self.left as f64, self.above as f64);
        let at = self.at + corner - self.view.jitter.as_dvec2();
        (self.samples_per_metre(), FINE as f64 * at)
    }

    /// Draws the figure that the picture is of, and tells where it is on. Its framing is the
    /// silhouette that the core draws.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub(crate) fn draw_figure(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
    ) -> std::result::Result<(BitPicture, SampleBounds), DrawError> {
        let mut picture = self.drawn(renderer, figure, &self.extent)?;
        let bounds = self.settled(renderer, figure, &mut picture)?;
        Ok((picture, bounds))
    }

    /// Draws the exposure of the figure at these moments, and tells where it is on at its own,
    /// which is drawn once if it is among them.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub(crate) fn draw_exposed(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
        moments: &[Figure<'_>],
    ) -> std::result::Result<(BitPicture, SampleBounds), DrawError> {
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

    /// Makes a drawing of the figure agree with the core's; where it is on then.
    fn settled(
        &self,
        renderer: &mut FineRenderer,
        figure: &Figure<'_>,
        picture: &mut BitPicture,
    ) -> std::result::Result<SampleBounds, DrawError> {
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
            renderer.silhouettes = Renderer::new(rasterizer, size);
        }
        let drawing = renderer
            .silhouettes
            .draw(figure, &camera, framing, jitter)?;
        let bounds = match drawing.frame {
            AnySilhouette::Binary(silhouette) => self.settle(picture, silhouette),
            AnySilhouette::Ninths(_) | AnySilhouette::Grey(_) => picture.bounds(),
        };
        bounds.ok_or(DrawError::Vanished)
    }

    /// Draws another figure: a shadow, or what stands before the walker. What lies outside of
    /// the picture does not show.
    ///
    /// [`Framing::Box`] of a figure that is not square stretches its hulls before it draws
    /// them, about 0.5 ms.
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

    /// The same of a figure whose extent is known.
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

    /// Draws the part of a figure in the window whose upper left pixel is this one.
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
            // A shadow that is seen edge on has no area.
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

    /// The framing that shows these pixel coordinates in the middle of a window.
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

    /// A point that appears at an image point, at the depth of the reference point.
    fn seen_at(&self, target: DVec2) -> Vec3 {
        let camera = &self.view.camera;
        let right = camera.viewpoint().right();
        let up = camera.viewpoint().up();
        let growth = self.growth(self.reference);
        let mut point = self.reference;
        // The second step takes back what the first one rounded.
        for _ in 0..2 {
            let away = (target - camera.project(point).as_dvec2()) / growth;
            point =
                (point.as_dvec3() + right.as_dvec3() * away.x + up.as_dvec3() * away.y).as_vec3();
        }
        point
    }

    /// Image metres for a metre at the depth of a point: 1 with parallel rays.
    fn growth(&self, point: Vec3) -> f64 {
        let camera = &self.view.camera;
        let right = camera.viewpoint().right();
        f64::from(camera.project(point + right).x) - f64::from(camera.project(point).x)
    }

    /// How many times as wide as high a metre is drawn.
    fn stretch(&self) -> f64 {
        self.scale.x / self.scale.y
    }

    /// A figure that is `stretch` times as far from the image's line x = 0.
    ///
    /// Every depth stays as it is, so that the image is stretched, whatever the lens is.
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
            // As many as the figure has, which are within the budget.
            let fits = body.push(Joint::Pelvis, points);
            debug_assert!(fits.is_ok(), "a figure is within the budget");
        }
        Ok(body)
    }

    /// The silhouette's pixel coordinates of a rectangle of the image.
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

/// Whether two figures of one body have the same points.
fn is_same(one: &Figure<'_>, other: &Figure<'_>) -> bool {
    one.len() == other.len() && one.points().eq(other.points())
}

/// Columns and rows of a silhouette.
fn pixels(size: Size) -> DVec2 {
    DVec2::new(size.columns() as f64, size.rows() as f64)
}

/// A count of pixels.
fn whole(pixels: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few thousand"
    )]
    let count = pixels as usize;
    count
}

//! Framing of figures, independent of the type of body and the rasteriser.

use super::DrawError;
use super::moments::AreaMoments;
use super::placement::{self, Extent, ExtentPlace, Placement, as_pixels};
use super::window::{Fill, Pixels};
use crate::camera::{Camera, Framing, NEAR_M};
use crate::silhouette::Size;
use glam::{Vec2, Vec3};

/// A figure before a camera, the window that it is drawn into, and the image that is cut out.
pub(crate) struct FramedFigure<'a, F, W: Pixels> {
    pub figure: &'a F,
    pub camera: &'a Camera,
    /// The number of the view among those given to [`Fill::look`].
    pub view: usize,
    pub window: &'a mut W,
    pub image: &'a mut W::Image,
}

impl<F, W: Fill<F>> FramedFigure<'_, F, W> {
    /// Draws the figure, which has this extent, and returns its placement and the share of it
    /// outside the image.
    pub fn draw(
        &mut self,
        extent: &Extent,
        framing: Framing,
        jitter: Vec2,
    ) -> Result<(Placement, f32), DrawError> {
        let size = self.window.size();
        match framing {
            Framing::Height => self.by_height(extent, jitter),
            Framing::Box => {
                let placement = placement::stretched(extent, image(size))?.moved(jitter);
                self.fill(&placement, size.columns());
                if self.cut(0) == 0 {
                    return Err(DrawError::Vanished);
                }
                Ok((placement, 0.0))
            }
            Framing::Fixed {
                centre,
                pixels_per_metre,
            } => {
                let centre = projected(self.camera, centre)?;
                let placement = placement::fixed(centre, pixels_per_metre, image(size))?;
                let clipped_share = self.at(extent, placement, jitter)?;
                Ok((placement.moved(jitter), clipped_share))
            }
        }
    }

    fn fill(&mut self, placement: &Placement, columns: usize) {
        self.window
            .draw(self.figure, self.camera, self.view, placement, columns);
    }

    fn cut(&mut self, left: isize) -> u64 {
        self.window.cut(left, self.image)
    }

    /// Draws a figure that fills the rows, and returns its placement and the share of it that is
    /// cut off.
    fn by_height(&mut self, extent: &Extent, jitter: Vec2) -> Result<(Placement, f32), DrawError> {
        let (size, limit) = (self.window.size(), self.window.width());
        let columns = |columns| self.window.columns(columns);
        let (placement, windows, columns) = placement::by_height(extent, size, limit, columns)?;
        let placement = placement.moved(jitter);
        let mut whole = AreaMoments::default();
        for index in 0..windows {
            let left = index * limit;
            let shifted = placement.moved(Vec2::new(as_pixels(left), 0.0));
            self.fill(&shifted, columns);
            whole.add(self.window.moments(), left);
        }
        if whole.area == 0 {
            return Err(DrawError::Vanished);
        }
        let middle = (size.columns() / 2).cast_signed();
        let mut left = whole.centroid_column(jitter.x) - middle;
        #[expect(clippy::cast_precision_loss, reason = "a few thousand columns")]
        let shifted = placement.moved(Vec2::new(left as f32, 0.0));
        if windows > 1 {
            self.fill(&shifted, columns);
            left = 0;
        }
        let area = self.cut(left);
        #[expect(clippy::cast_precision_loss, reason = "a share")]
        let clipped_share = 1.0 - (area as f32 / whole.area as f32).min(1.0);
        Ok((shifted, clipped_share))
    }

    /// Draws the visible part of a figure at `placement`, and returns the share that is not
    /// visible.
    fn at(
        &mut self,
        extent: &Extent,
        placement: Placement,
        jitter: Vec2,
    ) -> Result<f32, DrawError> {
        let size = self.window.size();
        let spread = placement::spread(extent, &placement, image(size))?;
        if spread == ExtentPlace::Outside {
            self.window.clear();
            self.cut(0);
            return Ok(1.0);
        }
        self.fill(&placement.moved(jitter), size.columns());
        self.cut(0);
        if spread == ExtentPlace::Inside {
            return Ok(0.0);
        }
        let whole = self.area(extent, &placement);
        if whole == 0.0 {
            return Err(DrawError::Vanished);
        }
        let inside = self.area(&placement.shown(extent, image(size)), &placement);
        Ok(1.0 - (inside / whole).min(1.0))
    }

    /// Measures the area of a placed figure within a part of the image. The part is stretched to
    /// the whole window, so that small parts are measured with as many samples.
    fn area(&mut self, part: &Extent, placement: &Placement) -> f32 {
        let columns = self.window.width();
        let window = Vec2::new(as_pixels(columns), image(self.window.size()).y);
        let stretched = placement::enlarged(part, placement, window);
        self.fill(&stretched, columns);
        let growth = stretched.scale / placement.scale;
        #[expect(clippy::cast_precision_loss, reason = "an area")]
        let area = self.window.moments().area as f32;
        area / growth.x / growth.y
    }
}

/// Returns the columns and rows of an image, pixels.
fn image(size: Size) -> Vec2 {
    Vec2::new(as_pixels(size.columns()), as_pixels(size.rows()))
}

/// Checks that samples stay within their pixel.
pub(crate) fn check_jitter(jitter: Vec2) -> Result<(), DrawError> {
    // A NaN fails the comparison.
    if jitter.abs().cmple(Vec2::splat(0.5)).all() {
        Ok(())
    } else {
        Err(DrawError::Jitter(jitter))
    }
}

/// Returns where a point appears in the image, metres to the right and up.
///
/// # Errors
/// When it is not finite, or too near to the camera.
pub fn projected(camera: &Camera, point: Vec3) -> Result<Vec2, DrawError> {
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

/// Returns the rectangle that points take in the image.
pub(crate) fn extent(
    points: impl IntoIterator<Item = Vec3>,
    camera: &Camera,
) -> Result<Extent, DrawError> {
    let mut points = points.into_iter();
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

//! Where a figure appears in the image.

use edgegait_core::body::Figure;
use edgegait_core::camera::{Camera, NEAR_M};
use edgegait_core::raster::DrawError;
use glam::{Vec2, Vec3};

/// The rectangle that a figure takes in the image, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Leftmost and lowest.
    pub(super) min: Vec2,
    /// Rightmost and highest.
    pub(super) max: Vec2,
}

impl Extent {
    /// That of a figure.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub(super) fn of(figure: &Figure<'_>, camera: &Camera) -> Result<Self, DrawError> {
        // What is wrong with a figure is found out one point after another.
        Self::of_seen(figure, camera).map_or_else(|| Self::of_each(figure, camera), Ok)
    }

    /// None if a point has no place in the image.
    fn of_seen(figure: &Figure<'_>, camera: &Camera) -> Option<Self> {
        let first = figure.points().next().filter(|point| point.is_finite())?;
        let (right, up) = (camera.viewpoint().right(), camera.viewpoint().up());
        if camera.depth_m(first) == f32::INFINITY {
            // Rays are parallel.
            let image = |point: Vec3| Vec2::new(right.dot(point), up.dot(point));
            return Self::around(figure.points().map(image));
        }
        let mut nearest = f32::INFINITY;
        let extent = Self::around(figure.points().map(|point| {
            nearest = nearest.min(camera.depth_m(point));
            camera.project(point)
        }));
        extent.filter(|_| nearest >= NEAR_M)
    }

    /// The rectangle of these points; none if one of them is not finite.
    #[inline]
    fn around(images: impl Iterator<Item = Vec2>) -> Option<Self> {
        let mut extent = Self {
            min: Vec2::INFINITY,
            max: Vec2::NEG_INFINITY,
        };
        let mut is_whole = true;
        for image in images {
            is_whole &= image.is_finite();
            extent.min = extent.min.min(image);
            extent.max = extent.max.max(image);
        }
        is_whole.then_some(extent)
    }

    fn of_each(figure: &Figure<'_>, camera: &Camera) -> Result<Self, DrawError> {
        let mut points = figure.points();
        let first = projected(camera, points.next().ok_or(DrawError::Empty)?)?;
        let mut extent = Self {
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
}

/// Where a point appears, if it is far enough in front of the camera.
pub(super) fn projected(camera: &Camera, point: Vec3) -> Result<Vec2, DrawError> {
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

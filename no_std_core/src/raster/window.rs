//! Traits of windows and figures, independent of the type of body and the rasteriser.

use super::moments::AreaMoments;
use super::placement::{Extent, Placement};
use super::{DrawError, Rasterizer, RenderView};
use crate::camera::Camera;
use crate::silhouette::Size;
use glam::Vec3;

/// A body in a pose: [`crate::body::Figure`] or [`crate::compact::CompactFigure`].
pub trait PosedHulls {
    /// Returns the points of each hull, metres.
    fn hulls(&self) -> impl Iterator<Item = impl Iterator<Item = Vec3>>;

    /// Returns the rectangle that all points take in the image.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    fn extent(&self, camera: &Camera) -> Result<Extent, DrawError>;
}

/// The pixels of a window, and the image that is cut out of them.
pub trait Pixels {
    /// The type of the image.
    type Image;

    /// Whether it finds outlines by facets.
    const NEEDS_FACETS: bool = true;

    /// Whether pixels of the image have more values than on and off.
    const IS_GREY: bool = false;

    /// Returns an empty image.
    fn blank(&self) -> Self::Image;

    /// Returns the rasteriser.
    fn rasterizer(&self) -> Rasterizer;

    /// Returns the size of the image.
    fn size(&self) -> Size;

    /// Returns the number of columns of the window.
    fn width(&self) -> usize;

    /// Returns the number of the window's columns in which a figure of `columns` columns is drawn.
    fn columns(&self, columns: f32) -> usize;

    /// Empties the window.
    fn clear(&mut self);

    /// Returns the area and first moment of the drawn figure.
    fn moments(&self) -> AreaMoments;

    /// Cuts the columns from `left` on out into `image`, and returns their area in the unit of
    /// [`Self::moments`].
    fn cut(&self, left: isize, image: &mut Self::Image) -> u64;
}

/// A window that draws figures of the type `F`.
pub trait Fill<F>: Pixels {
    /// Computes whatever does not depend on the placement of a figure, for at most
    /// [`crate::budget::VIEWS_AT_ONCE`] views.
    fn look(&mut self, _figure: &F, _views: &[RenderView]) {}

    /// Returns the rectangle that a figure takes in the image.
    fn extent(&mut self, figure: &F, camera: &Camera) -> Result<Extent, DrawError>;

    /// Draws a figure from one of the views given to [`Self::look`], with this number and camera,
    /// only into the leftmost `columns` columns. The last call of [`Self::extent`] must be for that
    /// view.
    fn draw(
        &mut self,
        figure: &F,
        camera: &Camera,
        view: usize,
        placement: &Placement,
        columns: usize,
    );
}

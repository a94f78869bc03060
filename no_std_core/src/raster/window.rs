//! What figures are drawn into, whatever carries their hulls and whatever fills their pixels.

use super::moments::AreaMoments;
use super::placement::{Extent, Placement};
use super::{DrawError, Rasterizer, RenderView};
use crate::camera::Camera;
use crate::silhouette::Size;
use glam::Vec3;

/// A body in a pose, as it lies in memory: [`crate::body::Figure`] or [`crate::lean::LeanFigure`].
pub trait PosedHulls {
    /// The points of each hull, metres.
    fn hulls(&self) -> impl Iterator<Item = impl Iterator<Item = Vec3>>;

    /// The rectangle that all of them take in the image.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    fn extent(&self, camera: &Camera) -> Result<Extent, DrawError>;
}

/// The pixels of a window, and the image that is cut out of them.
pub trait Pixels {
    /// What is drawn.
    type Image;

    /// Whether it draws outlines by facets.
    const NEEDS_FACETS: bool = true;

    /// Whether pixels of the image are more than on or off.
    const IS_GREY: bool = false;

    /// An image with nothing on.
    fn blank(&self) -> Self::Image;

    /// How pixels are decided.
    fn rasterizer(&self) -> Rasterizer;

    /// Rows and columns of the image.
    fn size(&self) -> Size;

    /// How many columns the window has.
    fn width(&self) -> usize;

    /// In how many of them a figure of so many is drawn.
    fn columns(&self, columns: f32) -> usize;

    /// Empties the window.
    fn clear(&mut self);

    /// Area and first moment of what was drawn.
    fn moments(&self) -> AreaMoments;

    /// The image's columns from `left` on; their area in the unit of [`Self::moments`].
    fn cut(&self, left: isize, image: &mut Self::Image) -> u64;
}

/// A window that bodies in poses are drawn into as they lie in memory: `F`.
pub trait Fill<F>: Pixels {
    /// Finds out what does not depend on where a figure is drawn, for at most
    /// [`crate::budget::VIEWS_AT_ONCE`] views.
    fn look(&mut self, _figure: &F, _views: &[RenderView]) {}

    /// The rectangle that a figure takes in the image.
    fn extent(&mut self, figure: &F, camera: &Camera) -> Result<Extent, DrawError>;

    /// Draws a figure as one of the views that it was looked at from sees it, into the leftmost
    /// `columns` and nothing else. Its extent in that view was asked for last.
    fn draw(&mut self, figure: &F, view: (&Camera, usize), placement: &Placement, columns: usize);
}

//! A window that keeps three by three samples a pixel as separate images.

use super::super::placement::{Extent, Placement};
use super::super::window::{Fill, Pixels};
use super::super::{DrawError, Rasterizer, RenderView, Simd};
use super::read::cut_images;
use super::{BitWindow, MAX_SAMPLES, Sampling};
use crate::body::Figure;
use crate::camera::Camera;
use crate::raster::moments::AreaMoments;
use crate::silhouette::{Silhouette, Size};

/// The window of [`Rasterizer::Rows3x3`] with nine separate images, one for each place of samples
/// in their pixels: the leftmost places first, from the top down. 34 kB.
///
/// Together they are an image of three times as many rows and columns, to which image effects can
/// be applied.
#[derive(Clone, Debug)]
pub struct SampleImages(BitWindow);

impl SampleImages {
    /// Makes an empty window that uses these registers.
    #[must_use]
    pub fn new(size: Size, simd: Simd) -> Self {
        Self(BitWindow::new(size, Sampling::ThreeByThree, simd))
    }
}

impl Pixels for SampleImages {
    type Image = [Silhouette; MAX_SAMPLES];
    const IS_GREY: bool = true;

    fn blank(&self) -> Self::Image {
        [Silhouette::empty(self.0.size); MAX_SAMPLES]
    }
    fn rasterizer(&self) -> Rasterizer {
        self.0.rasterizer()
    }
    fn size(&self) -> Size {
        self.0.size
    }
    fn width(&self) -> usize {
        self.0.width()
    }
    fn columns(&self, columns: f32) -> usize {
        self.0.columns(columns)
    }
    fn clear(&mut self) {
        self.0.clear();
    }
    fn moments(&self) -> AreaMoments {
        self.0.moments()
    }
    fn cut(&self, left: isize, images: &mut Self::Image) -> u64 {
        cut_images(&self.0, left, images);
        3 * images
            .iter()
            .map(|image| u64::from(image.area()))
            .sum::<u64>()
    }
}

impl<'a> Fill<Figure<'a>> for SampleImages {
    fn look(&mut self, figure: &Figure<'a>, views: &[RenderView]) {
        self.0.look(figure, views);
    }
    fn extent(&mut self, figure: &Figure<'a>, camera: &Camera) -> Result<Extent, DrawError> {
        Fill::extent(&mut self.0, figure, camera)
    }
    fn draw(
        &mut self,
        figure: &Figure<'a>,
        camera: &Camera,
        view: usize,
        placement: &Placement,
        columns: usize,
    ) {
        self.0.draw(figure, camera, view, placement, columns);
    }
}

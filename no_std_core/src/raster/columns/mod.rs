//! The column rasteriser: silhouettes at many elevations in one pass, column by column.
//!
//! With parallel rays, one azimuth and one scale, the image x of every point is the same at
//! all elevations. A hull is therefore cut once by the vertical plane through each column's
//! centre. The cut is a convex polygon; its corners lie where hull edges cross the plane, at
//! a height y and a depth w towards the camera. At elevation e a corner appears at
//! v = y cos e - w sin e, and the column's pixels that are on are those with centres between
//! the least and the greatest v: all elevations are computed together, one a lane.
//!
//! Only those of a hull's edges that can be outermost (about 4 above and 4 below, of 10) are cut,
//! only by planes that they cross, and without a branch on which these are.
//!
//! The conventions are those of the other rasterisers: a sample is on where `left < x <= right` and
//! `top < y <= bottom`. It does not work for perspective, roll, or a scale that changes with the
//! elevation. The method is ours.
//!
//! In perspective, with an eye at the distance d from the centre, the column at c metres is the
//! plane x d = c (d - w cos e - y sin e) (see [`crate::camera::Camera::project`]), which rotates
//! with the elevation unless c = 0. Each elevation would need cuts of its own for a single lane,
//! and elevations would share only the three coordinates of points. Bit rows draw such views.
//!
//! # Cost
//!
//! 19 hulls of 16 points, 48 rows tall, 19 elevations, drawn and counted: 171 ns a silhouette
//! with AVX-512, 473 with AVX2, 969 with SSE2, where bit rows take 1,134 and tiny-skia 23,456
//! (medians of `cargo bench --bench columns`, one core of a shared AMD EPYC).
//!
//! # Guarantees
//!
//! The bytes are the same with any [`Simd`], and at one elevation whatever others are drawn with
//! it: single-precision arithmetic, lane by lane, without fused operations. A hull that is a point
//! or a line draws nothing.
//!
//! ```
//! use edgegait_core::body::{Figure, UnpackedBody};
//! use edgegait_core::camera::Viewpoint;
//! use edgegait_core::raster::columns::{Azimuth, ColumnRenderer, ElevationImages, FigurePlace};
//! use edgegait_core::silhouette::Size;
//! use edgegait_core::skeleton::Joint;
//! use glam::{Vec2, Vec3};
//!
//! // A tetrahedron, 1 m wide, seen from the front: level, and from above.
//! let mut body = UnpackedBody::default();
//! body.push(Joint::Pelvis, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]).expect("within the budget");
//! let figure = Figure::at_rest(&body);
//! let elevations = [0.0, 90.0].map(|deg| Viewpoint::from_degrees(0.0, deg).expect("in range"));
//! let azimuth = Azimuth::new(&elevations).expect("one azimuth");
//! let place = FigurePlace {
//!     centre: Vec3::ZERO,
//!     pixels_per_metre: 10.25,
//!     jitter: Vec2::ZERO,
//! };
//! let mut images = ElevationImages::empty(Size::S50x30);
//! ColumnRenderer::new().draw(&figure, &azimuth, &place, &mut images).expect("a finite figure");
//! assert_eq!(images.rows(0, 15), 0b11_1111_1111 << 15); // 10 rows above the centre
//! assert_eq!(images.rows(1, 15), 0b11_1111_1111 << 25); // 10 below
//! ```

mod azimuth;
mod column;
mod section;

pub use azimuth::{Azimuth, AzimuthError};
pub(crate) use column::ImageColumn;

use super::framing::check_jitter;
use super::placement::as_pixels;
use super::{DrawError, check_scale};
use crate::body::Figure;
use crate::budget::{MAX_COLUMNS, MAX_REACH_PIXELS};
use crate::silhouette::{Silhouette, Size};
use crate::simd::{Simd, Wide, compiled, dispatch};
use glam::{Vec2, Vec3};
use section::{AzimuthPoints, Reach};

/// The placement of figures in images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FigurePlace {
    /// The point that appears in the middle of the image, metres.
    pub centre: Vec3,
    /// The scale, pixels per metre, above 0.
    pub pixels_per_metre: f32,
    /// The offset of samples from the pixels' centres, to the right and down, each within half a
    /// pixel.
    pub jitter: Vec2,
}

/// The images of one frame from one azimuth at all elevations. 12 kB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ElevationImages {
    size: Size,
    columns: [ImageColumn; MAX_COLUMNS],
    is_whole: bool,
}

impl ElevationImages {
    /// Makes empty images.
    #[must_use]
    pub const fn empty(size: Size) -> Self {
        Self {
            size,
            columns: [ImageColumn::EMPTY; MAX_COLUMNS],
            is_whole: true,
        }
    }

    /// Returns the size of each image.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Returns whether the whole figure is inside all images, judged by a bound that holds at every
    /// elevation.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Returns the pixels of one column at one elevation: bit `r` is row `r`, row 0 on top.
    #[must_use]
    pub fn rows(&self, elevation: usize, column: usize) -> u64 {
        self.columns()
            .get(column)
            .map_or(0, |it| it.rows(elevation))
    }

    /// Returns the silhouette at one elevation.
    #[must_use]
    pub fn silhouette(&self, elevation: usize) -> Silhouette {
        let mut silhouette = Silhouette::empty(self.size);
        for (column, it) in self.columns().iter().enumerate() {
            let bits = it.rows(elevation);
            for (row, out) in silhouette.all_rows_mut().iter_mut().enumerate() {
                *out |= (bits >> row & 1) << column;
            }
        }
        silhouette
    }

    /// Returns one column; there are as many as in the largest size.
    pub(crate) fn column(&self, column: usize) -> &ImageColumn {
        &self.columns[column % MAX_COLUMNS]
    }

    fn columns(&self) -> &[ImageColumn] {
        self.columns.get(..self.size.columns()).unwrap_or_default()
    }
}

/// A renderer that draws figures column by column and reuses its memory: 24 kB, and no heap.
#[derive(Clone, Debug)]
pub struct ColumnRenderer {
    simd: Simd,
    seen: AzimuthPoints,
}

impl Default for ColumnRenderer {
    fn default() -> Self {
        Self::new()
    }
}

impl ColumnRenderer {
    /// Makes a renderer that uses the widest registers of the processor.
    #[must_use]
    pub fn new() -> Self {
        Self::with_simd(Simd::widest())
    }

    /// Makes a renderer that uses these registers. Images do not depend on them.
    #[must_use]
    pub const fn with_simd(simd: Simd) -> Self {
        Self {
            simd,
            seen: AzimuthPoints::NOTHING,
        }
    }

    /// Draws `figure` into `images`, replacing their content.
    ///
    /// # Errors
    /// For figures without an image, and for figures that reach farther than [`MAX_REACH_PIXELS`]
    /// from the image's centre; see [`DrawError`].
    pub fn draw(
        &mut self,
        figure: &Figure<'_>,
        azimuth: &Azimuth,
        place: &FigurePlace,
        images: &mut ElevationImages,
    ) -> Result<(), DrawError> {
        check_jitter(place.jitter)?;
        check_scale(place.pixels_per_metre)?;
        if figure.is_empty() {
            return Err(DrawError::Empty);
        }
        let view = ColumnView::new(azimuth, place, images.size);
        let reach = dispatch!(self.simd, project(self, figure, &view));
        let reach = reach.ok_or(DrawError::NotFinite)?;
        let farthest = reach.across.max(reach.along);
        if farthest > MAX_REACH_PIXELS {
            return Err(DrawError::TooLarge(farthest));
        }
        images.is_whole = reach.across <= 0.5 * as_pixels(view.columns)
            && reach.along <= 0.5 * as_pixels(view.rows);
        dispatch!(self.simd, fill(self, figure, &view, images));
        Ok(())
    }
}

/// The parameters that do not depend on the figure.
struct ColumnView<'a> {
    azimuth: &'a Azimuth,
    place: &'a FigurePlace,
    /// Pixels to the right, and towards the camera, for each metre along x and z.
    right: Vec3,
    toward: Vec3,
    /// The image's centre, pixels to the right of its left side.
    left: f32,
    /// The number of row centres above the centre of the image, with a fraction.
    offset: f32,
    columns: usize,
    rows: usize,
}

impl<'a> ColumnView<'a> {
    fn new(azimuth: &'a Azimuth, place: &'a FigurePlace, size: Size) -> Self {
        let right = azimuth.right * place.pixels_per_metre;
        Self {
            azimuth,
            place,
            right,
            toward: section::toward(right),
            left: 0.5 * as_pixels(size.columns()) - place.jitter.x,
            offset: 0.5 * as_pixels(size.rows()) - place.jitter.y + 0.5,
            columns: size.columns(),
            rows: size.rows(),
        }
    }
}

compiled!(fn project(renderer: &mut ColumnRenderer, figure: &Figure<'_>, view: &ColumnView<'_>) -> Option<Reach>);
compiled!(fn fill(renderer: &mut ColumnRenderer, figure: &Figure<'_>, view: &ColumnView<'_>, images: &mut ElevationImages));

#[inline(always)]
fn project<L: Wide>(
    l: L,
    renderer: &mut ColumnRenderer,
    figure: &Figure<'_>,
    view: &ColumnView<'_>,
) -> Option<Reach> {
    renderer.seen.project(l, figure, view)
}

#[inline(always)]
fn fill<L: Wide>(
    l: L,
    renderer: &mut ColumnRenderer,
    figure: &Figure<'_>,
    view: &ColumnView<'_>,
    images: &mut ElevationImages,
) {
    for column in images.columns.iter_mut().take(view.columns) {
        *column = ImageColumn::EMPTY;
    }
    let toward = section::toward(view.azimuth.right);
    for (number, hull) in figure.hull_parts().enumerate() {
        let place = figure.places.get(number);
        let directions = [toward, Vec3::Y].map(|direction| place.direction(direction));
        renderer
            .seen
            .fill(l, &hull, directions, view, &mut images.columns);
    }
}

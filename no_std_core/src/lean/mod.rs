//! Drawing in a few kilobytes: hull by hull.
//!
//! [`crate::raster::Renderer`] is fast because it unpacks a body once and keeps everything
//! that poses and viewpoints share, 170 kB in all. A microcontroller has less than that. Here
//! nothing of a body is kept but its points, in whole steps (6 bytes a point), and which of
//! them are the corners of which facets (2 bytes a facet); everything else is found again for
//! each drawing. The arithmetic is the same, and so are the bytes of every silhouette
//! (`tests/lean.rs`). [`Budget`] says what a pack needs.
//!
//! ```
//! use edgegait_core::camera::{Camera, Framing, Viewpoint};
//! use edgegait_core::lean::{Body, GeiBuilder, Renderer, Rows};
//! use edgegait_core::pack::Pack;
//! use edgegait_core::pose::ModelPose;
//! use edgegait_core::silhouette::Size;
//! use glam::Vec2;
//!
//! /// Makes `pixels`, 1,500 bytes, the GEI of a pack's first walk, seen from the side.
//! fn side_view(bytes: &[u8], pixels: &mut [u8]) -> Option<()> {
//!     let pack = Pack::parse(bytes).ok()?;
//!     let walk = pack.walks().next()?;
//!     let avatar = pack.avatar(pack.subject(walk.subject)?.avatar)?;
//!     let cycle = pack.clip(walk.clip)?.as_loop()?;
//!     let skeleton = avatar.skeleton();
//!     let mut body = Body::<512, 1024>::EMPTY;
//!     body.load(&avatar).ok()?;
//!     let camera = Camera::orthographic(Viewpoint::from_degrees(90.0, 0.0).ok()?);
//!     let mut renderer = Renderer::<Rows>::new(Size::S50x30);
//!     let mut gei = GeiBuilder::new(Size::S50x30, pixels).ok()?;
//!     for frame in 0..32u8 {
//!         let pose = ModelPose::new(&skeleton, &cycle.pose(f32::from(frame) / 32.0));
//!         let drawing = renderer.draw(&body.posed(&pose), &camera, Framing::Height, Vec2::ZERO);
//!         gei.add(drawing.ok()?.silhouette).ok()?;
//!     }
//!     gei.finish();
//!     Some(())
//! }
//! assert_eq!(side_view(b"not a pack", &mut [0; 1500]), None);
//! ```

mod body;
mod budget;
mod gei;
mod rows;
#[cfg(feature = "skia")]
mod skia;

pub use body::{Body, Posed, Room};
pub use budget::Budget;
pub use gei::{BufferTooSmall, GeiBuilder};
pub use rows::Rows;
#[cfg(feature = "skia")]
pub use skia::Skia;

use crate::camera::{Camera, Framing};
use crate::raster::DrawError;
use crate::raster::framing::{self, Canvas, Moments, check_jitter};
use crate::raster::place::Placement;
use crate::silhouette::{Silhouette, Size};
use body::Sight;
use glam::Vec2;

/// A drawn figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing<'a> {
    /// The silhouette, which its renderer keeps until it draws the next one.
    pub silhouette: &'a Silhouette,
    /// As in [`crate::raster::Drawing`].
    pub clipped_share: f32,
}

/// What fills pixels: [`Rows`], or `Skia` with the feature of that name.
pub trait Window: fill::Fill {}

impl<W: fill::Fill> Window for W {}

/// Keeps what a window does to the crate.
mod fill {
    use super::{Moments, Placement, Sight, Silhouette, Size};

    pub trait Fill {
        fn new(size: Size) -> Self;

        /// Most bytes that it has on the heap at once.
        fn heap_bytes(size: Size) -> usize;

        /// Whether it draws outlines by facets.
        const NEEDS_FACETS: bool;

        /// How many columns it has.
        const WIDTH: usize;

        /// In how many of them a figure of so many is drawn.
        fn columns(columns: f32) -> usize;

        /// Draws a figure into the leftmost `columns`, and nothing else.
        fn draw(&mut self, sight: &Sight<'_>, placement: &Placement, columns: usize);

        /// Empties the window.
        fn clear(&mut self);

        /// Area and first moment of what was drawn.
        fn moments(&self) -> Moments;

        /// The image's columns from `left` on; their area in the unit of [`Self::moments`].
        fn cut(&self, left: isize, silhouette: &mut Silhouette) -> u64;
    }
}

/// Draws bodies in poses with one kind of window, in one size.
///
/// With [`Rows`] 2,072 bytes and no heap; with `Skia` 624, and [`Self::heap_bytes`]. Silhouettes and errors are those that
/// [`crate::raster::Renderer::draw`] makes of the same body, pose and camera.
#[derive(Debug)]
pub struct Renderer<W> {
    window: W,
    silhouette: Silhouette,
}

impl<W: Window> Renderer<W> {
    /// A renderer of this size; tiny-skia allocates its window.
    #[must_use]
    pub fn new(size: Size) -> Self {
        Self {
            window: W::new(size),
            silhouette: Silhouette::empty(size),
        }
    }

    /// Most bytes that it has on the heap at once, while one hull is filled; an allocator's own
    /// come on top.
    #[must_use]
    pub fn heap_bytes(size: Size) -> usize {
        W::heap_bytes(size)
    }

    /// Draws a body in a pose as `camera` sees it: [`crate::raster::Renderer::draw`].
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub fn draw(
        &mut self,
        posed: &Posed<'_>,
        camera: &Camera,
        framing: Framing,
        jitter: Vec2,
    ) -> Result<Drawing<'_>, DrawError> {
        check_jitter(jitter)?;
        // What is wrong with a figure is found out one point after another.
        let extent = posed.extent(camera);
        let extent = extent.map_or_else(|| framing::extent(posed.points(), camera), Ok)?;
        let mut sitting = Sitting {
            sight: Sight::new(posed, camera),
            window: &mut self.window,
            silhouette: &mut self.silhouette,
        };
        let clipped_share = framing::draw(&mut sitting, (camera, &extent), framing, jitter)?;
        Ok(Drawing {
            silhouette: &self.silhouette,
            clipped_share,
        })
    }
}

/// A figure before a camera, with what it is drawn on.
struct Sitting<'a, W> {
    sight: Sight<'a>,
    window: &'a mut W,
    silhouette: &'a mut Silhouette,
}

impl<W: Window> Canvas for Sitting<'_, W> {
    fn size(&self) -> Size {
        self.silhouette.size()
    }
    fn width(&self) -> usize {
        W::WIDTH
    }
    fn columns(&self, columns: f32) -> usize {
        W::columns(columns)
    }
    fn draw(&mut self, placement: &Placement, columns: usize) {
        self.window.draw(&self.sight, placement, columns);
    }
    fn clear(&mut self) {
        self.window.clear();
    }
    fn moments(&self) -> Moments {
        self.window.moments()
    }
    fn cut(&mut self, left: isize) -> u64 {
        self.window.cut(left, self.silhouette)
    }
}

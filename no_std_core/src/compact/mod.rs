//! Bodies in a few kilobytes, drawn hull by hull.
//!
//! [`crate::body::UnpackedBody`] is fast to draw because it is unpacked once and keeps everything
//! that poses and viewpoints share, 170 kB in all. A microcontroller has less than that. A
//! [`CompactBody`] keeps only its points, in whole steps (6 bytes a point), and the corners of its
//! facets (2 bytes a facet); everything else is computed again for each drawing. The same
//! [`crate::raster::Renderer`] draws it, into [`CompactRows`] or `raster::Skia`: the arithmetic is
//! the same, and so are the bytes of every silhouette (`tests/drawing/compact.rs`). [`Budget`]
//! computes what a pack needs.
//!
//! ```
//! use edgegait_core::camera::{Camera, Framing, Viewpoint};
//! use edgegait_core::glam::Vec2;
//! use edgegait_core::compact::{CompactBody, CompactRows};
//! use edgegait_core::pack::Pack;
//! use edgegait_core::pose::ModelPose;
//! use edgegait_core::raster::Renderer;
//! use edgegait_core::silhouette::Size;
//! use edgegait_core::template::GeiInPlace;
//!
//! /// Makes `pixels`, 1,500 bytes, the GEI of a pack's first walk, seen from the side.
//! fn side_view(bytes: &[u8], pixels: &mut [u8]) -> Option<()> {
//!     let pack = Pack::parse(bytes).ok()?;
//!     let walk = pack.walks().next()?;
//!     let avatar = pack.avatar(walk.avatar)?;
//!     let cycle = pack.clip(walk.clip)?.as_loop()?;
//!     let skeleton = avatar.skeleton();
//!     let mut body = CompactBody::<512, 1024>::EMPTY;
//!     body.load(&avatar).ok()?;
//!     let camera = Camera::orthographic(Viewpoint::from_degrees(90.0, 0.0).ok()?);
//!     let mut renderer = Renderer::with_window(CompactRows::new(Size::S50x30));
//!     let mut gei = GeiInPlace::new(Size::S50x30, pixels).ok()?;
//!     for frame in 0..32u8 {
//!         let pose = ModelPose::new(&skeleton, &cycle.pose(f32::from(frame) / 32.0));
//!         let drawing = renderer.draw(&body.posed(&pose), &camera, Framing::Height, Vec2::ZERO);
//!         gei.add(drawing.ok()?.frame).ok()?;
//!     }
//!     gei.finish();
//!     Some(())
//! }
//! assert_eq!(side_view(b"not a pack", &mut [0; 1500]), None);
//! ```

mod body;
mod budget;
mod rows;

pub use body::{CompactBody, CompactFigure, Room};
pub use budget::Budget;
pub use rows::CompactRows;

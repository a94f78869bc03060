//! Human gait silhouettes in bounded memory, with the same bytes on every target.
//!
//! A [`pack::Pack`] holds people: for each a body of convex hulls and gait cycles of a few hundred
//! bytes. The data flows one way to a Gait Energy Image, and each module uses only those before it:
//!
//! ```text
//! pack bytes -> pack -> clip (decode) -> pose -> body (hulls in a pose) -> camera
//!            -> raster -> silhouette -> template -> linear (the walker)
//! ```
//!
//! ```
//! use edgegait_core::body::{Figure, UnpackedBody};
//! use edgegait_core::camera::{Camera, Framing, Viewpoint};
//! use edgegait_core::glam::Vec2;
//! use edgegait_core::pack::Pack;
//! use edgegait_core::pose::ModelPose;
//! use edgegait_core::raster::{Rasterizer, Renderer};
//! use edgegait_core::silhouette::Size;
//! use edgegait_core::template::{Gei, GeiBuilder};
//!
//! /// The GEI of a pack's first walk, seen from the side.
//! fn side_view(bytes: &[u8]) -> Option<Gei> {
//!     let pack = Pack::parse(bytes).ok()?;
//!     let walk = pack.walks().next()?;
//!     let avatar = pack.avatar(walk.avatar)?;
//!     let cycle = pack.clip(walk.clip)?.as_loop()?;
//!     let (body, skeleton) = (UnpackedBody::new(&avatar), avatar.skeleton());
//!     let mut figure = Figure::at_rest(&body);
//!     let camera = Camera::orthographic(Viewpoint::from_degrees(90.0, 0.0).ok()?);
//!     let mut renderer = Renderer::new(Rasterizer::Rows, Size::S50x30);
//!     let mut gei = GeiBuilder::new(Size::S50x30);
//!     for frame in 0..32u8 {
//!         let pose = cycle.pose(f32::from(frame) / 32.0);
//!         figure.update(&ModelPose::new(&skeleton, &pose));
//!         let drawing = renderer.draw(&figure, &camera, Framing::Height, Vec2::ZERO).ok()?;
//!         gei.add(drawing.frame).ok()?;
//!     }
//!     Some(gei.gei())
//! }
//! assert_eq!(side_view(b"not a pack"), None);
//! ```
//!
//! [`cycle`] finds gait cycles in silhouettes, including those of a camera.
//!
//! The example takes 170 kB, which suits a host. A microcontroller draws the same bytes in 10 kB:
//! its body is a [`compact::CompactBody`], it draws into a [`compact::CompactRows`]
//! (`Renderer::with_window`), and the GEI lies in a buffer of the caller ([`template::GeiInPlace`]).
//! Everything else is the same.
//!
//! # Conventions
//!
//! Metres, seconds and radians (degrees only where a name says so). Y is up, the
//! walker faces and walks towards +Z, +X is the walker's left. Images are
//! `[row][column]`, row 0 on top, 50 rows by 30 columns or one of two larger
//! [`silhouette::Size`]s; a pixel is on if its centre is inside.
//!
//! # Guarantees
//!
//! - No panic, whatever the bytes and floats.
//! - No allocation of its own. Only tiny-skia allocates, at most [`budget::SKIA_HEAP_BYTES`].
//! - The same bytes on every target and with registers of any width: no fused multiply-add, and
//!   functions come from `libm`.
//! - `unsafe` only calls instructions that the processor was found to have, in `simd` alone.
#![no_std]
#![deny(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::panic))]

pub use glam;

pub mod avatar;
mod bit_adder;
pub mod bits;
pub mod body;
pub mod budget;
pub mod camera;
pub mod clip;
pub mod clothes;
pub mod codebook;
pub mod compact;
pub mod cycle;
mod entry_table;
pub mod facets;
pub mod format;
mod hull;
pub mod linear;
pub mod outline;
pub mod pack;
pub mod pose;
pub mod raster;
pub mod rotation;
pub mod silhouette;
mod simd;
pub mod skeleton;
pub mod template;

/// Compiles the example of the crate's README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

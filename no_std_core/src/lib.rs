//! Human gait silhouettes in bounded memory, with the same bytes on every target.
//!
//! A [`pack::Pack`] holds people: for each a body of convex hulls and gait cycles
//! of a few hundred bytes. From there to a Gait Energy Image the data flows one
//! way, each module using only those before it:
//!
//! ```text
//! pack bytes -> pack -> clip (decode) -> pose -> avatar (hulls) -> camera
//!            -> outline -> raster -> silhouette -> template
//! ```
//!
//! ```
//! # #[cfg(feature = "skia")] {
//! use edgegait_core::avatar::PosedHulls;
//! use edgegait_core::camera::{Camera, Viewpoint};
//! use edgegait_core::pack::Pack;
//! use edgegait_core::pose::ModelPose;
//! use edgegait_core::raster::{Rasterizer, Renderer};
//! use edgegait_core::template::{Gei, GeiBuilder};
//!
//! /// The GEI of a pack's first walk, seen from the side.
//! fn side_view(bytes: &[u8]) -> Option<Gei> {
//!     let pack = Pack::parse(bytes).ok()?;
//!     let walk = pack.walks().next()?;
//!     let avatar = pack.avatar(pack.subject(walk.subject)?.avatar)?;
//!     let cycle = pack.clip(walk.clip)?.as_loop()?;
//!     let camera = Camera::orthographic(Viewpoint::from_degrees(90.0, 0.0).ok()?);
//!     let mut renderer = Renderer::new(Rasterizer::Skia);
//!     let mut gei = GeiBuilder::new();
//!     for frame in 0..32u8 {
//!         let pose = cycle.pose(f32::from(frame) / 32.0);
//!         let model = ModelPose::new(&avatar.skeleton(), &pose);
//!         let figure = PosedHulls::new(&avatar, &model);
//!         gei.add(&renderer.draw(&figure, &camera).ok()?.frame);
//!     }
//!     Some(gei.finish())
//! }
//! assert_eq!(side_view(b"not a pack"), None);
//! # }
//! ```
//!
//! # Conventions
//!
//! Metres, seconds and radians (degrees only where a name says so). Y is up, the
//! walker faces and walks towards +Z, +X is the walker's left. Images are
//! `[row][column]`, row 0 on top, 50 rows by 30 columns; a pixel is on if its
//! centre is inside.
//!
//! # Guarantees
//!
//! No panic on any bytes and any floats, no `unsafe`, no allocation of its own
//! (tiny-skia allocates: at most [`budget::SKIA_HEAP_BYTES`]), and the same bytes
//! on every target: all arithmetic is scalar, without fused multiply-add, and
//! functions come from `libm`.
#![no_std]
#![deny(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::panic))]

pub mod avatar;
pub mod bits;
pub mod budget;
pub mod camera;
pub mod clip;
pub mod codebook;
pub mod format;
mod hull;
pub mod outline;
pub mod pack;
pub mod pose;
#[cfg(feature = "skia")]
pub mod raster;
pub mod rotation;
pub mod silhouette;
pub mod skeleton;
mod table;
pub mod template;

/// Compiles the example of the crate's README.
#[cfg(all(doctest, feature = "skia"))]
#[doc = include_str!("../README.md")]
struct Readme;

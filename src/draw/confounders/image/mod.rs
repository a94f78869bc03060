//! Confounders that act on the image: shadows, occluders, lenses, sensors and segmentation faults.
//!
//! A figure is first rendered into a [`Fine`] picture, with 3x3 samples for each pixel of its
//! silhouette. Shadows join it, occluders are removed from it, effects act on it, and then it is
//! framed:
//!
//! ```text
//! let fine = Fine::lay_out(&figure, &[&shadow], view, size)?;
//! let (mut picture, before) = fine.draw_figure(&mut renderer, &figure)?;
//! picture.join(&fine.draw(&mut renderer, &shadow)?);
//! picture.remove(&fine.draw(&mut renderer, &occluder)?);
//! erode(&mut picture, &fine, strength, &mut rng);
//! let framed = fine.frame(&picture, before);
//! ```
//!
//! An unchanged picture becomes the silhouette that the core renders directly.

mod counts;
mod distortion;
mod exposure;
mod faults;
mod fine;
mod frame;
mod light;
mod morphology;
mod occluder;
mod phases;
mod picture;
mod resolution;
mod shadow;
#[cfg(test)]
mod tests;
mod warp;
mod waver;

pub(crate) use distortion::distort;
#[cfg(feature = "plots")]
pub(crate) use distortion::straightened;
pub(crate) use faults::{filtered_noise, holes, merged_background, missing_part, salt_and_pepper};
pub(crate) use fine::{Fine, FineRenderer};
pub(crate) use frame::Framed;
pub(crate) use light::Light;
pub(crate) use morphology::{dilate, erode};
pub(crate) use occluder::{Crossing, Pillar};
pub(crate) use picture::BitPicture;
pub(crate) use resolution::{coarsen, to_cells};
pub(crate) use shadow::{Floor, Sun, shadow_body};
pub(crate) use waver::waver;

//! The reasons why a figure cannot be drawn.

use crate::budget::{MAX_FIGURE_COLUMNS, MAX_REACH_PIXELS};
use crate::camera::NEAR_M;
use core::fmt;
use glam::Vec2;

/// The reason why a figure cannot be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DrawError {
    /// The figure has no points.
    Empty,
    /// A point of the figure is not finite, or so far away that its projection is not.
    NotFinite,
    /// A point lies this many metres in front of the camera's eye, or behind it.
    TooNear(f32),
    /// The figure has no height from this viewpoint, or no width if it is to be stretched to its
    /// box, so that no scale fills the image.
    Flat,
    /// The figure would be this many columns wide; at most 2,048 are drawn.
    TooWide(f32),
    /// A part of the figure would lie this many pixels from the image's upper left corner, and
    /// another part inside the image.
    TooLarge(f32),
    /// The figure is so thin that no sample falls inside it.
    Vanished,
    /// A fixed framing has this scale, pixels a metre, which is not a number above 0.
    Scale(f32),
    /// The samples would be moved by more than half a pixel.
    Jitter(Vec2),
}

impl fmt::Display for DrawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("the figure has no points"),
            Self::NotFinite => f.write_str("a point of the figure is not finite"),
            Self::TooNear(depth_m) => write!(
                f,
                "a point of the figure lies {depth_m} m in front of the camera, expected at least {NEAR_M} (move the camera away)"
            ),
            Self::Flat => f.write_str("the figure has no height or no width from this viewpoint"),
            Self::TooWide(columns) => write!(
                f,
                "the figure is {columns} columns wide at its full height, expected at most {MAX_FIGURE_COLUMNS}"
            ),
            Self::TooLarge(pixels) => write!(
                f,
                "the figure reaches {pixels} pixels away from the image that it is partly in, expected at most {MAX_REACH_PIXELS} (move the camera away, or use a smaller scale)"
            ),
            Self::Vanished => f.write_str("the figure is too thin for any sample to fall inside"),
            Self::Scale(found) => {
                write!(
                    f,
                    "a scale of {found} pixels a metre: expected a number above 0"
                )
            }
            Self::Jitter(found) => write!(
                f,
                "samples moved by {found} pixels: expected -0.5 to 0.5 to the right and down"
            ),
        }
    }
}

impl core::error::Error for DrawError {}

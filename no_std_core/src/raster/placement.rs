//! Placement of figures by framings, independent of the rasteriser.

use super::{DrawError, check_scale};
use crate::budget::{MAX_FIGURE_COLUMNS, MAX_REACH_PIXELS, WINDOW_COLUMNS};
use crate::silhouette::Size;
use glam::Vec2;

/// The greatest factor by which a part of a figure is enlarged to measure it: parts that are then
/// thinner than a sample are a thousandth of a pixel.
const MAX_GROWTH: f32 = 1_024.0;

/// The map from metres in the image, which [`projected`](super::projected) returns, to pixels, with
/// y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Pixels per metre, to the right and down.
    pub scale: Vec2,
    /// An image point, metres to the right and up.
    pub origin: Vec2,
    /// The pixel coordinates on which the origin falls.
    pub at: Vec2,
}

impl Placement {
    /// Returns the pixel coordinates of an image point: x to the right, y down. Pixel `(c, r)`
    /// covers `c..c+1` by `r..r+1`.
    #[must_use]
    pub fn place(&self, point: Vec2) -> Vec2 {
        Vec2::new(
            (point.x - self.origin.x) * self.scale.x + self.at.x,
            (self.origin.y - point.y) * self.scale.y + self.at.y,
        )
    }

    /// Returns the part of `extent` that falls within this many columns and rows.
    pub(crate) fn shown(&self, extent: &Extent, pixels: Vec2) -> Extent {
        let corner = |x: f32, y: f32| {
            let metres = (Vec2::new(x, y) - self.at) / self.scale;
            self.origin + Vec2::new(metres.x, -metres.y)
        };
        Extent {
            min: extent.min.max(corner(0.0, pixels.y)),
            max: extent.max.min(corner(pixels.x, 0.0)),
        }
    }

    /// Returns the placement in a window, or for samples, this many pixels further right and down.
    #[must_use]
    pub(crate) fn moved(&self, pixels: Vec2) -> Self {
        Self {
            at: self.at - pixels,
            ..*self
        }
    }
}

/// The rectangle that a figure takes in the image, metres to the right and up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Leftmost and lowest.
    pub min: Vec2,
    /// Rightmost and highest.
    pub max: Vec2,
}

impl Extent {
    /// No rectangle.
    pub(crate) const NONE: Self = Self {
        min: Vec2::INFINITY,
        max: Vec2::NEG_INFINITY,
    };

    /// Returns the width, metres.
    #[must_use]
    pub fn width(&self) -> f32 {
        self.max.x - self.min.x
    }

    /// Returns the height, metres.
    #[must_use]
    pub fn height(&self) -> f32 {
        self.max.y - self.min.y
    }
}

/// Returns the placement that makes a figure of this extent fill the rows and centres it in a row
/// of windows of at most `limit` columns, the number of windows, and their columns, which `columns`
/// returns for the figure's width.
pub fn by_height(
    extent: &Extent,
    size: Size,
    limit: usize,
    columns: impl Fn(f32) -> usize,
) -> Result<(Placement, usize, usize), DrawError> {
    let scale = as_pixels(size.rows()) / extent.height();
    if !scale.is_finite() {
        return Err(DrawError::Flat);
    }
    let width = extent.width() * scale;
    let limit = as_pixels(limit);
    if width.is_nan() || width > as_pixels(MAX_FIGURE_COLUMNS) {
        return Err(DrawError::TooWide(width));
    }
    let mut windows = 1;
    while as_pixels(windows) * limit < width {
        windows += 1;
    }
    let columns = columns(width);
    let placement = Placement {
        scale: Vec2::splat(scale),
        origin: Vec2::new(0.5 * (extent.min.x + extent.max.x), extent.max.y),
        at: Vec2::new(0.5 * as_pixels(columns * windows), 0.0),
    };
    Ok((placement, windows, columns))
}

/// Returns the placement that stretches a figure of this extent to this many columns and rows.
pub fn stretched(extent: &Extent, pixels: Vec2) -> Result<Placement, DrawError> {
    let size = Vec2::new(extent.width(), extent.height());
    if !size.is_finite() {
        return Err(DrawError::NotFinite);
    }
    let scale = pixels / size;
    if !scale.is_finite() {
        return Err(DrawError::Flat);
    }
    Ok(Placement {
        scale,
        origin: Vec2::new(extent.min.x, extent.max.y),
        at: Vec2::ZERO,
    })
}

/// Returns a placement in which `part` fills this many columns and rows, enlarged by at most
/// [`MAX_GROWTH`] compared to `placement`.
pub fn enlarged(part: &Extent, placement: &Placement, pixels: Vec2) -> Placement {
    let size = Vec2::new(part.width(), part.height());
    Placement {
        scale: (pixels / size).min(MAX_GROWTH * placement.scale),
        origin: Vec2::new(part.min.x, part.max.y),
        at: Vec2::ZERO,
    }
}

/// Returns the placement that shows the image point `centre` in the middle of the image.
pub fn fixed(centre: Vec2, pixels_per_metre: f32, image: Vec2) -> Result<Placement, DrawError> {
    check_scale(pixels_per_metre)?;
    Ok(Placement {
        scale: Vec2::splat(pixels_per_metre),
        origin: centre,
        at: 0.5 * image,
    })
}

/// The relation of a figure's rectangle to the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtentPlace {
    /// Wholly inside the image.
    Inside,
    /// Partly inside, as far as the rectangle shows.
    Across,
    /// Wholly outside.
    Outside,
}

/// Returns where a placed figure of this extent lies in an image of this many columns and rows.
pub fn spread(
    extent: &Extent,
    placement: &Placement,
    image: Vec2,
) -> Result<ExtentPlace, DrawError> {
    let upper_left = placement.place(Vec2::new(extent.min.x, extent.max.y));
    let lower_right = placement.place(Vec2::new(extent.max.x, extent.min.y));
    if upper_left.cmpge(image).any() || lower_right.cmple(Vec2::ZERO).any() {
        return Ok(ExtentPlace::Outside);
    }
    if upper_left.cmpge(Vec2::ZERO).all() && lower_right.cmple(image).all() {
        return Ok(ExtentPlace::Inside);
    }
    let reach = upper_left.abs().max(lower_right.abs()).max_element();
    if reach <= MAX_REACH_PIXELS {
        Ok(ExtentPlace::Across)
    } else {
        Err(DrawError::TooLarge(reach))
    }
}

/// Returns the columns of the window of bit rows in which a figure of this many columns is drawn:
/// whole words.
pub fn row_columns(columns: f32) -> usize {
    // A column on each side allows for rounding.
    match columns + 2.0 {
        narrow if narrow <= 32.0 => 32,
        middle if middle <= 64.0 => 64,
        _ => WINDOW_COLUMNS,
    }
}

/// Returns where the `N` samples of a pixel lie along an axis.
pub const fn places<const N: usize>() -> [f32; N] {
    let (mut places, mut number) = ([0.0; N], 0);
    while number < N {
        places[number] = as_pixels(2 * number + 1) / as_pixels(2 * N);
        number += 1;
    }
    places
}

/// Converts a small count to pixels.
pub const fn as_pixels(count: usize) -> f32 {
    #[expect(clippy::cast_precision_loss, reason = "at most a few thousand")]
    let pixels = count as f32;
    pixels
}

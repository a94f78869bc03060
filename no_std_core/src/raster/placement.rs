//! Where framings place a figure, whatever fills its pixels.

use super::{DrawError, check_scale};
use crate::budget::{MAX_FIGURE_COLUMNS, MAX_REACH_PIXELS, WINDOW_COLUMNS};
use crate::silhouette::Size;
use glam::Vec2;

/// How many times as large a part of a figure is drawn to measure it, at most: what is then
/// thinner than a sample is a thousandth of a pixel.
const MAX_GROWTH: f32 = 1_024.0;

/// From metres in the image, which [`projected`](super::projected) gives, to pixels, y turned
/// downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Pixels a metre, to the right and down.
    pub scale: Vec2,
    /// An image point, metres to the right and up.
    pub origin: Vec2,
    /// The pixel coordinates on which the origin falls.
    pub at: Vec2,
}

impl Placement {
    /// The pixel coordinates of an image point: x to the right, y down, pixel
    /// `(c, r)` covers `c..c+1` by `r..r+1`.
    #[must_use]
    pub fn place(&self, point: Vec2) -> Vec2 {
        Vec2::new(
            (point.x - self.origin.x) * self.scale.x + self.at.x,
            (self.origin.y - point.y) * self.scale.y + self.at.y,
        )
    }

    /// The part of `extent` that falls within so many columns and rows.
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

    /// The same placement seen from a window, or sampled at points, this many pixels further
    /// right and down.
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
    /// Width, metres.
    #[must_use]
    pub fn width(&self) -> f32 {
        self.max.x - self.min.x
    }

    /// Height, metres.
    #[must_use]
    pub fn height(&self) -> f32 {
        self.max.y - self.min.y
    }
}

/// The placement that makes a figure of this extent fill the rows and centres it in a row
/// of windows of at most `limit` columns, how many windows that takes, and how many columns of
/// them: what `columns` says of a figure of so many.
pub fn by_height(
    extent: &Extent,
    size: Size,
    (limit, columns): (usize, impl Fn(f32) -> usize),
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

/// The placement that stretches a figure of this extent to so many columns and rows.
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

/// A placement in which `part` fills so many columns and rows, unless it is larger than
/// [`MAX_GROWTH`] times `placement`.
pub fn enlarged(part: &Extent, placement: &Placement, pixels: Vec2) -> Placement {
    let size = Vec2::new(part.width(), part.height());
    Placement {
        scale: (pixels / size).min(MAX_GROWTH * placement.scale),
        origin: Vec2::new(part.min.x, part.max.y),
        at: Vec2::ZERO,
    }
}

/// The placement that shows the image point `centre` in the middle of the image.
pub fn fixed(centre: Vec2, pixels_per_metre: f32, image: Vec2) -> Result<Placement, DrawError> {
    check_scale(pixels_per_metre)?;
    Ok(Placement {
        scale: Vec2::splat(pixels_per_metre),
        origin: centre,
        at: 0.5 * image,
    })
}

/// Where a figure's rectangle lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtentPlace {
    /// Wholly inside of the image.
    Inside,
    /// Partly inside, as far as the rectangle tells.
    Across,
    /// Wholly outside.
    Outside,
}

/// Where a placed figure of this extent lies, in an image of so many columns and rows.
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

/// Columns of a window of bit rows that a figure of so many columns is drawn in: whole words.
pub fn row_columns(columns: f32) -> usize {
    // A column on each side for what rounding adds.
    match columns + 2.0 {
        narrow if narrow <= 32.0 => 32,
        middle if middle <= 64.0 => 64,
        _ => WINDOW_COLUMNS,
    }
}

/// Where the `N` samples of a pixel lie along an axis.
pub const fn places<const N: usize>() -> [f32; N] {
    let (mut places, mut number) = ([0.0; N], 0);
    while number < N {
        places[number] = as_pixels(2 * number + 1) / as_pixels(2 * N);
        number += 1;
    }
    places
}

/// A small count as pixels.
pub const fn as_pixels(count: usize) -> f32 {
    #[expect(clippy::cast_precision_loss, reason = "at most a few thousand")]
    let pixels = count as f32;
    pixels
}

//! From posed hulls to a silhouette: framing, outlines, rasteriser.
//!
//! Framing is part of the projection: the figure is drawn once, at the size of
//! the silhouette, and nothing is resampled.

mod skia;

use crate::avatar::PosedHulls;
use crate::budget::{COLUMNS, MAX_WINDOWS, PIXELS, ROWS, WINDOW_COLUMNS};
use crate::camera::{Camera, Extent, Placement};
use crate::outline::{clipped, convex};
use crate::silhouette::{Coverage, Frame};
use core::fmt;
use glam::Vec2;
use skia::Window;

/// How pixels are decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rasterizer {
    /// tiny-skia without anti-aliasing: one sample at the pixel's centre, after
    /// coordinates were cut to 1/64 pixel (0.6-0.8 % of on-pixels differ from exact
    /// sampling).
    Skia,
    /// tiny-skia with anti-aliasing: 4x4 samples a pixel, hull by hull, so that
    /// two hulls which cover parts of one pixel blend instead of adding up.
    SkiaAa,
}

impl Rasterizer {
    /// All rasterisers.
    pub const ALL: [Self; 2] = [Self::Skia, Self::SkiaAa];

    /// The name under which results state it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Skia => "skia",
            Self::SkiaAa => "skia-aa",
        }
    }
}

impl fmt::Display for Rasterizer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A drawn figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing {
    /// The silhouette.
    pub frame: Frame,
    /// The share of the figure's area that lies left or right of the 30 columns, 0..=1.
    pub clipped_share: f32,
}

/// Why a figure cannot be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DrawError {
    /// The figure has no points.
    Empty,
    /// A point of the figure is not finite, or so far away that its projection is not.
    NotFinite,
    /// The figure has no height from this viewpoint, so that no scale fills 50 rows.
    Flat,
    /// The figure would be this many columns wide; at most 16 windows of 128 are drawn.
    TooWide(f32),
    /// The figure is so thin that no sample falls inside it.
    Vanished,
}

impl fmt::Display for DrawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("the figure has no points"),
            Self::NotFinite => f.write_str("a point of the figure is not finite"),
            Self::Flat => f.write_str("the figure has no height from this viewpoint"),
            Self::TooWide(columns) => write!(
                f,
                "the figure is {columns} columns wide at a height of {ROWS} rows, expected at most {}",
                MAX_WINDOWS * WINDOW_COLUMNS
            ),
            Self::Vanished => f.write_str("the figure is too thin for any sample to fall inside"),
        }
    }
}

impl core::error::Error for DrawError {}

/// Draws figures with one rasteriser, reusing its memory.
///
/// Holds [`crate::budget::SKIA_RESIDENT_BYTES`] of heap from the first figure on (its
/// window of 6,400 bytes from the start), and takes and gives back at most
/// [`crate::budget::SKIA_TRANSIENT_BYTES`] while it draws.
#[derive(Debug)]
pub struct Renderer {
    rasterizer: Rasterizer,
    window: Window,
}

impl Renderer {
    /// A renderer; allocates its window.
    #[must_use]
    pub fn new(rasterizer: Rasterizer) -> Self {
        Self {
            rasterizer,
            window: Window::new(rasterizer == Rasterizer::SkiaAa),
        }
    }

    /// The rasteriser in use.
    #[must_use]
    pub const fn rasterizer(&self) -> Rasterizer {
        self.rasterizer
    }

    /// Draws `figure` as `camera` sees it, framed by height: scaled so that it
    /// fills 50 rows, and shifted by whole columns so that its centroid (pixel
    /// centres at i + 0.5, rounded half up) lands on x = 15. What then lies outside
    /// of the 30 columns is cut away, and its share reported.
    ///
    /// # Errors
    /// For figures without an image; see [`DrawError`].
    pub fn draw(&mut self, figure: &PosedHulls, camera: &Camera) -> Result<Drawing, DrawError> {
        if figure.points().is_empty() {
            return Err(DrawError::Empty);
        }
        let image_points = figure.points().iter().map(|&point| camera.project(point));
        let extent = Extent::of(image_points).ok_or(DrawError::NotFinite)?;
        let (placement, windows) = place_by_height(&extent)?;

        let mut moments = Moments::default();
        for index in 0..windows {
            let left = index * WINDOW_COLUMNS;
            self.fill(figure, camera, &placement.shifted(as_pixels(left)));
            moments.add(self.window.pixels(), left);
        }
        if moments.sum == 0 {
            return Err(DrawError::Vanished);
        }
        let mut left = moments.centroid_column() - as_signed(COLUMNS / 2);
        if windows > 1 {
            #[expect(clippy::cast_precision_loss, reason = "a few thousand columns")]
            let shift = left as f32;
            self.fill(figure, camera, &placement.shifted(shift));
            left = 0;
        }
        let coverage = cut_columns(self.window.pixels(), left);
        let kept: u64 = coverage.pixels.iter().map(|&pixel| u64::from(pixel)).sum();
        #[expect(clippy::cast_precision_loss, reason = "a share")]
        let clipped_share = 1.0 - (kept as f32 / moments.sum as f32).min(1.0);
        let frame = match self.rasterizer {
            Rasterizer::Skia => Frame::Binary(coverage.to_silhouette()),
            Rasterizer::SkiaAa => Frame::Grey(coverage),
        };
        Ok(Drawing {
            frame,
            clipped_share,
        })
    }

    /// Draws the figure's hulls into the window.
    fn fill(&mut self, figure: &PosedHulls, camera: &Camera, placement: &Placement) {
        // One pixel of margin, so that the cut itself is never seen.
        let min = Vec2::splat(-1.0);
        let max = Vec2::new(as_pixels(WINDOW_COLUMNS + 1), as_pixels(ROWS + 1));
        self.window.clear();
        for hull in figure.hulls() {
            let pixels = hull
                .iter()
                .map(|&point| placement.place(camera.project(point)));
            self.window.fill(&clipped(&convex(pixels), min, max));
        }
    }
}

/// The placement that makes a figure of this extent 50 rows high and centres it
/// in a row of windows, and how many windows that takes.
fn place_by_height(extent: &Extent) -> Result<(Placement, usize), DrawError> {
    let scale = as_pixels(ROWS) / extent.height();
    if !scale.is_finite() {
        return Err(DrawError::Flat);
    }
    let columns = extent.width() * scale;
    let limit = as_pixels(WINDOW_COLUMNS);
    if columns.is_nan() || columns > limit * as_pixels(MAX_WINDOWS) {
        return Err(DrawError::TooWide(columns));
    }
    let mut windows = 1;
    while as_pixels(windows) * limit < columns {
        windows += 1;
    }
    let placement = Placement {
        scale,
        origin: Vec2::new(0.5 * (extent.min.x + extent.max.x), extent.max.y),
        column: 0.5 * limit * as_pixels(windows),
    };
    Ok((placement, windows))
}

/// Area and first moment of a figure over its windows' columns.
#[derive(Default)]
struct Moments {
    sum: u64,
    /// Sum of coverage times (2 * column + 1): twice the pixel centres, in integers.
    doubled: u64,
}

impl Moments {
    /// Adds a window whose first column is column `left` of the row of windows.
    fn add(&mut self, pixels: &[u8], left: usize) {
        // Sums of columns first: additions of whole rows vectorise.
        let mut columns = [0u32; WINDOW_COLUMNS];
        for row in pixels.chunks_exact(WINDOW_COLUMNS) {
            for (sum, &pixel) in columns.iter_mut().zip(row) {
                *sum += u32::from(pixel);
            }
        }
        for (column, &sum) in columns.iter().enumerate() {
            self.sum += u64::from(sum);
            self.doubled += u64::from(sum) * (2 * (left + column) + 1) as u64;
        }
    }

    /// The centroid's x, rounded half up.
    fn centroid_column(&self) -> isize {
        let rounded = (self.doubled + self.sum) / (2 * self.sum);
        isize::try_from(rounded).unwrap_or(0)
    }
}

/// The 30 columns from `left` on; columns outside of the window are empty.
fn cut_columns(window: &[u8], left: isize) -> Coverage {
    let mut coverage = Coverage {
        pixels: [0; PIXELS],
    };
    let rows = window.chunks_exact(WINDOW_COLUMNS);
    for (row, out) in rows.zip(coverage.pixels.chunks_exact_mut(COLUMNS)) {
        for (column, pixel) in out.iter_mut().enumerate() {
            let source = usize::try_from(left + as_signed(column)).ok();
            *pixel = source.and_then(|at| row.get(at)).copied().unwrap_or(0);
        }
    }
    coverage
}

/// A small count as pixels.
const fn as_pixels(count: usize) -> f32 {
    #[expect(clippy::cast_precision_loss, reason = "at most a few thousand")]
    let pixels = count as f32;
    pixels
}

/// A small count as a signed number.
const fn as_signed(count: usize) -> isize {
    count.cast_signed()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Viewpoint;
    use glam::Vec3;

    fn front() -> Camera {
        Camera::orthographic(Viewpoint::from_degrees(0.0, 0.0).expect("a viewpoint"))
    }

    /// An axis-parallel box, metres.
    fn slab(min: [f32; 3], max: [f32; 3]) -> [Vec3; 8] {
        core::array::from_fn(|corner| {
            Vec3::from_array(core::array::from_fn(|axis| {
                if corner >> axis & 1 == 1 {
                    max[axis]
                } else {
                    min[axis]
                }
            }))
        })
    }

    fn figure(hulls: &[[Vec3; 8]]) -> PosedHulls {
        let mut figure = PosedHulls::default();
        for hull in hulls {
            figure.push(*hull).expect("within the budget");
        }
        figure
    }

    fn silhouette(figure: &PosedHulls) -> crate::silhouette::Silhouette {
        let drawing = Renderer::new(Rasterizer::Skia).draw(figure, &front());
        drawing.expect("a figure").frame.silhouette()
    }

    #[test]
    fn a_box_fills_its_rows_and_is_centred() {
        // 0.4 m by 2 m: 25 px a metre, so 10 columns, 10..20.
        let row = silhouette(&figure(&[slab([3.0, 0.0, 0.0], [3.4, 2.0, 0.3])]));
        assert!(row.rows().iter().all(|&bits| bits == 0b11_1111_1111 << 10));
    }

    #[test]
    fn the_picture_does_not_depend_on_where_the_figure_stands_or_how_large_it_is() {
        let at_origin = figure(&[
            slab([-0.2, 0.0, 0.0], [0.2, 2.0, 0.3]),
            slab([0.2, 1.0, 0.0], [0.5, 1.2, 0.3]),
        ]);
        let mut elsewhere = PosedHulls::default();
        for hull in at_origin.hulls() {
            elsewhere
                .push(hull.iter().map(|&p| p * 0.5 + Vec3::new(64.0, 8.0, -4.0)))
                .expect("within the budget");
        }
        assert_eq!(silhouette(&at_origin), silhouette(&elsewhere));
    }

    #[test]
    fn what_is_cut_away_is_reported() {
        // 60 columns wide: half of it lies outside of the 30.
        let wide = figure(&[slab([0.0, 0.0, 0.0], [2.4, 2.0, 0.3])]);
        let drawing = Renderer::new(Rasterizer::Skia).draw(&wide, &front());
        let drawing = drawing.expect("a figure");
        assert!((drawing.clipped_share - 0.5).abs() < 1e-6);
        assert_eq!(drawing.frame.silhouette().area(), 1_500);
    }

    #[test]
    fn a_figure_wider_than_the_window_is_measured_in_several() {
        // 40 m by 2 m: 1,000 columns, of which 30 are kept.
        let wide = figure(&[slab([0.0, 0.0, 0.0], [40.0, 2.0, 0.3])]);
        let drawing = Renderer::new(Rasterizer::Skia).draw(&wide, &front());
        let drawing = drawing.expect("a figure");
        assert!((drawing.clipped_share - 0.97).abs() < 1e-3);
        assert_eq!(drawing.frame.silhouette().area(), 1_500);
        let wider = figure(&[slab([0.0, 0.0, 0.0], [90.0, 2.0, 0.3])]);
        let refused = Renderer::new(Rasterizer::Skia).draw(&wider, &front());
        assert_eq!(refused, Err(DrawError::TooWide(2_250.0)));
    }

    #[test]
    fn overlapping_hulls_do_not_cancel() {
        let body = slab([-0.2, 0.0, 0.0], [0.2, 2.0, 0.3]);
        let mirrored = body.map(|p| Vec3::new(-p.x, p.y, p.z));
        assert_eq!(
            silhouette(&figure(&[body, mirrored])),
            silhouette(&figure(&[body]))
        );
    }

    #[test]
    fn anti_aliasing_tells_how_much_is_covered() {
        // 10.5 columns: centred, the outer columns are covered by a quarter.
        let body = figure(&[slab([0.0, 0.0, 0.0], [0.42, 2.0, 0.3])]);
        let drawing = Renderer::new(Rasterizer::SkiaAa).draw(&body, &front());
        let Frame::Grey(coverage) = drawing.expect("a figure").frame else {
            panic!("anti-aliasing draws grey");
        };
        let total: u32 = coverage.pixels.iter().map(|&p| u32::from(p)).sum();
        let columns = f64::from(total) / 255.0 / 50.0;
        assert!((columns - 10.5).abs() < 0.05, "{columns}");
    }

    #[test]
    fn what_has_no_image_is_a_typed_error() {
        let mut renderer = Renderer::new(Rasterizer::Skia);
        let mut draw = |figure: &PosedHulls| renderer.draw(figure, &front());
        assert_eq!(draw(&PosedHulls::default()), Err(DrawError::Empty));
        assert_eq!(draw(&figure(&[[Vec3::ONE; 8]])), Err(DrawError::Flat));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for axis in 0..3 {
                let mut hull = slab([0.0; 3], [1.0; 3]);
                hull[5][axis] = bad;
                assert_eq!(draw(&figure(&[hull])), Err(DrawError::NotFinite));
            }
        }
        let huge = figure(&[slab([-1e38; 3], [1e38; 3])]);
        assert!(draw(&huge).is_ok_and(|d| d.frame.silhouette().area() == 1_500));
        let overflowing = figure(&[slab([-3e38; 3], [3e38; 3])]);
        assert!(draw(&overflowing).is_err());
        let needle = figure(&[slab([0.0; 3], [1e-6, 1.0, 0.0])]);
        assert_eq!(draw(&needle), Err(DrawError::Vanished));
    }
}

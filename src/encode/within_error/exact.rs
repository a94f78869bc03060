//! Silhouettes by exact coverage: the reference for every configuration.
//!
//! The renderer uses `f64` throughout and 16x16 samples per pixel, and is independent of the
//! core's rasterisers, which are under test. It follows the same definition of the image: an
//! orthographic view, framed by height.

use crate::error::{Result, SweepError};
use edgegait_core::camera::Viewpoint;
use edgegait_core::silhouette::{Silhouette, Size};
use glam::{DVec2, DVec3, Vec3};

/// The number of samples along each side of a pixel.
const SIDE: usize = 16;
/// The number of samples of a pixel.
const SAMPLES: u16 = (SIDE * SIDE) as u16;

/// The covered samples of each pixel, out of 256, row by row from the top.
#[derive(Clone, Debug)]
pub(crate) struct Exact {
    size: Size,
    samples: Vec<u16>,
}

impl Exact {
    /// Returns the covered share of each pixel, row by row from the top, 0..=1.
    pub(crate) fn shares(&self) -> impl Iterator<Item = f64> {
        let share = |&samples: &u16| f64::from(samples) / f64::from(SAMPLES);
        self.samples.iter().map(share)
    }

    /// Returns the silhouette of the pixels that are at least half covered.
    #[must_use]
    pub(crate) fn silhouette(&self) -> Silhouette {
        let rows = self.samples.chunks_exact(self.size.columns());
        let bits = rows.map(|row| {
            let on = row.iter().enumerate();
            on.fold(0, |bits, (column, &samples)| {
                bits | u64::from(2 * samples >= SAMPLES) << column
            })
        });
        Silhouette::from_rows(self.size, &bits.collect::<Vec<u64>>())
    }
}

/// Draws figures with exact coverage, reusing its memory.
#[derive(Clone, Debug)]
pub(crate) struct ExactRenderer {
    size: Size,
    /// The span of the current hull in each row of samples, in samples from the middle of the
    /// figure.
    sides: Vec<(f64, f64)>,
    /// The runs of samples in each row: the first sample and the one after the last.
    runs: Vec<Vec<(i32, i32)>>,
}

impl ExactRenderer {
    /// Creates a renderer for images of this size.
    #[must_use]
    pub(crate) fn new(size: Size) -> Self {
        let rows = size.rows() * SIDE;
        Self {
            size,
            sides: vec![(f64::INFINITY, f64::NEG_INFINITY); rows],
            runs: vec![Vec::new(); rows],
        }
    }

    /// Draws hulls, given by points in metres, in parallel projection from `view`: scaled to
    /// fill the rows, and moved by whole columns until the centroid of all samples, rounded
    /// half up, lies on the left side of the middle column.
    ///
    /// # Errors
    /// If the figure has no height from there.
    pub(crate) fn draw(&mut self, hulls: &[Vec<Vec3>], view: Viewpoint) -> Result<Exact> {
        let (right, up) = (view.right().as_dvec3(), view.up().as_dvec3());
        let seen = |point: &Vec3| {
            let point: DVec3 = point.as_dvec3();
            DVec2::new(point.dot(right), point.dot(up))
        };
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in hulls.iter().flatten().map(seen) {
            (least, most) = (least.min(point), most.max(point));
        }
        let height = most.y - least.y;
        if !(height > 0.0 && height.is_finite()) {
            return Err(SweepError::Flat(height).into());
        }
        // Samples per metre; the middle of the figure's width is a border between pixels.
        let scale = (self.size.rows() * SIDE) as f64 / height;
        let middle = 0.5 * (least.x + most.x);
        self.runs.iter_mut().for_each(Vec::clear);
        for hull in hulls {
            let placed = hull
                .iter()
                .map(seen)
                .map(|point| DVec2::new((point.x - middle) * scale, (most.y - point.y) * scale));
            self.fill(&outline(placed.collect()));
        }
        self.merge();
        Ok(self.cut())
    }

    /// Adds the runs of one convex outline, in samples, y downwards.
    fn fill(&mut self, outline: &[DVec2]) {
        let rows = self.sides.len() as f64;
        let top = outline.iter().map(|p| p.y).fold(rows, f64::min);
        let bottom = outline.iter().map(|p| p.y).fold(0.0, f64::max);
        let inside = |from: f64, to: f64| {
            let row = |y: f64| (y - 0.5).ceil().clamp(0.0, rows) as usize;
            row(from)..row(to)
        };
        for (index, &from) in outline.iter().enumerate() {
            let to = outline[(index + 1) % outline.len()];
            let slope = (to.x - from.x) / (to.y - from.y);
            for row in inside(from.y.min(to.y), from.y.max(to.y)) {
                let x = from.x + (row as f64 + 0.5 - from.y) * slope;
                let (left, right) = &mut self.sides[row];
                (*left, *right) = (left.min(x), right.max(x));
            }
        }
        for row in inside(top, bottom) {
            let (left, right) =
                std::mem::replace(&mut self.sides[row], (f64::INFINITY, f64::NEG_INFINITY));
            #[expect(clippy::cast_possible_truncation, reason = "saturates")]
            let run = [left, right].map(|x| (x - 0.5).ceil() as i32);
            if run[0] < run[1] {
                self.runs[row].push((run[0], run[1]));
            }
        }
    }

    /// Unites runs that overlap.
    fn merge(&mut self) {
        for runs in &mut self.runs {
            runs.sort_unstable();
            runs.dedup_by(|next, run| {
                let meets = next.0 <= run.1;
                if meets {
                    run.1 = run.1.max(next.1);
                }
                meets
            });
        }
    }

    /// Cuts out the columns around the centroid.
    fn cut(&self) -> Exact {
        // The number of samples, and twice the sum of their positions, which are at halves.
        let (mut area, mut doubled) = (0i64, 0i64);
        for &(first, end) in self.runs.iter().flatten() {
            let (first, end) = (i64::from(first), i64::from(end));
            area += end - first;
            doubled += (end - first) * (first + end);
        }
        // In pixels: half of the doubled mean over the samples of a side, rounded half up.
        let side = SIDE as i64;
        let centroid = (doubled + area * side).div_euclid((2 * area * side).max(1));
        let columns = self.size.columns();
        let left = (centroid - (columns / 2) as i64) * side;
        let mut samples = vec![0; self.size.pixels()];
        for (row, runs) in self.runs.iter().enumerate() {
            let pixels = &mut samples[row / SIDE * columns..][..columns];
            for &(first, end) in runs {
                let place = |sample: i32| {
                    let from_left = (i64::from(sample) - left).clamp(0, (columns * SIDE) as i64);
                    usize::try_from(from_left).unwrap_or_default()
                };
                cover(pixels, place(first), place(end));
            }
        }
        Exact {
            size: self.size,
            samples,
        }
    }
}

/// Counts the samples `first..end` of a row of samples in its pixels.
fn cover(pixels: &mut [u16], first: usize, end: usize) {
    for (pixel, count) in pixels
        .iter_mut()
        .enumerate()
        .take(end.div_ceil(SIDE))
        .skip(first / SIDE)
    {
        let (from, to) = (first.max(pixel * SIDE), end.min((pixel + 1) * SIDE));
        #[expect(clippy::cast_possible_truncation, reason = "at most 16")]
        let covered = to.saturating_sub(from) as u16;
        *count += covered;
    }
}

/// Returns the convex outline of points by Andrew's monotone chain (1979).
fn outline(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let mut outline: Vec<DVec2> = Vec::with_capacity(2 * points.len());
    let mut chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let start = outline.len();
        for point in points {
            while let [.., a, b] = outline[start..] {
                if (b - a).perp_dot(point - b) > 0.0 {
                    break;
                }
                outline.pop();
            }
            outline.push(point);
        }
        outline.pop();
    };
    chain(&mut points.iter().copied());
    chain(&mut points.iter().rev().copied());
    outline
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::S50x30;

    fn front() -> Viewpoint {
        Viewpoint::from_degrees(0.0, 0.0).expect("a viewpoint")
    }

    fn drawn(hulls: &[Vec<Vec3>]) -> Exact {
        ExactRenderer::new(SIZE)
            .draw(hulls, front())
            .expect("a figure")
    }

    /// Makes a flat rectangle, metres.
    fn rectangle(left: f32, right: f32, bottom: f32, top: f32) -> Vec<Vec3> {
        let corner = |x, y| Vec3::new(x, y, 0.0);
        vec![
            corner(left, bottom),
            corner(right, bottom),
            corner(right, top),
            corner(left, top),
        ]
    }

    fn row(exact: &Exact, row: usize) -> Vec<u16> {
        exact.samples[row * 30..][..30].to_vec()
    }

    #[test]
    fn a_box_of_ten_and_a_quarter_pixels_covers_them_about_the_middle() {
        // 2 m fill 50 rows: 0.41 m are 10.25 columns, 5.125 on each side of column 15's left.
        let exact = drawn(&[rectangle(1.0, 1.41, 0.0, 2.0)]);
        for y in 0..50 {
            let row = row(&exact, y);
            assert_eq!(row[..9], [0; 9]);
            // An eighth of a pixel is 2 of the 16 samples in each of its rows.
            assert_eq!((row[9], row[20]), (32, 32));
            assert_eq!(row[10..20], [256; 10]);
            assert_eq!(row[21..], [0; 9]);
        }
        let silhouette = exact.silhouette();
        assert_eq!(silhouette.area(), 500);
        assert!(exact.shares().sum::<f64>() - 512.5 == 0.0);
    }

    #[test]
    fn overlapping_hulls_count_once_and_the_centroid_shifts_by_whole_columns() {
        // A post of 4 columns with an arm of 8 to the right over 10 rows, which overlaps it by 2.
        let post = rectangle(0.0, 0.16, 0.0, 2.0);
        let arm = rectangle(0.08, 0.4, 1.0, 1.4);
        let exact = drawn(&[post, arm]);
        // 200 pixels at 2 and 60 at 7 from the left have their centroid at 3.15. The left side is 5
        // left of the middle of a width of 10: -1.85 rounds to -2, which becomes column 15.
        assert_eq!(exact.shares().sum::<f64>(), 260.0);
        let on: Vec<usize> = (0..30).filter(|&c| row(&exact, 20)[c] == 256).collect();
        assert_eq!(on, (12..22).collect::<Vec<_>>());
        assert_eq!(row(&exact, 49)[12..16], [256; 4]);
        assert_eq!(row(&exact, 14)[12..17], [256, 256, 256, 256, 0]);
        assert_eq!(row(&exact, 15)[12..17], [256; 5]);
    }

    #[test]
    fn a_polygon_of_32_corners_has_its_area() {
        let corners: Vec<Vec3> = (0..32)
            .map(|i| {
                let angle = std::f32::consts::TAU * i as f32 / 32.0;
                Vec3::new(0.4 * angle.cos(), 0.4 * angle.sin(), 0.3)
            })
            .collect();
        let stick = rectangle(-0.001, 0.001, -1.0, 1.0);
        let area: f64 = drawn(&[corners, stick.clone()]).shares().sum();
        let alone: f64 = drawn(&[stick]).shares().sum();
        // 2 m are 50 pixels, the radius is 10: half of 32 r^2 sin(2 pi / 32), and the parts of the
        // stick outside the polygon: 30 of 50 rows.
        let expected = 16.0 * 100.0 * (std::f64::consts::TAU / 32.0).sin() + 0.6 * alone;
        assert!((area - expected).abs() < 0.5, "{area} {expected}");
    }

    #[test]
    fn inner_points_and_their_order_do_not_matter() {
        let mut points = rectangle(0.0, 0.5, 0.0, 2.0);
        let expected = drawn(&[points.clone()]).samples;
        points.insert(1, Vec3::new(0.2, 0.7, 0.4));
        points.swap(0, 3);
        points.push(points[2]);
        assert_eq!(drawn(&[points]).samples, expected);
    }

    #[test]
    fn what_has_no_height_is_refused() {
        let flat = rectangle(0.0, 1.0, 0.5, 0.5);
        assert!(ExactRenderer::new(SIZE).draw(&[flat], front()).is_err());
        assert!(ExactRenderer::new(SIZE).draw(&[], front()).is_err());
    }
}

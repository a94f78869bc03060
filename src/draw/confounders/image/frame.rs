//! Framing of fine pictures as silhouettes.
//!
//! The framed extent is that of the figure's points, trimmed or grown by as many rows and columns
//! of samples as effects have moved the picture's borders. An unchanged picture is sampled at the
//! middle of each 3x3 samples, a changed one at the nearest sample.

use super::counts::ColumnCounts;
use super::fine::Fine;
use super::phases::{FINE, thirds};
use super::picture::{BitPicture, FigureSamples, SampleBounds};
use edgegait_core::camera::Framing;
use edgegait_core::raster::Placement;
use edgegait_core::silhouette::Silhouette;
use glam::DVec2;

/// A silhouette with its placement and the share of the figure that it clips.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Framed {
    /// The framed silhouette.
    pub silhouette: Silhouette,
    /// The share of the figure that lies outside of the silhouette, 0..=1, counted as in the core
    /// for [`Framing::Height`], and in fine samples for [`Framing::Fixed`].
    pub clipped_share: f32,
    /// The map from image points to the silhouette's pixels.
    pub placement: Placement,
}

/// Evenly spaced samples along an axis, in integer arithmetic.
#[derive(Clone, Copy)]
struct SampleAxis {
    /// The start of pixel 0, in half samples.
    halves: i64,
    /// The number of pixels that cover `span` samples.
    pixels: i64,
    span: i64,
}

impl SampleAxis {
    /// Returns the sample nearest to the middle of a pixel.
    fn sample(self, number: i64) -> Option<usize> {
        usize::try_from(self.at(number)).ok()
    }

    fn at(self, number: i64) -> i64 {
        let at = self.halves * self.pixels + (2 * number + 1) * self.span;
        at.div_euclid(2 * self.pixels)
    }

    /// Returns the samples of the first `count` pixels.
    fn samples(self, count: usize) -> impl Iterator<Item = Option<usize>> {
        (0..signed(count)).map(move |number| self.sample(number))
    }

    /// Returns the sample of a pixel if samples are three apart, otherwise `None`.
    fn start(self, number: i64) -> Option<isize> {
        if self.span != signed(FINE) * self.pixels {
            return None;
        }
        isize::try_from(self.at(number)).ok()
    }

    /// Returns the pixel coordinate at which a sample begins.
    fn pixel(self, sample: f64) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a few thousand")]
        let [halves, pixels, span] = [self.halves, self.pixels, self.span].map(|it| it as f64);
        (sample - halves / 2.0) * pixels / span
    }

    /// Returns the last pixel whose middle is at or before the start of a sample.
    fn before(self, sample: usize) -> i64 {
        let at = (2 * signed(sample) - self.halves) * self.pixels - self.span;
        at.div_euclid(2 * self.span)
    }
}

/// The samples that become the silhouette's pixels.
#[derive(Clone, Copy)]
struct SampleGrid {
    rows: SampleAxis,
    columns: SampleAxis,
    /// The pixel of the first column.
    first: i64,
}

impl Fine {
    /// Frames a picture after effects. `before` is from [`Self::draw_figure`]. Returns `None` if
    /// nothing is left.
    #[must_use]
    pub(crate) fn frame(&self, picture: &BitPicture, before: FigureSamples) -> Option<Framed> {
        let now = picture.bounds()?;
        let grid = self.grid(now, before.bounds);
        match self.view.framing {
            Framing::Height => {
                let (centroid, area) = self.centroid(picture, now, &grid)?;
                let grid = self.centred(grid, centroid + before.nudge);
                let silhouette = self.sampled(picture, &grid);
                Some(Framed {
                    clipped_share: clipped_share(silhouette.area().into(), area),
                    placement: self.placement(&grid),
                    silhouette,
                })
            }
            Framing::Box => {
                let silhouette = self.sampled(picture, &grid);
                (silhouette.area() > 0).then_some(Framed {
                    silhouette,
                    clipped_share: 0.0,
                    placement: self.placement(&grid),
                })
            }
            Framing::Fixed { .. } => {
                let size = self.size;
                let shown = (FINE * self.above..FINE * (self.above + size.rows())).map(|row| {
                    let (from, to) = (FINE * self.left, FINE * (self.left + size.columns()));
                    u64::from(picture.count(row, from, to))
                });
                Some(Framed {
                    silhouette: self.sampled(picture, &grid),
                    clipped_share: clipped_share(shown.sum(), picture.area()),
                    placement: self.placement(&grid),
                })
            }
        }
    }

    /// Makes `picture`, which was rendered in tiles, agree with the core's silhouette, and returns
    /// where the figure is. Coordinates are rounded differently, which moves edges by at most 1/64
    /// pixel, and can move the centroid to the next column.
    pub(super) fn settle(
        &self,
        picture: &mut BitPicture,
        drawn: &Silhouette,
    ) -> Option<FigureSamples> {
        let now = picture.bounds()?;
        let mut settled = FigureSamples {
            bounds: now,
            nudge: 0.0,
        };
        let mut grid = self.grid(now, now);
        let mut centroid = None;
        if self.view.framing == Framing::Height {
            let Some((column, _)) = self.centroid(picture, now, &grid) else {
                return Some(settled);
            };
            grid = self.centred(grid, column);
            centroid = Some(column);
        }
        let mut found = self.sampled(picture, &grid);
        if found == *drawn {
            return Some(settled);
        }
        if let Some(centroid) = centroid {
            let column = libm::floor(centroid);
            // The last value is above rounding, and far below a sample.
            for beside in [column - 1e-6, column + 1.0 + 1e-6] {
                let shifted = self.centred(grid, beside);
                let sampled = self.sampled(picture, &shifted);
                if differences(&sampled, drawn) < differences(&found, drawn) {
                    (grid, found) = (shifted, sampled);
                    settled.nudge = beside - centroid;
                }
            }
        }
        for (row, (found, drawn)) in (0..).zip(found.rows().iter().zip(drawn.rows())) {
            let mut differing = found ^ drawn;
            while differing != 0 {
                let column = differing.trailing_zeros();
                let at = grid.rows.sample(row);
                let sample = grid.columns.sample(grid.first + i64::from(column));
                if let Some((at, sample)) = at.zip(sample) {
                    let sample = sample.cast_signed();
                    picture.fill(at, sample, sample + 1, drawn >> column & 1 == 1);
                }
                differing &= differing - 1;
            }
        }
        settled.bounds = picture.bounds()?;
        Some(settled)
    }

    /// Returns the map from image points to pixels.
    fn placement(&self, grid: &SampleGrid) -> Placement {
        let (scale, at) = self.samples();
        let (rows, columns) = (grid.rows, grid.columns);
        #[expect(clippy::cast_precision_loss, reason = "a few thousand")]
        let first = grid.first as f64;
        let origin = DVec2::new(columns.pixel(at.x) - first, rows.pixel(at.y));
        let next = DVec2::new(
            columns.pixel(at.x + scale.x) - first,
            rows.pixel(at.y + scale.y),
        );
        Placement {
            scale: (next - origin).as_vec2(),
            origin: self.anchor().as_vec2(),
            at: origin.as_vec2(),
        }
    }

    /// Returns the samples of the pixels; for [`Framing::Height`], columns count from the figure's
    /// middle.
    fn grid(&self, now: SampleBounds, before: SampleBounds) -> SampleGrid {
        let size = self.size;
        let [top, left] = [self.above, self.left].map(|pixels| 2 * signed(FINE * pixels));
        let axis = |halves, pixels, from: i64, to: i64| SampleAxis {
            halves: halves + 2 * from,
            pixels: signed(pixels),
            span: signed(FINE * pixels) + to - from,
        };
        let up = moved(now.top, before.top);
        let down = moved(now.bottom, before.bottom);
        let (west, east) = (moved(now.left, before.left), moved(now.right, before.right));
        let rows = axis(top, size.rows(), up, down);
        let (rows, columns) = match self.view.framing {
            Framing::Height => {
                let halves = left + west + east;
                (rows, SampleAxis { halves, ..rows })
            }
            Framing::Box => (rows, axis(left, size.columns(), west, east)),
            Framing::Fixed { .. } => (
                axis(top, size.rows(), 0, 0),
                axis(left, size.columns(), 0, 0),
            ),
        };
        SampleGrid {
            rows,
            columns,
            first: 0,
        }
    }

    /// Returns the grid whose middle column holds a centroid.
    fn centred(&self, grid: SampleGrid, centroid: f64) -> SampleGrid {
        #[expect(clippy::cast_possible_truncation, reason = "a few thousand columns")]
        let column = libm::floor(centroid) as i64;
        let first = column - signed(self.size.columns() / 2);
        SampleGrid { first, ..grid }
    }

    /// Returns the column of the centroid of the sampled points, and how many of these are on;
    /// `None` if none is.
    fn centroid(
        &self,
        picture: &BitPicture,
        now: SampleBounds,
        grid: &SampleGrid,
    ) -> Option<(f64, u64)> {
        let most = self.size.rows();
        let rows = grid.rows.samples(most).flatten();
        let rows = rows.filter(|&row| row < picture.rows());
        let rows = rows.map(|row| picture.row(row));
        let counts = ColumnCounts::count(rows, picture.columns() / 64, most);
        let (mut area, mut doubled) = (0, 0);
        for number in grid.columns.before(now.left)..=grid.columns.before(now.right) {
            if let Some(column) = grid.columns.sample(number) {
                let on = i64::from(counts.of_column(column));
                area += on;
                doubled += on * (2 * number + 1);
            }
        }
        if area == 0 {
            return None;
        }
        // As in the core: both are whole numbers, so that ties are exact.
        #[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
        let (whole, sum) = (area as f64, doubled as f64);
        let jitter = f64::from(self.view.jitter.x);
        let centroid = (sum + whole * (1.0 + 2.0 * jitter)) / (2.0 * whole);
        Some((centroid, area.unsigned_abs()))
    }

    /// Samples the silhouette's pixels from a picture.
    fn sampled(&self, picture: &BitPicture, grid: &SampleGrid) -> Silhouette {
        let size = self.size;
        let rows = grid.rows.samples(size.rows());
        let rows = rows.map(|row| row.filter(|&row| row < picture.rows()));
        let rows = rows.map(|row| row.map_or(&[] as &[u64], |row| picture.row(row)));
        let rows: Vec<u64> = if let Some(start) = grid.columns.start(grid.first) {
            rows.map(|row| thirds(row, start)).collect()
        } else {
            let columns = (0..signed(size.columns()))
                .map(|column| grid.columns.sample(grid.first + column))
                .map(|sample| sample.map_or((usize::MAX, 0), |at| (at / 64, at % 64)));
            let columns: Vec<(usize, usize)> = columns.collect();
            let bits = |row: &[u64]| {
                let bits = columns.iter().enumerate();
                bits.fold(0, |bits, (bit, &(word, at))| {
                    bits | row.get(word).map_or(0, |word| (word >> at & 1) << bit)
                })
            };
            rows.map(bits).collect()
        };
        Silhouette::from_rows(size, &rows)
    }
}

/// Returns the share of `all` that is not `shown`, in the core's arithmetic.
fn clipped_share(shown: u64, all: u64) -> f32 {
    #[expect(clippy::cast_precision_loss, reason = "a share")]
    let share = 1.0 - (shown as f32 / all as f32).min(1.0);
    share
}

/// Returns how many pixels of two silhouettes of one size differ.
fn differences(a: &Silhouette, b: &Silhouette) -> u32 {
    let rows = a.rows().iter().zip(b.rows());
    rows.map(|(a, b)| (a ^ b).count_ones()).sum()
}

/// Returns by how many samples a border has moved.
fn moved(now: usize, before: usize) -> i64 {
    signed(now) - signed(before)
}

/// Converts a count to a signed number.
fn signed(count: usize) -> i64 {
    #[expect(clippy::cast_possible_wrap, reason = "a few thousand")]
    let signed = count as i64;
    signed
}

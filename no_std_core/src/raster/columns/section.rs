//! Cross-sections of hulls by the planes of the image's columns.

use super::column::{ImageColumn, PlaneSpan};
use super::{Azimuth, ColumnView, FigurePlace};
use crate::body::plane::{ALWAYS, Facets16};
use crate::body::{Figure, FigureHull};
use crate::budget::{LANES, MAX_COLUMNS, MAX_HULL_POINTS, MAX_POINTS};
use crate::raster::image_points::{dot, splat};
use crate::raster::placement::as_pixels;
use crate::simd::Wide;
use glam::Vec3;

/// Points of a figure, with padding that is read together with a hull's last point.
const POINTS: usize = MAX_POINTS + MAX_HULL_POINTS;

/// A figure's points as seen from one azimuth, pixels. 24 kB.
#[derive(Clone, Debug)]
pub struct AzimuthPoints {
    /// Distances to the right of the image's left side.
    u: [f32; POINTS],
    /// Distances upwards from the image's centre, and towards the camera, at elevation 0.
    y: [f32; POINTS],
    w: [f32; POINTS],
    /// The number of column centres left of each point.
    passed: [u32; POINTS],
    /// Corners that were cut and are not drawn yet.
    queue: [SectionCorners; QUEUE],
}

/// Corners of a cross-section, in the form for [`PlaneSpan::reach`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct SectionCorners {
    y: [f32; LANES],
    w: [f32; LANES],
    count: usize,
    /// The column, if these are its last corners.
    column: Option<usize>,
}

/// Entries of the queue. Corners are computed for many columns before any is drawn, so that a
/// processor that waits for some works on others.
const QUEUE: usize = MAX_COLUMNS;
/// The maximum number of entries in one column: its 90 edges in two words, eight at a time.
const MOST: usize = 64 / 8 + 32 / 8;

/// The distances to which a figure reaches from the image's centre, pixels.
pub struct Reach {
    /// The distance to the right or left.
    pub across: f32,
    /// The distance upwards, downwards or towards the camera, at any elevation.
    pub along: f32,
}

impl AzimuthPoints {
    pub const NOTHING: Self = Self {
        u: [0.0; POINTS],
        y: [0.0; POINTS],
        w: [0.0; POINTS],
        passed: [0; POINTS],
        queue: [SectionCorners {
            y: [0.0; LANES],
            w: [0.0; LANES],
            count: 0,
            column: None,
        }; QUEUE],
    };

    /// Projects a figure's points; `None` if one of them has no place.
    #[inline(always)]
    pub fn project<L: Wide>(
        &mut self,
        l: L,
        figure: &Figure<'_>,
        view: &ColumnView<'_>,
    ) -> Option<Reach> {
        let FigurePlace {
            centre,
            pixels_per_metre,
            ..
        } = *view.place;
        let (centre, scale) = (splat(l, centre), l.splat(pixels_per_metre));
        let (right, toward) = (splat(l, view.right), splat(l, view.toward));
        let (left, columns) = (l.splat(view.left), l.splat(as_pixels(view.columns)));
        let zero = l.splat(0.0);
        let (mut across, mut along, mut wild) = (zero, zero, zero);
        let from = figure.points.x.as_chunks::<LANES>().0.iter();
        let from = from.zip(figure.points.y.as_chunks::<LANES>().0);
        let from = from.zip(figure.points.z.as_chunks::<LANES>().0);
        let to = self.u.as_chunks_mut::<LANES>().0.iter_mut();
        let to = to.zip(self.y.as_chunks_mut::<LANES>().0);
        let to = to.zip(self.w.as_chunks_mut::<LANES>().0);
        let to = to.zip(self.passed.as_chunks_mut::<LANES>().0);
        let chunks = figure.len().div_ceil(LANES);
        for (((x, y), z), (((us, ys), ws), passed)) in from.zip(to).take(chunks) {
            let x = l.sub(l.load(x), centre[0]);
            let z = l.sub(l.load(z), centre[2]);
            let u = l.add(l.mul(x, right[0]), l.mul(z, right[2]));
            let y = l.mul(l.sub(l.load(y), centre[1]), scale);
            let w = l.add(l.mul(x, toward[0]), l.mul(z, toward[2]));
            let radius = l.add(l.mul(y, y), l.mul(w, w));
            across = l.max(l.max(u, l.sub(zero, u)), across);
            along = l.max(radius, along);
            // A number that is not finite minus itself is NaN.
            let both = l.add(u, radius);
            wild = l.add(wild, l.sub(both, both));
            let u = l.add(u, left);
            let shown = l.min(l.max(u, zero), columns);
            l.store(u, us);
            l.store(y, ys);
            l.store(w, ws);
            // floor(2 u) - floor(u) column centres are left of u.
            let halves = l.truncate(l.add(shown, shown));
            l.store_words(l.sub_words(halves, l.truncate(shown)), passed);
        }
        let (_, across) = l.bounds(zero, across);
        let (_, along) = l.bounds(zero, along);
        let is_finite = l.bits(l.not_less(wild, zero)) == (1 << LANES) - 1;
        is_finite.then_some(Reach {
            across,
            along: libm::sqrtf(along),
        })
    }

    /// Cuts a hull by all columns that cross it, and draws the cuts.
    #[inline(always)]
    pub fn fill<L: Wide>(
        &mut self,
        l: L,
        hull: &FigureHull<'_>,
        directions: [Vec3; 2],
        view: &ColumnView<'_>,
        columns: &mut [ImageColumn; MAX_COLUMNS],
    ) {
        let [above, below] = outermost(l, hull, directions, view.azimuth);
        let passed = self.passed.get(hull.points.start..);
        let Some(passed) = passed.and_then(<[u32]>::first_chunk) else {
            return;
        };
        let (mut first, mut end) = (u32::MAX, 0);
        for &passed in passed.iter().take(hull.points.len()) {
            (first, end) = (first.min(passed), end.max(passed));
        }
        let mut cuts = l.cuts((hull.edges, hull.spokes), [above, below], passed);
        let points = [&self.u, &self.y, &self.w]
            .map(|axis| axis.get(hull.points.start..).and_then(<[f32]>::first_chunk));
        let [Some(u), Some(y), Some(w)] = points else {
            return;
        };
        let mut queued = 0;
        for column in first as usize..end as usize {
            let plane = as_pixels(column) + 0.5;
            let mut masks = l.crossed(&mut cuts, column);
            loop {
                let ([y, w], count) = l.corners((&cuts, hull.edges), &mut masks, [u, y, w], plane);
                let corners = &mut self.queue[queued % QUEUE];
                l.store(y, &mut corners.y);
                l.store(w, &mut corners.w);
                (corners.count, corners.column) = (count, None);
                queued += 1;
                if masks == [[0; 2]; 2] {
                    corners.column = Some(column);
                    break;
                }
            }
            if queued > QUEUE - MOST {
                draw(l, &self.queue[..queued], view, columns);
                queued = 0;
            }
        }
        draw(l, &self.queue[..queued], view, columns);
    }
}

/// Draws the corners in the queue.
#[inline(always)]
fn draw<L: Wide>(
    l: L,
    queue: &[SectionCorners],
    view: &ColumnView<'_>,
    columns: &mut [ImageColumn; MAX_COLUMNS],
) {
    let mut section = PlaneSpan::empty(l);
    for corners in queue {
        section.reach(l, view.azimuth, [&corners.y, &corners.w], corners.count);
        if let Some(column) = corners.column {
            section.paint(
                l,
                view.azimuth.is_few,
                view.offset,
                view.rows,
                &mut columns[column],
            );
            section = PlaneSpan::empty(l);
        }
    }
}

/// Returns the horizontal direction to the camera.
pub const fn toward(right: Vec3) -> Vec3 {
    Vec3::new(-right.z, 0.0, right.x)
}

/// Returns the edges that can be uppermost, and those that can be lowest, at any elevation.
///
/// A cut's corner is uppermost in the directions between the normals of the facets beside it. From
/// elevation 0 to 90 the image's up is between the vertical and the direction away from the camera:
/// one of the two normals has to point upwards, and one away, or no direction between them does
/// both. Below the horizon only the first condition holds. Facets that are edge on count as
/// pointing both ways.
#[inline(always)]
fn outermost<L: Wide>(
    l: L,
    hull: &FigureHull<'_>,
    [facing, upwards]: [Vec3; 2],
    azimuth: &Azimuth,
) -> [[u64; 2]; 2] {
    let (facing, upwards) = (splat(l, facing), splat(l, upwards));
    let zero = l.splat(0.0);
    let [mut up, mut down, mut near, mut far] = [ALWAYS; 4];
    for (sixteen, facets) in hull.facets.iter().enumerate() {
        let Facets16 {
            x,
            y,
            z,
            tolerances,
            ..
        } = facets;
        let tolerance = l.load(tolerances);
        let opposite = l.sub(zero, tolerance);
        let normal = [l.load(x), l.load(y), l.load(z)];
        let (height, depth) = (dot(l, upwards, normal), dot(l, facing, normal));
        let first = LANES * sixteen;
        up |= u64::from(l.bits(l.less(opposite, height))) << first;
        down |= u64::from(l.bits(l.less(height, tolerance))) << first;
        near |= u64::from(l.bits(l.less(opposite, depth))) << first;
        far |= u64::from(l.bits(l.less(depth, tolerance))) << first;
    }
    if !azimuth.is_above {
        (near, far) = (u64::MAX, u64::MAX);
    }
    l.beside([[up, far], [down, near]], hull.edges)
}

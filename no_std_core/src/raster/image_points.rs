//! The points of a figure in the image of a camera, before framing.

use super::DrawError;
use super::framing::extent;
use super::placement::{Extent, Placement};
use super::window::PosedHulls;
use crate::body::Figure;
use crate::budget::{MAX_HULL_POINTS, MAX_POINTS};
use crate::camera::{Camera, NEAR_M};
use crate::simd::{LANES, Lanes, Simd, Wide, compiled, dispatch};
use glam::{Vec2, Vec3};

impl PosedHulls for Figure<'_> {
    fn hulls(&self) -> impl Iterator<Item = impl Iterator<Item = Vec3>> {
        Figure::hulls(self)
    }
    fn extent(&self, camera: &Camera) -> Result<Extent, DrawError> {
        let mut points = ImagePoints::ZERO;
        points.project(self, camera, Simd::widest())
    }
}

/// Points in the image, metres to the right and up, with padding that is read together with a
/// hull's last point. 6 kB.
#[derive(Clone, Debug)]
pub struct ImagePoints {
    pub x: [f32; POINTS],
    pub y: [f32; POINTS],
}

const POINTS: usize = MAX_POINTS + MAX_HULL_POINTS;

/// The rectangle that points take in the image, and whether all of them have a place there.
struct ImageSpan {
    extent: Extent,
    is_whole: bool,
}

impl ImagePoints {
    pub const ZERO: Self = Self {
        x: [0.0; POINTS],
        y: [0.0; POINTS],
    };

    /// Returns the points of the hull whose first one has this number, and what follows them.
    #[inline(always)]
    pub fn of_hull(&self, start: usize) -> Option<[&[f32; MAX_HULL_POINTS]; 2]> {
        let x = self.x.get(start..)?.first_chunk()?;
        Some([x, self.y.get(start..)?.first_chunk()?])
    }

    /// Projects a figure's points, and returns the rectangle that they take.
    pub fn project(
        &mut self,
        figure: &Figure<'_>,
        camera: &Camera,
        simd: Simd,
    ) -> Result<Extent, DrawError> {
        if figure.is_empty() {
            return Err(DrawError::Empty);
        }
        let sight = dispatch!(simd, see(self, figure, camera));
        if sight.is_whole {
            return Ok(sight.extent);
        }
        // The slow path finds the error of a figure that has one.
        extent(figure.points(), camera)
    }
}

compiled!(fn see(points: &mut ImagePoints, figure: &Figure<'_>, camera: &Camera) -> ImageSpan);

#[inline(always)]
fn see<L: Wide>(l: L, points: &mut ImagePoints, figure: &Figure<'_>, camera: &Camera) -> ImageSpan {
    if L::IS_ONE {
        project(l, points, figure, camera)
    } else {
        project(l.half(), points, figure, camera)
    }
}

/// Projects all points as [`Camera::project`] does, `N` at a time.
#[inline(always)]
fn project<const N: usize, L: Lanes<N>>(
    l: L,
    points: &mut ImagePoints,
    figure: &Figure<'_>,
    camera: &Camera,
) -> ImageSpan {
    let viewpoint = camera.viewpoint();
    let right = splat(l, viewpoint.right());
    let up = splat(l, viewpoint.up());
    let toward = splat(l, viewpoint.toward());
    let eye = camera.eye();
    let (zero, near) = (l.splat(0.0), l.splat(NEAR_M));
    let (mut min, mut max) = ([l.splat(f32::INFINITY); 2], [l.splat(f32::NEG_INFINITY); 2]);
    let mut wild = zero;
    let mut is_whole = l.not_less(zero, zero);
    let (px, _) = figure.points.x.as_chunks::<N>();
    let (py, _) = figure.points.y.as_chunks::<N>();
    let (pz, _) = figure.points.z.as_chunks::<N>();
    let (xs, _) = points.x.as_chunks_mut::<N>();
    let (ys, _) = points.y.as_chunks_mut::<N>();
    let each = px.iter().zip(py).zip(pz).zip(xs).zip(ys);
    for ((((px, py), pz), xs), ys) in each.take(figure.len().div_ceil(N)) {
        let mut point = [l.load(px), l.load(py), l.load(pz)];
        let (x, y) = if let Some((aim, distance_m)) = eye {
            let aim = splat(l, aim);
            let [x, y, z] = point;
            point = [l.sub(x, aim[0]), l.sub(y, aim[1]), l.sub(z, aim[2])];
            let distance = l.splat(distance_m);
            let depth = l.sub(distance, dot(l, toward, point));
            is_whole = l.and(is_whole, l.not_less(depth, near));
            let growth = l.div(distance, depth);
            let (x, y) = (dot(l, right, point), dot(l, up, point));
            (l.mul(x, growth), l.mul(y, growth))
        } else {
            (dot(l, right, point), dot(l, up, point))
        };
        // Once it is not finite, the sum stays so.
        wild = l.add(wild, l.add(x, y));
        l.store(x, xs);
        l.store(y, ys);
        min = [l.min(x, min[0]), l.min(y, min[1])];
        max = [l.max(x, max[0]), l.max(y, max[1])];
    }
    let (min_x, max_x) = l.bounds(min[0], max[0]);
    let (min_y, max_y) = l.bounds(min[1], max[1]);
    ImageSpan {
        extent: Extent {
            min: Vec2::new(min_x, min_y),
            max: Vec2::new(max_x, max_y),
        },
        // A sum that is not finite minus itself is NaN.
        is_whole: l.bits(l.and(is_whole, l.not_less(l.sub(wild, wild), zero))) == (1 << N) - 1,
    }
}

/// Copies a vector to all lanes.
#[inline(always)]
pub(super) fn splat<const N: usize, L: Lanes<N>>(l: L, vector: Vec3) -> [L::Floats; 3] {
    [l.splat(vector.x), l.splat(vector.y), l.splat(vector.z)]
}

/// Computes the scalar product, in the order of [`Vec3::dot`].
#[inline(always)]
pub(super) fn dot<const N: usize, L: Lanes<N>>(
    l: L,
    a: [L::Floats; 3],
    b: [L::Floats; 3],
) -> L::Floats {
    l.add(
        l.add(l.mul(a[0], b[0]), l.mul(a[1], b[1])),
        l.mul(a[2], b[2]),
    )
}

/// Stores `N` numbers from number `first` on.
#[inline(always)]
pub(super) fn store<const N: usize, L: Lanes<N>>(
    l: L,
    lanes: L::Floats,
    to: &mut [f32],
    first: usize,
) {
    if let Some(to) = to.get_mut(first..).and_then(<[f32]>::first_chunk_mut) {
        l.store(lanes, to);
    }
}

/// Places `N` points as [`Placement::place`] does.
#[inline(always)]
pub(super) fn placed<const N: usize, L: Lanes<N>>(
    l: L,
    [x, y]: [L::Floats; 2],
    placement: &Placement,
) -> [L::Floats; 2] {
    let Placement { scale, origin, at } = placement;
    let x = l.sub(x, l.splat(origin.x));
    let y = l.sub(l.splat(origin.y), y);
    [
        l.add(l.mul(x, l.splat(scale.x)), l.splat(at.x)),
        l.add(l.mul(y, l.splat(scale.y)), l.splat(at.y)),
    ]
}

/// Loads `N` numbers from number `first` on.
#[inline(always)]
pub(super) fn part<const N: usize, L: Lanes<N>>(l: L, numbers: &[f32], first: usize) -> L::Floats {
    match numbers.get(first..).and_then(<[f32]>::first_chunk) {
        Some(lanes) => l.load(lanes),
        None => l.splat(0.0),
    }
}

/// Returns the numbers from 0 on.
#[inline(always)]
pub(super) fn first_numbers<const N: usize, L: Lanes<N>>(l: L) -> L::Words {
    const NUMBERS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    match NUMBERS.first_chunk() {
        Some(numbers) => l.load_words(numbers),
        None => l.splat_word(0),
    }
}

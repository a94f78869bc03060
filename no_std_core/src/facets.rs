//! The facets and edges of a convex hull, from which its outline follows.
//!
//! Points that one joint carries keep their facets in every pose, so that facets are found once for
//! a body. From any viewpoint, the outline of the hull consists of the edges between a visible
//! facet and one that is not.

#[cfg(test)]
mod tests;

use crate::budget::{MAX_HULL_EDGES, MAX_HULL_FACETS, MAX_HULL_POINTS};
use glam::Vec3;

/// A triangle of a hull's surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Facet {
    /// The numbers of its corners among the hull's points.
    pub corners: [u8; 3],
    /// The numbers of its sides among the hull's edges.
    pub edges: [u8; 3],
}

/// The surface of one convex hull.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Facets {
    /// The triangles; a flat hull has none.
    pub facets: heapless::Vec<Facet, MAX_HULL_FACETS>,
    /// The triangles' sides as pairs of points, the smaller number first. For a flat hull they are
    /// its border, which is its outline from everywhere. A line or a point has none.
    pub edges: heapless::Vec<[u8; 2], MAX_HULL_EDGES>,
}

/// A point on a grid of [`GRID`] cells along each axis.
type GridCell = [i32; 3];

/// Cells along the bounding box of a hull: 2^20, so that its halves and quarters are not rounded.
/// Six times a tetrahedron's volume then stays below 2^63, so that every decision about the rounded
/// points is exact.
const GRID: f64 = 1_048_576.0;

/// The corners of a triangle, counterclockwise for a viewer outside.
type Triangle = [u8; 3];

/// A triangle of a growing surface.
trait Face: Copy {
    fn new(cells: &[GridCell], corners: Triangle) -> Self;

    fn corners(&self) -> Triangle;

    /// Returns six times the volume of the tetrahedron on the triangle; positive if `apex` sees it.
    fn volume(&self, cells: &[GridCell], apex: GridCell) -> i64;
}

/// A face of 3 bytes, whose plane is computed each time.
impl Face for Triangle {
    fn new(_: &[GridCell], corners: Triangle) -> Self {
        corners
    }

    fn corners(&self) -> Triangle {
        *self
    }

    fn volume(&self, cells: &[GridCell], apex: GridCell) -> i64 {
        along(
            normal(cells, *self),
            difference(apex, cell_of(cells, self[0])),
        )
    }
}

/// A face of 40 bytes with its plane, for four times the speed.
#[derive(Clone, Copy)]
struct Plane {
    corners: Triangle,
    /// Twice the triangle's area long, towards the outside.
    normal: [i64; 3],
    /// The product of the normal and a corner, modulo 2^64.
    level: i64,
}

impl Face for Plane {
    fn new(cells: &[GridCell], corners: Triangle) -> Self {
        let normal = normal(cells, corners);
        let level = along(normal, cell_of(cells, corners[0]));
        Self {
            corners,
            normal,
            level,
        }
    }

    fn corners(&self) -> Triangle {
        self.corners
    }

    /// The volume is below 2^63, so that it is exact although its parts are modulo 2^64.
    fn volume(&self, _: &[GridCell], apex: GridCell) -> i64 {
        along(self.normal, apex).wrapping_sub(self.level)
    }
}

fn sides([a, b, c]: Triangle) -> [[u8; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

type Faces<F> = heapless::Vec<F, MAX_HULL_FACETS>;

impl Facets {
    /// Computes the surface of the convex hull of at most the first 32 `points`, which are rounded
    /// to a 1,048,576th of the hull's size along each axis: a point that stands out by less may be
    /// left out. Points that are not finite have no surface.
    ///
    /// Incremental construction (Preparata & Hong 1977; de Berg et al. 2008, chapter 11) in
    /// integers: at most 32 x 60 determinants.
    #[must_use]
    pub fn from_points(points: &[Vec3]) -> Self {
        let cells = cells(points);
        let mut facets = Self::default();
        let faces = match surface::<Plane>(&cells) {
            HullSurface::Closed(faces) => faces,
            HullSurface::Flat(triangle) => {
                facets.edges = border(&cells, triangle);
                return facets;
            }
        };
        // The number of the edge between two points, the smaller one first.
        let mut numbers = [[u8::MAX; MAX_HULL_POINTS]; MAX_HULL_POINTS];
        for face in faces {
            let corners = face.corners();
            let edges = sides(corners).map(|side| facets.edge(side, &mut numbers));
            // As many as there are faces, which the capacity allows.
            let _ = facets.facets.push(Facet { corners, edges });
        }
        facets
    }

    /// Returns the number of an edge, and adds it if it is new.
    fn edge(
        &mut self,
        [a, b]: [u8; 2],
        numbers: &mut [[u8; MAX_HULL_POINTS]; MAX_HULL_POINTS],
    ) -> u8 {
        let [from, to] = [a.min(b), a.max(b)];
        let row = &mut numbers[usize::from(from) % MAX_HULL_POINTS];
        let number = &mut row[usize::from(to) % MAX_HULL_POINTS];
        if *number == u8::MAX {
            *number = u8::try_from(self.edges.len()).unwrap_or(u8::MAX);
            // Three edges for two triangles, which the capacity allows.
            let _ = self.edges.push([from, to]);
        }
        *number
    }
}

/// Calls `take` with the triangles of the surface of [`Facets::from_points`], or with the sides of a flat
/// one as triangles whose last two corners are equal; not at all for a line or a point. Takes a
/// tenth of the memory.
pub(crate) fn each_triangle<E>(
    points: &[Vec3],
    mut take: impl FnMut([u8; 3]) -> Result<(), E>,
) -> Result<(), E> {
    let cells = cells(points);
    match surface::<Triangle>(&cells) {
        HullSurface::Closed(faces) => faces.into_iter().try_for_each(take),
        HullSurface::Flat(triangle) => border(&cells, triangle)
            .into_iter()
            .try_for_each(|[a, b]| take([a, b, b])),
    }
}

/// The surface of the convex hull of points.
enum HullSurface<F> {
    /// Its triangles; none if all points are on one line.
    Closed(Faces<F>),
    /// A flat hull, in the plane of this triangle.
    Flat(Triangle),
}

fn surface<F: Face>(cells: &[GridCell]) -> HullSurface<F> {
    let mut surface = Faces::new();
    let Some(triangle) = first_triangle(cells) else {
        return HullSurface::Closed(surface);
    };
    let first = F::new(cells, triangle);
    let outside = (0..).zip(cells);
    let apex = outside
        .map(|(apex, cell)| (apex, first.volume(cells, *cell)))
        .find(|&(_, volume)| volume != 0);
    let Some((apex, side)) = apex else {
        return HullSurface::Flat(triangle);
    };
    let [a, b, c] = if side > 0 { turned(triangle) } else { triangle };
    let four = [[a, b, c], [b, a, apex], [c, b, apex], [a, c, apex]];
    surface.extend(four.map(|corners| F::new(cells, corners)));
    for (point, cell) in (0..).zip(cells) {
        grow(cells, &mut surface, (point, *cell));
    }
    HullSurface::Closed(surface)
}

/// Rounds the points to their grid; empty if one is not finite.
fn cells(points: &[Vec3]) -> heapless::Vec<GridCell, MAX_HULL_POINTS> {
    let points = points.get(..MAX_HULL_POINTS).unwrap_or(points);
    let mut cells = heapless::Vec::new();
    let Some(&first) = points.first() else {
        return cells;
    };
    if !points.iter().all(|point| point.is_finite()) {
        return cells;
    }
    let min = points.iter().fold(first, |min, &point| min.min(point));
    let max = points.iter().fold(first, |max, &point| max.max(point));
    cells.extend(points.iter().map(|point| {
        core::array::from_fn(|axis| {
            let width = f64::from(max[axis]) - f64::from(min[axis]);
            let share = (f64::from(point[axis]) - f64::from(min[axis])) / width;
            let exact = share * GRID;
            #[expect(clippy::cast_possible_truncation, reason = "0 to GRID; 0 for no width")]
            let below = exact as i32;
            // The difference is exact.
            below + i32::from(exact - f64::from(below) >= 0.5)
        })
    }));
    cells
}

/// Returns the first three points that are not on one line.
fn first_triangle(cells: &[GridCell]) -> Option<Triangle> {
    let first = cells.first()?;
    let (b, second) = (0..).zip(cells).find(|(_, cell)| *cell != first)?;
    let along = difference(*second, *first);
    let (c, _) = (0..)
        .zip(cells)
        .find(|(_, cell)| cross(along, difference(**cell, *first)) != [0; 3])?;
    Some([0, b, c])
}

/// Adds a point to the surface: the triangles that it sees are removed, and it is joined to the
/// border of the rest. A triangle in whose plane the point lies stays.
fn grow<F: Face>(cells: &[GridCell], surface: &mut Faces<F>, (point, cell): (u8, GridCell)) {
    let mut seen = Faces::<Triangle>::new();
    surface.retain(|face| {
        let is_seen = face.volume(cells, cell) > 0;
        if is_seen {
            let _ = seen.push(face.corners());
        }
        !is_seen
    });
    if seen.is_empty() {
        return;
    }
    // Bit `b` of word `a` is the side from `a` to `b`.
    let mut sides_seen = [0u32; MAX_HULL_POINTS];
    let sides = || seen.iter().copied().flat_map(sides);
    for [from, to] in sides() {
        sides_seen[usize::from(from) % MAX_HULL_POINTS] |= 1 << to;
    }
    for [from, to] in sides() {
        let is_inner = sides_seen[usize::from(to) % MAX_HULL_POINTS] >> from & 1 == 1;
        if !is_inner {
            // A closed surface of at most 32 points has at most 60 triangles (Euler).
            let _ = surface.push(F::new(cells, [from, to, point]));
        }
    }
}

/// Returns the border of points in the plane of the triangle `[a, b, c]`: their convex hull seen
/// along the axis nearest to the plane's normal (Andrew 1979).
fn border(cells: &[GridCell], [a, b, c]: Triangle) -> heapless::Vec<[u8; 2], MAX_HULL_EDGES> {
    let [a, b, c] = [a, b, c].map(|corner| cell_of(cells, corner));
    let normal = cross(difference(b, a), difference(c, a)).map(i64::abs);
    let [u, v] = match normal {
        [x, y, z] if x >= y && x >= z => [1, 2],
        [_, y, z] if y >= z => [0, 2],
        _ => [0, 1],
    };
    let flat = |point: u8| {
        let cell = cell_of(cells, point);
        [cell[u], cell[v]]
    };
    let mut sorted: heapless::Vec<u8, MAX_HULL_POINTS> =
        (0..).zip(cells).map(|(point, _)| point).collect();
    sorted.sort_unstable_by_key(|&point| (flat(point), point));
    let mut ring = heapless::Vec::<u8, { 2 * MAX_HULL_POINTS }>::new();
    let mut half = |points: &mut dyn Iterator<Item = u8>| {
        let base = ring.len().saturating_sub(1);
        for point in points {
            while let [.., before, last] = ring.as_slice() {
                let [o, p, q] = [*before, *last, point].map(flat);
                let turn = product(p[0] - o[0], q[1] - o[1]) - product(p[1] - o[1], q[0] - o[0]);
                if ring.len() < base + 2 || turn > 0 {
                    break;
                }
                ring.pop();
            }
            let _ = ring.push(point);
        }
    };
    half(&mut sorted.iter().copied());
    half(&mut sorted.iter().rev().copied().skip(1));
    // The ring closes on its first point.
    let sides = ring.iter().zip(ring.iter().skip(1));
    sides.map(|(&p, &q)| [p.min(q), p.max(q)]).collect()
}

/// Returns the normal of a triangle, twice its area long.
fn normal(cells: &[GridCell], corners: Triangle) -> [i64; 3] {
    let [a, b, c] = corners.map(|corner| cell_of(cells, corner));
    cross(difference(b, a), difference(c, a))
}

/// Returns the product of a normal and a cell, modulo 2^64.
fn along([x, y, z]: [i64; 3], [u, v, w]: GridCell) -> i64 {
    let products =
        [(x, u), (y, v), (z, w)].map(|(normal, cell)| normal.wrapping_mul(i64::from(cell)));
    products[0]
        .wrapping_add(products[1])
        .wrapping_add(products[2])
}

fn turned([a, b, c]: Triangle) -> Triangle {
    [a, c, b]
}

fn cell_of(cells: &[GridCell], point: u8) -> GridCell {
    cells.get(usize::from(point)).copied().unwrap_or_default()
}

fn difference(a: GridCell, b: GridCell) -> GridCell {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: GridCell, b: GridCell) -> [i64; 3] {
    [
        product(a[1], b[2]) - product(a[2], b[1]),
        product(a[2], b[0]) - product(a[0], b[2]),
        product(a[0], b[1]) - product(a[1], b[0]),
    ]
}

fn product(a: i32, b: i32) -> i64 {
    i64::from(a) * i64::from(b)
}

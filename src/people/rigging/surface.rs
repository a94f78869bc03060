//! Sections of a body's surface, and distances along it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::import::obj::Mesh;

/// The curve on which a field over the vertices has one value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    /// Mean of its points, metres.
    pub(super) centre: DVec3,
    /// Length of all its loops together, metres.
    pub(super) length: f64,
}

/// Returns the curve of `field = value` on the triangles whose first corner `keep` accepts, if
/// there is one.
pub(super) fn ring(
    mesh: &Mesh,
    field: &[f64],
    value: f64,
    keep: impl Fn(usize) -> bool,
) -> Option<Ring> {
    let mut ring = Ring {
        centre: DVec3::ZERO,
        length: 0.0,
    };
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| corner as usize);
        if !keep(a) || ![a, b, c].iter().all(|&corner| field[corner].is_finite()) {
            continue;
        }
        let mut ends = [(a, b), (b, c), (c, a)]
            .into_iter()
            .filter(|&(from, to)| (field[from] < value) != (field[to] < value))
            .map(|(from, to)| {
                let share = (value - field[from]) / (field[to] - field[from]);
                mesh.vertices[from].lerp(mesh.vertices[to], share)
            });
        if let (Some(from), Some(to)) = (ends.next(), ends.next()) {
            let length = from.distance(to);
            ring.centre += length * from.midpoint(to);
            ring.length += length;
        }
    }
    (ring.length > 0.0).then(|| Ring {
        centre: ring.centre / ring.length,
        ..ring
    })
}

/// Returns the distance of every vertex from one along the edges, metres (Dijkstra 1959); infinite
/// where no path leads.
pub(super) fn distances(mesh: &Mesh, from: usize) -> Vec<f64> {
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); mesh.vertices.len()];
    for [a, b, c] in &mesh.triangles {
        for (one, other) in [(a, b), (b, c), (c, a)] {
            neighbours[*one as usize].push(*other);
            neighbours[*other as usize].push(*one);
        }
    }
    let mut found = vec![f64::INFINITY; mesh.vertices.len()];
    found[from] = 0.0;
    // Distances are not negative, so their bits have the same order.
    let mut queue = BinaryHeap::from([Reverse((0.0f64.to_bits(), from))]);
    while let Some(Reverse((bits, at))) = queue.pop() {
        let so_far = f64::from_bits(bits);
        if so_far > found[at] {
            continue;
        }
        for &next in &neighbours[at] {
            let next = next as usize;
            let distance = so_far + mesh.vertices[at].distance(mesh.vertices[next]);
            if distance < found[next] {
                found[next] = distance;
                queue.push(Reverse((distance.to_bits(), next)));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An upright square tube of 0.2 m sides and 1 m, open at both ends.
    fn tube() -> Mesh {
        let corners = [(0.1, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.1, -0.1)];
        let mut vertices = Vec::new();
        for y in [0.0, 1.0] {
            vertices.extend(corners.map(|(x, z)| DVec3::new(x, y, z)));
        }
        let sides = [[0, 1, 4], [1, 5, 4], [1, 2, 5], [2, 6, 5]];
        let more = [[2, 3, 6], [3, 7, 6], [3, 0, 7], [0, 4, 7]];
        Mesh {
            vertices,
            triangles: sides.into_iter().chain(more).collect(),
        }
    }

    #[test]
    fn a_section_of_a_tube_is_its_girth_about_its_axis() {
        let mesh = tube();
        let heights: Vec<f64> = mesh.vertices.iter().map(|v| v.y).collect();
        let ring = ring(&mesh, &heights, 0.3, |_| true).unwrap();
        assert!((ring.length - 0.8).abs() < 1e-12);
        assert!(ring.centre.distance(DVec3::Y * 0.3) < 1e-12);
        assert!(super::ring(&mesh, &heights, 1.5, |_| true).is_none());
    }

    #[test]
    fn distances_follow_the_edges() {
        let found = distances(&tube(), 0);
        // Across to the far corner; up the edge; up a side's diagonal.
        assert!((found[2] - 0.4).abs() < 1e-12);
        assert!((found[4] - 1.0).abs() < 1e-12);
        assert!((found[7] - f64::hypot(0.2, 1.0)).abs() < 1e-12);
    }
}

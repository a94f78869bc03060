//! The surface of a convex hull, as triangles with normals that round its edges.

use glam::Vec3;

/// The distance within which a point is on a facet's plane, metres: far below a pixel.
const FLAT_M: f32 = 1e-5;
/// The cosine between normals above which two facets meet in a round edge: 40 degrees.
const ROUND: f32 = 0.77;

/// Returns the triangles of a hull's surface: each corner with its shading normal.
///
/// These are all triples of points with all other points on one side. A facet with more corners
/// gives all its triangles, which overlap. Tests all quadruples of points: 1 ms for 32.
pub(super) fn facets(points: &[Vec3]) -> Vec<[(Vec3, Vec3); 3]> {
    let mut found: Vec<([usize; 3], Vec3)> = Vec::new();
    for (a, &corner) in points.iter().enumerate() {
        for (b, &second) in points.iter().enumerate().skip(a + 1) {
            for (c, &third) in points.iter().enumerate().skip(b + 1) {
                let normal = (second - corner).cross(third - corner);
                let Some(normal) = normal.try_normalize() else {
                    continue;
                };
                for outward in [normal, -normal] {
                    if points.iter().all(|&p| outward.dot(p - corner) < FLAT_M) {
                        found.push(([a, b, c], outward));
                    }
                }
            }
        }
    }
    let lit = |corner: usize, facet: Vec3| {
        let around = found
            .iter()
            .filter(|(corners, normal)| corners.contains(&corner) && normal.dot(facet) > ROUND);
        around
            .map(|(_, normal)| *normal)
            .sum::<Vec3>()
            .normalize_or(facet)
    };
    found
        .iter()
        .map(|(corners, normal)| corners.map(|corner| (points[corner], lit(corner, *normal))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_has_six_flat_faces_of_four_triangles_each() {
        let corner = |bit: u8| f32::from(bit) - 0.5;
        let cube: Vec<Vec3> = (0..8u8)
            .map(|i| Vec3::new(corner(i & 1), corner(i >> 1 & 1), corner(i >> 2)))
            .collect();
        let with_middle = [cube.as_slice(), &[Vec3::ZERO]].concat();
        let facets = facets(&with_middle);
        assert_eq!(facets.len(), 6 * 4);
        for facet in facets {
            for (corner, normal) in facet {
                // Half an edge from the middle, and perpendicular to a face.
                assert!((normal.dot(corner) - 0.5).abs() < 1e-6, "{normal}");
                assert!((normal.abs().max_element() - 1.0).abs() < 1e-6, "{normal}");
            }
        }
    }

    #[test]
    fn points_on_a_line_have_no_surface() {
        assert!(facets(&[Vec3::ZERO, Vec3::X, 2.0 * Vec3::X, 3.0 * Vec3::X]).is_empty());
    }
}

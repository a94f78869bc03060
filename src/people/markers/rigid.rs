//! The rotation and translation that fit one set of points to another.
//!
//! Horn (1987), "Closed-form solution of absolute orientation using unit quaternions", J. Opt.
//! Soc. Am. A 4:629-642: the rotation is the eigenvector of the largest eigenvalue of a symmetric
//! 4 x 4 matrix of the points' products, his N.

use glam::{DQuat, DVec3};

/// A rotation, then a translation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rigid {
    pub(super) turn: DQuat,
    pub(super) shift: DVec3,
}

impl Rigid {
    /// Moves a point.
    pub(super) fn apply(&self, point: DVec3) -> DVec3 {
        self.turn * point + self.shift
    }

    /// Returns the least-squares fit of the first points of the pairs to the second; none for fewer
    /// than 3 pairs or points on a line.
    pub(super) fn fit(pairs: &[(DVec3, DVec3)]) -> Option<Self> {
        /// The minimum breadth of the points as a share of their spread; narrower ones have no
        /// orientation. Our choice.
        const LEAST_BREADTH: f64 = 0.02;
        if pairs.len() < 3 {
            return None;
        }
        let count = pairs.len() as f64;
        let a = pairs.iter().map(|pair| pair.0).sum::<DVec3>() / count;
        let b = pairs.iter().map(|pair| pair.1).sum::<DVec3>() / count;
        let mut breadth: f64 = 0.0;
        let mut reach: f64 = 0.0;
        for (p, _) in pairs {
            reach = reach.max((*p - a).length());
            for (q, _) in pairs {
                breadth = breadth.max((*p - a).cross(*q - a).length());
            }
        }
        if breadth < LEAST_BREADTH * reach * reach || reach == 0.0 {
            return None;
        }
        // s[i][j]: sum of the products of coordinates i of the first and j of the second points.
        let mut s = [[0.0; 3]; 3];
        for (p, q) in pairs {
            let (p, q) = ((*p - a).to_array(), (*q - b).to_array());
            for i in 0..3 {
                for j in 0..3 {
                    s[i][j] += p[i] * q[j];
                }
            }
        }
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = s;
        let [w, x, y, z] = largest_eigenvector([
            [xx + yy + zz, yz - zy, zx - xz, xy - yx],
            [yz - zy, xx - yy - zz, xy + yx, zx + xz],
            [zx - xz, xy + yx, yy - xx - zz, yz + zy],
            [xy - yx, zx + xz, yz + zy, zz - xx - yy],
        ]);
        let turn = DQuat::from_xyzw(x, y, z, w).normalize();
        Some(Self {
            turn,
            shift: b - turn * a,
        })
    }
}

/// Returns the unit eigenvector of a symmetric matrix's largest eigenvalue, by Jacobi rotations.
fn largest_eigenvector(mut m: [[f64; 4]; 4]) -> [f64; 4] {
    let mut vectors = [[0.0; 4]; 4];
    for (i, row) in vectors.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for _ in 0..30 {
        for (p, q) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            if m[p][q].abs() < 1e-300 {
                continue;
            }
            let theta = 0.5 * libm::atan2(2.0 * m[p][q], m[q][q] - m[p][p]);
            let (sin, cos) = libm::sincos(theta);
            for row in &mut m {
                (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
            }
            let (upper, lower) = (m[p], m[q]);
            m[p] = std::array::from_fn(|k| cos * upper[k] - sin * lower[k]);
            m[q] = std::array::from_fn(|k| sin * upper[k] + cos * lower[k]);
            for row in &mut vectors {
                (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
            }
        }
    }
    let best = (0..4)
        .max_by(|&a, &b| m[a][a].total_cmp(&m[b][b]))
        .unwrap_or(0);
    vectors.map(|row| row[best])
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [DVec3; 4] = [
        DVec3::new(0.0, 0.0, 0.0),
        DVec3::new(0.1, 0.0, 0.02),
        DVec3::new(0.0, 0.2, 0.0),
        DVec3::new(0.03, 0.05, 0.1),
    ];

    #[test]
    fn a_moved_cluster_is_moved_back() {
        for axis in [DVec3::X, DVec3::Y, DVec3::new(1.0, -2.0, 0.5).normalize()] {
            for angle in [0.0, 0.4, 2.0, 3.1] {
                let turn = DQuat::from_axis_angle(axis, angle);
                let shift = DVec3::new(1.0, -2.0, 3.0);
                let pairs = POINTS.map(|p| (p, turn * p + shift));
                let found = Rigid::fit(&pairs).unwrap();
                assert!(found.turn.dot(turn).abs() > 1.0 - 1e-12, "{axis} {angle}");
                assert!(found.shift.distance(shift) < 1e-12);
            }
        }
    }

    #[test]
    fn two_points_and_points_on_a_line_have_no_orientation() {
        let line = [0.0, 0.1, 0.2].map(|x| (DVec3::X * x, DVec3::Y * x));
        assert!(Rigid::fit(&line).is_none());
        assert!(Rigid::fit(&POINTS.map(|p| (p, p))[..2]).is_none());
    }
}

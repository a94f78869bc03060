//! Rotations as three numbers: modified Rodrigues parameters.
//!
//! A rotation by the angle `a` about the unit axis `n` is the vector `4 tan(a/4) n`
//! (Shuster 1993, "A survey of attitude representations", J. Astronaut. Sci. 41:439-517,
//! eq. 251, times 4): the rotation vector itself for small angles, 1 % longer at 40
//! degrees, finite up to a full turn. Turning it into a quaternion takes one division and
//! no trigonometry, and every finite vector is a rotation.

use glam::{Quat, Vec3};

/// Returns the unit quaternion of a vector `4 tan(a/4) n`.
#[must_use]
pub fn rotation(vector: Vec3) -> Quat {
    Quat::from_array(quaternion(vector.to_array()))
}

/// Returns the unit quaternion of a vector as plain numbers, which vectorise over joints.
#[inline]
pub(crate) fn quaternion(vector: [f32; 3]) -> [f32; 4] {
    let [x, y, z] = vector.map(|component| 0.25 * component);
    let square = x * x + y * y + z * z;
    let scale = 1.0 / (1.0 + square);
    let twice = 2.0 * scale;
    [x * twice, y * twice, z * twice, (1.0 - square) * scale]
}

/// Returns the quaternion of rotating by `b` and then by `a`.
#[inline]
pub(crate) fn product(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_turns_about_itself() {
        // 4 tan(90 / 4 degrees) = 1.656854.
        let turned = rotation(Vec3::new(0.0, 1.656_854_2, 0.0)) * Vec3::Z;
        assert!((turned - Vec3::X).length() < 1e-6, "{turned}");
        // Small vectors are rotation vectors.
        let small = rotation(Vec3::new(0.01, 0.0, 0.0));
        assert!((small.x - 0.005).abs() < 1e-7, "{small}");
    }

    #[test]
    fn half_a_turn_and_more_are_as_good_as_any() {
        // 4 tan(180 / 4) = 4; 270 degrees are -90.
        let half = rotation(Vec3::new(0.0, 0.0, 4.0));
        assert!(half.abs_diff_eq(Quat::from_xyzw(0.0, 0.0, 1.0, 0.0), 1e-6));
        let most = rotation(Vec3::new(9.656_854, 0.0, 0.0)) * Vec3::Y;
        assert!((most + Vec3::Z).length() < 1e-6, "{most}");
    }

    #[test]
    fn products_are_those_of_quaternions() {
        let (a, b) = (
            Quat::from_xyzw(0.1, -0.7, 0.5, 0.5).normalize(),
            Quat::from_xyzw(-0.3, 0.2, 0.9, -0.1).normalize(),
        );
        let found = Quat::from_array(product(a.to_array(), b.to_array()));
        assert!(found.abs_diff_eq(a * b, 1e-6));
    }
}

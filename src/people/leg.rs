//! Two-joint legs in closed form, the knee's place from hip and ankle, and their share of stature.

use glam::{DMat3, DQuat, DVec3};

/// Hip-to-ankle length over stature: (trochanter - malleolus) of ANSUR II's means,
/// (0.513 - 0.042) for men and (0.519 - 0.039) for women.
#[cfg(feature = "import")]
pub(super) const LEG_SHARE: f64 = 0.4755;

/// The lengths of a leg in the rest pose, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LegLengths {
    /// From the hip to the knee.
    pub thigh_m: f64,
    /// From the knee to the ankle.
    pub shank_m: f64,
}

/// A leg that reaches from a hip to an ankle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reached {
    /// The thigh's orientation.
    pub thigh: DQuat,
    /// The shank's orientation: the thigh's, turned about the knee's axis.
    pub shank: DQuat,
    /// Flexion of the knee, radians: 0 is a straight leg.
    pub knee: f64,
}

impl LegLengths {
    /// Returns the distance between hip and ankle at a knee flexion, radians, by the law of
    /// cosines.
    #[must_use]
    pub(crate) fn reach(&self, knee: f64) -> f64 {
        let (a, b) = (self.thigh_m, self.shank_m);
        libm::sqrt(a * a + b * b + 2.0 * a * b * libm::cos(knee))
    }

    /// Returns the knee flexion, radians, at a distance between hip and ankle. A distance out of
    /// reach counts as the nearest one within reach.
    #[must_use]
    pub(crate) fn knee(&self, distance: f64) -> f64 {
        let (a, b) = (self.thigh_m, self.shank_m);
        let cosine = (distance * distance - a * a - b * b) / (2.0 * a * b);
        libm::acos(cosine.clamp(-1.0, 1.0))
    }

    /// Returns the leg from `hip` towards `ankle` whose knee points to `ahead`. It reaches the
    /// ankle if it is long enough.
    #[must_use]
    pub(crate) fn reaching(&self, hip: DVec3, ankle: DVec3, ahead: DVec3) -> Reached {
        let along = (ankle - hip).normalize_or(-DVec3::Y);
        let distance = (ankle - hip).length();
        let knee = self.knee(distance);
        let front = (ahead - ahead.dot(along) * along).normalize_or(DVec3::Z);
        // The angle at the hip between the thigh and the line to the ankle.
        let (sin, cos) = libm::sincos(knee);
        let hip_angle = libm::atan2(self.shank_m * sin, self.thigh_m + self.shank_m * cos);
        let (sin, cos) = libm::sincos(hip_angle);
        let down = cos * along + sin * front;
        let side = (-along).cross(front).normalize_or(DVec3::X);
        let thigh = upright(-down, side);
        Reached {
            thigh,
            shank: (thigh * DQuat::from_rotation_x(knee)).normalize(),
            knee,
        }
    }
}

/// Returns the orientation with Y axis `up` and X axis `side`, perpendicular unit vectors.
fn upright(up: DVec3, side: DVec3) -> DQuat {
    DQuat::from_mat3(&DMat3::from_cols(side, up, side.cross(up))).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEG: LegLengths = LegLengths {
        thigh_m: 0.42,
        shank_m: 0.41,
    };

    #[test]
    fn a_leg_reaches_the_ankle_that_it_is_given() {
        let hip = DVec3::new(0.08, 0.9, 0.0);
        for ankle in [
            DVec3::new(0.05, 0.08, 0.1),
            DVec3::new(0.12, 0.2, -0.4),
            DVec3::new(0.0, 0.3, 0.35),
        ] {
            let leg = LEG.reaching(hip, ankle, DVec3::new(0.2, 0.0, 1.0));
            let knee = hip - LEG.thigh_m * (leg.thigh * DVec3::Y);
            let reached = knee - LEG.shank_m * (leg.shank * DVec3::Y);
            assert!((reached - ankle).length() < 1e-12, "{reached} {ankle}");
            // The knee lies in front of the line from hip to ankle.
            assert!((knee - hip.midpoint(ankle)).z > 0.0);
            assert!((LEG.reach(leg.knee) - hip.distance(ankle)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_leg_that_is_too_short_is_stretched_towards_the_ankle() {
        let leg = LEG.reaching(DVec3::Y, DVec3::new(0.0, 0.0, 0.5), DVec3::Z);
        let down = DVec3::new(0.0, -1.0, 0.5).normalize();
        assert!(leg.knee.abs() < 1e-9);
        assert!((leg.thigh * -DVec3::Y - down).length() < 1e-9);
    }

    #[test]
    fn a_knee_bends_as_the_law_of_cosines_says() {
        // A right angle: 0.3, 0.4, 0.5.
        let leg = LegLengths {
            thigh_m: 0.3,
            shank_m: 0.4,
        };
        assert!((leg.knee(0.5).to_degrees() - 90.0).abs() < 1e-9);
        assert!((leg.reach(0.0) - 0.7).abs() < 1e-12);
    }
}

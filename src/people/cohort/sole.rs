//! The roll of a foot over the floor: on the heel, on the whole sole, on the ball, on the toes.

use crate::people::BodyHull;

/// Range of the pitches for which a sole is tabulated, radians, and their number.
const PITCHES: (f64, f64, usize) = (-1.8, 1.2, 601);
/// Rounding of a sole's corners, metres: the scale of a smooth minimum. Our choice, for soft tissue
/// and shoes; a hard corner would jerk the ankle.
const ROUNDED_M: f64 = 0.004;

/// The ankle's motion by the foot's pitch while a foot rolls without slipping.
#[derive(Clone, Debug)]
pub(super) struct Sole {
    table: Vec<RolledAnkle>,
}

/// The ankle's place while a foot rolls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RolledAnkle {
    /// Distance ahead of its place above the flat foot, metres.
    pub ahead_m: f64,
    /// Height above the floor, metres.
    pub height_m: f64,
}

impl Sole {
    /// Returns the sole of a foot's hull, whose frame has Y up and Z ahead.
    ///
    /// A rolling body turns about the point of contact, so its ankle moves by its height per
    /// radian: the distance is the integral of the height.
    #[must_use]
    pub(super) fn from_hull(hull: &BodyHull) -> Self {
        let (least, most, count) = PITCHES;
        let step = (most - least) / (count - 1) as f64;
        let lowest = |pitch: f64| {
            let (sin, cos) = libm::sincos(pitch);
            hull.points
                .iter()
                .map(move |point| point.y * cos + point.z * sin)
        };
        let height = |pitch: f64| {
            let least = lowest(pitch).fold(f64::MAX, f64::min);
            let sum: f64 = lowest(pitch)
                .map(|height| libm::exp((least - height) / ROUNDED_M))
                .sum();
            ROUNDED_M * libm::log(sum) - least
        };
        // Rounding leaves the height of the flat foot unchanged.
        let rounded = height(0.0) + lowest(0.0).fold(f64::MAX, f64::min);
        let mut table: Vec<RolledAnkle> = (0..count)
            .map(|index| RolledAnkle {
                ahead_m: 0.0,
                height_m: height(least + step * index as f64) - rounded,
            })
            .collect();
        let flat = libm::round(-least / step) as usize;
        for index in flat + 1..count {
            let between = 0.5 * (table[index].height_m + table[index - 1].height_m);
            table[index].ahead_m = table[index - 1].ahead_m - step * between;
        }
        for index in (0..flat).rev() {
            let between = 0.5 * (table[index].height_m + table[index + 1].height_m);
            table[index].ahead_m = table[index + 1].ahead_m + step * between;
        }
        Self { table }
    }

    /// Returns the ankle's place above a foot that touches the floor with its toes raised by
    /// `pitch`, radians.
    #[must_use]
    pub(super) fn rolled(&self, pitch: f64) -> RolledAnkle {
        let (least, most, count) = PITCHES;
        let at = (pitch.clamp(least, most) - least) / (most - least) * (count - 1) as f64;
        let index = (at as usize).min(count - 2);
        let share = at - index as f64;
        let (before, after) = (self.table[index], self.table[index + 1]);
        let between = |before: f64, after: f64| before + share * (after - before);
        RolledAnkle {
            ahead_m: between(before.ahead_m, after.ahead_m),
            height_m: between(before.height_m, after.height_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::skeleton::Joint;
    use glam::DVec3;
    use std::f64::consts::FRAC_PI_6;

    /// A foot 25 cm long whose ankle is 8 cm high, 5 cm ahead of the heel.
    fn sole() -> Sole {
        let points = [(0.0, -0.05), (-0.08, -0.05), (-0.08, 0.2), (0.0, 0.1)];
        Sole::from_hull(&BodyHull {
            joint: Joint::LeftFoot,
            points: points.map(|(y, z)| DVec3::new(0.0, y, z)).to_vec(),
        })
    }

    #[test]
    fn a_flat_foot_has_its_ankle_above_its_place() {
        let flat = sole().rolled(0.0);
        assert!(flat.ahead_m.abs() < 1e-4);
        assert!((flat.height_m - 0.08).abs() < 1e-12);
    }

    #[test]
    fn a_foot_on_its_heel_turns_about_it() {
        // The ankle is (5, 8) cm from the heel; turned by 30 degrees it is
        // (5 cos - 8 sin, 5 sin + 8 cos) = (0.330, 9.428) from it.
        let raised = sole().rolled(FRAC_PI_6);
        assert!((raised.ahead_m - (-0.05 + 0.003_301)).abs() < 4e-3);
        assert!((raised.height_m - 0.094_282).abs() < 4e-3);
    }

    #[test]
    fn a_foot_on_its_toes_turns_about_them() {
        // The ankle is (-20, 8) cm from the toes; turned by -30 degrees it is
        // (-20 cos + 8 sin, 20 sin + 8 cos) = (-13.321, 16.928) from them.
        let raised = sole().rolled(-FRAC_PI_6);
        assert!((raised.ahead_m - (0.2 - 0.133_205)).abs() < 4e-3);
        assert!((raised.height_m - 0.169_282).abs() < 4e-3);
    }
}

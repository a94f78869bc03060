//! Coats and jackets: hulls of the trunk, the neck and the arms, moved outward, and what hangs
//! from the waist.
//!
//! Coats of 24 people of CASIA-B, seen from the side, widen neck and shoulders by 2.9 columns of
//! 1/64 of the stature (2.7 cm), the trunk by 2.6 to 3.0 and the thighs by 0.8, and most end before
//! the middle of the thighs.

use super::body_sections::{RestJoints, swell};
use super::cloth::ClothCut;
use super::{BodyPart, Outfit, Wearer, WornHull};
use edgegait_core::skeleton::Joint;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The cut of a garment that covers trunk, neck and arms, at strength 1.
struct CoatCut {
    /// Distances from the trunk, the arms and, around the collar, the neck, metres.
    trunk_m: f64,
    sleeves_m: f64,
    collar_m: f64,
    /// The hem's place, as a share of the thigh.
    hem: f64,
}

/// Our choice, so that CASIA-B's coats are as wide as is stated above.
const COAT: CoatCut = CoatCut {
    trunk_m: 0.040,
    sleeves_m: 0.030,
    collar_m: 0.050,
    hem: 0.95,
};
const DOWN_JACKET: CoatCut = CoatCut {
    trunk_m: 0.038,
    sleeves_m: 0.025,
    collar_m: 0.050,
    hem: 0.50,
};
const OPEN_COAT: CoatCut = CoatCut {
    trunk_m: 0.030,
    sleeves_m: 0.025,
    collar_m: 0.025,
    hem: 0.95,
};
/// Share of its thickness by which a garment is above the shoulders. Our choice.
const ABOVE: f64 = 0.3;
/// Share of its distance from the neck that a collar loses up to the skull. Our choice.
const CLOSER: f64 = 0.8;
/// Distances of a hem from the hips and the legs, metres. Our choice.
const HEM_M: f64 = 0.015;
/// How far the tails of an open coat stand away from the hips at the sides and behind, metres. Our
/// choice.
const TAILS_M: f64 = 0.08;

/// Puts on a closed coat or gown. At strength 1 it is 4 cm thick on the trunk, 3 cm on the arms
/// and 5 cm around the neck, and ends above the knees (see the module).
///
/// Its thickness and its length below the hips grow with the strength. Adds one draped hull of 32
/// points.
pub(crate) fn coat(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    closed(outfit, wearer, strength, &COAT);
}

/// Puts on a down jacket. At strength 1 it is 3.8 cm thick on the trunk, 2.5 cm on the arms and 5 cm
/// around the neck, and ends at half of the thighs (see the module). Thickness and length
/// grow with the strength. Adds one draped hull of 32 points.
pub(crate) fn down_jacket(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    closed(outfit, wearer, strength, &DOWN_JACKET);
}

/// Puts on a garment that is closed to its hem.
fn closed(outfit: &mut Outfit, wearer: &Wearer, strength: f64, cut: &CoatCut) {
    if strength == 0.0 {
        return;
    }
    cut.put_over(outfit, wearer, strength);
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let cloth = ClothCut {
        hem: cut.hem_height(&standing),
        ease: [0.0, HEM_M, HEM_M, HEM_M],
        strength,
    };
    outfit.hulls.push(cloth.hang(outfit, &standing));
}

/// Puts on an open coat. At strength 1 it is 3 cm thick on the trunk and 2.5 cm on the arms and
/// around the neck; its tails hang from the hips to above the knees, beside and behind the legs,
/// which step out of it ahead, and stand 8 cm away (our choice). Thickness, length and distance grow
/// with the strength. Adds one hull of 15 points, on the pelvis.
pub(crate) fn open_coat(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    OPEN_COAT.put_over(outfit, wearer, strength);
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let hip = standing.height(Joint::LeftThigh);
    let around = standing.slice(outfit, &[Joint::Pelvis], hip - 0.06..=hip + 0.06);
    let centre = around.centre();
    let hem = hip + strength * (OPEN_COAT.hem_height(&standing) - hip);
    let mut points = Vec::new();
    for (height, away) in [(hip + 0.04, 0.0), (0.5 * (hip + hem), 0.6), (hem, 1.0)] {
        // From the left side around the back to the right side.
        for index in 4..=8 {
            let angle = TAU * f64::from(index) / 8.0;
            let direction = DVec2::new(libm::cos(angle), libm::sin(angle));
            let out = 0.95 * around.reach(direction) + away * TAILS_M * strength;
            let place = DVec3::new(
                centre.x + direction.x * out,
                height,
                centre.z + direction.y * out,
            );
            points.push(standing.hang(Joint::Pelvis, place));
        }
    }
    outfit.hulls.push(WornHull {
        part: BodyPart::Garment,
        points,
    });
}

impl CoatCut {
    /// Returns the height of the hem at rest.
    fn hem_height(&self, standing: &RestJoints) -> f64 {
        let hip = standing.height(Joint::LeftThigh);
        hip + self.hem * (standing.height(Joint::LeftShank) - hip)
    }

    /// Moves the hulls of trunk, arms and neck outward.
    fn put_over(&self, outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
        // A recorded skeleton may have joints of no length.
        let neck = f64::from(wearer.skeleton.offsets[Joint::Head.index()].y).max(0.01);
        for hull in &mut outfit.hulls {
            let Some(joint) = hull.joint() else {
                continue;
            };
            // The left one of a pair.
            let left = joint.min(joint.mirrored());
            let (thick_m, along) = match left {
                Joint::Pelvis | Joint::Spine => (self.trunk_m, 1.0),
                Joint::Thorax | Joint::LeftClavicle => (self.trunk_m, ABOVE),
                Joint::LeftUpperArm | Joint::LeftForearm => (self.sleeves_m, ABOVE),
                // A collar is open above.
                Joint::Neck => (self.collar_m, 0.0),
                _ => continue,
            };
            let along = DVec3::new(1.0, along, 1.0);
            swell(hull, BodyPart::Garment, along, |(_, point)| {
                let share = match left {
                    Joint::Neck => 1.0 - CLOSER * (f64::from(point.y) / neck).clamp(0.0, 1.0),
                    _ => 1.0,
                };
                thick_m * share * strength
            });
        }
    }
}

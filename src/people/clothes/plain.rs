//! Clothes that follow the body, and short hair: existing hulls, moved outward.

use super::body_sections::{RestJoints, swell};
use super::{BodyPart, Outfit, Wearer};
use edgegait_core::skeleton::Joint;
use glam::DVec3;

/// Distances of clothes from the parts of a body, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ease {
    /// Distance from the trunk.
    pub trunk_m: f64,
    /// Distance from the upper arms.
    pub upper_arms_m: f64,
    /// Distance from the forearms.
    pub forearms_m: f64,
    /// Distances from the thighs at the hips, and at the knees.
    pub thighs_m: [f64; 2],
    /// Distance from the shanks.
    pub shanks_m: f64,
}

/// Puts on clothes that follow the body. Moves the hulls of the trunk and the limbs across their
/// length; hands, feet, the neck and the head stay.
pub(crate) fn clothes(outfit: &mut Outfit, wearer: &Wearer, ease: &Ease) {
    for hull in &mut outfit.hulls {
        let Some(joint) = hull.joint() else {
            continue;
        };
        // The left one of a pair.
        let left = joint.min(joint.mirrored());
        let [from, to] = match left {
            Joint::Pelvis | Joint::Spine | Joint::Thorax | Joint::LeftClavicle => [ease.trunk_m; 2],
            Joint::LeftUpperArm => [ease.upper_arms_m; 2],
            Joint::LeftForearm => [ease.forearms_m; 2],
            Joint::LeftThigh => ease.thighs_m,
            Joint::LeftShank => [ease.shanks_m; 2],
            _ => continue,
        };
        if [from, to] == [0.0; 2] {
            continue;
        }
        let thigh = f64::from(-wearer.skeleton.offsets[Joint::LeftShank.index()].y).max(0.01);
        let sideways = DVec3::new(1.0, 0.0, 1.0);
        // Shoulders have cloth above them too.
        let along = match left {
            Joint::Thorax | Joint::LeftClavicle => DVec3::ONE,
            _ => sideways,
        };
        swell(hull, BodyPart::Garment, along, |(_, point)| {
            let share = (f64::from(-point.y) / thigh).clamp(0.0, 1.0);
            from + share * (to - from)
        });
    }
}

/// Shares of the head's height above which hair grows all around, and at the back. Our choice.
const HAIRLINE: f64 = 0.75;
const NAPE: f64 = 0.3;

/// Puts on short hair of a thickness, metres: moves the points of the head above the brow and
/// behind the ears.
pub(crate) fn short_hair(outfit: &mut Outfit, wearer: &Wearer, thick_m: f64) {
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let head = standing.slice(outfit, &[Joint::Head], f64::MIN..=f64::MAX);
    let ((min, max), middle) = (head.bounds(), head.centre());
    let tall = (max.y - min.y).max(1e-6);
    let hulls = outfit.hulls.iter_mut();
    for hull in hulls.filter(|hull| hull.joint() == Some(Joint::Head)) {
        swell(hull, BodyPart::Hair, DVec3::ONE, |point| {
            let place = standing.place(point);
            let up = (place.y - min.y) / tall;
            let is_hairy = up > HAIRLINE || up > NAPE && place.z < middle.z;
            if is_hairy { thick_m } else { 0.0 }
        });
    }
}

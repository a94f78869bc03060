//! Loads: boxes with bevelled edges, on the back, at the hip, and in a hand.

use crate::people::clothes::{BodyPart, Outfit, RestJoints, Wearer, WornHull};
use edgegait_core::skeleton::Joint;
use glam::DVec3;

/// The hand that carries the suitcase.
pub(crate) const CARRYING_HAND: Joint = Joint::RightHand;

/// Breadth, height and depth of a backpack, metres. Our choice: a full day pack of about 25 l.
const BACKPACK_M: DVec3 = DVec3::new(0.32, 0.46, 0.20);
/// Thickness, height and length of a shoulder bag, metres. Our choice.
const BAG_M: DVec3 = DVec3::new(0.12, 0.30, 0.38);
/// Thickness, height and length of a suitcase, metres: the largest common cabin luggage
/// (recalled).
const SUITCASE_M: DVec3 = DVec3::new(0.20, 0.40, 0.55);
/// The depth to which a load sinks into the body, metres, so that no gap shows between them.
const OVERLAP_M: f64 = 0.03;

/// Adds a backpack. Strength 1: 32 cm broad, 46 cm tall and 20 cm deep (our choice), its top at the
/// height of the shoulders; sizes grow with the strength. One hull of 16 points, on the thorax.
pub(crate) fn backpack(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let size = BACKPACK_M * strength;
    let top = standing.height(Joint::LeftUpperArm);
    let trunk = [Joint::Thorax, Joint::Spine];
    let (least, _) = standing
        .slice(outfit, &trunk, top - BACKPACK_M.y..=top - 0.05)
        .bounds();
    let middle = DVec3::new(
        standing.at(Joint::Thorax).x,
        top - 0.5 * BACKPACK_M.y,
        least.z - 0.5 * size.z + OVERLAP_M,
    );
    outfit
        .hulls
        .push(case(&standing, Joint::Thorax, middle, size));
}

/// Adds a bag that hangs from the right shoulder to the left hip. Strength 1: 12 cm thick,
/// 30 cm tall and 38 cm long (our choice); sizes grow with the strength. One hull of 16 points, on
/// the pelvis.
pub(crate) fn shoulder_bag(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let size = BAG_M * strength;
    let hip = standing.at(Joint::LeftThigh);
    let seat = [Joint::Pelvis, Joint::LeftThigh];
    let (_, most) = standing
        .slice(outfit, &seat, hip.y - 0.10..=hip.y + 0.10)
        .bounds();
    let middle = DVec3::new(most.x + 0.5 * size.x - OVERLAP_M, hip.y, hip.z);
    outfit
        .hulls
        .push(case(&standing, Joint::Pelvis, middle, size));
}

/// Adds a suitcase in the right hand. Strength 1: 55 cm long, 40 cm tall and 20 cm thick (the
/// largest common cabin luggage, recalled); sizes grow with the strength. One hull of 16
/// points, on the hand. The caller must hold the arm still.
pub(crate) fn suitcase(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let size = SUITCASE_M * strength;
    let hand = standing.at(CARRYING_HAND);
    let around = standing.slice(outfit, &[CARRYING_HAND], f64::MIN..=f64::MAX);
    let low = if around.is_empty() {
        hand.y
    } else {
        around.bounds().0.y
    };
    let middle = DVec3::new(hand.x, low + OVERLAP_M - 0.5 * size.y, hand.z);
    outfit
        .hulls
        .push(case(&standing, CARRYING_HAND, middle, size));
}

/// Returns a box about `middle` with bevelled edges along its X axis.
fn case(standing: &RestJoints, joint: Joint, middle: DVec3, size: DVec3) -> WornHull {
    let half = 0.5 * size;
    let mut points = Vec::new();
    for x in [-1.0, 1.0] {
        for (y, z) in [(0.7, 1.0), (1.0, 0.8)] {
            for (up, ahead) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let place = middle + half * DVec3::new(x, y * up, z * ahead);
                points.push(standing.hang(joint, place));
            }
        }
    }
    WornHull {
        part: BodyPart::Load,
        points,
    }
}

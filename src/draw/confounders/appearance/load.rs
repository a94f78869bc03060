//! Loads: on the back, at the hip, in the hands, overhead, and ahead.

use crate::draw::confounders::motion::{AROUND_BOX, AT_THE_BAR, ArmPose, UNDER_UMBRELLA, raised};
use crate::people::clothes::{BodyPart, Outfit, RestJoints, Wearer, WornHull};
use edgegait_core::skeleton::{Joint, Skeleton};
use glam::DVec3;
use std::f64::consts::TAU;

/// The hand that carries the suitcase.
pub(crate) const CARRYING_HAND: Joint = Joint::RightHand;

/// Breadth, height and depth of a backpack, metres. Our choice: a full day pack of about 25 l.
const BACKPACK_M: DVec3 = DVec3::new(0.32, 0.46, 0.20);
/// Thickness, height and length of a shoulder bag, and the distances of its middle behind and
/// below the hip, metres. Our choice: bags of 24 people of CASIA-B widen the lower trunk by 2.5 to 3.5 columns of
/// 2.7 cm from the side, mostly behind it.
const BAG_M: DVec3 = DVec3::new(0.12, 0.34, 0.40);
const BEHIND_M: f64 = 0.10;
const BELOW_M: f64 = 0.05;
/// Depth of a backpack's top below the shoulders, metres. Our choice, for the same reason.
const SLUNG_M: f64 = 0.05;
/// Thickness, height and length of a suitcase, metres: the largest common cabin luggage
/// (recalled).
const SUITCASE_M: DVec3 = DVec3::new(0.20, 0.40, 0.55);
/// Breadth, height and depth of a box that is carried before the body, metres. Our choice: a carton.
const BOX_M: DVec3 = DVec3::new(0.40, 0.30, 0.32);
/// Radius of an umbrella and height of its canopy, thickness of its shaft, and the height of the
/// canopy's rim above the head, metres. Our choice.
const CANOPY_M: [f64; 2] = [0.50, 0.18];
const SHAFT_M: f64 = 0.015;
const OVERHEAD_M: f64 = 0.05;
/// Breadth of a stroller, and the length from its bar to the hub of its front wheels, metres. Our
/// choice, after common ones.
const STROLLER_M: [f64; 2] = [0.50, 0.70];
/// The height above the floor at which the wheels end, metres: a stroller goes up and down with the
/// head, and may not lift the feet.
const WHEELS_UP_M: f64 = 0.06;
/// The depth to which a load sinks into the body, metres, so that no gap shows between them.
const OVERLAP_M: f64 = 0.03;

/// Adds a backpack. Strength 1: 32 cm broad, 46 cm tall and 20 cm deep, its top 5 cm below the
/// shoulders (our choice); sizes grow with the strength. One hull of 16 points, on the thorax.
pub(crate) fn backpack(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let size = BACKPACK_M * strength;
    let top = standing.height(Joint::LeftUpperArm) - SLUNG_M;
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
/// 34 cm tall and 40 cm long, its middle 10 cm behind and 5 cm below the hip (our choice); sizes grow with the
/// strength. One hull of 16 points, on the pelvis.
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
    let middle = DVec3::new(
        most.x + 0.5 * size.x - OVERLAP_M,
        hip.y - BELOW_M,
        hip.z - BEHIND_M,
    );
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

/// Opens an umbrella. Strength 1: 1 m wide and 18 cm high, its rim 5 cm above the head (our choice).
/// It is held wholly up from a strength of a quarter on; its width grows with the strength. Two
/// hulls of 17 and 8 points, on the thorax. The caller must pose the arm.
pub(crate) fn umbrella(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let held = Held::new(outfit, wearer, Joint::Thorax, strength);
    let grip = held.grip(UNDER_UMBRELLA, -1.0);
    let head = held
        .standing
        .slice(outfit, &[Joint::Head], f64::MIN..=f64::MAX)
        .bounds()
        .1
        .y;
    let [radius, rise] = CANOPY_M;
    let rim = DVec3::new(0.5 * grip.x, head.max(grip.y) + OVERHEAD_M, 0.5 * grip.z);
    let mut canopy = vec![rim + DVec3::Y * rise];
    for (height, share) in [(0.0, 1.0), (0.7 * rise, 0.65)] {
        canopy.extend((0..8).map(|index| {
            let (sin, cos) = libm::sincos(TAU * f64::from(index) / 8.0);
            let out = radius * share * strength;
            rim + DVec3::new(out * cos, height, out * sin)
        }));
    }
    let (low, high) = (grip - DVec3::Y * 0.1, rim + DVec3::Y * rise);
    let shaft = [low, high].map(|end| square(end, 0.5 * SHAFT_M));
    for places in [canopy, shaft.concat()] {
        outfit.hulls.push(held.hull(places));
    }
}

/// Adds a box before the belly. Strength 1: 40 cm broad, 30 cm high and 32 cm deep (our choice);
/// sizes grow with the strength. One hull of 16 points, on the thorax. The caller must pose the
/// arms.
pub(crate) fn carried_box(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let held = Held::new(outfit, wearer, Joint::Thorax, strength);
    let size = BOX_M * strength;
    let grip = held.grip(AROUND_BOX, -1.0);
    let trunk = [Joint::Thorax, Joint::Spine, Joint::Pelvis];
    let (_, most) = held
        .standing
        .slice(
            outfit,
            &trunk,
            grip.y - 0.5 * BOX_M.y..=grip.y + 0.5 * BOX_M.y,
        )
        .bounds();
    let middle = DVec3::new(
        0.0,
        grip.y + 0.35 * size.y,
        most.z + 0.5 * size.z - OVERLAP_M,
    );
    outfit
        .hulls
        .push(case(&held.standing, Joint::Thorax, middle, size));
}

/// Adds a stroller. Strength 1: 70 cm long and 50 cm wide, with a seat under a hood and four wheels
/// (our choice). It stands before the walker from a strength of a quarter on; its length grows with
/// the strength. Four hulls of 8 to 16 points, on the head, which turns least. The caller must pose
/// the arms.
pub(crate) fn stroller(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let held = Held::new(outfit, wearer, Joint::Head, strength);
    let grip = held.grip(AT_THE_BAR, -1.0).with_x(0.0);
    let feet = [Joint::LeftFoot, Joint::RightFoot];
    let soles = held.standing.slice(outfit, &feet, f64::MIN..=f64::MAX);
    let floor = soles.bounds().0.y.min(grip.y) + WHEELS_UP_M;
    let [breadth, length] = STROLLER_M;
    // Corners by their heights above the floor and places between the bar (0) and the front (1).
    let sides = |corners: &[(f64, f64)]| -> Vec<DVec3> {
        let each = corners.iter().flat_map(|&(up, ahead)| {
            let place = DVec3::new(0.0, floor + up, grip.z + ahead * length * strength);
            [0.5, -0.5].map(|side| place + DVec3::X * (side * breadth))
        });
        each.collect()
    };
    let bar = grip.y - floor;
    let wheel = |ahead: f64, radius: f64| -> Vec<(f64, f64)> {
        let rim = (0..8).map(|index| {
            let (sin, cos) = libm::sincos(TAU * f64::from(index) / 8.0);
            (radius * (1.0 + sin), ahead + radius * cos / length)
        });
        rim.collect()
    };
    for corners in [
        // The bar and the frame, from the hands to the front wheels.
        vec![
            (bar - 0.02, 0.0),
            (bar + 0.02, 0.0),
            (0.08, 1.0),
            (0.12, 1.0),
        ],
        // The seat and its hood.
        vec![
            (0.62, 0.25),
            (0.95, 0.30),
            (0.98, 0.50),
            (0.88, 0.68),
            (0.55, 1.0),
            (0.38, 1.0),
            (0.32, 0.55),
        ],
        wheel(0.35, 0.12),
        wheel(1.0, 0.09),
    ] {
        outfit.hulls.push(held.hull(sides(&corners)));
    }
}

/// What is held away from the body: at little strength still within the body, from where it is
/// raised.
struct Held {
    standing: RestJoints,
    skeleton: Skeleton,
    joint: Joint,
    /// Where it comes from, and the share of the way on which it is.
    from: DVec3,
    share: f64,
}

impl Held {
    fn new(outfit: &Outfit, wearer: &Wearer, joint: Joint, strength: f64) -> Self {
        let standing = RestJoints::from_skeleton(&wearer.skeleton);
        let trunk = [Joint::Thorax];
        let chest = standing.slice(outfit, &trunk, f64::MIN..=f64::MAX);
        Self {
            from: chest.centre(),
            skeleton: wearer.skeleton.clone(),
            standing,
            joint,
            share: raised(strength),
        }
    }

    /// Returns the place of a posed hand's grip, on the left (1) or right (-1).
    fn grip(&self, arm: ArmPose, side: f64) -> DVec3 {
        let shoulder = if side > 0.0 {
            Joint::LeftUpperArm
        } else {
            Joint::RightUpperArm
        };
        self.standing.at(shoulder) + arm.reach(&self.skeleton, side)
    }

    /// Returns a hull of these places when it is raised.
    fn hull(&self, places: Vec<DVec3>) -> WornHull {
        let place = |place: DVec3| self.from + self.share * (place - self.from);
        let points = places.into_iter().map(place);
        WornHull {
            part: BodyPart::Load,
            points: points
                .map(|at| self.standing.hang(self.joint, at))
                .collect(),
        }
    }
}

/// Returns the corners of a level square about a place.
fn square(middle: DVec3, half: f64) -> [DVec3; 4] {
    [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(x, z)| middle + half * DVec3::new(x, 0.0, z))
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

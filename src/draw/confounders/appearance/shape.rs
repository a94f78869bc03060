//! Changes of body proportions: mass, build and age, by published dimensions.

use crate::people::clothes::{BodyPart, Outfit, RestJoints, Wearer};
use crate::people::cohort::anthropometry::{DIMENSIONS, Dimensions, NAMES};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::{Joint, Skeleton};
use glam::DVec3;

/// The factor on a person's mass at strength 1. Our choice: two standard deviations of the body
/// mass index in ANSUR II are 29 % of the mean for men and 27 % for women.
const MASS_FACTOR: f64 = 1.3;
/// The ranges of stature, metres, and body mass index that the regressions cover, less rounding.
const STATURE_M: (f64, f64) = (0.5, 2.5);
const BMI: (f64, f64) = (12.001, 59.999);
/// The height of the lumbar joint (at the iliac crests) above the navel, where waists are
/// measured, metres: ANSUR II's means are 0.005 for men and 0.016 for women.
const NAVEL_M: f64 = 0.010;
/// Residual standard deviations of the build at strength 1. Our choice.
const BUILD_SD: f64 = 2.0;
/// Loss of stature between the ages of 30 and 80, metres: men, women. Sorkin, Muller & Andres
/// (1999), Am. J. Epidemiol. 150:969-977, abstract.
const LOSS_M: (f64, f64) = (0.05, 0.08);

/// Returns whether a dimension is a length or a height, by its name.
fn is_length(name: &str) -> bool {
    name.ends_with("height")
        || name.ends_with("length") && name != "head_length"
        || name == "tragion_to_vertex"
}

/// Adds mass to the body, or removes it at negative strengths. Strength 1: 1.3 times the mass
/// (26 kg more for ANSUR II's mean man of 85 kg), -1: divided by 1.3, within body mass indices of
/// 12 to 60. Breadths and depths of all hulls follow ANSUR II's regressions on the body mass
/// index ([`Dimensions`]); lengths stay.
pub(crate) fn body_mass(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    let before = wearer.expected(1.0, &[0.0; DIMENSIONS]);
    let factor = libm::pow(MASS_FACTOR, strength);
    let after = wearer.expected(factor, &[0.0; DIMENSIONS]);
    reshape(outfit, wearer, &before, &after);
}

/// Broadens the build, or narrows it at negative strengths. Strength 1: all breadths, depths and
/// girths are two residual standard deviations above what ANSUR II's regressions give for the
/// same stature and mass ([`Dimensions`]), -1: two below (the number is ours). Lengths stay.
pub(crate) fn build(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    let residuals = NAMES.map(|name| {
        if is_length(name) {
            0.0
        } else {
            BUILD_SD * strength
        }
    });
    let before = wearer.expected(1.0, &[0.0; DIMENSIONS]);
    let after = wearer.expected(1.0, &residuals);
    reshape(outfit, wearer, &before, &after);
}

/// Ages the body. Strength 1: 80 years instead of 30. Men lose 5 cm and women 8 cm of stature
/// (Sorkin, Muller & Andres 1999), all from the trunk: pose the body with the skeleton of
/// [`Wearer::aged`]. Waists are 4 % broader and 10 % deeper, chests 3 % deeper, thighs 6 %,
/// calves 5 % and arms 4 % slenderer (recalled from cross-sections of the NHANES surveys, not
/// checked).
pub(crate) fn age_body(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let before = wearer.expected(1.0, &[0.0; DIMENSIONS]);
    let mut after = before.clone();
    for (dimension, more) in [
        (&mut after.waist_breadth, 0.04),
        (&mut after.waist_depth, 0.10),
        (&mut after.chest_depth, 0.03),
        (&mut after.thigh_circumference, -0.06),
        (&mut after.lower_thigh_circumference, -0.05),
        (&mut after.calf_circumference, -0.05),
        (&mut after.biceps_circumference, -0.04),
        (&mut after.forearm_circumference, -0.04),
    ] {
        *dimension *= 1.0 + more * strength;
    }
    reshape(outfit, wearer, &before, &after);
    let share = wearer.kept_of_trunk(strength);
    for hull in &mut outfit.hulls {
        for (joint, point) in &mut hull.points {
            if matches!(joint, Joint::Spine | Joint::Thorax) {
                point.y = (f64::from(point.y) * share) as f32;
            }
        }
    }
}

impl Wearer {
    /// Returns the person at the age of [`age_body`]: a shorter trunk and a smaller stature. Pose
    /// the aged body with this skeleton.
    #[must_use]
    pub(crate) fn aged(&self, strength: f64) -> Self {
        let mut offsets = self.skeleton.offsets;
        let share = self.kept_of_trunk(strength);
        for joint in [
            Joint::Thorax,
            Joint::Neck,
            Joint::LeftClavicle,
            Joint::RightClavicle,
        ] {
            let offset = &mut offsets[joint.index()];
            offset.y = (f64::from(offset.y) * share) as f32;
        }
        Self {
            skeleton: Skeleton { offsets },
            stature_m: self.stature_m - self.lost_m() * strength,
            ..self.clone()
        }
    }

    /// Returns the dimensions that the regressions expect at `factor` times the mass, with stature
    /// and body mass index clamped to the regressions' ranges.
    fn expected(&self, factor: f64, residuals: &[f64; DIMENSIONS]) -> Dimensions {
        let stature_m = self.stature_m.clamp(STATURE_M.0, STATURE_M.1);
        let area = stature_m * stature_m;
        let mass_kg = (factor * self.mass_kg).clamp(BMI.0 * area, BMI.1 * area);
        let person = Dimensions::expected(stature_m, mass_kg, self.sex, residuals);
        person.expect("a stature and a mass index within the range of the regressions")
    }

    /// Returns the stature that the person loses by the age of 80, metres.
    fn lost_m(&self) -> f64 {
        match self.sex {
            Some(Sex::Male) => LOSS_M.0,
            Some(Sex::Female) => LOSS_M.1,
            None => 0.5 * (LOSS_M.0 + LOSS_M.1),
        }
    }

    /// Returns the share of the trunk's height above the lumbar joint that remains.
    fn kept_of_trunk(&self, strength: f64) -> f64 {
        let rise = |joint: Joint| f64::from(self.skeleton.offsets[joint.index()].y);
        let trunk = rise(Joint::Thorax) + rise(Joint::Neck);
        // A recorded skeleton may have joints of no length.
        1.0 - self.lost_m() * strength / trunk.max(4.0 * LOSS_M.1)
    }
}

/// A place on the axis of a body part, with the factors by which the part grows there: sideways,
/// and to the front and back.
#[derive(Clone, Copy)]
struct Knot {
    at: DVec3,
    grows: [f64; 2],
}

/// Scales all hulls of the body across their axes by the ratios of two people's dimensions.
fn reshape(outfit: &mut Outfit, wearer: &Wearer, before: &Dimensions, after: &Dimensions) {
    if before == after {
        return;
    }
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let knots: Vec<(Joint, Vec<Knot>)> = Joint::ALL
        .into_iter()
        .map(|joint| (joint, axis(joint, &standing, &|of| of(after) / of(before))))
        .collect();
    for hull in outfit
        .hulls
        .iter_mut()
        .filter(|hull| hull.part == BodyPart::Body)
    {
        for point in &mut hull.points {
            let (_, knots) = &knots[point.0.index()];
            *point = standing.hang(point.0, scaled(knots, standing.place(*point)));
        }
    }
}

/// Returns a place after it has moved away from its axis, at right angles to the axis.
fn scaled(knots: &[Knot], place: DVec3) -> DVec3 {
    let [first, .., last] = knots else {
        return place;
    };
    // Clavicles run across the walker, other parts up or down. Growth depends on the place along
    // this direction only.
    let whole = last.at - first.at;
    let is_across = whole.x.abs() > whole.y.abs();
    let way = if is_across {
        DVec3::X * whole.x.signum()
    } else {
        DVec3::Y * whole.y.signum()
    };
    let along = |at: DVec3| (at - first.at).dot(way);
    let pair = knots
        .windows(2)
        .rfind(|pair| along(pair[0].at) <= along(place))
        .unwrap_or(&knots[..2]);
    let [from, to] = pair else {
        return place;
    };
    // A recorded skeleton may have joints of no length.
    let length = (along(to.at) - along(from.at)).max(1e-9);
    let share = (along(place) - along(from.at)) / length;
    let within = share.clamp(0.0, 1.0);
    let [x, z] = [0, 1].map(|axis| from.grows[axis] + within * (to.grows[axis] - from.grows[axis]));
    // Beyond its ends the axis continues in a straight line.
    let middle = from.at + share * (to.at - from.at);
    let away = place - middle;
    // Clavicles grow in height as in depth.
    let grows = if is_across {
        DVec3::new(1.0, z, z)
    } else {
        DVec3::new(x, 1.0, z)
    };
    middle + away * grows
}

/// Returns the axis of the body part at a joint.
fn axis(
    joint: Joint,
    standing: &RestJoints,
    ratio: &dyn Fn(fn(&Dimensions) -> f64) -> f64,
) -> Vec<Knot> {
    let knot = |at: DVec3, breadth: fn(&Dimensions) -> f64, depth: fn(&Dimensions) -> f64| Knot {
        at,
        grows: [ratio(breadth), ratio(depth)],
    };
    let round = |at: DVec3, girth: fn(&Dimensions) -> f64| knot(at, girth, girth);
    let at = |joint: Joint| standing.at(joint);
    let below = |joint: Joint, length: f64| at(joint) - DVec3::Y * length;
    let side = |left: Joint| {
        if joint.is_left() {
            left
        } else {
            left.mirrored()
        }
    };
    let pair = |left: Joint| joint == left || joint == left.mirrored();
    if matches!(joint, Joint::Pelvis | Joint::Spine | Joint::Thorax) {
        // ANSUR II's mean chest heights are 0.24 (men) and 0.14 (women) of the way.
        let chest = at(Joint::Thorax) + 0.2 * (at(Joint::Neck) - at(Joint::Thorax));
        return vec![
            knot(at(Joint::Pelvis), |d| d.hip_breadth, |d| d.buttock_depth),
            knot(
                below(Joint::Spine, NAVEL_M),
                |d| d.waist_breadth,
                |d| d.waist_depth,
            ),
            knot(chest, |d| d.chest_breadth, |d| d.chest_depth),
            knot(
                at(Joint::Neck),
                |d| d.biacromial_breadth,
                |d| d.neck_circumference,
            ),
        ];
    }
    if joint == Joint::Neck {
        return vec![
            round(at(Joint::Neck), |d| d.neck_circumference),
            round(at(Joint::Head), |d| d.neck_circumference),
        ];
    }
    if joint == Joint::Head {
        let over = at(Joint::Head) + DVec3::Y * 0.1;
        let head = |at| knot(at, |d| d.head_breadth, |d| d.head_length);
        return vec![head(at(Joint::Head)), head(over)];
    }
    let upper_arm = at(side(Joint::LeftUpperArm));
    let forearm = at(side(Joint::LeftForearm));
    let hand = side(Joint::LeftHand);
    let shank = at(side(Joint::LeftShank));
    let foot = side(Joint::LeftFoot);
    if pair(Joint::LeftClavicle) {
        vec![
            round(at(joint), |d| d.biceps_circumference),
            round(upper_arm, |d| d.biceps_circumference),
        ]
    } else if pair(Joint::LeftUpperArm) {
        vec![
            round(upper_arm, |d| d.biceps_circumference),
            round(forearm, |d| d.forearm_circumference),
        ]
    } else if pair(Joint::LeftForearm) {
        vec![
            round(forearm, |d| d.forearm_circumference),
            round(at(hand), |d| d.wrist_circumference),
        ]
    } else if pair(Joint::LeftHand) {
        vec![
            round(at(hand), |d| d.wrist_circumference),
            knot(below(hand, 0.08), |d| d.hand_breadth, |d| d.hand_breadth),
        ]
    } else if pair(Joint::LeftThigh) {
        vec![
            round(at(joint), |d| d.thigh_circumference),
            round(shank, |d| d.lower_thigh_circumference),
        ]
    } else if pair(Joint::LeftShank) {
        vec![
            round(shank, |d| d.lower_thigh_circumference),
            round(shank + 0.28 * (at(foot) - shank), |d| d.calf_circumference),
            round(at(foot), |d| d.ankle_circumference),
        ]
    } else {
        // The sole stays where it is: feet grow in breadth alone.
        let broad = |at| knot(at, |d| d.foot_breadth, |_| 1.0);
        vec![broad(at(foot)), broad(below(foot, 0.05))]
    }
}

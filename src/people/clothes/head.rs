//! Hair, hoods and hats.

use super::body_sections::{BodySlice, RestJoints, swell};
use super::{BodyPart, Outfit, Wearer, WornHull};
use edgegait_core::skeleton::Joint;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Thickness of full hair, and reach of long hair below the base of the neck, metres. Our choice.
const HAIR_M: f64 = 0.030;
const TRESSES_M: f64 = 0.22;
/// Distance of a hood from the head and from the neck, metres, and the share of the head's depth
/// from its front that stays free. Our choice.
const HOOD_M: f64 = 0.030;
const FACE: f64 = 0.3;
/// Width of a brim beyond the head, its thickness, the distance of a hat's crown from the head,
/// and its height above the head, metres. Our choice.
const BRIM_M: f64 = 0.070;
const BRIM_THICK_M: f64 = 0.010;
const CROWN_M: f64 = 0.010;
const CROWN_ABOVE_M: f64 = 0.050;

/// A section of the head at one height.
struct Round {
    around: BodySlice,
    height: f64,
}

impl Round {
    /// Returns the section at the share `along` of the head's height, 0 at its lowest point and 1
    /// at its highest; `None` if no hull is there.
    fn at_height(outfit: &Outfit, standing: &RestJoints, along: f64) -> Option<Self> {
        let all = standing.slice(outfit, &HEAD, f64::MIN..=f64::MAX);
        let (min, max) = all.bounds();
        let height = min.y + along * (max.y - min.y);
        let near = 0.02 * (max.y - min.y);
        let around = standing.slice(outfit, &HEAD, height - near..=height + near);
        (!around.is_empty()).then_some(Self { around, height })
    }

    /// Returns the point in direction `angle`, 0 to the left and a quarter turn to the front,
    /// `span` times as far out as the head and `ease` metres more.
    fn at(&self, angle: f64, span: f64, ease: f64) -> DVec3 {
        let direction = DVec2::new(libm::cos(angle), libm::sin(angle));
        let out = direction * (span * self.around.reach(direction) + ease);
        let centre = self.around.centre();
        DVec3::new(centre.x + out.x, self.height, centre.z + out.y)
    }

    /// Returns eight points around the head.
    fn ring(&self, span: f64, ease: f64) -> [DVec3; 8] {
        std::array::from_fn(|index| self.at(TAU * index as f64 / 8.0, span, ease))
    }
}

const HEAD: [Joint; 1] = [Joint::Head];

/// Puts on full and long hair. At strength 1 it is 3 cm thick above, behind and beside the face,
/// and reaches down the back to 22 cm below the base of the neck (our choice). Adds one draped hull
/// of 26 points, on the head and the thorax, in place of existing long hair.
pub(crate) fn hair(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    outfit
        .hulls
        .retain(|hull| hull.part != BodyPart::Hair || hull.joint().is_some());
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let round = |along| Round::at_height(outfit, &standing, along);
    let (Some(top), Some(temples), Some(nape)) = (round(0.92), round(0.60), round(0.25)) else {
        return;
    };
    let thick = HAIR_M * strength;
    let span = 0.85 + 0.23 * strength;
    let mut places = Vec::new();
    let crown = standing
        .slice(outfit, &HEAD, f64::MIN..=f64::MAX)
        .bounds()
        .1
        .y;
    let mut above = top.around.centre();
    above.y = crown - 0.02 * (1.0 - strength) + thick;
    places.push(above);
    places.extend(top.ring(span, 0.8 * thick));
    // The face is free: in front, hair ends at the hairline.
    for index in 0..8 {
        let angle = TAU * f64::from(index) / 8.0;
        let is_front = (1..=3).contains(&index);
        let (span, ease) = if is_front { (0.85, 0.0) } else { (span, thick) };
        places.push(temples.at(angle, span, ease));
    }
    for index in [0, 4, 5, 6, 7] {
        places.push(nape.at(TAU * f64::from(index) / 8.0, span, thick));
    }
    let mut points: Vec<_> = places
        .into_iter()
        .map(|place| standing.hang(Joint::Head, place))
        .collect();
    // Tresses lie on the back; without any strength they end within the neck.
    let neck = standing.at(Joint::Neck);
    let end = neck.y - TRESSES_M * strength;
    let trunk = [Joint::Thorax, Joint::Spine];
    let back = standing
        .slice(outfit, &trunk, end - 0.01..=neck.y)
        .bounds()
        .0
        .z;
    let behind = neck.z + strength * (back.min(neck.z) - neck.z);
    for (side, deep) in [(0.09, 0.0), (-0.09, 0.0), (0.06, thick), (-0.06, thick)] {
        let place = DVec3::new(neck.x + side * strength, end, behind - deep);
        points.push(standing.hang(Joint::Thorax, place));
    }
    outfit.hulls.push(WornHull {
        part: BodyPart::Hair,
        points,
    });
}

/// Puts up a hood. At strength 1 it stands 3 cm away from the head above, beside and behind the
/// face, and from the neck (our choice). Moves the hulls of head and neck.
pub(crate) fn hood(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let (min, max) = standing.slice(outfit, &HEAD, f64::MIN..=f64::MAX).bounds();
    let face = max.z - FACE * (max.z - min.z);
    for hull in &mut outfit.hulls {
        if !matches!(hull.joint(), Some(Joint::Head | Joint::Neck)) {
            continue;
        }
        swell(hull, BodyPart::Garment, DVec3::ONE, |point| {
            let is_face = point.0 == Joint::Head && standing.place(point).z > face;
            if is_face { 0.0 } else { HOOD_M * strength }
        });
    }
}

/// Puts on a hat. At strength 1 it has a brim 7 cm wide around the head, above the brows, and a
/// crown that ends 5 cm above the head (our choice). Adds two hulls of 16 points, over hair if
/// there is some.
pub(crate) fn hat(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let round = |along| Round::at_height(outfit, &standing, along);
    let (Some(brow), Some(top)) = (round(0.68), round(0.90)) else {
        return;
    };
    if strength == 0.0 {
        return;
    }
    let span = 0.85 + 0.24 * strength;
    let mut brim: Vec<_> = brow.ring(span, BRIM_M * strength).into();
    let thick = DVec3::new(0.0, BRIM_THICK_M, 0.0);
    brim.extend(brim.clone().into_iter().map(|place| place + thick));
    let (_, highest) = standing.slice(outfit, &HEAD, f64::MIN..=f64::MAX).bounds();
    let lift = highest.y - top.height - 0.03 * (1.0 - strength) + CROWN_ABOVE_M * strength;
    let mut crown: Vec<_> = brow.ring(span, CROWN_M * strength).into();
    crown.extend(
        top.ring(span, CROWN_M * strength)
            .map(|place| place + DVec3::Y * lift),
    );
    for places in [brim, crown] {
        let points = places
            .into_iter()
            .map(|place| standing.hang(Joint::Head, place));
        outfit.hulls.push(WornHull {
            part: BodyPart::Garment,
            points: points.collect(),
        });
    }
}

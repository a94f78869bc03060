//! Clothes, hair and hats: hulls of a body that they move outward, and cloth that hangs.
//!
//! An [`Outfit`] begins as the hulls of a body, from any source; each function changes hulls or
//! adds some. Clothes that follow the body (sleeves, trousers, shoes) move its hulls outward, so
//! that only clothes that stand away from it need new hulls.
//!
//! Strengths are 0..=1. 0 leaves every bit unchanged; small strengths change little. Order
//! matters: trousers and shoes come before a skirt and a coat, then hair and a hat, since each
//! goes around what is already there.

mod body_sections;
mod cloth;
mod coats;
mod head;
mod plain;

pub(crate) use body_sections::RestJoints;
pub(crate) use cloth::{shoes, skirt, wide_trousers};
pub(crate) use coats::{coat, down_jacket, open_coat};
pub(crate) use head::{hair, hat, hood};
pub(crate) use plain::{Ease, clothes, short_hair};

use crate::people::{Body, BodyHull};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::{Joint, Skeleton};
use glam::{DVec3, Vec3};

/// The kind of a hull, by which pictures colour it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BodyPart {
    /// The body itself.
    Body,
    /// Hair.
    Hair,
    /// Clothes, and parts of the body that clothes enlarge.
    Garment,
    /// Carried load.
    Load,
}

/// A convex hull of a walker's body, clothes or load.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WornHull {
    /// Kind of the hull.
    pub part: BodyPart,
    /// Points of the hull, metres, each in the frame of the joint that carries it.
    pub points: Vec<(Joint, Vec3)>,
}

impl WornHull {
    /// Returns the joint that carries all of its points, if there is one.
    pub(crate) fn joint(&self) -> Option<Joint> {
        let (first, _) = self.points.first()?;
        let is_same = |(joint, _): &(Joint, Vec3)| joint == first;
        self.points.iter().all(is_same).then_some(*first)
    }
}

/// The hulls of a body and of everything that it wears and carries.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outfit {
    /// The body's hulls in the avatar's order, then the added ones in the order of dressing.
    pub hulls: Vec<WornHull>,
}

impl Outfit {
    /// Returns the hulls of a body, and nothing else.
    pub(crate) fn of_body(body: &Body) -> Self {
        let points = |hull: &BodyHull| -> Vec<(Joint, Vec3)> {
            let points = hull.points.iter();
            points.map(|point| (hull.joint, point.as_vec3())).collect()
        };
        let worn = |points| WornHull {
            part: BodyPart::Body,
            points,
        };
        let draped = body
            .draped
            .iter()
            .map(|parts| parts.iter().flat_map(points));
        Self {
            hulls: body
                .hulls
                .iter()
                .map(|hull| worn(points(hull)))
                .chain(draped.map(|points| worn(points.collect())))
                .collect(),
        }
    }

    /// Returns the body on the joints of `bare` with these hulls.
    pub(crate) fn into_body(self, bare: &Body) -> Body {
        let mut dressed = Body {
            hulls: Vec::new(),
            draped: Vec::new(),
            ..bare.clone()
        };
        for worn in self.hulls {
            let mut parts: Vec<BodyHull> = Vec::new();
            for (joint, point) in &worn.points {
                let point: DVec3 = point.as_dvec3();
                match parts.iter_mut().find(|part| part.joint == *joint) {
                    Some(part) => part.points.push(point),
                    None => parts.push(BodyHull {
                        joint: *joint,
                        points: vec![point],
                    }),
                }
            }
            match worn.joint() {
                Some(_) => dressed.hulls.append(&mut parts),
                None => dressed.draped.push(parts),
            }
        }
        dressed
    }
}

/// The wearer of an outfit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wearer {
    /// Joints of the body.
    pub skeleton: Skeleton,
    /// Sex, where it is known.
    pub sex: Option<Sex>,
    /// Stature, metres.
    pub stature_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
}

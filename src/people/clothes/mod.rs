//! What people wear: hulls of a body that clothes move outward, and cloth that hangs.
//!
//! An [`Outfit`] begins as the hulls of a body, whatever they were made from or fitted to; each
//! function changes them or adds some. What follows the body (sleeves, trousers, shoes) moves
//! hulls that are there outward, so that only what stands away from it takes new ones.
//!
//! Strengths are 0..=1. 0 changes nothing, not even a bit; small strengths change little. Order
//! matters as it does to who gets dressed: trousers and shoes before a skirt and a coat, then
//! hair and a hat: each goes around what is there.

mod body_sections;
mod cloth;
mod head;
mod plain;

pub(crate) use body_sections::RestJoints;
pub(crate) use cloth::{coat, shoes, skirt, wide_trousers};
pub(crate) use head::{hair, hat};
pub(crate) use plain::{Ease, clothes, short_hair};

use crate::people::{Body, BodyHull};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::{Joint, Skeleton};
use glam::{DVec3, Vec3};

/// What a hull is, as pictures colour it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BodyPart {
    /// The body itself.
    Body,
    /// Hair.
    Hair,
    /// Clothes; and parts of the body that clothes have made larger.
    Garment,
    /// What is carried.
    Load,
}

/// A convex hull that a walker has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WornHull {
    /// What it is.
    pub part: BodyPart,
    /// Its points, metres, each in the frame of the joint that carries it.
    pub points: Vec<(Joint, Vec3)>,
}

impl WornHull {
    /// The joint that carries all of its points, if one does.
    pub(crate) fn joint(&self) -> Option<Joint> {
        let (first, _) = self.points.first()?;
        let is_same = |(joint, _): &(Joint, Vec3)| joint == first;
        self.points.iter().all(is_same).then_some(*first)
    }
}

/// The hulls of a body and of all that it wears and carries.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outfit {
    /// The body's hulls in the avatar's order, then what was put on, in its order.
    pub hulls: Vec<WornHull>,
}

impl Outfit {
    /// The hulls of a body, and nothing else.
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

    /// The body on the joints of `bare` with these hulls.
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

/// Whose outfit it is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wearer {
    /// Where the joints are.
    pub skeleton: Skeleton,
    /// Sex, where it is known.
    pub sex: Option<Sex>,
    /// Stature, metres.
    pub stature_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
}

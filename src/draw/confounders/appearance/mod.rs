//! Body shape, clothes and loads of a walker: changes to a body's hulls, before it is posed.
//!
//! An [`Outfit`] begins as the hulls of an avatar; each function changes them or adds some.
//! Sleeves, trousers and shoes follow the body and move its hulls outward. Only what stands away
//! from the body takes new hulls: one each for a coat, a jacket, a skirt, hair, a backpack, a
//! shoulder bag, a suitcase and a box, two for a hat and an umbrella, four for a stroller. A body of
//! 24 hulls and 512 points has room for eight of them.
//!
//! Strengths are 0..=1, or -1..=1 where stated. 0 changes no bit; small strengths change little.
//! Each item goes around the hulls that are there, so order matters: first the body
//! ([`body_mass`], [`build`], [`age_body`]), then trousers, shoes, skirt, coat, hair, hood, hat, and
//! last the loads.
//!
//! Sizes that are marked as ours were chosen by looking at pictures of built-in people.

mod load;
mod shape;
#[cfg(test)]
mod tests;

pub(crate) use load::{backpack, carried_box, shoulder_bag, stroller, suitcase, umbrella};
pub(crate) use shape::{age_body, body_mass, build};

use crate::error::{Error, Result};
pub(crate) use crate::people::clothes::{
    BodyPart, Outfit, Wearer, coat, down_jacket, hair, hat, hood, open_coat, shoes, skirt,
    wide_trousers,
};
use crate::people::clothes::{RestJoints, WornHull};
use crate::people::cohort::anthropometry::{DIMENSIONS, Dimensions, PopulationNorms};
use edgegait_core::avatar::{Avatar, Hull};
use edgegait_core::body::UnpackedBody;
use edgegait_core::budget::{MAX_DRAPED_HULLS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use edgegait_core::pack::{Sex, SubjectEntry};
use edgegait_core::skeleton::{Joint, Skeleton};

/// Returns the kind of a hull: draped hulls on the head are hair, other draped hulls garments.
fn part_of(hull: &Hull<'_>) -> BodyPart {
    match (hull.drape(), hull.joint()) {
        (None, _) => BodyPart::Body,
        (Some(_), Joint::Head) => BodyPart::Hair,
        (Some(_), _) => BodyPart::Garment,
    }
}

impl Outfit {
    /// Returns the hulls of an avatar, with the clothes that it has already.
    #[must_use]
    pub(crate) fn from_avatar(avatar: &Avatar<'_>) -> Self {
        let mut hulls: Vec<WornHull> = Vec::new();
        let mut last = None;
        for hull in avatar.hulls() {
            let points = hull.points().map(|point| (hull.joint(), point));
            match hulls.last_mut() {
                Some(draped) if hull.drape().is_some() && hull.drape() == last => {
                    draped.points.extend(points);
                }
                _ => hulls.push(WornHull {
                    part: part_of(&hull),
                    points: points.collect(),
                }),
            }
            last = hull.drape();
        }
        Self { hulls }
    }

    /// Adds the hulls to a body that can be rendered. Hulls of one joint are rigid, hulls of
    /// several joints are draped.
    ///
    /// # Errors
    /// If the hulls exceed the core's budget.
    pub(crate) fn unpack(&self, body: &mut UnpackedBody) -> Result<()> {
        let is_draped = |hull: &&WornHull| hull.joint().is_none() && !hull.points.is_empty();
        let points = || self.hulls.iter().map(|hull| hull.points.len());
        for (what, found, most) in [
            ("hulls", self.hulls.len(), MAX_HULLS),
            (
                "draped hulls",
                self.hulls.iter().filter(is_draped).count(),
                MAX_DRAPED_HULLS,
            ),
            (
                "points of a hull",
                points().max().unwrap_or(0),
                MAX_HULL_POINTS,
            ),
            ("points in all", points().sum(), MAX_POINTS),
        ] {
            if found > most {
                return Err(Error::Usage(format!(
                    "a body with its clothes and loads: expected at most {most} {what}, found {found} (leave out a garment or a load)"
                )));
            }
        }
        for hull in &self.hulls {
            let pushed = match hull.joint() {
                Some(joint) => body.push(joint, hull.points.iter().map(|(_, point)| *point)),
                None => body.push_draped(hull.points.iter().copied()),
            };
            pushed.map_err(|error| {
                Error::Usage(format!(
                    "a body with its clothes and loads: {error} (leave out a garment or a load)"
                ))
            })?;
        }
        Ok(())
    }
}

impl Wearer {
    /// Creates the wearer for a subject of a pack.
    ///
    /// An unknown stature is estimated from the skeleton: the height of the skull's base above the
    /// ankles is the same share of stature as for ANSUR II's mean people. An unknown mass follows
    /// from their mean body mass index. Without a sex, the mean of men and women is used.
    #[must_use]
    pub(crate) fn new(skeleton: Skeleton, subject: &SubjectEntry<'_>) -> Self {
        let sexes = match subject.sex {
            Some(sex) => vec![sex],
            None => vec![Sex::Female, Sex::Male],
        };
        let mean = |of: &dyn Fn(Sex) -> f64| {
            sexes.iter().map(|&sex| of(sex)).sum::<f64>() / sexes.len() as f64
        };
        let bmi = mean(&|sex| PopulationNorms::for_sex(sex).bmi.0);
        let stature_m = match subject.stature_mm {
            0 => {
                let share = mean(&|sex| {
                    let (stature, bmi) = (
                        PopulationNorms::for_sex(sex).stature.0,
                        PopulationNorms::for_sex(sex).bmi.0,
                    );
                    let mass = bmi * stature * stature;
                    let person = Dimensions::expected(stature, mass, Some(sex), &[0.0; DIMENSIONS]);
                    let person = person.expect("the mean of a population is a plausible person");
                    1.0 - (person.malleolus_height + person.tragion_to_vertex) / stature
                });
                let standing = RestJoints::from_skeleton(&skeleton);
                let ankles = [Joint::LeftFoot, Joint::RightFoot].map(|foot| standing.at(foot).y);
                let head = standing.at(Joint::Head).y - 0.5 * (ankles[0] + ankles[1]);
                head / share
            }
            known => 1e-3 * f64::from(known),
        };
        let mass_kg = match subject.mass_hg {
            0 => bmi * stature_m * stature_m,
            known => 0.1 * f64::from(known),
        };
        Self {
            skeleton,
            sex: subject.sex,
            stature_m,
            mass_kg,
        }
    }
}

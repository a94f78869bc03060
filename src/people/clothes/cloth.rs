//! Clothes that enlarge the body's own hulls, and cloth that hangs from the waist.

use super::body_sections::{BodySlice, RestJoints, swell};
use super::{BodyPart, Outfit, Wearer, WornHull};
use edgegait_core::skeleton::Joint;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Place of the longest skirt's hem, as a share of the way from hip to ankle. Our choice.
const SKIRT_HEM: f64 = 0.90;
/// How much wider than the leg wide trousers are all around, metres, at the hip, the knee and
/// the ankle. Our choice: a hem of about 60 cm around.
const TROUSERS_M: [f64; 3] = [0.010, 0.030, 0.055];
/// Thickness of a sole under the ball and under the heel, metres. Under the heel it is the mean
/// of 25 mm for men and 45 mm for women (Pheasant 1996, as above); under the ball it is ours.
const SOLE_M: [f64; 2] = [0.020, 0.035];
/// Share of a foot's height above which the foot does not follow the sole. Our choice.
const INSTEP: f64 = 0.3;
/// How far shoes reach beyond the toes, and beyond the foot elsewhere, metres. Our choice.
const TOECAP_M: f64 = 0.025;
const UPPER_M: f64 = 0.006;

/// Puts on a skirt, taut between the legs. At strength 1 it reaches from the waist to a hem at
/// nine tenths of the way from the hips to the ankles, where it stands 3 cm away from the legs
/// (our choice: it is straight, so that its girth limits the stride, and its hem is no wider than
/// the steps of free legs); at strength 0.5 it ends above the knees. Adds one draped hull of 32
/// points.
pub(crate) fn skirt(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let (hip, ankle) = (
        standing.height(Joint::LeftThigh),
        standing.height(Joint::LeftFoot),
    );
    let cut = ClothCut {
        hem: hip + SKIRT_HEM * (ankle - hip),
        ease: [0.005, 0.015, 0.030, 0.030],
        strength,
    };
    outfit.hulls.push(cut.hang(outfit, &standing));
}

/// The cut of cloth that hangs from the waist.
pub(super) struct ClothCut {
    /// Height of the hem at strength 1.
    pub hem: f64,
    /// Distances from the waist, the hips, the knees and, at the hem, from the legs, metres, at
    /// strength 1.
    pub ease: [f64; 4],
    pub strength: f64,
}

/// Joints that cloth from the waist goes around at the waist and at the hips.
const TRUNK: [Joint; 2] = [Joint::Pelvis, Joint::Spine];
const SEAT: [Joint; 3] = [Joint::Pelvis, Joint::LeftThigh, Joint::RightThigh];

impl ClothCut {
    /// Returns the cloth: rings around waist and hips, and around each leg at the knee and at the
    /// hem, each on the joint that it moves with. While the hem is above the knees, the ring at
    /// the knees is on the way there.
    pub(super) fn hang(&self, outfit: &Outfit, standing: &RestJoints) -> WornHull {
        let hip = standing.height(Joint::LeftThigh);
        let knee = standing.height(Joint::LeftShank);
        let waist = standing.at(Joint::Spine).y;
        let hem = hip + self.strength * (self.hem - hip);
        // A recorded skeleton may have joints of no length.
        let share = ((hip - hem) / (hip - knee).max(0.01)).clamp(0.0, 1.0);
        let middle = hip + share * share * (knee - hip);
        let [at_waist, at_hips, at_knees, at_hem] = self.ease.map(|ease| ease * self.strength);
        let band = |height: f64| height - 0.03..=height + 0.03;

        let mut points = Vec::new();
        let around = standing.slice(outfit, &TRUNK, band(waist));
        points.extend(
            self.ring(&around, waist, at_waist)
                .map(|p| standing.hang(Joint::Spine, p)),
        );
        let around = standing.slice(outfit, &SEAT, hip - 0.06..=hip + 0.02);
        points.extend(
            self.ring(&around, hip - 0.02, at_hips)
                .map(|p| standing.hang(Joint::Pelvis, p)),
        );
        for thigh in [Joint::LeftThigh, Joint::RightThigh] {
            let shank = if thigh.is_left() {
                Joint::LeftShank
            } else {
                Joint::RightShank
            };
            let leg = [thigh, shank];
            let around = standing.slice(outfit, &leg, band(middle));
            points.extend(
                self.corners(&around, middle, at_knees)
                    .map(|p| standing.hang(thigh, p)),
            );
            // All of the leg between the two, so that calves are inside.
            let around = standing.slice(outfit, &leg, hem..=middle.max(hem));
            let on = if hem < knee { shank } else { thigh };
            points.extend(
                self.corners(&around, hem, at_hem)
                    .map(|p| standing.hang(on, p)),
            );
        }
        WornHull {
            part: BodyPart::Garment,
            points,
        }
    }

    /// Returns the cloth's size before the ease, as a share of what it goes around: less than 1 at
    /// strength 0, so that it does not show, and enough to enclose it (`all`) at strength 1.
    fn span(&self, all: f64) -> f64 {
        0.85 + self.strength * (all - 0.85)
    }

    /// Returns eight points around a slice, at one height.
    fn ring(&self, around: &BodySlice, height: f64, ease: f64) -> [DVec3; 8] {
        // The sides of an octagon are a twelfth nearer than its corners.
        let span = self.span(1.0 / libm::cos(TAU / 16.0));
        let centre = around.centre();
        std::array::from_fn(|index| {
            let angle = TAU * index as f64 / 8.0;
            let direction = DVec2::new(libm::cos(angle), libm::sin(angle));
            let out = direction * (span * around.reach(direction) + ease);
            DVec3::new(centre.x + out.x, height, centre.z + out.y)
        })
    }

    /// Returns the four corners of a slice's bounds, at one height.
    fn corners(&self, around: &BodySlice, height: f64, ease: f64) -> [DVec3; 4] {
        let span = self.span(1.0) * std::f64::consts::FRAC_1_SQRT_2.max(self.strength);
        let (min, max) = around.bounds();
        let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, z)| {
            DVec3::new(
                centre.x + x * (span * half.x + ease),
                height,
                centre.z + z * (span * half.z + ease),
            )
        })
    }
}

/// Puts on wide trousers. At strength 1 legs are 1 cm wider all around at the hips, 3 cm at the
/// knees and 5.5 cm at the ankles (our choice). Moves the legs' own hulls.
pub(crate) fn wide_trousers(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let [hip, knee, ankle] = TROUSERS_M.map(|wider| wider * strength);
    for hull in &mut outfit.hulls {
        let (from, to, child) = match hull.joint() {
            Some(Joint::LeftThigh) => (hip, knee, Joint::LeftShank),
            Some(Joint::RightThigh) => (hip, knee, Joint::RightShank),
            Some(Joint::LeftShank) => (knee, ankle, Joint::LeftFoot),
            Some(Joint::RightShank) => (knee, ankle, Joint::RightFoot),
            _ => continue,
        };
        // A recorded skeleton may have joints of no length.
        let length = f64::from(-wearer.skeleton.offsets[child.index()].y).max(0.01);
        let sideways = DVec3::new(1.0, 0.0, 1.0);
        swell(hull, BodyPart::Garment, sideways, |(_, point)| {
            let share = (f64::from(-point.y) / length).clamp(0.0, 1.0);
            from + share * (to - from)
        });
    }
}

/// Puts on shoes. At strength 1 they have soles of 2 cm under the ball and 3.5 cm under the heel
/// (the mean of Pheasant's 1996 corrections, 25 mm for men and 45 mm for women), are 2.5 cm longer
/// than the toes, and 6 mm thick elsewhere (our choice). Moves the feet's own hulls, down to where
/// the floor has to be.
pub(crate) fn shoes(outfit: &mut Outfit, wearer: &Wearer, strength: f64) {
    if strength == 0.0 {
        return;
    }
    let standing = RestJoints::from_skeleton(&wearer.skeleton);
    let feet = [Joint::LeftFoot, Joint::RightFoot].map(|foot| {
        let (min, max) = standing
            .slice(outfit, &[foot], f64::MIN..=f64::MAX)
            .bounds();
        // A foot may be flat.
        (foot, min, (max - min).max(DVec3::splat(1e-6)))
    });
    for hull in &mut outfit.hulls {
        let on = hull.joint();
        let Some(&(_, min, size)) = feet.iter().find(|(foot, ..)| on == Some(*foot)) else {
            continue;
        };
        let shares: Vec<DVec3> = hull
            .points
            .iter()
            .map(|&point| (standing.place(point) - min) / size)
            .collect();
        let level = DVec3::new(1.0, 0.0, 1.0);
        swell(hull, BodyPart::Garment, level, |_| UPPER_M * strength);
        let [ball, heel] = SOLE_M;
        for ((_, point), share) in hull.points.iter_mut().zip(shares) {
            // The sole moves down, points above it less, and the instep stays.
            let low = (1.0 - share.y / INSTEP).max(0.0);
            let sole = if share.z < 0.4 { heel } else { ball };
            let toe = ((share.z - 0.5) / 0.5).clamp(0.0, 1.0);
            let way = DVec3::new(0.0, -sole * low, (TOECAP_M - UPPER_M) * toe);
            *point += (way * strength).as_vec3();
        }
    }
}

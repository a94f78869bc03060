//! Bodies built from measurements: joint offsets, and hulls of elliptical rings.
//!
//! Lengths, breadths, depths and circumferences come from [`Dimensions`]. Values that no
//! survey measures (how far the shoulder lies inside of the acromion, how square a
//! trunk's cross-section is) are marked as ours, and chosen by eye against photographs.

use super::anthropometry::Dimensions;
use super::rings::{ELLIPSE, around, half_depth, radius, ring, ring_across, round};
use crate::people::{Body, BodyHull};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DVec3;

/// How far the diagonal points of a trunk's ring lie out, as a share of the half
/// axes: 0.707 is an ellipse. Our choice: trunks are a little square.
const TRUNK_DIAGONAL: f64 = 0.77;
/// The farthest point of the buttocks above the greater trochanter, metres: the mean
/// difference of ANSUR II's buttock and trochanterion heights.
const BUTTOCK: f64 = -0.012;
/// The navel above the iliac crests, metres: ANSUR II's mean difference is -0.005 for men and
/// -0.016 for women.
const NAVEL: f64 = -0.010;
/// How broad and deep the rib cage is at its lower end, as a share of the chest. Our choice: it
/// leaves room for the armpits.
const FLANK: f64 = 0.96;
/// Gap between the thighs under the crotch, metres. Our choice: just enough to keep them apart when
/// the body is quantised for its pack.
const CROTCH_GAP: f64 = 0.004;
/// The upper end of the patella above the epicondyles, metres: half of a patella of 4.4 cm,
/// whose middle is at their height (ANSUR II).
const SUPRAPATELLA: f64 = 0.022;
/// Circumferences of hanging arms as shares of flexed arms', and of the elbow as a share of
/// the flexed forearm's. Our choice.
const RELAXED_BICEPS: f64 = 0.92;
const RELAXED_FOREARM: f64 = 0.95;
const ELBOW: f64 = 0.88;
/// Shoulder centre below the acromion as a share of stature (about 3.5 cm), and its distance
/// from the midline as a share of the acromion's. Our choice.
pub(in crate::people) const SHOULDER_DROP: f64 = 0.020;
const SHOULDER_INSET: f64 = 0.90;
/// The armpit below the shoulder centre, as a share of stature: ANSUR II's mean axilla heights
/// are 0.064 (men) and 0.059 (women) below the acromia, less the shoulder's drop.
const AXILLA: f64 = 0.042;
/// Ankle joint ahead of the heel, as a share of foot length. Our choice.
const HEEL: f64 = 0.22;
/// Ball of the foot ahead of the heel, as a share of foot length (ANSUR ball of foot
/// length over foot length, about 0.73).
const BALL: f64 = 0.73;

/// Returns the offsets of a person's joints in the rest pose, metres.
///
/// The hip centres lie at the height of the greater trochanters and, after Harrington
/// et al. (2007, J. Biomech. 40:595-602, equation for z), 0.33 x pelvic width + 7.3 mm
/// from the midline; the pelvic width, between the iliac spines, is taken as 0.85 of
/// the breadth between the crests (our choice).
#[must_use]
pub fn offsets(d: &Dimensions) -> [DVec3; JOINTS] {
    let hip_height = d.trochanterion_height;
    let hip_side = 0.33 * 0.85 * d.bicristal_breadth + 0.0073;
    let spine_height = d.iliocristale_height;
    let trunk = d.cervicale_height - spine_height;
    let thorax_height = spine_height + 0.35 * trunk;
    let clavicle = DVec3::new(0.02, d.suprasternale_height - thorax_height, 0.04);
    let shoulder = DVec3::new(
        0.5 * SHOULDER_INSET * d.biacromial_breadth,
        d.acromial_height - SHOULDER_DROP * d.stature - thorax_height,
        -0.01,
    );
    let upper_arm = d.acromion_radiale_length - SHOULDER_DROP * d.stature;
    let mut offsets = [DVec3::ZERO; JOINTS];
    let mut set = |joint: Joint, x: f64, y: f64, z: f64| {
        offsets[joint.index()] = DVec3::new(x, y, z);
        if joint.mirrored() != joint {
            offsets[joint.mirrored().index()] = DVec3::new(-x, y, z);
        }
    };
    set(Joint::Spine, 0.0, spine_height - hip_height, -0.02);
    set(Joint::Thorax, 0.0, 0.35 * trunk, 0.0);
    set(Joint::Neck, 0.0, 0.65 * trunk, -0.02);
    let head_height = d.stature - d.tragion_to_vertex;
    set(Joint::Head, 0.0, head_height - d.cervicale_height, 0.022);
    set(Joint::LeftClavicle, clavicle.x, clavicle.y, clavicle.z);
    let arm = shoulder - clavicle;
    set(Joint::LeftUpperArm, arm.x, arm.y, arm.z);
    set(Joint::LeftForearm, 0.0, -upper_arm, 0.0);
    set(Joint::LeftHand, 0.0, -d.radiale_stylion_length, 0.0);
    set(Joint::LeftThigh, hip_side, 0.0, 0.0);
    set(Joint::LeftShank, 0.0, d.knee_height - hip_height, 0.0);
    set(
        Joint::LeftFoot,
        0.0,
        d.malleolus_height - d.knee_height,
        0.0,
    );
    offsets
}

/// Returns a body of these dimensions. `offsets` are the person's own if a skeleton was
/// measured, and [`offsets`] of the dimensions otherwise; hulls follow them.
#[must_use]
pub fn body(d: &Dimensions, offsets: [DVec3; JOINTS]) -> Body {
    let mut hulls = trunk(d, &offsets);
    for (joint, points) in limbs(d, &offsets) {
        let mirrored = points.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect();
        hulls.push(BodyHull {
            joint: joint.mirrored(),
            points: mirrored,
        });
        hulls.push(BodyHull { joint, points });
    }
    Body {
        offsets,
        hulls,
        draped: Vec::new(),
        clothes: None,
        fit: None,
    }
}

/// Returns the hulls of pelvis, spine, thorax, neck and head.
fn trunk(d: &Dimensions, offsets: &[DVec3; JOINTS]) -> Vec<BodyHull> {
    let height = |joint: Joint| offsets[joint.index()].y;
    let crotch = d.crotch_height - d.trochanterion_height;
    let spine = offsets[Joint::Spine.index()];
    let (thorax, neck) = (height(Joint::Thorax), height(Joint::Neck));
    let waist = (0.5 * d.waist_breadth, 0.5 * d.waist_depth);
    let chest = (0.5 * d.chest_breadth, 0.5 * d.chest_depth);
    let hips = (0.5 * d.hip_breadth, 0.5 * d.buttock_depth);
    let at = |y: f64, z: f64| DVec3::new(0.0, y, z);
    let square = |y: f64, z: f64, half: (f64, f64)| ring(at(y, z), half, TRUNK_DIAGONAL);
    let share = |(x, z): (f64, f64), share: f64| (share * x, share * z);

    // The pelvis is straight from the hips to the waist, at the navel, and on to its top within
    // the abdomen.
    let buttock = BUTTOCK.max(crotch + 0.02);
    let flare = NAVEL / (spine.y + NAVEL - buttock).max(0.05);
    let crest = |hips: f64, waist: f64| {
        let most = waist.min(hips);
        (waist - flare * (waist - hips)).clamp(0.85 * most, most)
    };
    let pelvis = [
        square(crotch, -0.02, (0.92 * hips.0, 0.86 * hips.1)),
        square(buttock, -0.02, hips),
        square(
            spine.y,
            spine.z + 0.01,
            (crest(hips.0, waist.0), crest(hips.1, waist.1)),
        ),
    ];
    // The rib cage reaches up to the shoulders and out to where the deltoids begin, as far as
    // the chest's breadth allows: a hull with wide shoulders is no narrower below.
    let shoulder = offsets[Joint::LeftClavicle.index()] + offsets[Joint::LeftUpperArm.index()];
    let top = shoulder.y.min(neck);
    let nipples = (d.chest_height - d.iliocristale_height - thorax)
        .min(top - 0.05)
        .max(-0.08);
    let armpit = (top - 0.05 * d.stature).max(nipples + 0.02);
    let flank = (nipples - 0.045).min(-0.01);
    let widening = (armpit - nipples) / (nipples - flank);
    let widest = (1.0 + (1.0 - FLANK) * widening) * chest.0;
    let beside = (shoulder.x - 0.5 * deltoid(d, offsets)).clamp(0.8 * chest.0, widest);
    let ribs = [
        square(flank, 0.005, share(chest, FLANK)),
        square(nipples, 0.005, chest),
        square(armpit, 0.0, (beside, 0.90 * chest.1)),
        square(top + 0.01, -0.015, (0.85 * beside, 0.62 * chest.1)),
    ];
    // The abdomen's top lies on the line from the waist to the chest. Its lower end is narrow
    // enough that the waist remains the slenderest part of slender people.
    let under_chest = (nipples - 0.015).min(0.02);
    // A recorded skeleton may have joints of no length.
    let rise = (thorax + under_chest - NAVEL).max(0.05);
    let along = rise / (rise + nipples - under_chest);
    let between = |waist: f64, chest: f64| waist + along * (chest - waist);
    let upper = (between(waist.0, chest.0), between(waist.1, chest.1));
    let within = |waist: f64, upper: f64| waist - 0.035 / rise * (upper - waist).max(0.0);
    let abdomen = [
        square(
            NAVEL - 0.035,
            0.01,
            (within(waist.0, upper.0), within(waist.1, upper.1)),
        ),
        square(NAVEL, 0.01, waist),
        square(thorax + under_chest, 0.01, upper),
    ];
    // A column up to the seventh vertebra; above it tapers into the head.
    let throat = radius(d.neck_circumference);
    let skull = offsets[Joint::Head.index()];
    let below = (top - neck).min(0.0) - 0.02;
    let neck_hull = [
        round(at(below, 0.005), throat),
        round(at(0.0, 0.015), throat),
        round(at(skull.y + 0.01, skull.z - 0.01), 0.92 * throat),
    ];
    [
        (Joint::Pelvis, pelvis.concat()),
        (Joint::Spine, abdomen.concat()),
        (Joint::Thorax, ribs.concat()),
        (Joint::Neck, neck_hull.concat()),
        (Joint::Head, head(d)),
    ]
    .into_iter()
    .map(|(joint, points)| BodyHull { joint, points })
    .collect()
}

/// Returns the points of the head about the ear's height: chin, jaw, temples and crown.
fn head(d: &Dimensions) -> Vec<DVec3> {
    let (half_breadth, half_length) = (0.5 * d.head_breadth, 0.5 * d.head_length);
    let crown = d.tragion_to_vertex;
    let at = |y: f64, z: f64| DVec3::new(0.0, y, z);
    let chin_z = half_length - 0.02;
    let mut points = vec![
        DVec3::new(0.25 * half_breadth, -0.75 * crown, chin_z),
        DVec3::new(-0.25 * half_breadth, -0.75 * crown, chin_z),
        DVec3::new(0.55 * half_breadth, -0.62 * crown, 0.3 * half_length),
        DVec3::new(-0.55 * half_breadth, -0.62 * crown, 0.3 * half_length),
        at(crown, 0.0),
    ];
    let jaw = (0.93 * half_breadth, 0.96 * half_length);
    points.extend(ring(at(-0.25 * crown, 0.005), jaw, 0.74));
    points.extend(ring(
        at(0.30 * crown, 0.0),
        (half_breadth, half_length),
        0.74,
    ));
    let top = (0.82 * half_breadth, 0.82 * half_length);
    points.extend(ring(at(0.80 * crown, -0.005), top, 0.72));
    points
}

/// Returns the hulls of the left limbs.
fn limbs(d: &Dimensions, offsets: &[DVec3; JOINTS]) -> Vec<(Joint, Vec<DVec3>)> {
    let [clavicle, upper_arm] = shoulder(d, offsets);
    let length = |joint: Joint| -offsets[joint.index()].y;
    let at = DVec3::new;
    let elbow = radius(d.forearm_circumference);
    let fore = length(Joint::LeftHand);
    let wrist = around(d.wrist_circumference, (0.85, 1.15), 0.74);
    let forearm = [
        round(at(0.0, 0.02, 0.0), ELBOW * elbow),
        round(at(0.0, -0.20 * fore, 0.0), RELAXED_FOREARM * elbow),
        ring(at(0.0, -fore, 0.0), wrist, 0.74),
    ];
    // Half-closed, as walkers carry it: 0.85 of the stretched length (our choice).
    let (hand, palm) = (0.85 * d.hand_length, 0.5 * d.hand_breadth);
    let hand_points = [
        ring(at(0.0, 0.01, 0.0), (0.90 * wrist.0, 0.90 * wrist.1), 0.74),
        ring(at(-0.005, -0.50 * hand, 0.0), (0.018, palm), 0.80),
        ring(at(-0.015, -hand, 0.005), (0.014, 0.60 * palm), 0.80),
    ];
    let thigh_length = length(Joint::LeftShank);
    let knee = radius(d.lower_thigh_circumference);
    // Deeper than broad where round thighs would not fit beside each other.
    let breadth = (0.25 * d.hip_breadth - 0.5 * CROTCH_GAP).min(radius(d.thigh_circumference));
    let thigh = (breadth, half_depth(d.thigh_circumference, breadth));
    let crotch = d.crotch_height - d.trochanterion_height;
    let groin = 0.5 * d.hip_breadth - thigh.0 - offsets[Joint::LeftThigh.index()].x;
    // The thighs meet in the midline at the crotch and part below it, as a V that no lean of the
    // legs closes from below, so that no hole opens between them and the pelvis.
    let hip = offsets[Joint::LeftThigh.index()].x;
    let parted = hip + groin - thigh.0;
    let top = (crotch + 0.05).max(0.01);
    // The hull is straight from there to the knee where the ring between them is farther out.
    let past_knee = (hip - knee) / (crotch - SUPRAPATELLA + thigh_length).max(0.1);
    let beyond = (top - crotch) * (parted / 0.04).min(past_knee);
    let beyond = beyond.clamp(0.0, 0.03);
    let (inner, outer) = (-hip - beyond, groin + 0.96 * thigh.0);
    let thigh_hull = [
        ring(
            at(0.5 * (outer + inner), top, -0.015),
            (0.5 * (outer - inner), 0.90 * thigh.1),
            ELLIPSE,
        ),
        ring(at(groin, crotch - 0.04, -0.01), thigh, ELLIPSE),
        round(at(0.0, SUPRAPATELLA - thigh_length, 0.0), knee),
        round(at(0.0, -thigh_length - 0.015, 0.0), 0.85 * knee),
    ];
    let shank_length = length(Joint::LeftFoot);
    let (calf, ankle) = (radius(d.calf_circumference), radius(d.ankle_circumference));
    // The shin is straight: calves bulge to the back.
    let under_knee = knee.min(calf);
    let shin = under_knee + 0.30 / 0.94 * (ankle - under_knee);
    let shank = [
        round(at(0.0, 0.015, 0.0), under_knee),
        round(at(0.0, -0.28 * shank_length, shin.min(calf) - calf), calf),
        round(at(0.0, -0.92 * shank_length, 0.0), ankle),
        round(at(0.0, -shank_length, 0.0), 0.86 * ankle),
    ];
    vec![
        (Joint::LeftClavicle, clavicle),
        (Joint::LeftUpperArm, upper_arm),
        (Joint::LeftForearm, forearm.concat()),
        (Joint::LeftHand, hand_points.concat()),
        (Joint::LeftThigh, thigh_hull.concat()),
        (Joint::LeftShank, shank.concat()),
        (Joint::LeftFoot, foot(d)),
    ]
}

/// Returns the left clavicle, from within the neck along the trapezius to the acromion, and the
/// left upper arm, whose topmost and outermost point is the acromion.
fn shoulder(d: &Dimensions, offsets: &[DVec3; JOINTS]) -> [Vec<DVec3>; 2] {
    let at = DVec3::new;
    let joint = offsets[Joint::LeftUpperArm.index()];
    let upper = -offsets[Joint::LeftForearm.index()].y;
    let deltoid = deltoid(d, offsets);
    let arm = RELAXED_BICEPS * radius(d.biceps_circumference);
    let elbow = (ELBOW * radius(d.forearm_circumference)).min(0.95 * arm);
    // At least as thick as the arm, however far out the skeleton has its shoulders.
    let cap = deltoid.max(1.15 * arm);
    let (inset, drop) = (
        0.5 * (1.0 - SHOULDER_INSET) * d.biacromial_breadth,
        SHOULDER_DROP * d.stature,
    );
    let neck = offsets[Joint::Neck.index()].y - offsets[Joint::LeftClavicle.index()].y - joint.y;
    let trapezius = (neck - 0.01 * d.stature).clamp(2.3 * drop, 3.0 * drop);
    let within_neck = 0.5 * radius(d.neck_circumference) - offsets[Joint::LeftClavicle.index()].x;
    let armpit = -AXILLA * d.stature;
    let clavicle = [
        ring_across(
            joint + at(0.1 * deltoid, 0.0, 0.0),
            (armpit.min(-0.85 * cap), drop),
            0.85 * cap,
        ),
        ring_across(
            at(within_neck, joint.y, joint.z),
            (armpit.min(-0.80 * cap), trapezius),
            0.80 * cap,
        ),
    ];
    // A hull is at least as broad as the straight line from the deltoid to the elbow. Where that
    // is farther out than the arm, the arm moves outwards, and the deltoid less far inwards.
    let straight = 0.5 * (deltoid + elbow);
    let bulge = (straight - arm).clamp(0.0, 0.4 * arm);
    let inside = (2.0 * (arm - bulge) - elbow).min(arm);
    let upper_arm = [
        ring(
            at(inset - 0.4 * arm, drop, 0.0),
            (0.4 * arm, 0.8 * arm),
            ELLIPSE,
        ),
        ring(
            at(0.5 * (deltoid - inside), -0.10 * upper, 0.0),
            (0.5 * (deltoid + inside), 1.05 * arm),
            ELLIPSE,
        ),
        round(at(bulge, -0.55 * upper, 0.0), arm),
        round(at(0.0, -upper, 0.0), elbow),
    ];
    [clavicle.concat(), upper_arm.concat()]
}

/// Returns how far the deltoid reaches out from the shoulder joint, metres: to half the bideltoid
/// breadth, and at least 3 cm.
fn deltoid(d: &Dimensions, offsets: &[DVec3; JOINTS]) -> f64 {
    let joint = offsets[Joint::LeftClavicle.index()].x + offsets[Joint::LeftUpperArm.index()].x;
    (0.5 * d.bideltoid_breadth - joint).max(0.03)
}

/// Returns the points of a foot: heel, ball, toes that rise a little (so that a push-off rolls
/// over the ball, like a foot that bends at the toes), and instep. Its lowest points are the sole.
fn foot(d: &Dimensions) -> Vec<DVec3> {
    let (length, half, sole) = (d.foot_length, 0.5 * d.foot_breadth, -d.malleolus_height);
    let mut points = Vec::new();
    for (width, y, along) in [
        (0.50, sole, 0.03),
        (0.35, sole + 0.025, 0.0),
        (0.50, -0.01, 0.04),
        (0.55, 0.02, HEEL + 0.12),
        (1.00, sole, BALL),
        (0.80, sole + 0.045, BALL - 0.03),
        (0.60, sole + 0.028, 0.97),
        (0.45, sole + 0.042, 1.0),
    ] {
        for side in [1.0, -1.0] {
            points.push(DVec3::new(side * width * half, y, (along - HEEL) * length));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::super::anthropometry::DIMENSIONS;
    use super::*;
    use edgegait_core::pack::Sex;

    fn man() -> Dimensions {
        Dimensions::expected(1.756, 85.4, Some(Sex::Male), &[0.0; DIMENSIONS])
            .expect("a plausible man")
    }

    /// All hull points in the rest pose with the soles on the floor.
    fn standing(d: &Dimensions) -> Vec<(Joint, DVec3)> {
        let body = body(d, offsets(d));
        let mut positions = [DVec3::new(0.0, d.trochanterion_height, 0.0); JOINTS];
        for joint in Joint::ALL {
            if let Some(parent) = joint.parent() {
                positions[joint.index()] = positions[parent.index()] + body.offsets[joint.index()];
            }
        }
        let points = body.hulls.iter().flat_map(|hull| {
            let at = positions[hull.joint.index()];
            hull.points.iter().map(move |&p| (hull.joint, at + p))
        });
        points.collect()
    }

    #[test]
    fn a_body_stands_as_tall_and_wide_as_it_was_measured() {
        let d = man();
        let points = standing(&d);
        let max = |axis: usize| points.iter().map(|(_, p)| p[axis]).fold(f64::MIN, f64::max);
        let min = |axis: usize| points.iter().map(|(_, p)| p[axis]).fold(f64::MAX, f64::min);
        assert!((max(1) - 1.756).abs() < 1e-9);
        assert!(min(1).abs() < 1e-9);
        assert!((max(0) - min(0) - d.bideltoid_breadth).abs() < 0.01);
    }

    #[test]
    fn breadths_and_depths_are_those_asked_for() {
        let d = man();
        let points = standing(&d);
        let span = |joint: Joint, axis: usize| {
            let along = || {
                points
                    .iter()
                    .filter(|(j, _)| *j == joint)
                    .map(|(_, p)| p[axis])
            };
            along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
        };
        assert!((span(Joint::Pelvis, 0) - d.hip_breadth).abs() < 1e-9);
        assert!((span(Joint::Spine, 0) - d.waist_breadth).abs() < 1e-9);
        assert!((span(Joint::Head, 0) - d.head_breadth).abs() < 1e-9);
        assert!((span(Joint::LeftFoot, 2) - d.foot_length).abs() < 1e-9);
    }

    #[test]
    fn left_and_right_mirror_each_other() {
        let d = man();
        let body = body(&d, offsets(&d));
        for hull in &body.hulls {
            let other: Vec<_> = body
                .hulls
                .iter()
                .filter(|h| h.joint == hull.joint.mirrored())
                .collect();
            let [other] = other.as_slice() else {
                panic!("one hull a joint")
            };
            assert_eq!(other.points.len(), hull.points.len());
        }
    }
}

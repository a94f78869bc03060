//! Bodies built from measurements: joint offsets, and hulls of elliptical rings.
//!
//! Lengths, breadths, depths and circumferences come from [`Dimensions`]. Values that no
//! survey measures (how far the shoulder lies inside of the acromion, how square a
//! trunk's cross-section is) are marked as ours, and chosen by eye against photographs.

use super::anthropometry::Dimensions;
use super::head_and_neck::{NECK_WITHIN, head_points, neck_points};
use super::limbs::{SHOULDER_DROP, SHOULDER_INSET, deltoid, limbs};
use super::rings::ring;
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
/// The tragus ahead of the hips, as a share of stature: the centre of the head is 15 mm ahead in a
/// standard and 57 mm ahead in a natural and comfortable posture (50 young adults, X-rays: BMC
/// Musculoskelet. Disord. 2020, 10.1186/s12891-020-03715-2). Walkers are taken to be between both.
const TRAGUS_AHEAD: f64 = 0.0205;
/// The line from the seventh cervical vertebra to the tragus is 48.9 degrees above horizontal, and
/// that from the shoulder to the vertebra 53.7 (160 adults, standing at ease: Raine & Twomey 1997,
/// Arch. Phys. Med. Rehabil. 78:1215-1223): their cotangents.
const TRAGUS_COTANGENT: f64 = 0.872;
const SHOULDER_COTANGENT: f64 = 0.735;
/// The marker of that shoulder below the acromion, as a share of stature: halfway to the centre.
/// Our choice.
const SHOULDER_MARKER: f64 = 0.5 * SHOULDER_DROP;
/// How far the back between the shoulders has reached from the nape to its rearmost point, halfway
/// down, as a share: backs are round. Our choice.
const KYPHOSIS: f64 = 0.65;
/// Joints of spine and thorax behind the hips, metres: the lumbar joint, and that at the twelfth
/// thoracic vertebra (Dumas & Wojtusch 2018, for the standing pelvic tilt; rounded).
const SPINE_BEHIND: f64 = 0.020;
const THORAX_BEHIND: f64 = 0.005;
/// Centres of cross-sections ahead of the hips, metres: of the buttocks, the crest, the waist, and
/// the chest. They bring the centres of volume near those of Dumas & Wojtusch (2018), whose pelvis,
/// without the groin, has its centre 4 cm behind the hips.
const BUTTOCKS_Z: f64 = -0.033;
const WAIST_Z: f64 = -0.005;
const CHEST_Z: f64 = 0.008;
/// How far the pelvis reaches below the crotch, metres. Our choice: no gap opens under a pelvis that
/// tips.
const GROIN: f64 = 0.013;

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
    let head_height = d.stature - d.tragion_to_vertex;
    // Ahead of the hips.
    let tragus = TRAGUS_AHEAD * d.stature;
    let nape = tragus - TRAGUS_COTANGENT * (head_height - d.cervicale_height);
    let marker = d.acromial_height - SHOULDER_MARKER * d.stature;
    let shoulder_z = nape + SHOULDER_COTANGENT * (d.cervicale_height - marker);
    let neck = nape + NECK_WITHIN * d.stature;
    let clavicle = DVec3::new(0.02, d.suprasternale_height - thorax_height, 0.05);
    let shoulder = DVec3::new(
        0.5 * SHOULDER_INSET * d.biacromial_breadth,
        d.acromial_height - SHOULDER_DROP * d.stature - thorax_height,
        shoulder_z + THORAX_BEHIND,
    );
    let upper_arm = d.acromion_radiale_length - SHOULDER_DROP * d.stature;
    let mut offsets = [DVec3::ZERO; JOINTS];
    let mut set = |joint: Joint, x: f64, y: f64, z: f64| {
        offsets[joint.index()] = DVec3::new(x, y, z);
        if joint.mirrored() != joint {
            offsets[joint.mirrored().index()] = DVec3::new(-x, y, z);
        }
    };
    let rise = spine_height - hip_height;
    set(Joint::Spine, 0.0, rise, -SPINE_BEHIND);
    set(
        Joint::Thorax,
        0.0,
        0.35 * trunk,
        SPINE_BEHIND - THORAX_BEHIND,
    );
    set(Joint::Neck, 0.0, 0.65 * trunk, THORAX_BEHIND + neck);
    let skull = head_height - d.cervicale_height;
    set(Joint::Head, 0.0, skull, tragus - neck);
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
    let crest = |hips: f64, waist: f64| waist - flare * (waist - hips);
    let half_crest = |hips: f64, waist: f64| {
        let most = waist.min(hips);
        crest(hips, waist).clamp(0.85 * most, most)
    };
    let pelvis = [
        square(crotch - GROIN, BUTTOCKS_Z, (0.92 * hips.0, 0.86 * hips.1)),
        square(buttock, BUTTOCKS_Z, hips),
        square(
            spine.y,
            spine.z + SPINE_BEHIND + crest(BUTTOCKS_Z, WAIST_Z),
            (half_crest(hips.0, waist.0), half_crest(hips.1, waist.1)),
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
    let chest_z = THORAX_BEHIND + CHEST_Z;
    // The back curves from the nape to its rearmost point at the chest.
    let nape_z = offsets[Joint::Neck.index()].z - NECK_WITHIN * d.stature;
    let back_z = nape_z + KYPHOSIS * (chest_z - chest.1 - nape_z).min(0.0);
    let ribs = [
        square(flank, chest_z, share(chest, FLANK)),
        square(nipples, chest_z, chest),
        square(armpit, chest_z - 0.005, (beside, 0.90 * chest.1)),
        square(
            top + 0.01,
            back_z + 0.66 * chest.1,
            (0.85 * beside, 0.66 * chest.1),
        ),
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
    let waist_z = SPINE_BEHIND + WAIST_Z;
    let upper_z = offsets[Joint::Thorax.index()].z + chest_z;
    let abdomen = [
        square(
            NAVEL - 0.035,
            // In line with what is above: a hull's section at the navel is no deeper than the waist.
            waist_z - 0.035 / rise * (upper_z - waist_z),
            (within(waist.0, upper.0), within(waist.1, upper.1)),
        ),
        square(NAVEL, waist_z, waist),
        square(thorax + under_chest, upper_z, upper),
    ];
    // Within the top of the rib cage.
    let below = (top - neck).min(0.0) - 0.02;
    [
        (Joint::Pelvis, pelvis.concat()),
        (Joint::Spine, abdomen.concat()),
        (Joint::Thorax, ribs.concat()),
        (
            Joint::Neck,
            neck_points(d, &offsets[Joint::Head.index()], below),
        ),
        (Joint::Head, head_points(d)),
    ]
    .into_iter()
    .map(|(joint, points)| BodyHull { joint, points })
    .collect()
}

#[cfg(test)]
mod tests;

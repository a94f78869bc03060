//! The hulls of a body's arms and legs.

use super::anthropometry::Dimensions;
use super::rings::{ELLIPSE, around, half_depth, radius, ring, ring_across, round};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DVec3;

/// Shoulder centre below the acromion as a share of stature (about 3.5 cm), and its distance
/// from the midline as a share of the acromion's. Our choice.
pub(in crate::people) const SHOULDER_DROP: f64 = 0.020;
pub(super) const SHOULDER_INSET: f64 = 0.90;
/// How far the diagonal points of a thigh's ring lie out under the crotch, as a share of the half
/// axes: 0.707 is an ellipse. Our choice: thighs are a little square where they touch each other, so
/// that they are no deeper than the buttocks.
const THIGH_DIAGONAL: f64 = 0.715;
/// Gap between the thighs under the crotch, metres. Our choice: just enough to keep them apart when
/// the body is quantised for its pack.
const CROTCH_GAP: f64 = 0.004;
/// How far a thigh reaches past the midline at the crotch at least, metres. Our choice, as above.
const CROTCH_LAP: f64 = 0.0005;
/// The upper end of the patella above the epicondyles, metres: half of a patella of 4.4 cm,
/// whose middle is at their height (ANSUR II).
const SUPRAPATELLA: f64 = 0.022;
/// Circumferences of hanging arms as shares of flexed arms', and of the elbow as a share of
/// the flexed forearm's. Our choice.
const RELAXED_BICEPS: f64 = 0.92;
const RELAXED_FOREARM: f64 = 0.95;
const ELBOW: f64 = 0.88;
/// The armpit below the shoulder centre, as a share of stature: ANSUR II's mean axilla heights
/// are 0.064 (men) and 0.059 (women) below the acromia, less the shoulder's drop.
const AXILLA: f64 = 0.042;
/// Centres of a leg's cross-sections ahead of the line from the hip to the knee, and from the knee
/// to the ankle, as shares of their lengths: legs' centres of volume are 4.1 % (men) and 7.7 %
/// (women) of a thigh's and 4.8 % of a shank's length behind these lines (Dumas & Wojtusch 2018).
const THIGH_Z: f64 = -0.070;
const KNEE_Z: f64 = -0.010;
const CALF_Z: f64 = -0.058;
const ANKLE_Z: f64 = -0.025;
/// Ankle joint ahead of the heel, as a share of foot length. Our choice.
const HEEL: f64 = 0.22;
/// Ball of the foot ahead of the heel, as a share of foot length (ANSUR ball of foot
/// length over foot length, about 0.73).
const BALL: f64 = 0.73;

/// Returns the hulls of the left limbs.
pub(super) fn limbs(d: &Dimensions, offsets: &[DVec3; JOINTS]) -> Vec<(Joint, Vec<DVec3>)> {
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
    let thigh = (
        breadth,
        half_depth(d.thigh_circumference, breadth, THIGH_DIAGONAL),
    );
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
    let beyond = (beyond + CROTCH_LAP).clamp(0.0, 0.03);
    let (inner, outer) = (-hip - beyond, groin + 0.96 * thigh.0);
    let thigh_hull = [
        ring(
            at(0.5 * (outer + inner), top, THIGH_Z * thigh_length),
            (0.5 * (outer - inner), 0.90 * thigh.1),
            THIGH_DIAGONAL,
        ),
        ring(
            at(groin, crotch - 0.04, THIGH_Z * thigh_length),
            thigh,
            THIGH_DIAGONAL,
        ),
        round(
            at(0.0, SUPRAPATELLA - thigh_length, KNEE_Z * thigh_length),
            knee,
        ),
        round(
            at(0.0, -thigh_length - 0.015, KNEE_Z * thigh_length),
            0.85 * knee,
        ),
    ];
    let shank_length = length(Joint::LeftFoot);
    let (calf, ankle) = (radius(d.calf_circumference), radius(d.ankle_circumference));
    // The shin is straight from the ankle to the knee: calves bulge to the back.
    let (calf_z, ankle_z) = (CALF_Z * shank_length, ANKLE_Z * shank_length);
    let tilt = (calf_z + calf - ankle_z - ankle) / (0.92 - 0.28);
    let under_knee = 0.92 * knee.min(calf);
    let shin = calf_z + calf + 0.28 * tilt;
    let shank = [
        round(at(0.0, 0.015, shin - under_knee), under_knee),
        round(at(0.0, -0.28 * shank_length, calf_z), calf),
        round(at(0.0, -0.92 * shank_length, ankle_z), ankle),
        round(at(0.0, -shank_length, ankle_z), 0.86 * ankle),
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
pub(super) fn deltoid(d: &Dimensions, offsets: &[DVec3; JOINTS]) -> f64 {
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

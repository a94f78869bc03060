//! Shoulders, elbows and wrists.

use edgegait_core::skeleton::Joint;
use glam::DVec3;

use super::frame_range::MarkerTracks;
use super::joints::{MarkerJoints, each, middles};
use super::legs::MARKER_RADIUS_M;
use super::names::{MarkerSide, Site};
use crate::people::cohort::SHOULDER_DROP;

/// Breadth of the elbow as a share of stature: 67 mm of 1.45 m in biomechzoo's HC002D, the only
/// clip that states it.
const ELBOW_BREADTH: f64 = 0.046;

/// Adds both arms as far as their markers are present.
pub(super) fn add(
    joints: &mut MarkerJoints,
    tracks: &MarkerTracks,
    stature_m: f64,
    warnings: &mut Vec<String>,
) {
    let mut missing = Vec::new();
    for (side, name, [upper_arm, forearm, hand]) in [
        (
            MarkerSide::Left,
            "left",
            [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
        ),
        (
            MarkerSide::Right,
            "right",
            [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
        ),
    ] {
        let Some(shoulder) = shoulder(joints, tracks, side, stature_m) else {
            missing.push(name);
            continue;
        };
        let wrist = wrist(tracks, side);
        let elbow = elbow(tracks, side, stature_m, &shoulder, wrist.as_deref());
        joints.put(upper_arm, shoulder);
        match (elbow, wrist) {
            (Some(elbow), Some(wrist)) => {
                joints.put(forearm, elbow);
                joints.put(hand, wrist);
            }
            (Some(elbow), None) => {
                joints.put(forearm, elbow);
                warnings.push(format!(
                    "no markers of the {name} wrist: the elbow bends as in the norm"
                ));
            }
            (None, _) => missing.push(name),
        }
    }
    if !missing.is_empty() {
        warnings.push(format!(
            "no markers of the {} arm: it swings with the other leg, as in the norm",
            missing.join(" and the ")
        ));
    }
}

/// Returns the shoulder: the middle of the markers in front of and behind it, else a point below
/// the acromion marker along the rib cage, as far as in the cohort's bodies.
fn shoulder(
    joints: &MarkerJoints,
    tracks: &MarkerTracks,
    side: MarkerSide,
    stature_m: f64,
) -> Option<Vec<DVec3>> {
    if let (Some(front), Some(back)) = (
        tracks.get(Site::ShoulderFront, side),
        tracks.get(Site::ShoulderBack, side),
    ) {
        return Some(middles(front, back));
    }
    let drop_m = SHOULDER_DROP * stature_m + MARKER_RADIUS_M;
    let turns = joints.turns(Joint::Thorax)?;
    Some(each(
        tracks.get(Site::Shoulder, side)?,
        turns,
        |marker, turn| marker - turn * DVec3::Y * drop_m,
    ))
}

fn wrist(tracks: &MarkerTracks, side: MarkerSide) -> Option<Vec<DVec3>> {
    let thumb = tracks.get(Site::WristThumb, side);
    let little = tracks.get(Site::WristLittle, side);
    match (thumb, little) {
        (Some(thumb), Some(little)) => Some(middles(thumb, little)),
        (Some(one), None) | (None, Some(one)) => Some(one.to_vec()),
        (None, None) => None,
    }
}

/// Returns the elbow: the middle of its two markers, else half its breadth inside the lateral one,
/// perpendicular to the plane of the arm, as in Plug-in Gait.
fn elbow(
    tracks: &MarkerTracks,
    side: MarkerSide,
    stature_m: f64,
    shoulder: &[DVec3],
    wrist: Option<&[DVec3]>,
) -> Option<Vec<DVec3>> {
    /// Sine of the bend below which the arm has no plane. Our choice: 10 degrees.
    const LEAST_BEND: f64 = 0.17;
    let marker = tracks.get(Site::Elbow, side)?;
    if let Some(medial) = tracks.get(Site::ElbowMedial, side) {
        return Some(middles(marker, medial));
    }
    let depth_m = 0.5 * ELBOW_BREADTH * stature_m + MARKER_RADIUS_M;
    let Some(wrist) = wrist else {
        return Some(marker.to_vec());
    };
    let inwards = (0..marker.len()).map(|i| {
        let upper = (marker[i] - shoulder[i]).normalize_or_zero();
        let fore = (wrist[i] - marker[i]).normalize_or_zero();
        // The forearm bends ahead: lower end x upper end points to the walker's right.
        let normal = fore.cross(upper);
        (normal.length() > LEAST_BEND).then(|| side.sign() * -normal.normalize())
    });
    let inwards: Vec<Option<DVec3>> = inwards.collect();
    let mut last = inwards.iter().flatten().next().copied();
    let centres = marker.iter().zip(inwards).map(|(marker, inward)| {
        last = inward.or(last);
        last.map_or(*marker, |inward| marker + inward * depth_m)
    });
    Some(centres.collect())
}

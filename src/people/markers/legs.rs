//! Knees, ankles and feet.

use edgegait_core::skeleton::Joint;
use glam::{DQuat, DVec3};

use super::centres::{Prior, chord, motion_of, shared_centre};
use super::frame_range::MarkerTracks;
use super::joints::{MarkerJoints, each, frames_of, middles};
use super::names::{MarkerPlace, MarkerSide, Segment, Site};
use super::pelvis::Pelvis;
use super::set::median;

/// Breadths of the knee and of the ankle as shares of the distance from the anterior iliac spine to
/// the ankle: medians of the subject parameters in the tests of pyCGM (leg 940, knee 105, ankle
/// 70 mm) and pyCGM2 (860, 102, 75 and 893, 91, 66), and in the files of a BTK sample (695, 90,
/// 65), of biomechzoo's HC002D (740, 83, 62) and of the Sydney clips (851, 111, 59).
const KNEE_BREADTH: f64 = 0.115;
const ANKLE_BREADTH: f64 = 0.079;

/// Height of a marker's centre above the skin, metres: Plug-in Gait's markers of 14 mm.
pub(super) const MARKER_RADIUS_M: f64 = 0.007;

/// Length of the thigh as a share of thigh plus shank: 0.245 and 0.246 statures (Winter 2009,
/// figure 4.1, after Drillis & Contini 1966).
const THIGH_SHARE: f64 = 0.245 / 0.491;

/// Place of an ankle without a marker: between heel and toe markers, as a share of their distance,
/// and above them, metres. Our choice, for an adult: as in the cohort's bodies.
const ANKLE_AHEAD: f64 = 0.22;
const ANKLE_ABOVE_M: f64 = 0.04;

/// The minimum cosine between a constructed knee or ankle axis and the pelvis's; a construction
/// below it is rejected. Our choice: 60 degrees.
const LEAST_LATERAL: f64 = 0.5;

/// The joints of one leg, by frame.
struct MarkerLeg {
    knee: Vec<DVec3>,
    ankle: Vec<DVec3>,
    /// Unit vector to the left along the knee's axis.
    left: Vec<DVec3>,
}

/// Adds both legs.
pub(super) fn add(
    joints: &mut MarkerJoints,
    tracks: &MarkerTracks,
    pelvis: &Pelvis,
    warnings: &mut Vec<String>,
) -> Result<(), String> {
    for (side, hips, [thigh, shank, foot]) in [
        (
            MarkerSide::Left,
            &pelvis.hips[0],
            [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
        ),
        (
            MarkerSide::Right,
            &pelvis.hips[1],
            [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
        ),
    ] {
        let leg = leg(tracks, pelvis, hips, side, warnings)?;
        let thigh_up = each(hips, &leg.knee, |a, b| a - b);
        let shank_up = each(&leg.knee, &leg.ankle, |a, b| a - b);
        let shanks = frames_of(&leg.left, &shank_up);
        joints.turn(thigh, frames_of(&leg.left, &thigh_up));
        joints.turn(
            foot,
            feet(tracks, side, &leg, &shanks, &pelvis.ahead, warnings),
        );
        joints.turn(shank, shanks);
        joints.put(thigh, hips.clone());
        joints.put(shank, leg.knee);
        joints.put(foot, leg.ankle);
    }
    Ok(())
}

/// Returns the distances from marker to joint centre of the knee and the ankle: half the breadth
/// plus a marker's radius.
fn depths(tracks: &MarkerTracks) -> (f64, f64) {
    let mut lengths: Vec<f64> = Vec::new();
    for side in MarkerSide::BOTH {
        let ankle = tracks
            .get(Site::Ankle, side)
            .or_else(|| tracks.get(Site::AnkleCentre, side));
        if let (Some(asis), Some(ankle)) = (tracks.get(Site::Asis, side), ankle) {
            lengths.extend(each(asis, ankle, DVec3::distance));
        }
    }
    let leg_m = median(&mut lengths);
    let half = |share: f64| 0.5 * share * leg_m + MARKER_RADIUS_M;
    (half(KNEE_BREADTH), half(ANKLE_BREADTH))
}

/// Returns the ankle's marker, or its centre if there is none. Without knee and ankle markers, the
/// clusters determine the centres, the ankle first.
fn ankle_near(
    tracks: &MarkerTracks,
    side: MarkerSide,
    say: &mut dyn FnMut(&str, &str),
) -> Result<Vec<DVec3>, String> {
    let clusters = |segment| motion_of(&tracks.tracks(segment, side));
    let functional_ankle = || {
        let (shank, foot) = (clusters(Segment::Shank)?, clusters(Segment::Foot)?);
        let (heel, toe) = (tracks.get(Site::Heel, side)?, toe(tracks, side)?);
        let above = tracks.tracks(Segment::Shank, side);
        let near: Vec<DVec3> = (0..heel.len())
            .map(|frame| {
                let sole = heel[frame].lerp(toe[frame], ANKLE_AHEAD);
                let shin =
                    above.iter().map(|track| track[frame]).sum::<DVec3>() / above.len() as f64;
                sole + (shin - sole).normalize_or_zero() * ANKLE_ABOVE_M
            })
            .collect();
        shared_centre(&shank, &foot, Prior::Near(&near))
    };
    Ok(
        match (
            tracks.get(Site::Ankle, side),
            tracks.get(Site::AnkleCentre, side),
        ) {
            (Some(marker), _) => marker.to_vec(),
            (None, Some(centre)) => {
                say(
                    &MarkerPlace(Site::Ankle, side).to_string(),
                    "no marker: the file's joint centre is used",
                );
                centre.to_vec()
            }
            (None, None) => {
                say(
                    &MarkerPlace(Site::Ankle, side).to_string(),
                    "no marker: taken where shank and foot turn about each other",
                );
                functional_ankle().ok_or_else(|| {
                    format!("no marker for the {}", MarkerPlace(Site::Ankle, side))
                })?
            }
        },
    )
}

fn leg(
    tracks: &MarkerTracks,
    pelvis: &Pelvis,
    hips: &[DVec3],
    side: MarkerSide,
    warnings: &mut Vec<String>,
) -> Result<MarkerLeg, String> {
    let (knee_m, ankle_m) = depths(tracks);
    let mut say = |what: &str, how: &str| warnings.push(format!("{what}: {how}"));
    let clusters = |segment| motion_of(&tracks.tracks(segment, side));
    let ankle_marker = tracks.get(Site::Ankle, side);
    let ankle_near = ankle_near(tracks, side, &mut say)?;
    let square = |down: &[DVec3]| -> Vec<DVec3> {
        let line = each(hips, down, |a, b| a - b);
        each(&pelvis.left, &line, |left, line| {
            left.reject_from(line).normalize_or_zero()
        })
    };
    let sign = side.sign();
    let lateral =
        |axis: &[DVec3]| median(&mut each(axis, &pelvis.left, DVec3::dot)) > LEAST_LATERAL;
    let (knee, left) = match tracks.get(Site::Knee, side) {
        Some(marker) => match knee_of(tracks, marker, hips, side, knee_m, &lateral) {
            Some(found) => found,
            None => {
                say(
                    &MarkerPlace(Site::Knee, side).to_string(),
                    "no medial marker and no thigh wand on the outer side: the knee's axis is taken as the pelvis's",
                );
                let left = square(marker);
                (
                    each(marker, &left, |marker, left| marker - sign * knee_m * left),
                    left,
                )
            }
        },
        None => {
            let centre = tracks.get(Site::KneeCentre, side).map(<[DVec3]>::to_vec);
            let turning = || {
                shared_centre(
                    &clusters(Segment::Thigh)?,
                    &clusters(Segment::Shank)?,
                    Prior::Across(&middles(hips, &ankle_near), &pelvis.left),
                )
            };
            let (knee, how) = match (centre, turning()) {
                (Some(centre), _) => (centre, "the file's joint centre is used"),
                (None, Some(centre)) => {
                    (centre, "taken where thigh and shank turn about each other")
                }
                (None, None) => (
                    bent(hips, &ankle_near, &pelvis.ahead),
                    "it bends forward as far as hip and ankle require",
                ),
            };
            say(
                &MarkerPlace(Site::Knee, side).to_string(),
                &format!("no marker: {how}"),
            );
            let left = square(&ankle_near);
            (knee, left)
        }
    };
    let ankle = match ankle_marker {
        None => ankle_near,
        Some(marker) => {
            let medial = tracks
                .get(Site::AnkleMedial, side)
                .map(|medial| middles(marker, medial));
            let wand = || {
                let wand = tracks.get(Site::ShankWand, side)?;
                let centre = chords(wand, &knee, marker, ankle_m)?;
                lateral(&each(marker, &centre, |m, c| sign * (m - c) / ankle_m)).then_some(centre)
            };
            medial.or_else(wand).unwrap_or_else(|| {
                each(marker, &left, |marker, left| marker - sign * ankle_m * left)
            })
        }
    };
    Ok(MarkerLeg { knee, ankle, left })
}

/// Returns the knee's centre and its axis to the left, from a medial marker or by the chord with
/// the thigh's wand.
fn knee_of(
    tracks: &MarkerTracks,
    marker: &[DVec3],
    hips: &[DVec3],
    side: MarkerSide,
    depth_m: f64,
    is_lateral: &dyn Fn(&[DVec3]) -> bool,
) -> Option<(Vec<DVec3>, Vec<DVec3>)> {
    let centre = match tracks.get(Site::KneeMedial, side) {
        Some(medial) => middles(marker, medial),
        None => chords(tracks.get(Site::ThighWand, side)?, hips, marker, depth_m)?,
    };
    let left = each(marker, &centre, |m, c| {
        (side.sign() * (m - c)).normalize_or_zero()
    });
    is_lateral(&left).then_some((centre, left))
}

/// Returns the [`chord`] of every frame.
fn chords(wand: &[DVec3], from: &[DVec3], at: &[DVec3], depth_m: f64) -> Option<Vec<DVec3>> {
    let frames = wand.iter().zip(from).zip(at);
    frames
        .map(|((wand, from), at)| chord(*wand, *from, *at, depth_m))
        .collect()
}

/// Returns the knees of legs of constant length that bend forward.
fn bent(hips: &[DVec3], ankles: &[DVec3], ahead: &[DVec3]) -> Vec<DVec3> {
    /// Length of the leg over its longest reach, so that the knee is never quite straight. Our
    /// choice.
    const STRAIGHTEST: f64 = 1.005;
    let reach = each(hips, ankles, DVec3::distance);
    let leg_m = STRAIGHTEST * reach.iter().copied().fold(0.0, f64::max);
    let (thigh, shank) = (THIGH_SHARE * leg_m, (1.0 - THIGH_SHARE) * leg_m);
    each(
        &each(hips, ankles, |hip, ankle| (hip, ankle)),
        ahead,
        |(hip, ankle), ahead| {
            let line = ankle - hip;
            let d = line.length().max(1e-6);
            let along = (thigh * thigh - shank * shank + d * d) / (2.0 * d);
            let out = libm::sqrt((thigh * thigh - along * along).max(0.0));
            hip + line / d * along + ahead.reject_from(line).normalize_or_zero() * out
        },
    )
}

/// Returns the front of the foot: the second toe, else the middle of the first and the fifth, else
/// the toe tip or one of these two.
fn toe(tracks: &MarkerTracks, side: MarkerSide) -> Option<Vec<DVec3>> {
    let track = |site| tracks.get(site, side).map(<[DVec3]>::to_vec);
    let between = || {
        Some(middles(
            tracks.get(Site::FirstToe, side)?,
            tracks.get(Site::FifthToe, side)?,
        ))
    };
    track(Site::Toe).or_else(between).or_else(|| {
        [Site::ToeTip, Site::FirstToe, Site::FifthToe]
            .into_iter()
            .find_map(track)
    })
}

/// Returns the foot's orientation, level where it stands flat. It points from heel to toe; its roll
/// about that line follows the shank.
fn feet(
    tracks: &MarkerTracks,
    side: MarkerSide,
    leg: &MarkerLeg,
    shanks: &[DQuat],
    ahead: &[DVec3],
    warnings: &mut Vec<String>,
) -> Vec<DQuat> {
    /// Share of the frames, those with the lowest foot, in which it counts as flat. Our choice.
    const FLAT_SHARE: f64 = 0.15;
    let toe = toe(tracks, side);
    let heel = tracks.get(Site::Heel, side);
    let along = match (&toe, heel) {
        (Some(toe), Some(heel)) => each(toe, heel, |toe, heel| toe - heel),
        (Some(toe), None) => each(toe, &leg.ankle, |toe, ankle| toe - ankle),
        (None, _) => {
            warnings.push(format!(
                "{}: no marker: the foot is at a right angle to the shank",
                MarkerPlace(Site::Toe, side)
            ));
            each(ahead, shanks, |ahead, shank| {
                ahead.reject_from(shank * DVec3::Y)
            })
        }
    };
    let left = each(shanks, &along, |shank, along| {
        (shank * DVec3::X).reject_from(along)
    });
    let up = each(&along, &left, DVec3::cross);
    let raw = frames_of(&left, &up);
    let height = |frame: usize| {
        let toe = toe.as_ref().map_or(0.0, |toe| toe[frame].y);
        let heel = heel.map_or(0.0, |heel| heel[frame].y);
        toe + heel + leg.ankle[frame].y
    };
    let mut frames: Vec<usize> = (0..raw.len()).collect();
    frames.sort_by(|&a, &b| height(a).total_cmp(&height(b)));
    frames.truncate(((raw.len() as f64 * FLAT_SHARE) as usize).max(1));
    // Mean rotation from the markers' axes to level ones over the flat frames.
    let mut sum = glam::DVec4::ZERO;
    for &frame in &frames {
        let toe = raw[frame] * DVec3::Z;
        let level = DQuat::from_rotation_y(libm::atan2(toe.x, toe.z));
        let step = glam::DVec4::from(raw[frame].inverse() * level);
        sum += if step.dot(sum) < 0.0 { -step } else { step };
    }
    let level = if sum.length() > 1e-9 {
        DQuat::from_vec4(sum.normalize())
    } else {
        DQuat::IDENTITY
    };
    raw.into_iter().map(|turn| turn * level).collect()
}

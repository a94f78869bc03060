//! Spine, rib cage, neck and head.
//!
//! The thorax has the axes of Plug-in Gait: ahead from C7 and T10 to the clavicles and the sternum,
//! up from T10 and the sternum to C7 and the clavicles. Its joints lie along the trunk as in the
//! cohort's bodies (ANSUR II, [`body::offsets`](crate::people::cohort::body::offsets)).

use edgegait_core::skeleton::Joint;
use glam::{DQuat, DVec3};

use super::frame_range::MarkerTracks;
use super::joints::{MarkerJoints, each, frames_of, middles};
use super::names::{MarkerSide, Site};
use super::pelvis::{Pelvis, pair};
use super::set::median;

/// Height of the spine joint between hips and C7, as a share: (iliocristale - trochanterion) /
/// (cervicale - trochanterion) heights, ANSUR II means of men and women.
const SPINE_SHARE: f64 = 0.267;
/// Height of the thorax joint between the spine joint and the neck, as a share: as in the cohort's
/// bodies.
const THORAX_SHARE: f64 = 0.35;
/// Distance of spine and thorax behind hips and neck, as a share of the trunk: 2 cm of 58.
const BEHIND: f64 = 0.035;
/// Neck joint ahead of C7's marker, as a share of the way to the suprasternal notch. Our choice:
/// the vertebral body lies a little behind the middle of the neck.
const NECK_SHARE: f64 = 0.45;
/// Neck joint ahead of C7's marker without a notch marker, as a share of the trunk. Our choice: 5
/// cm of 58.
const NECK_AHEAD: f64 = 0.086;
/// Heights of C7 above the acromia and above the suprasternal notch, as shares of the trunk: ANSUR
/// II means of cervicale, acromial and suprasternale heights over cervicale less trochanterion.
const C7_ABOVE_ACROMIA: f64 = 0.117;
const C7_ABOVE_NOTCH: f64 = 0.124;
/// Sternoclavicular joints beside and behind the notch's marker, metres. Our choice.
const COLLAR_M: DVec3 = DVec3::new(0.02, 0.0, -0.02);
/// Base of the skull below the middle of the four head markers, as a share of their depth from
/// front to back. Our choice: the band is worn 5 cm above the ear canals.
const SKULL_DROP: f64 = 0.27;

/// Returns the mean of the tracks that are present.
fn mean(tracks: &[Option<Vec<DVec3>>]) -> Option<Vec<DVec3>> {
    let there: Vec<&Vec<DVec3>> = tracks.iter().flatten().collect();
    let first = there.first()?;
    let count = there.len() as f64;
    Some(
        (0..first.len())
            .map(|i| there.iter().map(|t| t[i]).sum::<DVec3>() / count)
            .collect(),
    )
}

/// The markers that determine the rib cage.
struct Ribs {
    c7: Option<Vec<DVec3>>,
    notch: Option<Vec<DVec3>>,
    t10: Option<Vec<DVec3>>,
    sternum: Option<Vec<DVec3>>,
    shoulders: Option<[Vec<DVec3>; 2]>,
}

impl Ribs {
    fn find(tracks: &MarkerTracks) -> Self {
        let single = |site| tracks.get(site, MarkerSide::Middle).map(<[DVec3]>::to_vec);
        Self {
            c7: single(Site::C7).or_else(|| single(Site::T2)),
            notch: single(Site::Clavicle)
                .or_else(|| pair(tracks, Site::ClavicleEnd).map(|[a, b]| middles(a, b))),
            t10: single(Site::T10),
            sternum: single(Site::Sternum),
            shoulders: pair(tracks, Site::Shoulder).map(|pair| pair.map(<[DVec3]>::to_vec)),
        }
    }

    /// Returns a point near the base of the neck.
    fn top(&self) -> Option<Vec<DVec3>> {
        let shoulders = self.shoulders.as_ref().map(|[a, b]| middles(a, b));
        mean(&[self.c7.clone(), self.notch.clone()]).or(shoulders)
    }

    /// Returns the walker's left.
    fn left(&self, pelvis: &Pelvis, up: &[DVec3], warnings: &mut Vec<String>) -> Vec<DVec3> {
        let front = mean(&[self.notch.clone(), self.sternum.clone()]);
        let back = mean(&[self.c7.clone(), self.t10.clone()]);
        match (front, back, &self.shoulders) {
            (Some(front), Some(back), _) => {
                each(up, &each(&front, &back, |f, b| f - b), DVec3::cross)
            }
            (.., Some([left, right])) => each(left, right, |l, r| l - r),
            _ => {
                warnings.push(
                    "the rib cage's markers do not fix its heading: it turns with the pelvis"
                        .into(),
                );
                pelvis.left.clone()
            }
        }
    }

    /// Returns the long axis from markers above one another.
    fn long_axis(&self) -> Option<Vec<DVec3>> {
        let line = |top: &Option<Vec<DVec3>>, low: &Option<Vec<DVec3>>| {
            Some(each(top.as_ref()?, low.as_ref()?, |a, b| a - b))
        };
        mean(&[line(&self.c7, &self.t10), line(&self.notch, &self.sternum)])
    }
}

/// Adds the trunk and the head as far as their markers are present.
pub(super) fn add(
    joints: &mut MarkerJoints,
    tracks: &MarkerTracks,
    pelvis: &Pelvis,
    warnings: &mut Vec<String>,
) {
    let hips = middles(&pelvis.hips[0], &pelvis.hips[1]);
    joints.turn(Joint::Pelvis, pelvis.turns.clone());
    let ribs = Ribs::find(tracks);
    if let Some(top) = ribs.top() {
        thorax(joints, &ribs, &hips, &top, pelvis, warnings);
        if !head(joints, tracks) {
            warnings.push("no markers of the head: it stays upright above the neck".into());
        }
    } else {
        warnings.push(
            "no markers of the trunk and the head: they stay upright and turn with the pelvis"
                .into(),
        );
    }
    joints.put(Joint::Pelvis, hips);
}

fn thorax(
    joints: &mut MarkerJoints,
    ribs: &Ribs,
    hips: &[DVec3],
    top: &[DVec3],
    pelvis: &Pelvis,
    warnings: &mut Vec<String>,
) {
    let trunk_m = median(&mut each(top, hips, DVec3::distance));
    let rough = each(top, hips, |top, hips| top - hips);
    let left = ribs.left(pelvis, &rough, warnings);
    let upright = frames_of(&left, &rough);
    let at = |points: &[DVec3], turns: &[DQuat], offset: DVec3| {
        each(points, turns, |p, t| p + t * offset)
    };
    let neck = match (&ribs.c7, &ribs.notch) {
        (Some(c7), Some(notch)) => each(
            &each(c7, notch, |a, b| (a, b)),
            &upright,
            |(c7, notch), turn| {
                c7 + turn * DVec3::Z * (NECK_SHARE * (turn.inverse() * (notch - c7)).z)
            },
        ),
        (Some(c7), None) => at(c7, &upright, DVec3::Z * NECK_AHEAD * trunk_m),
        (None, Some(notch)) => at(
            notch,
            &upright,
            DVec3::new(0.0, C7_ABOVE_NOTCH, -NECK_AHEAD) * trunk_m,
        ),
        (None, None) => at(top, &upright, DVec3::Y * C7_ABOVE_ACROMIA * trunk_m),
    };
    let trunk_m = median(&mut each(&neck, hips, DVec3::distance));
    let behind = DVec3::new(0.0, 0.0, -BEHIND * trunk_m);
    let spine = at(
        hips,
        &pelvis.turns,
        DVec3::Y * SPINE_SHARE * trunk_m + behind,
    );
    let line = each(&neck, &spine, |a, b| a - b);
    let turns = match ribs.long_axis() {
        Some(axis) => {
            let raw = frames_of(&left, &axis);
            // Marker axes lean by a constant: the median trunk line is taken as upright.
            let mut leans = each(&raw, &line, |turn, line| {
                let line = turn.inverse() * line;
                libm::atan2(line.z, line.y)
            });
            let level = DQuat::from_rotation_x(median(&mut leans));
            raw.into_iter().map(|turn| turn * level).collect()
        }
        None => frames_of(&left, &line),
    };
    let ribs_m = (1.0 - SPINE_SHARE) * (1.0 - THORAX_SHARE) * trunk_m;
    let thorax = at(&neck, &turns, DVec3::Y * -ribs_m + behind);
    let spine_up = each(&thorax, &spine, |a, b| a - b);
    let spine_left = each(&turns, &pelvis.turns, |a, b| {
        (a * DVec3::X) + (b * DVec3::X)
    });
    joints.turn(Joint::Spine, frames_of(&spine_left, &spine_up));
    for (joint, sign) in [(Joint::LeftClavicle, 1.0), (Joint::RightClavicle, -1.0)] {
        let from = match &ribs.notch {
            Some(notch) => at(
                notch,
                &turns,
                DVec3::new(sign * COLLAR_M.x, COLLAR_M.y, COLLAR_M.z),
            ),
            None => {
                let ahead = (NECK_SHARE * NECK_AHEAD + NECK_AHEAD) * trunk_m;
                at(
                    &neck,
                    &turns,
                    DVec3::new(sign * COLLAR_M.x, -C7_ABOVE_NOTCH * trunk_m, ahead),
                )
            }
        };
        joints.put(joint, from);
        joints.turn(joint, turns.clone());
    }
    joints.turn(Joint::Thorax, turns);
    joints.put(Joint::Spine, spine);
    joints.put(Joint::Thorax, thorax);
    joints.put(Joint::Neck, neck);
}

/// Adds the head from its four markers. Returns false if they are not all there.
fn head(joints: &mut MarkerJoints, tracks: &MarkerTracks) -> bool {
    let (Some([front_left, front_right]), Some([back_left, back_right])) =
        (pair(tracks, Site::HeadFront), pair(tracks, Site::HeadBack))
    else {
        return false;
    };
    let (front, back) = (
        middles(front_left, front_right),
        middles(back_left, back_right),
    );
    let ahead = each(&front, &back, |f, b| f - b);
    let left = each(
        &middles(front_left, back_left),
        &middles(front_right, back_right),
        |l, r| l - r,
    );
    let raw = frames_of(&left, &each(&ahead, &left, DVec3::cross));
    // Head bands sit askew: the median pitch is taken as level.
    let mut pitches: Vec<f64> = raw
        .iter()
        .map(|turn| {
            let up = turn.inverse() * DVec3::Y;
            libm::atan2(up.z, up.y)
        })
        .collect();
    let level = DQuat::from_rotation_x(median(&mut pitches));
    let turns: Vec<DQuat> = raw.into_iter().map(|turn| turn * level).collect();
    let depth_m = median(&mut ahead.iter().map(|a| a.length()).collect::<Vec<_>>());
    let skull = each(&middles(&front, &back), &turns, |p, t| {
        p - t * DVec3::Y * SKULL_DROP * depth_m
    });
    if let Some(neck) = joints.points(Joint::Neck) {
        let up = each(&skull, neck, |a, b| a - b);
        let left: Vec<DVec3> = turns.iter().map(|turn| *turn * DVec3::X).collect();
        let neck_turns = frames_of(&left, &up);
        // The neck leans ahead at rest: it turns with the head, less its median lean.
        let mut leans = each(&neck_turns, &turns, |neck, head| {
            let up = head.inverse() * (neck * DVec3::Y);
            libm::atan2(up.z, up.y)
        });
        let lean = DQuat::from_rotation_x(-median(&mut leans));
        joints.turn(
            Joint::Neck,
            neck_turns.into_iter().map(|turn| turn * lean).collect(),
        );
    }
    joints.turn(Joint::Head, turns);
    joints.put(Joint::Head, skull);
    true
}

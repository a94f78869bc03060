//! Fits the canonical skeleton to markers on a body.
//!
//! Markers are found by name, repaired, converted to metres with Y up, and low-passed. The longest
//! stretch in which the markers of the pelvis and the legs are present is used. Joint centres and
//! segment axes follow published constructions, cited where they are implemented. Parts without
//! markers move as in the norm, with a warning. Segment lengths are then made constant.

mod arms;
mod centres;
mod fit;
mod frame_range;
mod joints;
mod legs;
mod names;
mod neutral;
mod pelvis;
mod rebuild;
mod repair;
mod rigid;
mod set;
#[cfg(test)]
mod tests;
mod trunk;

use edgegait_core::skeleton::Joint;

use self::fit::FittedMotion;
use self::frame_range::MarkerTracks;
use self::joints::{MarkerJoints, each};
use self::names::{Segment, Site, place_of};
use self::neutral::Neutral;
use self::pelvis::{Pelvis, pair};
pub(super) use self::set::people;
use self::set::{Marks, median};
use super::cleaning::low_pass::LowPass;
use super::leg::LEG_SHARE;
use super::retarget::{RetargetedMotion, floor, leg_length_m};
use crate::import::Markers;
use glam::DVec3;

/// Returns whether the table of markers has a name.
pub(super) fn is_known_marker(name: &str) -> bool {
    place_of(name).is_some()
}

impl RetargetedMotion {
    /// Fits the canonical skeleton to markers. `cut_off_hz` is the cut-off of the low-pass, usually
    /// [`DEFAULT_CUT_OFF_HZ`](super::retarget::DEFAULT_CUT_OFF_HZ); `None` leaves the motion as
    /// recorded.
    ///
    /// Gaps of up to 0.2 s are filled. Longer ones are reconstructed from three other markers of
    /// the same segment. Spikes and exchanged sides are repaired. Every repair adds a warning.
    ///
    /// # Errors
    /// A sentence without the file's name: a marker is missing, or no known unit gives human legs.
    pub fn from_markers(markers: &Markers, cut_off_hz: Option<f64>) -> Result<Self, String> {
        let mut warnings = markers.warnings.clone();
        let mut marks = Marks::find(markers, &mut warnings)?;
        marks.require()?;
        let unit_m = marks.count_in_metres(markers.unit_m, &mut warnings)?;
        repair::mend_exchanged_sides(&mut marks, &mut warnings);
        repair::drop_spikes(&mut marks, &mut warnings);
        repair::fill_short_gaps(&mut marks, &mut warnings);
        rebuild::drop_strays(&mut marks, &mut warnings);
        rebuild::rebuild(&mut marks, &mut warnings);
        let mut tracks = MarkerTracks::choose(&marks, &mut warnings)?;
        let cut_off_hz = smooth(&mut tracks, cut_off_hz, marks.sample_rate_hz, &mut warnings);
        let pelvis = name_sides(&mut tracks, &mut warnings)?;

        let mut joints = MarkerJoints::default();
        legs::add(&mut joints, &tracks, &pelvis, &mut warnings)?;
        let stature_m = stature(&joints);
        trunk::add(&mut joints, &tracks, &pelvis, &mut warnings);
        arms::add(&mut joints, &tracks, stature_m, &mut warnings);
        let neutral = Neutral::new(&joints, marks.sample_rate_hz, stature_m)?;
        let mut fit = FittedMotion::new(&joints, &neutral);

        let floor_m = floor(&fit.positions, leg_length_m(&fit.offsets));
        for point in fit.positions.iter_mut().flatten() {
            point.y -= floor_m;
        }
        Ok(Self {
            sample_rate_hz: marks.sample_rate_hz,
            start_s: tracks.frames.start as f64 / marks.sample_rate_hz,
            cut_off_hz,
            unit_m,
            offsets: fit.offsets,
            is_placed: false,
            knows_upright: true,
            roots: fit
                .positions
                .iter()
                .map(|points| points[Joint::Pelvis.index()])
                .collect(),
            rotations: fit.rotations,
            positions: fit.positions,
            residual_mm: fit.residual.rms_mm(),
            warnings,
        })
    }
}

/// Low-passes the tracks and returns the cut-off, or `None` if the tracks were not filtered.
fn smooth(
    tracks: &mut MarkerTracks,
    cut_off_hz: Option<f64>,
    sample_rate_hz: f64,
    warnings: &mut Vec<String>,
) -> Option<f64> {
    let cut_off_hz = cut_off_hz?;
    let Some(filter) = LowPass::new(cut_off_hz, sample_rate_hz) else {
        warnings.push(format!(
            "the frame rate is too low for a {cut_off_hz} Hz low-pass: not filtered"
        ));
        return None;
    };
    tracks.smooth(&filter);
    Some(cut_off_hz)
}

/// Exchanges sides that were named the wrong way round and returns the pelvis. A pelvis that points
/// down means that all sides are wrong; legs or arms on the wrong side of it, that theirs are.
fn name_sides(tracks: &mut MarkerTracks, warnings: &mut Vec<String>) -> Result<Pelvis, String> {
    let mut pelvis = Pelvis::find(tracks)?;
    let mut up = each(&pelvis.ahead, &pelvis.left, |ahead, left| {
        ahead.cross(left).y
    });
    if median(&mut up) < 0.0 {
        warnings.push(
            "left and right are the wrong way round (by name, or in a left-handed file): exchanged"
                .into(),
        );
        tracks.exchange_sides(|_| true);
        pelvis = Pelvis::find(tracks)?;
    }
    let is_leg = |site: Site| {
        matches!(
            site.segment(),
            Segment::Thigh | Segment::Shank | Segment::Foot
        ) || matches!(site, Site::KneeCentre | Site::AnkleCentre)
    };
    let is_arm = |site: Site| !is_leg(site) && site.segment() != Segment::Pelvis;
    let beside = |tracks: &MarkerTracks, sites: &[Site]| {
        let [left, right] = sites.iter().find_map(|&site| pair(tracks, site))?;
        Some(median(&mut each(
            &each(left, right, |l, r| l - r),
            &pelvis.left,
            DVec3::dot,
        )))
    };
    if beside(
        tracks,
        &[Site::Knee, Site::Ankle, Site::KneeCentre, Site::AnkleCentre],
    )
    .is_some_and(|b| b < 0.0)
    {
        warnings.push("left and right legs were named the wrong way round: exchanged".into());
        tracks.exchange_sides(is_leg);
    }
    if beside(tracks, &[Site::Shoulder, Site::Elbow]).is_some_and(|b| b < 0.0) {
        warnings.push("left and right arms were named the wrong way round: exchanged".into());
        tracks.exchange_sides(is_arm);
    }
    Ok(pelvis)
}

/// Returns the stature of a person with these legs, metres.
fn stature(joints: &MarkerJoints) -> f64 {
    let length = |near, far| match (joints.points(near), joints.points(far)) {
        (Some(near), Some(far)) => median(&mut each(near, far, DVec3::distance)),
        _ => 0.0,
    };
    let left =
        length(Joint::LeftThigh, Joint::LeftShank) + length(Joint::LeftShank, Joint::LeftFoot);
    let right =
        length(Joint::RightThigh, Joint::RightShank) + length(Joint::RightShank, Joint::RightFoot);
    0.5 * (left + right) / LEG_SHARE
}

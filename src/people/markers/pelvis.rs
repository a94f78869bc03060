//! The pelvis and the hip joint centres.
//!
//! The pelvis's axes follow Davis et al. (1991), "A gait analysis data collection and reduction
//! technique", Hum. Mov. Sci. 10:575-587, and Plug-in Gait: to the left between the anterior
//! spines, ahead from the sacrum (or the middle of the posterior spines) in their plane. The hips
//! follow Harrington et al. (2007), "Prediction of the hip joint centre in adults, children, and
//! patients with cerebral palsy based on magnetic resonance imaging", J. Biomech. 40:595-602, in
//! the equations with pelvic width and depth alone.

use glam::{DQuat, DVec3};

use super::frame_range::MarkerTracks;
use super::joints::{each, frames_of, middles};
use super::names::{MarkerSide, Site};
use super::set::median;
use crate::people::cohort::STANDING_TILT_DEG;

/// The pelvis and the hips, by frame.
pub(super) struct Pelvis {
    /// Canonical orientation: upright when the person stands.
    pub(super) turns: Vec<DQuat>,
    /// Left and right hip joint centres.
    pub(super) hips: [Vec<DVec3>; 2],
    /// Unit vector to the left along the anterior spines.
    pub(super) left: Vec<DVec3>,
    /// Unit vector ahead, in the plane of the spines.
    pub(super) ahead: Vec<DVec3>,
}

/// Returns the left and the right track of a place.
pub(super) fn pair(tracks: &MarkerTracks, site: Site) -> Option<[&[DVec3]; 2]> {
    Some([
        tracks.get(site, MarkerSide::Left)?,
        tracks.get(site, MarkerSide::Right)?,
    ])
}

impl Pelvis {
    /// Finds the pelvis from the iliac spines and the sacrum.
    ///
    /// # Errors
    /// If the markers are missing or lie on a line.
    pub(super) fn find(tracks: &MarkerTracks) -> Result<Self, String> {
        let lacks = || {
            "the markers of the pelvis (LASI, RASI, SACR or LPSI and RPSI) are not seen together"
                .to_owned()
        };
        let [asis_left, asis_right] = pair(tracks, Site::Asis).ok_or_else(lacks)?;
        let back = match tracks.get(Site::Sacrum, MarkerSide::Middle) {
            Some(sacrum) => sacrum.to_vec(),
            None => {
                let [left, right] = pair(tracks, Site::Psis).ok_or_else(lacks)?;
                middles(left, right)
            }
        };
        let front = middles(asis_left, asis_right);
        let left = each(asis_left, asis_right, |l, r| (l - r).normalize_or_zero());
        let depth = each(&front, &back, |front, back| front - back);
        let ahead = each(&depth, &left, |depth, left| {
            depth.reject_from(left).normalize_or_zero()
        });
        if left
            .iter()
            .zip(&ahead)
            .any(|(l, a)| *l == DVec3::ZERO || !a.is_finite() || *a == DVec3::ZERO)
        {
            return Err("the markers of the pelvis lie on a line".into());
        }
        let up = each(&ahead, &left, DVec3::cross);
        let width_m = median(&mut each(asis_left, asis_right, DVec3::distance));
        let depth_m = median(&mut depth.iter().map(|d| d.length()).collect::<Vec<_>>());
        let centre = hip_centre(width_m, depth_m);
        let plane = frames_of(&left, &up);
        let hips = MarkerSide::BOTH.map(|side| {
            each(&front, &plane, |front, turn| {
                front + turn * DVec3::new(side.sign() * centre.x, centre.y, centre.z)
            })
        });
        let upright = DQuat::from_rotation_x(-STANDING_TILT_DEG.to_radians());
        Ok(Self {
            turns: plane.iter().map(|turn| *turn * upright).collect(),
            hips,
            left,
            ahead,
        })
    }
}

/// Returns the left hip joint centre from the middle of the anterior spines, metres: to the left,
/// up and ahead. `width_m`: between the anterior spines. `depth_m`: from their middle to the middle
/// of the posterior spines.
///
/// Harrington et al. (2007): x = -0.24 PD - 9.9, y = -0.30 PW - 10.9, z = 0.33 PW + 7.3 (mm; x
/// ahead, y up, z lateral).
fn hip_centre(width_m: f64, depth_m: f64) -> DVec3 {
    DVec3::new(
        0.33 * width_m + 0.0073,
        -0.30 * width_m - 0.0109,
        -0.24 * depth_m - 0.0099,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pelvis_of_240_by_150_mm_has_its_hips_where_harrington_has_them() {
        // x = -0.24 * 150 - 9.9 = -45.9, y = -0.30 * 240 - 10.9 = -82.9,
        // z = 0.33 * 240 + 7.3 = 86.5.
        let hip = hip_centre(0.240, 0.150);
        assert!(
            hip.distance(DVec3::new(0.0865, -0.0829, -0.0459)) < 1e-9,
            "{hip}"
        );
    }
}

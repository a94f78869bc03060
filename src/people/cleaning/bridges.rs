//! Flips of joints on which nothing hangs, bridged.
//!
//! Captures lose hands for a moment or read them the wrong way round (which is why `clean` passes
//! over them), and which way round they are hardly shows in a silhouette. Such noise is worth a
//! warning, not a walk: it is bridged here, where the encoder would refuse it and nowhere else.

use crate::people::cleaning::flips::{MotionEnds, largest_step_deg, steps};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DQuat;

/// Most seconds that a bridge takes, half of them to either side of the flip: what the usual
/// low-pass of 10 Hz makes of a flip in one frame takes half of it. Ours.
const LONGEST_BRIDGE_S: f64 = 0.2;

/// A bridge turns by at most this share of what is refused, so that its ends are no edges. Ours.
const BRIDGE_SHARE: f64 = 0.5;

/// Joints on which nothing hangs: what they do moves no other joint.
const ENDS: [Joint; 5] = [
    Joint::Head,
    Joint::LeftHand,
    Joint::RightHand,
    Joint::LeftFoot,
    Joint::RightFoot,
];
/// Those of them that may be another way round after the flip than before it. A foot or a head
/// that stays turned is another posture, and is refused.
const EITHER_WAY: [Joint; 2] = [Joint::LeftHand, Joint::RightHand];

/// Bridges that a warning names before it only counts.
const NAMED: usize = 4;

/// Bridges the flips of joints on which nothing hangs: the fewest frames about a flip are
/// interpolated between those before and behind, where the joint is back 0.1 s after it,
/// and for hands also where it stays. A joint all of whose flips cannot be bridged is left as it
/// is, and so is all else. What was done, a sentence for each joint.
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
                "joint {joint:?} turns {:.0} degrees from frame {} to {} (at most {most:.0} at {rate_hz:.0} frames a second): taken for noise of the capture, frames {}{more} are interpolated",
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

/// What was interpolated.
struct Bridge {
    turned_deg: f64,
    before: usize,
    after: usize,
    /// First and last frame that changed.
    first: usize,
    last: usize,
}

/// Bridges all flips of a joint; `None` where one of them cannot be.
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
    // Every bridge takes out one flip at least and makes none, so none is before it any more.
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

/// The frames that a bridge may be built between, from the nearest to the flip.
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
        reason = "some frames"
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

    /// At 100 frames a second 36 degrees are the most.
    const RATE_HZ: f64 = 100.0;

    /// Frames in which a joint is turned about its axis by these degrees.
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

    /// 40 frames with these degrees in some of them.
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
                    "joint {joint:?} turns 100 degrees from frame 19 to 20 (at most 36 at 100 frames a second): taken for noise of the capture, frames 18 to 21 are interpolated"
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

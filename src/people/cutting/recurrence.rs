//! The period of a recording so short that no event occurs twice.

use edgegait_core::skeleton::Joint;
use glam::{DQuat, DVec3};

use crate::people::retarget::RetargetedMotion;

/// The joints whose rotations are compared.
const LIMBS: [Joint; 8] = [
    Joint::LeftThigh,
    Joint::LeftShank,
    Joint::LeftFoot,
    Joint::RightThigh,
    Joint::RightShank,
    Joint::RightFoot,
    Joint::LeftUpperArm,
    Joint::RightUpperArm,
];

/// Largest mean difference of the limbs' rotations in similar poses, radians. Our choice.
const ALIKE: f64 = 0.2;

/// Largest relative difference of a period from the stride that the steps give. Our choice.
const NEAR_STRIDE: f64 = 0.08;

/// The minimum number of frames that a motion can lack. Less is rounding. Our choice.
const LEAST_MISSING: f64 = 0.5;

/// The minimum share of the squared difference between two poses that the motion's direction
/// explains if it goes straight on from one to the other, or in a curve. Our choice.
const STRAIGHT_ON: f64 = 0.5;
const IN_A_CURVE: f64 = 0.1;

/// The minimum distance of a pose from another, in frames of motion, that is none of noise. Our
/// choice.
const APART: f64 = 3.0;

/// Lag of the most similar poses, as a share of the stride that the steps give, from which on they
/// count as a period apart even if the motion goes on between them. Our choice: steps give the
/// stride to about 2 %.
const FULL_STRIDE: f64 = 0.97;

/// The period of a recording of about one stride.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Period {
    /// A pose recurs between these frames.
    Recurs { from: f64, to: f64 },
    /// The first pose recurs after this many frames, more than there are.
    Beyond(f64),
}

/// Returns the period of a recording, if its steps are `stride` / 2 frames apart.
///
/// The two most similar poses about a stride apart are a period apart, unless the motion goes on
/// from the later one to the earlier one. Then frames are missing: as many as the motion takes if
/// they are few, else those up to the stride.
pub(super) fn period(take: &RetargetedMotion, stride: f64) -> Period {
    let last = (take.len() - 1) as f64;
    let Some((from, to)) = most_similar(take, stride) else {
        return Period::Beyond(stride.max(last));
    };
    let (lag, missing) = ((to - from) as f64, missing(take, from, to));
    let few = (1.0 - FULL_STRIDE) * stride + LEAST_MISSING;
    let found = match missing {
        Missing::Frames(frames) if frames < 1.5 => lag + 1.0,
        Missing::Frames(frames) if (lag + frames - stride).abs() <= few => lag + frames,
        Missing::Frames(_) | Missing::Some if lag < FULL_STRIDE * stride => stride,
        _ => lag,
    };
    if found > last {
        return Period::Beyond(found);
    }
    let from = (last - found).min(from as f64);
    let to = from + found;
    Period::Recurs { from, to }
}

/// Returns the two most similar poses about a stride apart; none if they are not similar.
fn most_similar(take: &RetargetedMotion, stride: f64) -> Option<(usize, usize)> {
    let difference = |a: usize, b: usize| {
        let apart = LIMBS.map(|joint| {
            let joint = joint.index();
            take.rotations[a][joint].angle_between(take.rotations[b][joint])
        });
        apart.iter().sum::<f64>() / LIMBS.len() as f64
    };
    let shortest = ((1.0 - NEAR_STRIDE) * stride) as usize;
    let longest = ((1.0 + NEAR_STRIDE) * stride) as usize;
    let lengths = shortest..=longest.min(take.len() - 1);
    lengths
        .flat_map(|length| (0..take.len() - length).map(move |from| (from, from + length)))
        .map(|(from, to)| (difference(from, to), from, to))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(difference, ..)| *difference < ALIKE)
        .map(|(_, from, to)| (from, to))
}

/// The frames that a motion lacks before a pose recurs.
enum Missing {
    /// None: it recurs, or the motion does not lead there.
    None,
    /// As many as the motion takes, going straight on.
    Frames(f64),
    /// Some: the motion goes there in a curve.
    Some,
}

/// Returns the frames that are missing after `to` before the pose at `from`.
fn missing(take: &RetargetedMotion, from: usize, to: usize) -> Missing {
    let turn = |joint: Joint, a: usize, b: usize| {
        let [a, b] = [a, b].map(|frame| take.rotations[frame][joint.index()]);
        let turn: DQuat = b * a.inverse();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        turn.to_scaled_axis()
    };
    let (mut across, mut along, mut along_squared) = (0.0, 0.0, 0.0);
    for joint in LIMBS {
        let gap: DVec3 = turn(joint, to, from);
        let step = 0.5 * (turn(joint, to - 1, to) + turn(joint, from, from + 1));
        across += gap.length_squared();
        along += gap.dot(step);
        along_squared += step.length_squared();
    }
    let explained = along * along / (across * along_squared);
    let (found, apart) = (along / along_squared, (across / along_squared).sqrt());
    if along > 0.0 && explained > STRAIGHT_ON && found >= LEAST_MISSING {
        Missing::Frames(found)
    } else if along > 0.0 && explained > IN_A_CURVE && apart > APART {
        Missing::Some
    } else {
        Missing::None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cutting::contacts::tests::walker;

    fn cut_to(frames: usize) -> RetargetedMotion {
        let mut take = walker(1.0, 1.0, 0.0, 1.3);
        take.roots.truncate(frames);
        take.rotations.truncate(frames);
        take.positions.truncate(frames);
        take
    }

    #[test]
    fn a_recording_without_a_repeated_event_still_has_a_repeated_pose() {
        for frames in [101, 102, 115] {
            let Period::Recurs { from, to } = period(&cut_to(frames), 105.0) else {
                panic!("{frames} frames hold a period");
            };
            assert!((to - from - 100.0).abs() < 0.02, "{frames}: {from} {to}");
        }
    }

    #[test]
    fn a_recording_that_lacks_its_end_goes_on_to_its_beginning() {
        for frames in 85..=100 {
            for stride in [99.0, 100.0, 101.0] {
                let Period::Beyond(found) = period(&cut_to(frames), stride) else {
                    panic!("{frames} frames are no period");
                };
                let most = if frames > 98 { 0.1 } else { 1.01 };
                assert!((found - 100.0).abs() < most, "{frames}: {found}");
            }
        }
    }
}

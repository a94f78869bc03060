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

/// Largest share of the difference between two poses that is left if the motion goes on from one to
/// the other. More is another pose, not a later one. Our choice.
const UNEXPLAINED: f64 = 0.5;

/// The period of a recording of about one stride.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Period {
    /// A pose recurs in this frame.
    Recurs { from: f64, to: f64 },
    /// The first pose recurs after this many frames, more than there are.
    Beyond(f64),
}

/// Returns the period of a recording, if its steps are `stride` / 2 frames apart.
///
/// The two most similar poses about a stride apart are a period apart, unless the motion goes on
/// from the later one to the earlier one: then the frames that this takes are missing.
pub(super) fn period(take: &RetargetedMotion, stride: f64) -> Period {
    let last = take.len() - 1;
    let (from, to) = match most_similar(take, stride) {
        Some((from, to)) => {
            let Some(missing) = missing(take, from, to) else {
                let [from, to] = [from, to].map(|frame| frame as f64);
                return Period::Recurs { from, to };
            };
            let found = (to - from) as f64 + missing;
            if found <= last as f64 {
                let from = (last as f64 - found).min(from as f64);
                let to = from + found;
                return Period::Recurs { from, to };
            }
            (from, to)
        }
        None => (0, last),
    };
    let found = missing(take, from, to).map(|missing| (to - from) as f64 + missing);
    let near = found.filter(|found| (found / stride - 1.0).abs() < NEAR_STRIDE);
    Period::Beyond(near.unwrap_or(stride).max(last as f64))
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

/// Returns the number of frames after `to` in which the motion goes on to the pose at `from`; none
/// if it does not lead there, or is there.
fn missing(take: &RetargetedMotion, from: usize, to: usize) -> Option<f64> {
    /// Steps of a frame in which the number is searched.
    const FINE: usize = 50;
    if to < from + 4 {
        return None;
    }
    let turn = |joint: Joint, a: usize, b: usize| {
        let [a, b] = [a, b].map(|frame| take.rotations[frame][joint.index()]);
        let turn: DQuat = b * a.inverse();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        turn.to_scaled_axis()
    };
    // The gap, and the sum and the difference of the slopes and of the curvatures at its ends.
    let ends: Vec<[DVec3; 3]> = LIMBS
        .iter()
        .map(|&joint| {
            let [before, long_before] = [1, 2].map(|by| turn(joint, to, to - by));
            let [after, long_after] = [1, 2].map(|by| turn(joint, from, from + by));
            let slopes = 0.5 * (long_before - 4.0 * before) + 0.5 * (4.0 * after - long_after);
            let curves = (long_before - 2.0 * before) - (long_after - 2.0 * after);
            [turn(joint, to, from), slopes, curves]
        })
        .collect();
    // The integral of a cubic over the gap, from its values and slopes at both ends.
    let left = |frames: f64| -> f64 {
        let of_joint = |[gap, slopes, curves]: &[DVec3; 3]| {
            let covered = *slopes * (frames / 2.0) + *curves * (frames * frames / 12.0);
            (*gap - covered).length_squared()
        };
        ends.iter().map(of_joint).sum()
    };
    let most = (2.0 * NEAR_STRIDE * (to - from) as f64) as usize * FINE;
    let (left_over, found) = (0..=most)
        .map(|step| step as f64 / FINE as f64)
        .map(|frames| (left(frames), frames))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let leads_there = left_over <= UNEXPLAINED * left(0.0);
    (leads_there && found >= LEAST_MISSING).then_some(found)
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
        for frames in 86..=100 {
            for stride in [98.0, 100.0, 103.0] {
                let Period::Beyond(found) = period(&cut_to(frames), stride) else {
                    panic!("{frames} frames are no period");
                };
                assert!((found - 100.0).abs() < 0.1, "{frames}: {found}");
            }
        }
    }
}

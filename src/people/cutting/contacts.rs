//! Finds when the feet touch the floor and leave it.
//!
//! No forces are needed, after Zeni, Richards & Higginson (2008), "Two simple methods for
//! determining gait events during treadmill and overground walking using kinematic data", Gait &
//! Posture 27:710: the heel strikes when the ankle is farthest ahead of the pelvis, and the toe
//! leaves when it is farthest behind. A turning walker is measured along the heading of the pelvis,
//! averaged over about a stride.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use crate::people::cutting::stance::FeetMotion;
use crate::people::retarget::RetargetedMotion;

/// Possible durations of a stride, seconds: from a sprint to a slow patient's walk.
pub(in crate::people) const STRIDE_S: std::ops::RangeInclusive<f64> = 0.35..=3.0;

/// Smallest swing of an ankle past the pelvis that counts as a step, metres. Our choice: every
/// patient of the Shum set steps farther.
const SMALLEST_STEP_M: f64 = 0.08;

/// The minimum prominence of a contact, as a share of the ankle's range. Our choice.
const PROMINENCE: f64 = 0.35;

/// The minimum prominence of a contact on a side where the recording ends. Our choice.
const EDGE_PROMINENCE: f64 = 0.05;

/// The minimum depth below the pelvis of a foot on the floor, as a share of its usual maximum. Our
/// choice.
const LEAST_BELOW: f64 = 0.75;

/// The gait events of one foot, in fractional frames, ascending.
#[derive(Clone, Debug)]
pub(crate) struct FootEvents {
    /// Heel strikes, with the ankle farthest ahead.
    pub contacts: Vec<f64>,
    /// Toe lifts, with the ankle farthest behind.
    pub lifts: Vec<f64>,
}

/// Finds the events of the left and the right foot.
#[must_use]
pub(crate) fn foot_events(take: &RetargetedMotion) -> [FootEvents; 2] {
    let facing = facing(take);
    [Joint::LeftFoot, Joint::RightFoot].map(|foot| {
        let mut ahead: Vec<f64> = take
            .positions
            .iter()
            .zip(&facing)
            .map(|(points, facing)| {
                (points[foot.index()] - points[Joint::Pelvis.index()]).dot(*facing)
            })
            .collect();
        let apart = STRIDE_S.start() * take.sample_rate_hz;
        let mut contacts = peaks(&ahead, apart);
        contacts.retain(|at| is_low(take, foot, *at));
        for value in &mut ahead {
            *value = -*value;
        }
        FootEvents {
            contacts,
            lifts: peaks(&ahead, apart),
        }
    })
}

/// Returns whether a foot is as far below the pelvis as one on the floor; false in a kick.
fn is_low(take: &RetargetedMotion, foot: Joint, at: f64) -> bool {
    let below = |points: &[DVec3; JOINTS]| points[Joint::Pelvis.index()].y - points[foot.index()].y;
    let mut all: Vec<f64> = take.positions.iter().map(below).collect();
    let here = all[(at.round() as usize).min(all.len() - 1)];
    all.sort_by(f64::total_cmp);
    here > LEAST_BELOW * all[all.len() * 9 / 10]
}

/// Returns the pairs of successive events a stride apart.
pub(in crate::people) fn strides(events: &[f64], rate: f64) -> Vec<(f64, f64)> {
    events
        .windows(2)
        .map(|pair| (pair[0], pair[1]))
        .filter(|(from, to)| STRIDE_S.contains(&((to - from) / rate)))
        .collect()
}

/// Returns the median time between events of the two feet, contacts or lifts, that can be one step
/// apart, seconds.
pub(in crate::people) fn step_s(left: &FootEvents, right: &FootEvents, rate: f64) -> Option<f64> {
    let mut steps: Vec<f64> = Vec::new();
    for (ours, theirs) in [
        (&left.contacts, &right.contacts),
        (&left.lifts, &right.lifts),
    ] {
        for a in ours {
            let apart = theirs.iter().map(|b| (a - b).abs() / rate);
            steps.extend(apart.filter(|step| STRIDE_S.contains(&(2.0 * step))));
        }
    }
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

/// Returns the horizontal unit vector that the pelvis faces, averaged over about a stride, by
/// frame.
pub(in crate::people) fn facing(take: &RetargetedMotion) -> Vec<DVec3> {
    let pelvis: Vec<DQuat> = take
        .rotations
        .iter()
        .map(|pose| pose[Joint::Pelvis.index()])
        .collect();
    averaged_heading(&pelvis, take.sample_rate_hz)
}

/// Returns the horizontal heading of pelvis orientations, averaged over about a stride.
pub(in crate::people) fn averaged_heading(pelvis: &[DQuat], sample_rate_hz: f64) -> Vec<DVec3> {
    let ahead: Vec<DVec3> = pelvis
        .iter()
        .map(|turn| {
            let z = *turn * DVec3::Z;
            DVec3::new(z.x, 0.0, z.z).normalize_or(DVec3::Z)
        })
        .collect();
    let reach = (0.5 * sample_rate_hz) as usize;
    (0..ahead.len())
        .map(|i| {
            let around = &ahead[i.saturating_sub(reach)..(i + reach + 1).min(ahead.len())];
            around.iter().sum::<DVec3>().normalize_or(DVec3::Z)
        })
        .collect()
}

/// Returns the speed of the belt under a walker who stays in place, m/s: the median backward speed
/// of the soles' lowest point. None if it is too slow for a belt.
pub(in crate::people) fn belt_mps(take: &RetargetedMotion) -> Option<f64> {
    /// Slowest speed that counts as a belt. Our choice.
    const SLOWEST_M_S: f64 = 0.2;
    let mut backwards: Vec<f64> = FeetMotion::of_take(take)
        .lowest_slides()
        .iter()
        .zip(facing(take))
        .map(|(slide, ahead)| -slide.dot(ahead) * take.sample_rate_hz)
        .collect();
    backwards.sort_by(f64::total_cmp);
    let median = backwards.get(backwards.len() / 2).copied();
    median.filter(|speed| *speed > SLOWEST_M_S)
}

/// Returns a motion on a belt of this speed as it would be over ground.
pub(in crate::people) fn over_ground(take: &RetargetedMotion, belt_mps: f64) -> RetargetedMotion {
    let ahead = facing(take).iter().sum::<DVec3>().normalize_or(DVec3::Z);
    let mut moved = take.clone();
    for (frame, (root, points)) in moved.roots.iter_mut().zip(&mut moved.positions).enumerate() {
        let along = ahead * belt_mps * frame as f64 / take.sample_rate_hz;
        *root += along;
        for point in points {
            *point += along;
        }
    }
    moved
}

/// Returns prominent local maxima at least `apart` samples apart, refined by a parabola. A maximum
/// at an end of the recording does not count.
fn peaks(signal: &[f64], apart: f64) -> Vec<f64> {
    let mut sorted = signal.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (Some(low), Some(high)) = (sorted.first(), sorted.last()) else {
        return Vec::new();
    };
    let range = high - low;
    if range < 2.0 * SMALLEST_STEP_M {
        return Vec::new();
    }
    let mut found: Vec<(usize, f64)> = Vec::new();
    for i in 1..signal.len().saturating_sub(1) {
        let value = signal[i];
        if value <= signal[i - 1] || value < signal[i + 1] {
            continue;
        }
        // The signal must fall far enough on either side before it rises above this value. Less is
        // required of a side where the recording ends.
        let falls = |side: &mut dyn Iterator<Item = &f64>| {
            let mut least = value;
            for other in side {
                if *other > value {
                    return value - least >= PROMINENCE * range;
                }
                least = least.min(*other);
            }
            value - least >= EDGE_PROMINENCE * range
        };
        if !falls(&mut signal[..i].iter().rev()) || !falls(&mut signal[i + 1..].iter()) {
            continue;
        }
        match found.last_mut() {
            Some(last) if i as f64 - (last.0 as f64) < apart => {
                if value > last.1 {
                    *last = (i, value);
                }
            }
            _ => found.push((i, value)),
        }
    }
    found
        .into_iter()
        .map(|(i, value)| {
            let (a, b) = (signal[i - 1], signal[i + 1]);
            let curve = a - 2.0 * value + b;
            let shift = if curve < 0.0 {
                0.5 * (a - b) / curve
            } else {
                0.0
            };
            i as f64 + shift
        })
        .collect()
}

#[cfg(test)]
pub(in crate::people) mod tests {
    use std::f64::consts::TAU;

    use glam::DQuat;

    use super::*;
    use crate::people::forward_kinematics;

    /// Returns a walker with straight legs of 0.9 m whose thighs swing by 0.4 rad in antiphase.
    pub(in crate::people) fn walker(
        period_s: f64,
        speed_mps: f64,
        heading: f64,
        seconds: f64,
    ) -> RetargetedMotion {
        let rate = 100.0;
        let mut offsets = [DVec3::ZERO; JOINTS];
        for (thigh, shank, foot, x) in [
            (Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot, 0.1),
            (Joint::RightThigh, Joint::RightShank, Joint::RightFoot, -0.1),
        ] {
            offsets[thigh.index()] = DVec3::X * x;
            offsets[shank.index()] = -DVec3::Y * 0.45;
            offsets[foot.index()] = -DVec3::Y * 0.45;
        }
        let turn = DQuat::from_rotation_y(heading);
        let mut take = RetargetedMotion {
            sample_rate_hz: rate,
            start_s: 0.0,
            cut_off_hz: None,
            unit_m: 1.0,
            is_placed: false,
            knows_upright: true,
            offsets,
            roots: Vec::new(),
            rotations: Vec::new(),
            positions: Vec::new(),
            residual_mm: 0.0,
            warnings: Vec::new(),
        };
        for i in 0..(seconds * rate) as usize {
            let t = i as f64 / rate;
            let swing = 0.4 * libm::sin(TAU * t / period_s);
            let mut pose = [DQuat::IDENTITY; JOINTS];
            pose[0] = turn;
            pose[Joint::LeftThigh.index()] = DQuat::from_rotation_x(-swing);
            pose[Joint::RightThigh.index()] = DQuat::from_rotation_x(swing);
            let root = turn * DVec3::new(0.0, 0.97, speed_mps * t);
            take.positions
                .push(forward_kinematics(&offsets, root, &pose).0);
            take.roots.push(root);
            take.rotations.push(pose);
        }
        take
    }

    #[test]
    fn contacts_are_where_the_legs_reach_ahead() {
        let [left, right] = foot_events(&walker(1.0, 1.3, 0.7, 3.6));
        let close = |found: &[f64], expected: &[f64]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() < 0.05, "{a} {b}");
            }
        };
        close(&left.contacts, &[25.0, 125.0, 225.0, 325.0]);
        close(&right.contacts, &[75.0, 175.0, 275.0]);
        close(&left.lifts, &right.contacts);
    }
}

//! Makes a closed cycle of a stride, and a mean cycle of closed cycles.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use crate::people::cleaning::low_pass::LowPass;
use crate::people::retarget::RetargetedMotion;
use crate::people::{Cycle, forward_kinematics};

/// The number of frames to which every cycle is resampled. Our choice.
pub const CYCLE_FRAMES: usize = 96;

/// The minimum speed of a walker who travels; slower ones are taken to be on a treadmill. Our
/// choice.
const SLOWEST_TRAVEL_M_S: f64 = 0.1;

/// Cut-off of the low-pass that removes the kink of a closed cycle, over the motion's own cut-off:
/// high enough to keep what that one passed. Our choice.
const KINK_CUT_OFF: f64 = 1.5;

/// Returns the pose at a fractional frame.
fn sample(take: &RetargetedMotion, at: f64) -> (DVec3, [DQuat; JOINTS]) {
    let last = take.len() - 1;
    let low = (at.max(0.0) as usize).min(last);
    let high = (low + 1).min(last);
    let t = at - low as f64;
    let root = take.roots[low].lerp(take.roots[high], t);
    let rotations = std::array::from_fn(|joint| {
        take.rotations[low][joint].slerp(take.rotations[high][joint], t)
    });
    (root, rotations)
}

/// Returns whether the walker travels between two frames.
pub(in crate::people) fn travels(take: &RetargetedMotion, from: f64, to: f64) -> bool {
    let travel = sample(take, to).0 - sample(take, from).0;
    let seconds = (to - from) / take.sample_rate_hz;
    libm::hypot(travel.x, travel.z) > SLOWEST_TRAVEL_M_S * seconds
}

/// Returns the rise of the pelvis from the first frame to the last, metres.
pub(in crate::people) fn rise_m(take: &RetargetedMotion, from: f64, to: f64) -> f64 {
    sample(take, to).0.y - sample(take, from).0.y
}

/// Makes a closed cycle along +Z of one stride.
///
/// The pose at the end differs from the one at the start. The difference of each joint and of the
/// root's height is spread linearly over the cycle, half of it to either end, so nothing moves by
/// more than half the gap. Speeds differ as well, which leaves a kink where the ends meet. A
/// low-pass that runs around the cycle removes it.
pub(in crate::people) fn close(take: &RetargetedMotion, from: f64, to: f64, phase: f64) -> Cycle {
    let period_s = (to - from) / take.sample_rate_hz;
    let (first_root, first) = sample(take, from);
    let (last_root, last) = sample(take, to);
    let travel = DVec3::new(last_root.x - first_root.x, 0.0, last_root.z - first_root.z);
    let moves = travels(take, from, to);
    let frames: Vec<(DVec3, [DQuat; JOINTS])> = (0..CYCLE_FRAMES)
        .map(|i| sample(take, from + (to - from) * i as f64 / CYCLE_FRAMES as f64))
        .collect();
    let ahead = if moves {
        travel
    } else {
        frames
            .iter()
            .map(|(_, pose)| pose[Joint::Pelvis.index()] * DVec3::Z)
            .sum()
    };
    let heading = DQuat::from_rotation_y(-libm::atan2(ahead.x, ahead.z));
    let gap: [DQuat; JOINTS] = std::array::from_fn(|joint| {
        let gap = first[joint] * last[joint].inverse();
        if gap.w < 0.0 { -gap } else { gap }
    });
    let rise = first_root.y - last_root.y;
    let (mut root, mut rotations, mut before) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (at, pose)) in frames.iter().enumerate() {
        let u = i as f64 / CYCLE_FRAMES as f64;
        let share = u - 0.5;
        let at = *at - travel * u;
        let closed_at = at + DVec3::Y * rise * share;
        let closed: [DQuat; JOINTS] = std::array::from_fn(|joint| {
            let part = DQuat::from_scaled_axis(gap[joint].to_scaled_axis() * share);
            (part * pose[joint]).normalize()
        });
        before.push(forward_kinematics(&take.offsets, at, pose).0);
        root.push(closed_at);
        rotations.push(closed);
    }
    let rate = CYCLE_FRAMES as f64 / period_s;
    let cut_off_hz = take.cut_off_hz.map(|hz| KINK_CUT_OFF * hz);
    if let Some(filter) = cut_off_hz.and_then(|hz| LowPass::new(hz, rate)) {
        smooth_round(&filter, &mut root, &mut rotations);
    }
    let mut moved_m: f64 = 0.0;
    for ((before, at), pose) in before.iter().zip(&mut root).zip(&mut rotations) {
        let after = forward_kinematics(&take.offsets, *at, pose).0;
        for (a, b) in before.iter().zip(&after) {
            moved_m = moved_m.max(a.distance(*b));
        }
        *at = heading * *at;
        pose[0] = (heading * pose[0]).normalize();
    }
    let centre = root.iter().sum::<DVec3>() / CYCLE_FRAMES as f64;
    for at in &mut root {
        at.x -= centre.x;
        at.z -= centre.z;
    }
    let shift = (phase * CYCLE_FRAMES as f64).round() as usize % CYCLE_FRAMES;
    root.rotate_left(shift);
    rotations.rotate_left(shift);
    let drift_m = if moves { travel.length() } else { 0.0 };
    Cycle {
        period_s,
        drift_m,
        closure_mm: moved_m * 1e3,
        root,
        rotations,
    }
}

/// Filters a closed cycle as if it repeated for ever.
fn smooth_round(filter: &LowPass, root: &mut [DVec3], rotations: &mut [[DQuat; JOINTS]]) {
    let frames = root.len();
    let mut thrice = root.repeat(3);
    filter.positions(&mut thrice);
    root.copy_from_slice(&thrice[frames..2 * frames]);
    for joint in 0..JOINTS {
        let once: Vec<DQuat> = rotations.iter().map(|pose| pose[joint]).collect();
        let mut thrice = once.repeat(3);
        filter.rotations(&mut thrice);
        for (pose, rotation) in rotations.iter_mut().zip(&thrice[frames..]) {
            pose[joint] = *rotation;
        }
    }
}

/// Returns the mean of cycles at each phase, with their mean period. Its `closure_mm` is the
/// largest of theirs.
pub(in crate::people) fn mean_cycle<'a>(cycles: impl Iterator<Item = &'a Cycle> + Clone) -> Cycle {
    let count = cycles.clone().count().max(1) as f64;
    let mean = |of: fn(&Cycle) -> f64| cycles.clone().map(of).sum::<f64>() / count;
    let root = |frame: usize| cycles.clone().map(|cycle| cycle.root[frame]).sum::<DVec3>() / count;
    let rotation = |frame: usize, joint: usize| {
        let mut all = cycles.clone().map(|cycle| cycle.rotations[frame][joint]);
        let first = all.next().unwrap_or(DQuat::IDENTITY);
        // Each rotation is added with the sign that is nearer to the first.
        all.fold(first, |sum, one| {
            if one.dot(first) < 0.0 {
                sum - one
            } else {
                sum + one
            }
        })
        .normalize()
    };
    Cycle {
        period_s: mean(|cycle| cycle.period_s),
        drift_m: mean(|cycle| cycle.drift_m),
        closure_mm: cycles
            .clone()
            .map(|cycle| cycle.closure_mm)
            .fold(0.0, f64::max),
        root: (0..CYCLE_FRAMES).map(root).collect(),
        rotations: (0..CYCLE_FRAMES)
            .map(|frame| std::array::from_fn(|joint| rotation(frame, joint)))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_two_cycles_is_half_way_whatever_the_signs_of_their_rotations() {
        let cycle = |angle: f64, sign: f64, length: f64| Cycle {
            period_s: length,
            drift_m: 2.0 * length,
            closure_mm: 10.0 * length,
            root: vec![DVec3::Y * length; CYCLE_FRAMES],
            rotations: vec![[DQuat::from_rotation_x(angle) * sign; JOINTS]; CYCLE_FRAMES],
        };
        let both = [cycle(0.2, 1.0, 1.0), cycle(0.4, -1.0, 1.2)];
        let mean = mean_cycle(both.iter());
        assert!((mean.period_s - 1.1).abs() < 1e-12 && (mean.drift_m - 2.2).abs() < 1e-12);
        assert!((mean.closure_mm - 12.0).abs() < 1e-12);
        assert!(mean.root[5].distance(DVec3::Y * 1.1) < 1e-12);
        let turn = mean.rotations[7][3].angle_between(DQuat::from_rotation_x(0.3));
        assert!(turn < 1e-7, "{turn}");
    }
}

//! Finds the part of a recording that a body can perform.
//!
//! Recordings begin with a T-pose, roots jump through the room and joints flip over. No filter
//! repairs that, so the recording is cut to its longest clean stretch.

use std::ops::Range;

use glam::DVec3;

use crate::import::Motion;

/// Fastest joint rotation accepted, degrees a second: 30 degrees a frame at 120 Hz.
const FASTEST_ROTATION_DEG_S: f64 = 3600.0;

/// Largest step accepted at any rate, degrees. Beyond it, the direction of the turn is a guess.
/// Our choice.
const LARGEST_STEP_DEG: f64 = 75.0;

/// Fastest root accepted, m/s. The fastest sprinter reached 12.3 (Berlin 2009).
const FASTEST_ROOT_M_S: f64 = 15.0;

/// Ratio of the first step to the median one above which frame 0 is a T-pose. Our choice: it finds
/// the T-poses of the cgspeed, Character Creator and Xsens clips, and no others.
const T_POSE_RATIO: f64 = 8.0;

/// The usable part of a recording.
pub(in crate::people) struct Clean {
    /// The frames to use.
    pub(in crate::people) frames: Range<usize>,
    /// Whether frame 0 is a T-pose put before the motion.
    pub(in crate::people) t_pose: bool,
    pub(in crate::people) warnings: Vec<String>,
}

/// Finds the longest stretch without a jump of the root or a flip of the given joints.
///
/// Hands do not count: they flip for a frame in CMU's 08_07 and 08_09, and the low-pass hides it,
/// or [`bridges`](super::bridges) bridges it. `unit_m` is metres in one source unit, and
/// `positions` are those of the root, by frame.
pub(in crate::people) fn longest_clean_stretch(
    motion: &Motion,
    joints: &[usize],
    unit_m: f64,
    positions: &[DVec3],
) -> Clean {
    let count = motion.frames.len();
    let mut warnings = Vec::new();
    let t_pose = begins_with_t_pose(motion, joints);
    let start = usize::from(t_pose);
    if t_pose {
        warnings.push("frame 0 is a T-pose and was dropped".into());
    }
    let limit_deg = (FASTEST_ROTATION_DEG_S / motion.sample_rate_hz).min(LARGEST_STEP_DEG);
    let limit_m = FASTEST_ROOT_M_S / motion.sample_rate_hz;
    let mut best = start..start;
    let mut from = start;
    let mut first_fault = None;
    for frame in start..count {
        let fault = (frame > start)
            .then(|| {
                let step_m = positions[frame].distance(positions[frame - 1]) * unit_m;
                if step_m > limit_m {
                    return Some(format!("the root jumps {step_m:.2} m at frame {frame}"));
                }
                let (joint, step) = largest_step(motion, joints, frame);
                (step > limit_deg).then(|| {
                    let name = &motion.joints[joint].name;
                    format!("joint {name} turns {step:.0} degrees at frame {frame}")
                })
            })
            .flatten();
        if let Some(fault) = fault {
            first_fault.get_or_insert(fault);
            from = frame;
        }
        if frame + 1 - from > best.len() {
            best = from..frame + 1;
        }
    }
    if let Some(fault) = first_fault {
        warnings.push(format!(
            "{fault}: only frames {} to {} of {count} are used",
            best.start,
            best.end.saturating_sub(1)
        ));
    }
    Clean {
        frames: best,
        t_pose,
        warnings,
    }
}

/// Returns the joint that turns most from the frame before, and its angle, degrees.
fn largest_step(motion: &Motion, joints: &[usize], frame: usize) -> (usize, f64) {
    joints
        .iter()
        .map(|&joint| (joint, step_deg(motion, joint, frame)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0))
}

fn step_deg(motion: &Motion, joint: usize, frame: usize) -> f64 {
    let before = motion.frames[frame - 1].rotations[joint];
    before
        .angle_between(motion.frames[frame].rotations[joint])
        .to_degrees()
}

/// Returns whether the first step is much larger than the others.
fn begins_with_t_pose(motion: &Motion, joints: &[usize]) -> bool {
    let mean_step = |frame| {
        let sum: f64 = joints
            .iter()
            .map(|&joint| step_deg(motion, joint, frame))
            .sum();
        sum / joints.len().max(1) as f64
    };
    if motion.frames.len() < 10 {
        return false;
    }
    let mut steps: Vec<f64> = (2..motion.frames.len()).map(mean_step).collect();
    steps.sort_by(f64::total_cmp);
    let high = steps[steps.len() * 95 / 100];
    mean_step(1) > 2.0
        && mean_step(1) > T_POSE_RATIO * steps[steps.len() / 2]
        && mean_step(1) > 2.0 * high
}

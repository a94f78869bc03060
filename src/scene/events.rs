//! Gait cycles out of a recorded take: cut at the foot contacts, closed, straight ahead.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use super::Cycle;
use super::contacts::{STRIDE_S, facing, foot_events, recurrence, step_s, strides};
use super::filter::LowPass;
use super::forward_kinematics;
use super::retarget::Take;

/// Frames that every cycle is resampled to. Ours.
pub const CYCLE_FRAMES: usize = 96;

/// A cycle that turns more is not straight walking, degrees.
const LARGEST_TURN_DEG: f64 = 20.0;

/// Cadence above which a frame rate is doubted, steps a minute: sprinters reach about
/// 280, runners 150 to 200 (CMU 141 at a wrong 120 Hz gives 350).
const HIGHEST_CADENCE: f64 = 220.0;

/// Cadence that only sprinters exceed, steps a minute, and a sprint's speed, m/s. Ours.
const QUICK_CADENCE: f64 = 200.0;
const SPRINT_M_S: f64 = 4.5;

/// Share of a stride that must be recorded for the rest to be interpolated. Ours.
const LEAST_RECORDED: f64 = 0.85;

/// Slower than this the walker is taken to be on a treadmill. Ours.
const SLOWEST_TRAVEL_M_S: f64 = 0.1;

/// Cut-off of the low-pass that takes out the kink of a closed cycle, over that of the take:
/// high enough to leave what the take's own left. Ours.
const KINK_CUT_OFF: f64 = 1.5;

/// The cycles of one take.
#[derive(Clone, Debug)]
pub struct Cut {
    /// In order of time; at least one.
    pub cycles: Vec<CutCycle>,
    /// Steps a minute, median over the strides of both feet.
    pub cadence_spm: f64,
    /// Horizontal travel over time, mean over the cycles, m/s; 0 on a treadmill.
    pub speed_mps: f64,
    /// What was assumed or dropped.
    pub warnings: Vec<String>,
}

/// One cycle with what is known about it.
#[derive(Clone, Debug)]
pub struct CutCycle {
    /// Closed, straight ahead along +Z.
    pub cycle: Cycle,
    /// Seconds from the source's frame 0.
    pub start_s: f64,
    /// Two steps a period, a minute.
    pub cadence_spm: f64,
    /// Travel along +Z, m/s.
    pub speed_mps: f64,
}

/// Cuts a take into closed cycles of [`CYCLE_FRAMES`] frames, from left contact to
/// left contact. A take too short for that is cut between the first events that come
/// twice: right contacts, left lifts, right lifts, else the two poses a stride apart that
/// are most alike; if as much as 85 % of a stride is there, the rest is interpolated. Phase 0 is the left contact then
/// too: cycles are turned to begin there.
///
/// # Errors
/// A sentence, if there is no full gait cycle that is straight.
pub fn cut(take: &Take) -> Result<Cut, String> {
    let mut take = take;
    let extended;
    let [left, right] = foot_events(take);
    let rate = take.sample_rate_hz;
    let mut warnings = Vec::new();
    let kinds = [
        (strides(&left.contacts, rate), "left contacts"),
        (strides(&right.contacts, rate), "right contacts"),
        (strides(&left.lifts, rate), "left lifts"),
        (strides(&right.lifts, rate), "right lifts"),
    ];
    let mut kinds = kinds.to_vec();
    if kinds.iter().all(|(spans, _)| spans.is_empty()) {
        let step_s = step_s(&left, &right, rate);
        let Some(stride_s) = step_s.map(|step_s| 2.0 * step_s) else {
            return Err("no gait cycle: no foot contacts are recorded".into());
        };
        if let Some(span) = recurrence(take, stride_s) {
            kinds.push((vec![span], "like poses"));
        } else if let Some(longer) = completed(take, stride_s * rate) {
            let percent = 100.0 * take.len() as f64 / (stride_s * rate);
            warnings.push(format!(
                "only {percent:.0} % of a stride is recorded: the rest is interpolated"
            ));
            extended = longer;
            take = &extended;
            kinds.push((
                vec![(0.0, stride_s * rate)],
                "its first frame and a stride later",
            ));
        } else {
            let cadence = 120.0 / stride_s;
            return Err(format!(
                "no gait cycle: no full stride is recorded ({cadence:.0} steps/min at {rate:.1} Hz)"
            ));
        }
    }
    // Contacts are sharper events than the others, which count only without any.
    let measured = if kinds[..2].iter().any(|(spans, _)| !spans.is_empty()) {
        2
    } else {
        kinds.len()
    };
    let mut periods: Vec<f64> = kinds[..measured]
        .iter()
        .flat_map(|(spans, _)| spans)
        .map(|(from, to)| (to - from) / rate)
        .collect();
    periods.sort_by(f64::total_cmp);
    let period_s = periods
        .get(periods.len() / 2)
        .copied()
        .unwrap_or(*STRIDE_S.end());
    let (spans, kind) = kinds
        .into_iter()
        .find(|(spans, _)| !spans.is_empty())
        .unwrap_or_default();
    if kind != "left contacts" {
        warnings.push(format!(
            "no full left cycle: cut between {kind}, phase 0 moved to the left contact"
        ));
    }
    let facing = facing(take);
    let mut cycles = Vec::new();
    for (from, to) in spans {
        let turn_deg = facing[from as usize]
            .angle_between(facing[(to.ceil() as usize).min(take.len() - 1)])
            .to_degrees();
        let start_s = take.start_s + from / rate;
        if turn_deg > LARGEST_TURN_DEG {
            warnings.push(format!(
                "the cycle at {start_s:.2} s turns {turn_deg:.0} degrees: dropped"
            ));
            continue;
        }
        let phase = left_contact_phase(&left.contacts, &right.contacts, from, to);
        let cycle = close(take, from, to, phase);
        cycles.push(CutCycle {
            start_s,
            cadence_spm: 120.0 / cycle.period_s,
            speed_mps: cycle.drift_m / cycle.period_s,
            cycle,
        });
    }
    if cycles.is_empty() {
        return Err("no gait cycle: every cycle turns".into());
    }
    let cadence_spm = 120.0 / period_s;
    let seconds: f64 = cycles.iter().map(|cut| cut.cycle.period_s).sum();
    let speed_mps = cycles.iter().map(|cut| cut.cycle.drift_m).sum::<f64>() / seconds;
    if cadence_spm > HIGHEST_CADENCE || (cadence_spm > QUICK_CADENCE && speed_mps < SPRINT_M_S) {
        warnings.push(format!(
            "a cadence of {cadence_spm:.0} steps/min is implausible: is the frame rate of {rate:.1} Hz right?"
        ));
    }
    if speed_mps == 0.0 {
        warnings.push("the walker does not travel (a treadmill?): the speed is unknown".into());
    }
    Ok(Cut {
        cycles,
        cadence_spm,
        speed_mps,
        warnings,
    })
}

/// Phase of the left contact in a stride: seen in it, or half a stride from the right.
fn left_contact_phase(left: &[f64], right: &[f64], from: f64, to: f64) -> f64 {
    let seen = |events: &[f64]| events.iter().copied().find(|at| (from..to).contains(at));
    let phase = |at: f64| (at - from) / (to - from);
    match (seen(left), seen(right)) {
        (Some(at), _) => phase(at),
        (None, Some(at)) => (phase(at) + 0.5) % 1.0,
        (None, None) => 0.0,
    }
}

/// A take that lacks the end of its only stride, with the way from its last pose to its
/// first put in; none if too much is lacking.
fn completed(take: &Take, stride: f64) -> Option<Take> {
    let last = take.len() - 1;
    if (take.len() as f64) < LEAST_RECORDED * stride {
        return None;
    }
    let mut longer = take.clone();
    let travel = take.roots[last] - take.roots[0];
    let step = DVec3::new(travel.x, 0.0, travel.z) / last as f64;
    for frame in last + 1..=stride.ceil() as usize {
        let t = ((frame - last) as f64 / (stride - last as f64)).min(1.0);
        let mut root = take.roots[last] + step * (frame - last) as f64;
        root.y += (take.roots[0].y - root.y) * t;
        let pose = std::array::from_fn(|joint| {
            take.rotations[last][joint].slerp(take.rotations[0][joint], t)
        });
        longer
            .positions
            .push(forward_kinematics(&take.offsets, root, &pose).0);
        longer.roots.push(root);
        longer.rotations.push(pose);
    }
    Some(longer)
}

/// The pose at a fraction of a frame.
fn sample(take: &Take, at: f64) -> (DVec3, [DQuat; JOINTS]) {
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

/// One stride as a closed cycle along +Z.
///
/// The pose at the end differs from the one at the start. Each joint's and the root
/// height's difference is spread linearly over the cycle, half of it to either end, so
/// that nothing moves by more than half the gap. Speeds differ as well, which leaves a kink
/// where the ends meet: a low-pass that runs round the cycle takes it out.
fn close(take: &Take, from: f64, to: f64, phase: f64) -> Cycle {
    let period_s = (to - from) / take.sample_rate_hz;
    let (first_root, first) = sample(take, from);
    let (last_root, last) = sample(take, to);
    let travel = DVec3::new(last_root.x - first_root.x, 0.0, last_root.z - first_root.z);
    let moves = travel.length() > SLOWEST_TRAVEL_M_S * period_s;
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

/// Filters a closed cycle as if it had gone on for ever.
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

#[cfg(test)]
mod tests {
    use super::super::contacts::tests::walker;
    use super::*;

    #[test]
    fn a_perfect_walker_gives_perfect_cycles_whatever_the_heading() {
        for heading in [0.0, 1.0, 3.1, -2.0] {
            let cut = cut(&walker(1.2, 1.5, heading, 4.0)).unwrap();
            assert!((cut.cadence_spm - 100.0).abs() < 0.1, "{}", cut.cadence_spm);
            assert!((cut.speed_mps - 1.5).abs() < 1e-3, "{}", cut.speed_mps);
            assert!(cut.warnings.is_empty(), "{:?}", cut.warnings);
            for one in &cut.cycles {
                assert_eq!(one.cycle.root.len(), CYCLE_FRAMES);
                assert!((one.cycle.drift_m - 1.8).abs() < 2e-3);
                assert!(one.cycle.closure_mm < 1.0, "{}", one.cycle.closure_mm);
                // Phase 0: the left leg is ahead, the walker faces +Z.
                let thigh = one.cycle.rotations[0][Joint::LeftThigh.index()].to_scaled_axis();
                assert!((thigh.x + 0.4).abs() < 1e-3, "{thigh}");
                let facing = one.cycle.rotations[0][0] * DVec3::Z;
                assert!(facing.distance(DVec3::Z) < 1e-6, "{facing}");
                for root in &one.cycle.root {
                    assert!(root.distance(DVec3::new(0.0, 0.97, 0.0)) < 1e-3, "{root}");
                }
            }
        }
    }

    #[test]
    fn a_treadmill_has_no_speed_and_says_so() {
        let cut = cut(&walker(1.0, 0.0, 0.5, 3.0)).unwrap();
        assert_eq!(cut.speed_mps, 0.0);
        assert!(cut.warnings[0].contains("treadmill"), "{:?}", cut.warnings);
    }

    #[test]
    fn a_take_with_two_right_contacts_only_still_begins_at_the_left_one() {
        // Frames 27 to 222: right contacts at 75 and 175, a left one at 125 only.
        let mut take = walker(1.0, 1.0, 0.0, 3.0);
        take.roots = take.roots[27..223].to_vec();
        take.rotations = take.rotations[27..223].to_vec();
        take.positions = take.positions[27..223].to_vec();
        let cut = cut(&take).unwrap();
        assert!(
            cut.warnings[0].contains("right contacts"),
            "{:?}",
            cut.warnings
        );
        let thigh = cut.cycles[0].cycle.rotations[0][Joint::LeftThigh.index()].to_scaled_axis();
        assert!((thigh.x + 0.4).abs() < 1e-3, "{thigh}");
    }

    #[test]
    fn nine_tenths_of_a_stride_are_completed_and_less_is_refused() {
        // A period of 100 frames; contacts at 25 and 75.
        let mut take = walker(1.0, 1.0, 0.0, 0.9);
        let done = cut(&take).unwrap();
        assert!(
            done.warnings[0].contains("only 90 %"),
            "{:?}",
            done.warnings
        );
        assert!((done.cadence_spm - 120.0).abs() < 0.1);
        assert!((done.speed_mps - 1.0).abs() < 1e-2, "{}", done.speed_mps);
        take.roots.truncate(84);
        take.rotations.truncate(84);
        take.positions.truncate(84);
        assert!(
            cut(&take)
                .unwrap_err()
                .contains("120 steps/min at 100.0 Hz")
        );
    }

    #[test]
    fn a_frame_rate_that_doubles_the_cadence_is_doubted() {
        let mut take = walker(1.0, 1.3, 0.0, 4.0);
        take.sample_rate_hz = 180.0;
        let cut = cut(&take).unwrap();
        assert!(
            cut.warnings[0].contains("implausible"),
            "{:?}",
            cut.warnings
        );
    }

    #[test]
    fn standing_still_has_no_gait_cycle() {
        let mut take = walker(1.0, 0.0, 0.0, 2.0);
        take.positions = vec![take.positions[0]; take.positions.len()];
        assert!(cut(&take).unwrap_err().starts_with("no gait cycle"));
    }

    #[test]
    fn an_open_loop_is_closed_by_half_the_gap_at_either_end() {
        let mut take = walker(1.0, 1.0, 0.0, 1.6);
        // The pelvis sinks 40 mm a second: 20 mm at either end of the cycle.
        for (i, root) in take.roots.iter_mut().enumerate() {
            root.y -= 0.04 * i as f64 / 100.0;
        }
        let cut = cut(&take).unwrap();
        let one = &cut.cycles[0];
        assert!(
            (one.cycle.closure_mm - 20.0).abs() < 0.1,
            "{}",
            one.cycle.closure_mm
        );
        let heights: Vec<f64> = one.cycle.root.iter().map(|root| root.y).collect();
        assert!(
            heights.iter().all(|y| (y - heights[0]).abs() < 1e-3),
            "{heights:?}"
        );
    }
}

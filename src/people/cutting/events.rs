//! Cuts a recorded motion at the foot contacts into closed gait cycles that walk straight ahead.

use std::borrow::Cow;

use glam::DVec3;

pub use crate::people::cutting::closing::CYCLE_FRAMES;
use crate::people::cutting::closing::{close, mean_cycle, rise_m, travels};
use crate::people::cutting::contacts::{
    belt_mps, facing, foot_events, over_ground, step_s, strides,
};
use crate::people::cutting::recurrence::{Period, period};
use crate::people::cutting::stance::FeetMotion;
use crate::people::retarget::RetargetedMotion;
use crate::people::{Cycle, forward_kinematics};

/// Largest turn of a straight cycle, degrees.
const LARGEST_TURN_DEG: f64 = 20.0;

/// Cadence above which the frame rate is doubted, steps a minute: sprinters reach about 280,
/// runners 150 to 200 (CMU 141 at a wrong 120 Hz gives 350).
const HIGHEST_CADENCE: f64 = 220.0;

/// Cadence that only sprinters exceed, steps a minute, and the least speed of a sprint, m/s. Our
/// choice.
const QUICK_CADENCE: f64 = 200.0;
const SPRINT_M_S: f64 = 4.5;

/// The minimum recorded share of a stride for which the rest is interpolated. Our choice.
const LEAST_RECORDED: f64 = 0.85;

/// Largest rise or fall of the pelvis over a cycle on level ground, metres. Our choice: the ends of
/// a level cycle differ by less than 0.05.
const LEVEL_M: f64 = 0.1;

/// The gait cycles that were cut from one recorded motion.
#[derive(Clone, Debug)]
pub struct CutTake {
    /// The cycles in order of time; at least one.
    pub cycles: Vec<CutCycle>,
    /// The number of cycles that were cut.
    pub found: usize,
    /// Cadence, steps a minute: median over the straight strides of both feet.
    pub cadence_spm: f64,
    /// Mean horizontal speed over the cycles, m/s; relative to the belt on a treadmill, 0 on the
    /// spot.
    pub speed_mps: f64,
    /// Travel in a cycle, mean over the cycles, metres.
    pub stride_m: f64,
    /// Share of a cycle in which a foot stands, mean over both feet and the cycles.
    pub duty_factor: f64,
    /// Warnings about what was assumed or dropped.
    pub warnings: Vec<String>,
}

/// A gait cycle that was cut from a recording, with its measures.
#[derive(Clone, Debug)]
pub struct CutCycle {
    /// The closed cycle, straight ahead along +Z.
    pub cycle: Cycle,
    /// Start of the cycle, seconds from the source's frame 0.
    pub start_s: f64,
    /// Speed along +Z, m/s.
    pub speed_mps: f64,
}

/// The strides between events of one kind.
struct Strides {
    /// The first and last frame of each.
    spans: Vec<(f64, f64)>,
    /// The name of the events.
    name: &'static str,
}

impl Strides {
    fn one(span: (f64, f64), name: &'static str) -> Self {
        Self {
            spans: vec![span],
            name,
        }
    }
}

/// Cuts a motion into closed cycles of [`CYCLE_FRAMES`] frames, from left contact to left contact.
///
/// A motion too short for that is cut between the first events that occur twice: right contacts,
/// left lifts, right lifts, else the two most similar poses a stride apart. If 85 to 100 % of a
/// stride are recorded, the rest is interpolated. In every case phase 0 is the left contact: cycles
/// are rotated to begin there.
///
/// # Errors
/// A sentence, if there is no full gait cycle that is straight.
pub fn cut(take: &RetargetedMotion) -> Result<CutTake, String> {
    let mut warnings = Vec::new();
    let [left, right] = foot_events(take);
    let rate = take.sample_rate_hz;
    let strides = |events: &[f64], name| Strides {
        spans: strides(events, rate),
        name,
    };
    let mut kinds = vec![
        strides(&left.contacts, "left contacts"),
        strides(&right.contacts, "right contacts"),
        strides(&left.lifts, "left lifts"),
        strides(&right.lifts, "right lifts"),
    ];
    let mut take = Cow::Borrowed(take);
    if kinds.iter().all(|kind| kind.spans.is_empty()) {
        let Some(step_s) = step_s(&left, &right, rate) else {
            return Err("no gait cycle: no foot contacts are recorded; expected two steps or more of a walk or a run".into());
        };
        let (stride, longer) = only_stride(&take, 2.0 * step_s, &mut warnings)?;
        kinds.push(stride);
        take = longer.map_or(take, Cow::Owned);
    }
    let facing = facing(&take);
    let turn_deg = |&(from, to): &(f64, f64)| {
        let end = (to.ceil() as usize).min(take.len() - 1);
        facing[from as usize]
            .angle_between(facing[end])
            .to_degrees()
    };
    let is_straight = |span: &(f64, f64)| turn_deg(span) <= LARGEST_TURN_DEG;
    let chosen = kinds
        .iter()
        .position(|kind| kind.spans.iter().any(is_straight));
    let Some(chosen) = chosen else {
        return Err("no gait cycle: every cycle turns".into());
    };
    let Strides { spans, name } = &kinds[chosen];
    // The left contacts come first.
    if chosen > 0 {
        warnings.push(format!(
            "no full left cycle: cut between {name}, phase 0 moved to the left contact"
        ));
    }
    for span in spans.iter().filter(|span| !is_straight(span)) {
        warnings.push(format!(
            "the cycle at {:.2} s turns {:.0} degrees: dropped",
            take.start_s + span.0 / rate,
            turn_deg(span)
        ));
    }
    let spans: Vec<_> = spans.iter().copied().filter(is_straight).collect();
    let cadence_spm = cadence_spm(&kinds, is_straight, rate);
    if spans.iter().all(|&(from, to)| !travels(&take, from, to)) {
        warnings.push(match belt_mps(&take) {
            Some(belt_mps) => {
                take = Cow::Owned(over_ground(&take, belt_mps));
                "the walker does not travel (a treadmill?): the speed is taken from the standing foot"
                    .into()
            }
            None => {
                "the walker does not travel, and no foot slides back: the speed is unknown".into()
            }
        });
    }
    let mut cycles = Vec::new();
    for (from, to) in spans {
        let rise_m = rise_m(&take, from, to);
        if rise_m.abs() > LEVEL_M {
            warnings.push(format!(
                "the cycle at {:.2} s ends {rise_m:+.2} m higher than it began (stairs, a slope?): closing removes this, so standing feet slide",
                take.start_s + from / rate
            ));
        }
        let phase = left_contact_phase(&left.contacts, &right.contacts, from, to);
        let cycle = close(&take, from, to, phase);
        cycles.push(CutCycle {
            start_s: take.start_s + from / rate,
            speed_mps: cycle.drift_m / cycle.period_s,
            cycle,
        });
    }
    let seconds: f64 = cycles.iter().map(|cut| cut.cycle.period_s).sum();
    let travel_m: f64 = cycles.iter().map(|cut| cut.cycle.drift_m).sum();
    let duty_factors = cycles
        .iter()
        .map(|cut| FeetMotion::of_cycle(&cut.cycle, &take.offsets).duty_factor());
    let cut = CutTake {
        found: cycles.len(),
        cadence_spm,
        speed_mps: travel_m / seconds,
        stride_m: travel_m / cycles.len() as f64,
        duty_factor: duty_factors.sum::<f64>() / cycles.len() as f64,
        cycles,
        warnings,
    };
    Ok(cut.doubted(rate))
}

/// Returns the cadence of the median of the spans that count, left and right contacts first. Contacts
/// are sharper events than the others, which count only if there are no contacts.
fn cadence_spm(kinds: &[Strides], is_straight: impl Fn(&(f64, f64)) -> bool, rate: f64) -> f64 {
    let straight = |kinds: &[Strides]| -> Vec<f64> {
        let spans = kinds.iter().flat_map(|kind| &kind.spans);
        let straight = spans.filter(|span| is_straight(span));
        straight.map(|(from, to)| (to - from) / rate).collect()
    };
    let mut periods = straight(&kinds[..2]);
    if periods.is_empty() {
        periods = straight(kinds);
    }
    periods.sort_by(f64::total_cmp);
    let count = periods.len();
    240.0 / (periods[(count - 1) / 2] + periods[count / 2])
}

impl CutTake {
    /// Adds a warning if the cadence is implausible.
    fn doubted(mut self, rate: f64) -> Self {
        let cadence = self.cadence_spm;
        if cadence > HIGHEST_CADENCE || (cadence > QUICK_CADENCE && self.speed_mps < SPRINT_M_S) {
            self.warnings.push(format!(
                "a cadence of {cadence:.0} steps/min is implausible: is the frame rate of {rate:.1} Hz right? (at {:.0} Hz it is {:.0})",
                0.5 * rate,
                0.5 * cadence
            ));
        }
        self
    }

    /// Returns the mean of all cycles: the mean pose at each phase.
    #[must_use]
    pub fn mean(&self) -> CutCycle {
        let cycle = mean_cycle(self.cycles.iter().map(|cut| &cut.cycle));
        CutCycle {
            start_s: self.cycles.first().map_or(0.0, |cut| cut.start_s),
            speed_mps: cycle.drift_m / cycle.period_s,
            cycle,
        }
    }
}

/// Returns the only stride of a motion in which no event occurs twice: the motion if it had to be
/// extended, the stride's frames, and a name for its ends.
fn only_stride(
    take: &RetargetedMotion,
    stride_s: f64,
    warnings: &mut Vec<String>,
) -> Result<(Strides, Option<RetargetedMotion>), String> {
    let stride = match period(take, stride_s * take.sample_rate_hz) {
        Period::Recurs { from, to } => {
            return Ok((Strides::one((from, to), "similar poses"), None));
        }
        Period::Beyond(stride) => stride,
    };
    let Some(longer) = completed(take, stride) else {
        return Err(format!(
            "no gait cycle: no full stride is recorded ({:.0} steps/min at {:.1} Hz)",
            120.0 / stride_s,
            take.sample_rate_hz
        ));
    };
    warnings.push(if take.len() as f64 + 0.5 > stride {
        "the last pose is a frame before the first one recurs: the motion is taken as one cycle"
            .into()
    } else {
        format!(
            "only {:.0} % of a stride is recorded: the rest is interpolated",
            100.0 * take.len() as f64 / stride
        )
    });
    let stride = Strides::one((0.0, stride), "the first frame and a stride later");
    Ok((stride, Some(longer)))
}

/// Returns the phase of the left contact in a stride: as seen, or half a stride after the right
/// one.
fn left_contact_phase(left: &[f64], right: &[f64], from: f64, to: f64) -> f64 {
    let seen = |events: &[f64]| events.iter().copied().find(|at| (from..to).contains(at));
    let phase = |at: f64| (at - from) / (to - from);
    match (seen(left), seen(right)) {
        (Some(at), _) => phase(at),
        (None, Some(at)) => (phase(at) + 0.5) % 1.0,
        (None, None) => 0.0,
    }
}

/// Completes a motion that lacks the end of its only stride by interpolating from its last pose to
/// its first. None if too much is missing.
fn completed(take: &RetargetedMotion, stride: f64) -> Option<RetargetedMotion> {
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

#[cfg(test)]
mod tests {
    use edgegait_core::pack::Sex;
    use edgegait_core::skeleton::Joint;

    use super::*;
    use crate::people::cohort::Person;
    use crate::people::cutting::contacts::tests::walker;

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
    fn marching_on_the_spot_has_no_speed_and_says_so() {
        let cut = cut(&walker(1.0, 0.0, 0.5, 3.0)).unwrap();
        assert_eq!(cut.speed_mps, 0.0);
        assert!(cut.warnings[0].contains("unknown"), "{:?}", cut.warnings);
    }

    #[test]
    fn a_treadmill_is_as_fast_as_the_standing_foot() {
        let person = Person::average(Sex::Female);
        for speed_kmh in [4.0, 6.0] {
            let made = person.cycle(speed_kmh);
            let mut take = walker(1.0, 0.0, 0.0, 0.01);
            take.sample_rate_hz = made.root.len() as f64 / made.period_s;
            take.offsets = person.body.offsets;
            take.roots = made.root.repeat(3);
            take.rotations = made.rotations.repeat(3);
            let poses = take.roots.iter().zip(&take.rotations);
            take.positions = poses
                .map(|(root, pose)| forward_kinematics(&take.offsets, *root, pose).0)
                .collect();
            let cut = cut(&take).unwrap();
            let off = cut.speed_mps / (speed_kmh / 3.6) - 1.0;
            // Synthetic feet slide; recorded ones come within 5 % (`tests/import/manifest.rs`).
            assert!(off.abs() < 0.15, "{speed_kmh}: {}", cut.speed_mps);
            assert!(cut.warnings[0].contains("treadmill"), "{:?}", cut.warnings);
        }
    }

    #[test]
    fn a_walker_on_a_slope_is_warned_of() {
        let mut take = walker(1.0, 1.0, 0.0, 3.0);
        for (i, root) in take.roots.iter_mut().enumerate() {
            root.y -= 0.3 * i as f64 / 100.0;
        }
        let cut = cut(&take).unwrap();
        assert!(
            cut.warnings[0].contains("-0.30 m higher"),
            "{:?}",
            cut.warnings
        );
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

//! The paths of the feet, which are planted, rolled over and swung regardless of the angles.

mod stand;

use super::angles::AngleNorm;
use super::gait_style::GaitStyle;
use super::norms::Angle;
use super::pose::{angle_of, pose, turn_x, turn_y};
use super::sole::Sole;
use super::steps_and_pelvis::{PelvisWaves, Regulated};
use super::style::{Side, Style};
use super::swing::{LATE_TOES, LEAST_KNEE, Polar, Swing, floored, least};
use crate::people::forward_kinematics;
use crate::people::leg::LegLengths;
use edgegait_core::pack::Gait;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};
use std::cell::RefCell;
use std::collections::HashMap;

/// The largest amount by which toes are raised further in the swing, radians. Our choice: 6
/// degrees.
const MOST_TOES_UP: f64 = 0.11;
/// The most by which a late heel is higher or lower than by the angles, radians, and the share of
/// the late stance after which it may be. Our choice: 20 degrees.
const MOST_HEEL: f64 = 0.35;
const HEEL_FREE: f64 = 0.5;
/// Samples over a range of phases.
const SAMPLES: usize = 48;

/// Returns the joints of a leg.
pub(super) const fn leg_of(side: Side) -> [Joint; 3] {
    match side {
        Side::Left => [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
        Side::Right => [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
    }
}

/// Returns +1 for the left side and -1 for the right.
pub(super) const fn sign(side: Side) -> f64 {
    match side {
        Side::Left => 1.0,
        Side::Right => -1.0,
    }
}

/// One person's steps at one speed.
pub(super) struct PersonSteps<'a> {
    walker: &'a GaitStyle<'a>,
    norm: &'a AngleNorm,
    regulated: Regulated,
    soles: [Sole; 2],
    legs: [LegLengths; 2],
    /// How far ahead of the pelvis a foot stands in the middle of its time flat on the floor,
    /// metres.
    ahead_m: f64,
    /// Correction of the feet's pitch, radians, that makes them level while they stand flat.
    level: [f64; 2],
    /// The directions of the feet, radians about the vertical.
    headings: [f64; 2],
    /// Cache of the legs by the person's angles, by side and phase.
    known: RefCell<HashMap<(Side, u64), Intended>>,
    /// Motion of the pelvis.
    pelvis: PelvisWaves,
    swings: [Swing; 2],
}

/// A leg by the person's angles alone.
#[derive(Clone, Copy, Debug)]
struct Intended {
    /// The hip relative to the middle of the pelvis, metres.
    hip: DVec3,
    /// The ankle relative to the middle of the pelvis, metres.
    ankle: DVec3,
    /// How far the toes are raised, radians.
    pitch: f64,
}

/// A leg in the air by the person's angles alone.
struct Unswung {
    bent: Polar,
    /// The place of the hip, metres.
    hip: DVec3,
    /// The share of the swing, and [`Swing::rise`] there.
    share: f64,
    rise: f64,
}

/// A foot's place, in the frame that travels with the walker.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    /// Place of the ankle, metres.
    pub ankle: DVec3,
    /// How far the toes are raised, radians.
    pub pitch: f64,
}

impl<'a> PersonSteps<'a> {
    /// Returns the steps of `walker`.
    #[must_use]
    pub(super) fn new(
        walker: &'a GaitStyle<'a>,
        norm: &'a AngleNorm,
        regulated: Regulated,
    ) -> Self {
        let offsets = &walker.body.offsets;
        let sides = [Side::Left, Side::Right];
        let soles = sides.map(|side| {
            let [_, _, foot] = leg_of(side);
            let hull = walker.body.hulls.iter().find(|hull| hull.joint == foot);
            Sole::from_hull(hull.expect("a synthetic body has feet"))
        });
        let legs = sides.map(|side| {
            let [_, shank, foot] = leg_of(side);
            LegLengths {
                thigh_m: offsets[shank.index()].length(),
                shank_m: offsets[foot.index()].length(),
            }
        });
        let mut steps = Self {
            walker,
            norm,
            regulated,
            soles,
            legs,
            ahead_m: 0.0,
            level: [0.0; 2],
            headings: [0.0; 2],
            known: RefCell::default(),
            pelvis: PelvisWaves::LEVEL,
            swings: [Swing::NONE; 2],
        };
        for side in sides {
            let pitches = steps.flat().map(|phase| steps.intended(side, phase).pitch);
            steps.level[side as usize] = mean(pitches);
            steps.headings[side as usize] = steps.heading(side);
        }
        steps.stand();
        for side in sides {
            steps.swings[side as usize] = steps.swing(side);
        }
        steps
    }

    /// Returns the place of the pelvis at a phase.
    #[must_use]
    pub(super) fn root(&self, phase: f64) -> DVec3 {
        self.pelvis.root(&self.regulated.beat(phase))
    }

    /// Returns the pose at a phase: the person's angles above the hips, and legs that reach the
    /// feet.
    #[must_use]
    pub(super) fn pose(&self, phase: f64) -> [DQuat; JOINTS] {
        let mut rotations = pose(self.walker.style, self.norm, phase);
        let pelvis = rotations[Joint::Pelvis.index()];
        for side in [Side::Left, Side::Right] {
            let joints = leg_of(side).map(Joint::index);
            let [thigh, shank, foot] = joints;
            let placed = self.foot(side, own(side, phase));
            let hip = self.root(phase) + pelvis * self.walker.body.offsets[thigh];
            let leg = self.legs[side as usize].reaching(hip, placed.ankle, self.knee(side, phase));
            rotations[thigh] = (pelvis.inverse() * leg.thigh).normalize();
            rotations[shank] = (leg.thigh.inverse() * leg.shank).normalize();
            let turn = turn_y(self.headings[side as usize]) * turn_x(-placed.pitch);
            rotations[foot] = (leg.shank.inverse() * turn).normalize();
        }
        rotations
    }

    /// Returns a foot at a phase of its own side, 0 to 1 from its contact.
    #[must_use]
    pub(super) fn foot(&self, side: Side, phase: f64) -> Placed {
        let phase = phase - libm::floor(phase);
        if phase < self.regulated.stance {
            return self.standing(side, phase);
        }
        let share = (phase - self.regulated.stance) / (1.0 - self.regulated.stance);
        let swing = &self.swings[side as usize];
        let mut placed = self.swung(swing, side, &self.unswung(side, phase, share));
        // No toe goes through the floor.
        let least = self.soles[side as usize].rolled(placed.pitch).height_m;
        placed.ankle.y = placed.ankle.y.max(least);
        placed
    }

    /// Returns a leg in the air by the angles alone, at a share of the swing.
    fn unswung(&self, side: Side, phase: f64, share: f64) -> Unswung {
        Unswung {
            bent: self.angles_bring(side, phase),
            hip: self.hip(side, phase),
            share,
            rise: Swing::rise(share),
        }
    }

    /// Returns a foot in the air.
    fn swung(&self, swing: &Swing, side: Side, by_angles: &Unswung) -> Placed {
        let leg = self.legs[side as usize];
        let &Unswung { bent, hip, .. } = by_angles;
        let bent = bent.map2(swing.at(by_angles.share), |bent, more| bent + more);
        let (lift_m, toes_up) = swing.lift(by_angles.share, by_angles.rise);
        let long = leg.reach(floored(bent.knee)) - lift_m;
        let aside = bent.side_m - hip.x;
        let long = libm::sqrt((long * long - aside * aside).max(0.0));
        let (sin, cos) = libm::sincos(bent.ahead);
        Placed {
            ankle: DVec3::new(bent.side_m, hip.y - long * cos, hip.z + long * sin),
            pitch: bent.pitch + toes_up,
        }
    }

    /// Returns the place of a hip at a phase of its own side.
    fn hip(&self, side: Side, phase: f64) -> DVec3 {
        self.root(own(side, phase)) + self.intended(side, phase).hip
    }

    /// Returns the leg from a hip to a foot.
    fn polar(&self, side: Side, hip: DVec3, Placed { ankle, pitch }: Placed) -> Polar {
        Polar {
            knee: self.legs[side as usize].knee(hip.distance(ankle)),
            ahead: libm::atan2(ankle.z - hip.z, hip.y - ankle.y),
            side_m: ankle.x,
            pitch,
        }
    }

    /// Returns a foot on the floor. Its heel rises until the knee bends as by the angles.
    fn standing(&self, side: Side, phase: f64) -> Placed {
        let knee = self.knee_deg(side, phase).to_radians().max(LEAST_KNEE);
        let hip = self.hip(side, phase);
        let leg = self.legs[side as usize];
        let at = |raised: f64| self.planted(side, phase, -raised);
        let raised = least(self.raised(side, phase), |raised| {
            leg.knee(hip.distance(at(raised))) < knee
        });
        Placed {
            ankle: at(raised),
            pitch: -raised,
        }
    }

    /// Returns the range of a standing foot's pitch, heel up: about that by the angles in the late
    /// stance.
    fn raised(&self, side: Side, phase: f64) -> (f64, f64) {
        let by_angles = -self.standing_pitch(side, phase);
        let [_, to] = self.flat_phases();
        let more = MOST_HEEL * smooth((phase - to) / (HEEL_FREE * (self.regulated.stance - to)));
        ((by_angles - more).max(by_angles.min(0.0)), by_angles + more)
    }

    /// Returns the knee's flexion by the angles at a phase of its own side, degrees.
    fn knee_deg(&self, side: Side, phase: f64) -> f64 {
        let all = own(side, phase);
        angle_of(self.walker.style, self.norm, Angle::KneeFlexion, side, all)
    }

    /// Returns the ankle of a foot on the floor, at a pitch.
    fn planted(&self, side: Side, phase: f64, pitch: f64) -> DVec3 {
        let rolled = self.soles[side as usize].rolled(pitch);
        let (sin, cos) = libm::sincos(self.headings[side as usize]);
        let longer = 0.5 * sign(side) * self.regulated.longer_left_m;
        let travel = self.regulated.stride_m() * (self.middle() - phase);
        DVec3::new(
            sign(side) * 0.5 * self.regulated.step_width_m + rolled.ahead_m * sin,
            rolled.height_m,
            self.ahead_m + longer + travel + rolled.ahead_m * cos,
        )
    }

    /// Returns how far the toes of a standing foot are raised: by the angles at both ends, on the
    /// heel first and on the toes last, and flat in between.
    fn standing_pitch(&self, side: Side, phase: f64) -> f64 {
        let pitch = self.intended(side, phase).pitch - self.level[side as usize];
        let [from, to] = self.flat_phases();
        let ramp = 0.6 * from;
        if phase < self.middle() {
            pitch.max(0.0) * smooth((from - phase) / ramp)
        } else {
            pitch.min(0.0) * smooth((phase - to) / ramp)
        }
    }

    /// Returns the leg by the angles alone, in the line of its foot on the floor.
    fn angles_bring(&self, side: Side, phase: f64) -> Polar {
        let Intended { ankle, pitch, .. } = self.intended(side, phase);
        let foot = Placed {
            ankle: ankle + self.root(own(side, phase)),
            pitch: pitch - self.level[side as usize],
        };
        Polar {
            side_m: sign(side) * 0.5 * self.regulated.step_width_m,
            ..self.polar(side, self.hip(side, phase), foot)
        }
    }

    /// Returns the leg by the person's angles at a phase of its own side.
    fn intended(&self, side: Side, phase: f64) -> Intended {
        let key = (side, phase.to_bits());
        if let Some(known) = self.known.borrow().get(&key) {
            return *known;
        }
        let found = self.intended_by(self.walker.style, side, phase);
        self.known.borrow_mut().insert(key, found);
        found
    }

    /// Returns the leg by the angles of a style.
    fn intended_by(&self, style: &Style, side: Side, phase: f64) -> Intended {
        let [thigh, _, foot] = leg_of(side);
        let pose = pose(style, self.norm, own(side, phase));
        let offsets = &self.walker.body.offsets;
        let (positions, turns) = forward_kinematics(offsets, DVec3::ZERO, &pose);
        let ahead = turns[foot.index()] * DVec3::Z;
        Intended {
            hip: pose[Joint::Pelvis.index()] * offsets[thigh.index()],
            ankle: positions[foot.index()],
            pitch: libm::asin(ahead.y.clamp(-1.0, 1.0)),
        }
    }

    /// Returns the start and end of a foot's time flat on the floor, cycles: a sixth and half of a
    /// walker's stance, shorter in fast and in slow walking, and the middle of a runner's. Our
    /// choice: where it ends later, knees of some people straighten again before they swing.
    fn flat_phases(&self) -> [f64; 2] {
        match self.regulated.gait {
            Gait::Walk => {
                let faster = self.regulated.speed_mps - 1.39;
                let to = 0.49 - (0.12 * faster).max(-0.054 * faster);
                [0.17, to].map(|share| share * self.regulated.stance)
            }
            Gait::Run => [0.22, 0.50].map(|share| share * self.regulated.stance),
        }
    }

    /// Returns the middle of a foot's time flat on the floor, cycles.
    fn middle(&self) -> f64 {
        let [from, to] = self.flat_phases();
        0.5 * (from + to)
    }

    /// Returns phases at which a foot is flat on the floor.
    fn flat(&self) -> impl Iterator<Item = f64> + use<> {
        let [from, to] = self.flat_phases();
        (0..SAMPLES).map(move |i| from + (to - from) * (i as f64 + 0.5) / SAMPLES as f64)
    }

    /// Returns the direction of a foot, radians about the vertical.
    fn heading(&self, side: Side) -> f64 {
        let progression = self.flat().map(|phase| {
            angle_of(
                self.walker.style,
                self.norm,
                Angle::FootProgression,
                side,
                own(side, phase),
            )
        });
        -sign(side) * mean(progression).to_radians()
    }

    /// Returns the direction to which a knee points.
    fn knee(&self, side: Side, phase: f64) -> DVec3 {
        let of = |angle| angle_of(self.walker.style, self.norm, angle, side, phase);
        let inwards = of(Angle::PelvicRotation) + of(Angle::HipRotation);
        let (sin, cos) = libm::sincos(-sign(side) * inwards.to_radians());
        DVec3::new(sin, 0.0, cos)
    }

    /// Returns the correction that leads a foot from one stance to the next.
    fn swing(&self, side: Side) -> Swing {
        const STEP: f64 = 1e-3;
        let from = self.regulated.stance;
        let duration = 1.0 - from;
        let offset = |standing: f64, phase: f64| {
            let placed = self.standing(side, standing);
            let stood = self.polar(side, self.hip(side, standing), placed);
            stood.map2(self.angles_bring(side, phase), |stood, bent| stood - bent)
        };
        let (first, last) = (offset(from, from), offset(0.0, 1.0));
        let speed = |early: Polar, late: Polar| {
            late.map2(early, |late, early| (late - early) * duration / STEP)
        };
        let mut landing = speed(last, offset(STEP, 1.0 + STEP));
        if self.regulated.gait == Gait::Run {
            // A runner's leg lands nearly straight and then bends at once. It does not begin before.
            landing.knee = landing.knee.min(0.0);
        }
        let mut swing = Swing {
            ends: [first, last],
            speeds: [speed(offset(from - STEP, from - STEP), first), landing],
            late_toes: match self.regulated.gait {
                Gait::Walk => LATE_TOES,
                Gait::Run => 0.0,
            },
            ..Swing::NONE
        };
        // The sole is lowest in mid-swing where it passes the other foot, and clears the floor less
        // before and after. Toes are raised where they are lowest, early in the swing, and the knee
        // bends more if that is not enough.
        let shares = (0..SAMPLES).map(|i| 0.3 + 0.4 * i as f64 / SAMPLES as f64);
        let asked = |share: f64| (8.0 * (share - 0.3)).min(4.0 * (0.7 - share)).min(1.0);
        let legs = shares.map(|share| self.unswung(side, from + share * duration, share));
        let legs: Vec<Unswung> = legs.collect();
        let is_low = |swing: &Swing, until: f64| {
            legs.iter().take_while(|leg| leg.share < until).any(|leg| {
                let placed = self.swung(swing, side, leg);
                let rolled = self.soles[side as usize].rolled(placed.pitch);
                placed.ankle.y - rolled.height_m < self.regulated.clearance_m * asked(leg.share)
            })
        };
        swing.toes_up = least((0.0, MOST_TOES_UP), |toes_up| {
            is_low(&Swing { toes_up, ..swing }, 0.5)
        });
        // A runner's heel rises as high as the angles bring it.
        let lowered = if self.regulated.gait == Gait::Run {
            0.0
        } else {
            -0.03
        };
        swing.lift_m = least((lowered, 0.2), |lift_m| {
            is_low(&Swing { lift_m, ..swing }, 1.0)
        });
        swing
    }
}

/// Returns the walker's phase at a phase of one side.
fn own(side: Side, phase: f64) -> f64 {
    phase + 0.5 * f64::from(side as u8)
}

/// Returns a smooth step from 0 to 1 with level ends.
fn smooth(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    share * share * share * (10.0 - share * (15.0 - 6.0 * share))
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

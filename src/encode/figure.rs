//! A cycle as it will be decoded, and what changing one of its numbers does to it.
//!
//! Rounding each number by itself leaves most points far within the stated error and a few
//! at it. Moving single numbers by a step until those few are within it as well allows
//! coarser steps: a quarter fewer bytes at 5 mm, measured on CMU's straight walks.

use super::cycle::{Mean, Numbers, mean_of, trim};
use super::frames::{Frames, VIRTUAL_POINTS, hanging_on};
use super::target::{Target, virtual_points};
use edgegait_core::format::CHANNELS;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DMat3, DQuat, DVec3};

/// Rounds of [`Figure::refine`], and numbers that each round may move. With 200 moves,
/// packs are 4 % larger at 1 mm.
const ROUNDS: usize = 10;
const MOVES: usize = 400;
/// What refining aims below the stated error: the decoder computes in f32.
const MARGIN: f64 = 0.998;

/// A cycle decoded in f64 from its numbers, frame by frame.
pub(super) struct Figure<'a> {
    target: &'a Target<'a>,
    frames: &'a Frames,
    scale: u8,
    numbers: Numbers,
    /// By channel, by frame: radians or metres.
    values: Vec<Vec<f64>>,
    /// By frame, by joint.
    states: Vec<[State; JOINTS]>,
    /// By joint: itself and what hangs on it, parents first.
    hanging: Vec<Vec<usize>>,
    /// The error that costs are shares of, metres.
    error_m: f64,
    /// What a change makes of the joints that it moves, before it is accepted.
    trial: Trial,
}

/// One joint in one frame.
#[derive(Clone, Copy, Debug)]
struct State {
    orientation: DQuat,
    position: DVec3,
    at: Points,
}

/// A joint's virtual points and how far off they are.
#[derive(Clone, Copy, Debug)]
struct Points {
    points: [DVec3; VIRTUAL_POINTS],
    /// Greatest squared distance from the true ones, square metres.
    worst: f64,
    /// The sum of (distance / stated error)^10.
    cost: f64,
}

/// A change that may not be made.
#[derive(Default)]
struct Trial {
    /// By frame: how the joint that moves turns, about where, and how far it shifts.
    motions: Vec<(DQuat, DVec3, DVec3)>,
    /// By frame, by joint that moves.
    points: Vec<Points>,
}

/// What a change has to do to be made.
#[derive(Clone, Copy, Debug)]
enum Goal {
    /// Lower the sum of costs.
    Cheaper,
    /// Leave every point within this squared distance.
    Within(f64),
}

impl Points {
    fn new(points: [DVec3; VIRTUAL_POINTS], truth: &[DVec3; VIRTUAL_POINTS], error_m: f64) -> Self {
        let mut found = Self {
            points,
            worst: 0.0,
            cost: 0.0,
        };
        found.weigh(truth, error_m);
        found
    }

    /// States how far the points are from where they ought to be.
    #[inline]
    fn weigh(&mut self, truth: &[DVec3; VIRTUAL_POINTS], error_m: f64) {
        (self.worst, self.cost) = (0.0, 0.0);
        for (point, truth) in self.points.iter().zip(truth) {
            let square = point.distance_squared(*truth);
            self.worst = self.worst.max(square);
            let share = square / (error_m * error_m);
            let fourth = share * share;
            self.cost += fourth * fourth * share;
        }
    }
}

impl<'a> Figure<'a> {
    /// Decodes the numbers of a cycle. Costs are of the shares of `max_error_mm`.
    pub(super) fn new(
        target: &'a Target<'a>,
        frames: &'a Frames,
        mean: Option<&Mean>,
        scale: u8,
        numbers: Numbers,
        max_error_mm: f64,
    ) -> Self {
        let values = numbers.iter().enumerate().map(|(channel, own)| {
            let step = frames.step(channel, scale);
            let usual = mean.map_or(0, |mean| mean[channel].len());
            let coefficients: Vec<f64> = (0..own.len().max(usual))
                .map(|index| {
                    let number = own.get(index).copied().unwrap_or(0);
                    f64::from(number) * step + mean_of(mean, channel, index)
                })
                .collect();
            target.series.synthesise(&coefficients)
        });
        let mut figure = Self {
            target,
            frames,
            scale,
            values: values.collect(),
            numbers,
            states: Vec::new(),
            hanging: (0..JOINTS).map(hanging_on).collect(),
            error_m: (MARGIN * max_error_mm * 1e-3).max(f64::MIN_POSITIVE.sqrt()),
            trial: Trial::default(),
        };
        figure.states = (0..target.len()).map(|frame| figure.posed(frame)).collect();
        figure
    }

    /// The coefficients in steps.
    pub(super) fn into_numbers(self) -> Numbers {
        self.numbers
    }

    /// Greatest error over all points and frames, mm.
    pub(super) fn max_error_mm(&self) -> f64 {
        let worst = self.states.iter().flatten().map(|state| state.at.worst);
        worst.fold(0.0, f64::max).sqrt() * 1e3
    }

    /// Three channels in one frame.
    fn vector(&self, part: usize, frame: usize) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|axis| self.values[3 * part + axis][frame]))
    }

    /// All joints in one frame.
    fn posed(&self, frame: usize) -> [State; JOINTS] {
        let root = self.vector(JOINTS, frame);
        let mut states = [State {
            orientation: DQuat::IDENTITY,
            position: root,
            at: Points {
                points: [root; VIRTUAL_POINTS],
                worst: 0.0,
                cost: 0.0,
            },
        }; JOINTS];
        for joint in Joint::ALL {
            let index = joint.index();
            let local = self.frames.rotation(index, self.vector(index, frame));
            let (position, orientation) = match joint.parent() {
                Some(parent) => {
                    let parent = &states[parent.index()];
                    let arm = parent.orientation * self.target.offsets[index];
                    (parent.position + arm, parent.orientation * local)
                }
                None => (root, local),
            };
            let points = virtual_points(position, orientation);
            states[index] = State {
                orientation,
                position,
                at: Points::new(points, &self.target.points[frame][index], self.error_m),
            };
        }
        states
    }

    /// Adds `steps` to one number, if that reaches the goal; whether it did.
    fn change(&mut self, channel: usize, index: usize, steps: i32, goal: Goal) -> bool {
        let by = f64::from(steps) * self.frames.step(channel, self.scale);
        // The root moves what hangs on the pelvis: everything.
        let joint = (channel / 3) % JOINTS;
        if !self.try_change(channel, joint, index, by, goal) {
            return false;
        }
        self.numbers[channel][index] += steps;
        let wave = self.target.series.wave(index);
        for (value, wave) in self.values[channel].iter_mut().zip(wave) {
            *value += by * wave;
        }
        let mut points = self.trial.points.iter();
        for (states, &(turn, pivot, shift)) in self.states.iter_mut().zip(&self.trial.motions) {
            for (&below, &at) in self.hanging[joint].iter().zip(&mut points) {
                let state = &mut states[below];
                state.position = pivot + turn * (state.position - pivot) + shift;
                state.orientation = (turn * state.orientation).normalize();
                state.at = at;
            }
        }
        true
    }

    /// What a change would do to the joints that it moves, in `trial`; whether that reaches
    /// the goal.
    fn try_change(
        &mut self,
        channel: usize,
        joint: usize,
        index: usize,
        by: f64,
        goal: Goal,
    ) -> bool {
        let hanging = &self.hanging[joint];
        let costs = self
            .states
            .iter()
            .map(|states| -> f64 { hanging.iter().map(|&below| states[below].at.cost).sum() });
        let before: f64 = costs.sum();
        let mut after = 0.0;
        self.trial.motions.clear();
        self.trial.points.clear();
        for (frame, wave) in self.target.series.wave(index).iter().enumerate() {
            let states = &self.states[frame];
            let mut vector = self.vector(channel / 3, frame);
            vector[channel % 3] += by * wave;
            let pivot = states[joint].position;
            let (turn, shift) = if channel / 3 == JOINTS {
                (DQuat::IDENTITY, vector - pivot)
            } else {
                let local = self.frames.rotation(joint, vector);
                let orientation = match Joint::ALL[joint].parent() {
                    Some(parent) => states[parent.index()].orientation * local,
                    None => local,
                };
                (
                    orientation * states[joint].orientation.inverse(),
                    DVec3::ZERO,
                )
            };
            let matrix = DMat3::from_quat(turn);
            let moved = pivot + shift - matrix * pivot;
            for &below in hanging {
                // In place: without all optimisations, as tests are built, copies and closures
                // take most of the time.
                self.trial.points.push(states[below].at);
                let at = self.trial.points.last_mut().expect("just pushed");
                for point in &mut at.points {
                    *point = moved + matrix * *point;
                }
                at.weigh(&self.target.points[frame][below], self.error_m);
                after += at.cost;
                let fails = match goal {
                    Goal::Cheaper => after >= before,
                    Goal::Within(square) => at.worst > square,
                };
                if fails {
                    return false;
                }
            }
            self.trial.motions.push((turn, pivot, shift));
        }
        true
    }

    /// Moves numbers by single steps until no point is off by more than the stated error;
    /// whether that was reached.
    pub(super) fn refine(&mut self) -> bool {
        for _ in 0..ROUNDS {
            if self.is_within() {
                return true;
            }
            let mut any = false;
            for (channel, index, steps) in self.downhill() {
                any |= self.change(channel, index, steps, Goal::Cheaper);
            }
            if !any {
                break;
            }
        }
        self.is_within()
    }

    fn is_within(&self) -> bool {
        let bound = self.error_m * self.error_m;
        self.states
            .iter()
            .flatten()
            .all(|state| state.at.worst <= bound)
    }

    /// The numbers whose change by a step lowers the cost most, to first order.
    fn downhill(&self) -> Vec<(usize, usize, i32)> {
        let frames = self.target.len();
        // What a turn about a joint, and a shift of the root, do to the cost.
        let mut torques = vec![[DVec3::ZERO; JOINTS]; frames];
        let mut forces = vec![[DVec3::ZERO; JOINTS]; frames];
        for (frame, states) in self.states.iter().enumerate() {
            for joint in Joint::ALL.iter().rev() {
                let index = joint.index();
                let state = &states[index];
                for (point, truth) in state.at.points.iter().zip(self.target.points[frame][index]) {
                    let off = point - truth;
                    let share = off.length_squared() / (self.error_m * self.error_m);
                    let force = off * (share * share * share * share);
                    forces[frame][index] += force;
                    torques[frame][index] += (point - state.position).cross(force);
                }
                if let Some(parent) = joint.parent().map(Joint::index) {
                    let arm = state.position - states[parent].position;
                    let (force, torque) = (forces[frame][index], torques[frame][index]);
                    forces[frame][parent] += force;
                    torques[frame][parent] += torque + arm.cross(force);
                }
            }
        }
        let mut slopes = Vec::new();
        for channel in 0..CHANNELS {
            let (joint, axis) = (channel / 3, channel % 3);
            let along: Vec<f64> = (0..frames)
                .map(|frame| match Joint::ALL.get(joint) {
                    Some(moved) => {
                        let axis = self.frames.axis(joint, axis);
                        let parent = moved.parent().map(Joint::index);
                        let turned = parent
                            .map_or(axis, |parent| self.states[frame][parent].orientation * axis);
                        torques[frame][joint].dot(turned)
                    }
                    None => forces[frame][0][axis],
                })
                .collect();
            let step = self.frames.step(channel, self.scale);
            for index in 0..self.numbers[channel].len() {
                let wave = self.target.series.wave(index).iter();
                let slope = step * wave.zip(&along).map(|(a, b)| a * b).sum::<f64>();
                slopes.push((channel, index, slope));
            }
        }
        slopes.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
        slopes.truncate(MOVES);
        slopes
            .into_iter()
            .map(|(channel, index, slope)| (channel, index, if slope > 0.0 { -1 } else { 1 }))
            .collect()
    }

    /// Leaves out last harmonics while no point is off by more than the stated error.
    pub(super) fn shorten(&mut self) {
        let goal = Goal::Within(self.error_m * self.error_m);
        for channel in 0..CHANNELS {
            while let Some(index) = self.numbers[channel].iter().rposition(|&n| n != 0) {
                let number = self.numbers[channel][index];
                // Only small ones: one step, beyond the constant.
                if index == 0 || number.abs() > 1 || !self.change(channel, index, -number, goal) {
                    break;
                }
            }
            trim(&mut self.numbers[channel]);
        }
    }
}

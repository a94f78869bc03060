//! The wave in the legs' outline: one period a cycle, and its second harmonic, one period a step.
//!
//! A window of samples is weighted by Hann's window, which suppresses waves of other periods once it
//! spans four steps, and the trend is removed. At each frequency of cycles, the powers at that
//! frequency and at twice that frequency are added. From the side nearly all power is that of the
//! step, from nearly in front that of the cycle: left and right steps look alike from the side only.
//! How widely the legs are spread shows roughly where the camera is, and so how much each power
//! counts.

use crate::budget::{
    CYCLE_FREQUENCIES, CYCLE_FREQUENCY_STEP_HZ, CYCLE_LOWEST_HZ, CYCLE_SAMPLES,
    CYCLE_STEPS_PER_MINUTE,
};
use core::f32::consts::TAU;

/// The mean spreads of the legs up to which the camera is taken to be in front or behind, and from
/// which at the side; in between there is doubt. The mean spread is 0.05 of the height from 18
/// degrees, 0.07 from 36, and 0.1 from the side. Our choice, like all constants of frequencies here:
/// of 200 people of the built-in population, dressed, at 3 to 7 km/h, and of 84 recorded people, seen
/// from all sides, most have the right period.
const SPREADS: (f32, f32) = (0.05, 0.078);
/// The shares with which the cycle's power counts from the side and from in front; the rest is that
/// of the step's.
const CYCLE_SHARES: (f32, f32) = (0.42, 0.7);
/// The power of the cycle, as a multiple of the step's, from which what is seen from the side is a
/// slow walker's step. Our choice: it is the power of a harmonic of 0.63 of the swing.
const MOST_OF_CYCLE: f32 = 2.5;
/// The weight of the sway beside the spread where a step is widest, from in front. Our choice: of 0,
/// 0.3, 0.5, 1 and 2, boundaries are nearest to heel strikes with 0.3.
const SWAY_WEIGHT: f32 = 0.3;
/// The frequency of cycles that is expected most, Hz: 120 steps a minute.
const USUAL_HZ: f32 = 1.0;
/// How far below and above it frequencies are expected half as much, Hz.
const HALF_AS_USUAL_HZ: (f32, f32) = (0.9, 0.6);

/// The minimum swing of walking legs, as a share of the figure's height. Our choice: nine of ten
/// walkers seen from in front reach twice as much.
pub(super) const LEAST_SWING: f32 = 0.003;
/// The share of the slowest cycle's frequency below which a cycle is too slow. Our choice: the
/// frequency of a walker at the limit is found to 5 %.
const TOO_SLOW: f32 = 0.95;

/// The measurements of one sample: spread and sway; both 0 if nobody is visible.
pub(super) type WaveSample = [f32; 2];

/// A steady wave.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave {
    /// Samples per step.
    pub step: f32,
    /// The widest stance nearest to the window's middle, in samples from the window's last: negative.
    pub peak: f32,
    /// The window's middle, in samples from the window's last.
    pub middle: f32,
    /// The amplitude of cycle and step together, as a share of the figure's height.
    pub swing: f32,
    /// The share of the change in the window that it explains, 0..1.
    pub regular: f32,
}

/// A window of samples, weighted, and relative to their trend.
struct SampleWindow {
    len: usize,
    /// Index of the middle.
    middle: f32,
    /// Hann's window, 0 for samples that show nobody.
    weights: [f32; CYCLE_SAMPLES],
    /// Spread and sway as differences from their trends, weighted.
    weighted: [WaveSample; CYCLE_SAMPLES],
    /// Sum of all weights.
    sum: f32,
    /// How doubtful it is by the mean spread that the camera is at the side, 0..1.
    doubt: f32,
}

/// Real and imaginary parts of spread and sway at one frequency.
type WaveParts = [[f32; 2]; 2];

impl Wave {
    /// Fits a wave to these samples at `rate_hz`; `None` if most of them show nobody.
    pub(super) fn fit(samples: impl Iterator<Item = WaveSample>, rate_hz: f32) -> Option<Self> {
        let window = SampleWindow::new(samples)?;
        let frequency = window.frequency(rate_hz) / rate_hz;
        let parts = window.cycle_and_step(frequency);
        if window.is_slow_step(parts) {
            let frequency = 0.5 * frequency;
            return Some(window.wave(frequency, window.cycle_and_step(frequency)));
        }
        Some(window.wave(frequency, parts))
    }

    /// Returns the steps per minute at `rate_hz`, if they are too few.
    pub(super) fn slow_steps_per_minute(&self, rate_hz: f32) -> Option<f32> {
        let steps = 60.0 * rate_hz / self.step;
        let (slowest, _) = CYCLE_STEPS_PER_MINUTE;
        (steps < TOO_SLOW * slowest).then_some(steps)
    }
}

impl SampleWindow {
    fn new(samples: impl Iterator<Item = WaveSample>) -> Option<Self> {
        let mut weighted = [[0.0; 2]; CYCLE_SAMPLES];
        let mut len = 0;
        for (to, sample) in weighted.iter_mut().zip(samples) {
            *to = sample;
            len += 1;
        }
        let count = count(len);
        let middle = (count - 1.0) / 2.0;
        let mut weights = [0.0; CYCLE_SAMPLES];
        // Weighted sums of 1, t, t^2 and of spread and sway times 1 and t.
        let (mut ones, mut times, mut squares) = (0.0, 0.0, 0.0);
        let mut sums = [[0.0; 2]; 2];
        let mut whole = 0.0;
        let turn = Turn::new(1.0 / (count + 1.0), middle);
        for ((weight, sample), (t, [cos, _])) in
            weights.iter_mut().zip(&weighted).zip(turn).take(len)
        {
            let hann = 0.5 + 0.5 * cos;
            whole += hann;
            let [spread, _] = sample;
            if *spread <= 0.0 {
                continue;
            }
            *weight = hann;
            ones += hann;
            times += hann * t;
            squares += hann * t * t;
            for (sums, value) in sums.iter_mut().zip(sample) {
                let [sum, by_time] = sums;
                *sum += hann * value;
                *by_time += hann * t * value;
            }
        }
        let determinant = ones * squares - times * times;
        if ones < 0.5 * whole || determinant <= 0.0 {
            return None;
        }
        let trends = sums.map(|[sum, by_time]| {
            let level = (squares * sum - times * by_time) / determinant;
            let slope = (ones * by_time - times * sum) / determinant;
            [level, slope]
        });
        let [[spread, _], _] = trends;
        let (narrow, wide) = SPREADS;
        let doubt = ((wide - spread) / (wide - narrow)).clamp(0.0, 1.0);
        let mut t = -middle;
        for (sample, weight) in weighted.iter_mut().zip(&weights).take(len) {
            for (value, [level, slope]) in sample.iter_mut().zip(trends) {
                *value = weight * (*value - level - slope * t);
            }
            t += 1.0;
        }
        Some(Self {
            len,
            middle,
            weights,
            weighted,
            sum: ones,
            doubt,
        })
    }

    /// Returns the frequency of the cycle, Hz: that of the score's highest local maximum, or the
    /// lowest that is tried if there is none.
    fn frequency(&self, rate_hz: f32) -> f32 {
        let (side, front) = CYCLE_SHARES;
        let share = side + (front - side) * self.doubt;
        let score = |hz: f32| {
            let [cycle, step] = self.cycle_and_step(hz / rate_hz).map(power);
            share * cycle + (1.0 - share) * step
        };
        // From the side the share alone tells a cycle from its half and its double.
        let usual = |hz| 1.0 - self.doubt * (1.0 - how_usual(hz));
        let hz = |number| CYCLE_LOWEST_HZ + count(number) * CYCLE_FREQUENCY_STEP_HZ;
        let scores: [f32; CYCLE_FREQUENCIES] = core::array::from_fn(|number| score(hz(number)));
        let Some((number, [left, middle, right])) = highest(&scores, |number| usual(hz(number)))
        else {
            return CYCLE_LOWEST_HZ;
        };
        // Twice as close, the step's frequencies are as far apart as the cycle's were.
        let (hz, half) = (hz(number), 0.5 * CYCLE_FREQUENCY_STEP_HZ);
        let closer = [left, score(hz - half), middle, score(hz + half), right];
        let Some((number, [left, middle, right])) = highest(&closer, |_| 1.0) else {
            return hz;
        };
        // The vertex of the parabola through three scores.
        let aside = 0.5 * (left - right) / (left - 2.0 * middle + right);
        hz + half * (count(number) - 2.0 + aside)
    }

    /// Returns the parts of cycle and step if the cycle has this frequency, in periods a sample.
    fn cycle_and_step(&self, frequency: f32) -> [WaveParts; 2] {
        [self.at(frequency), self.at(2.0 * frequency)]
    }

    /// Returns whether what seems to be a cycle is a slow walker's step, seen from the side.
    fn is_slow_step(&self, [cycle, step]: [WaveParts; 2]) -> bool {
        self.doubt <= 0.0 && power(cycle) > MOST_OF_CYCLE * power(step)
    }

    /// Returns the wave whose cycle has this frequency, in periods a sample, and these parts.
    fn wave(&self, frequency: f32, [cycle, step]: [WaveParts; 2]) -> Wave {
        let scale = 2.0 / self.sum;
        let swing = scale * libm::sqrtf(power(cycle) + power(step));
        let mut all = 0.0;
        for (sample, weight) in self.weighted.iter().zip(&self.weights) {
            if *weight > 0.0 {
                all += sample.iter().map(|value| value * value).sum::<f32>() / weight;
            }
        }
        let all = all / self.sum;
        let regular = if all > 0.0 {
            swing * swing / 2.0 / all
        } else {
            0.0
        };
        // From in front the spread hardly changes, and the sway peaks twice a cycle, ahead and back.
        let [widest, _] = step;
        let [_, sway] = cycle;
        let sway = twice_the_phase(sway);
        let doubt = self.doubt * self.doubt;
        let weight = SWAY_WEIGHT * doubt * doubt;
        let [re, im] = [0, 1].map(|part| widest[part] + weight * sway[part]);
        Wave {
            step: 0.5 / frequency,
            peak: -self.middle - libm::atan2f(im, re) / (2.0 * TAU * frequency),
            middle: -self.middle,
            swing,
            regular: regular.min(1.0),
        }
    }

    /// Sums spread and sway times a wave of `frequency` periods a sample, whose phase is 0 in the
    /// middle.
    fn at(&self, frequency: f32) -> WaveParts {
        let mut parts: WaveParts = [[0.0; 2]; 2];
        let turn = Turn::new(frequency, self.middle);
        for (sample, (_, [cos, sin])) in self.weighted.iter().take(self.len).zip(turn) {
            for ([re, im], value) in parts.iter_mut().zip(sample) {
                *re += value * cos;
                *im -= value * sin;
            }
        }
        parts
    }
}

/// Returns the local maximum that is the highest if multiplied by its weight, and not at an end, as
/// its number and the three scores around it.
fn highest(scores: &[f32], weight: impl Fn(usize) -> f32) -> Option<(usize, [f32; 3])> {
    let (mut best, mut most) = (None, 0.0);
    for (number, around) in (1..).zip(scores.windows(3)) {
        let &[left, middle, right] = around else {
            continue;
        };
        let height = weight(number) * middle;
        if middle > left && middle >= right && height > most {
            (best, most) = (Some((number, [left, middle, right])), height);
        }
    }
    best
}

/// Returns how usual a frequency of cycles is, 0..1: Cauchy's curve.
fn how_usual(hz: f32) -> f32 {
    let (below, above) = HALF_AS_USUAL_HZ;
    let off = hz - USUAL_HZ;
    let off = off / if off < 0.0 { below } else { above };
    1.0 / (1.0 + off * off)
}

/// Returns the sum of all squares.
fn power(parts: WaveParts) -> f32 {
    parts.iter().flatten().map(|part| part * part).sum()
}

/// Returns a complex number of the same size and twice the phase.
fn twice_the_phase([re, im]: [f32; 2]) -> [f32; 2] {
    let size = libm::sqrtf(re * re + im * im);
    if size > 0.0 {
        [(re * re - im * im) / size, 2.0 * re * im / size]
    } else {
        [0.0; 2]
    }
}

/// Converts a number of samples, which a byte holds.
fn count(number: usize) -> f32 {
    f32::from(u8::try_from(number).unwrap_or(u8::MAX))
}

/// An iterator over times from the middle of a window, with the cosine and sine of a wave whose
/// phase is 0 there. It advances by one rotation a sample: over a window its error stays below
/// 1e-5.
struct Turn {
    t: f32,
    now: [f32; 2],
    by: [f32; 2],
}

impl Turn {
    fn new(frequency: f32, middle: f32) -> Self {
        let of = |angle| {
            let (sin, cos) = libm::sincosf(angle);
            [cos, sin]
        };
        Self {
            t: -middle,
            now: of(-TAU * frequency * middle),
            by: of(TAU * frequency),
        }
    }
}

impl Iterator for Turn {
    type Item = (f32, [f32; 2]);

    fn next(&mut self) -> Option<Self::Item> {
        let found = (self.t, self.now);
        let ([cos, sin], [by_cos, by_sin]) = (self.now, self.by);
        self.now = [cos * by_cos - sin * by_sin, sin * by_cos + cos * by_sin];
        self.t += 1.0;
        Some(found)
    }
}

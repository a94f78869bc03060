//! The wave in the legs' outline: one period a step.
//!
//! A window of samples is weighted by Hann's window, which suppresses waves of two steps or half a
//! step once it spans four steps. The trend is removed (an approaching walker grows), the rest is
//! divided by the mean, and the frequency is the one with the highest power within the range of
//! human steps.

use crate::budget::{
    CYCLE_FREQUENCIES, CYCLE_FREQUENCY_STEP_HZ, CYCLE_LOWER_FREQUENCIES, CYCLE_LOWEST_HZ,
    CYCLE_SAMPLES,
};
use core::f32::consts::TAU;

/// The swing of the width, as a share of its mean, from which the width alone is used. Our choice:
/// for the people used for tuning it is 0.17 or more from 45, 90 or 135 degrees, and 0.05 (median)
/// from in front or behind. Values from 0.09 to 0.16 make no difference.
const WIDE_SWING: f32 = 0.12;
/// The weight of the pixels beside the width below that swing. Our choice: from in front they swing
/// by 0.04 of their mean and more steadily than the width; 2 and 3 find most cycles of the people
/// used for tuning.
const PIXELS_WEIGHT: f32 = 3.0;

/// The minimum swing of the outline of walking legs. Our choice: nine of ten walkers seen from in
/// front reach three times as much.
pub(super) const LEAST_SWING: f32 = 0.03;
/// The swing of a slower wave, as a multiple of a step's, from which the steps are doubted. Our
/// choice: 98 % of the windows in which a walk slowed to 40 to 66 steps a minute would be read
/// wrongly have such a wave, and 0.8 % of those in which a walk of usual speed is read rightly
/// (19 people slowed, and all takes with known heel strikes, from all views).
const SLOWER_SWING: f32 = 1.4;

/// The measurements of one sample: width and pixels; both 0 if nobody is visible.
pub(super) type WaveSample = [f32; 2];

/// A steady wave.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave {
    /// Samples per step.
    pub step: f32,
    /// The maximum nearest to the window's middle, in samples from the window's last: negative.
    pub peak: f32,
    /// The window's middle, in samples from the window's last.
    pub middle: f32,
    /// The amplitude, as a share of the mean.
    pub swing: f32,
    /// The share of the change in the window that it explains, 0..1.
    pub regular: f32,
}

/// The wave of a window, and what speaks against it.
pub(super) struct FittedWave {
    pub wave: Wave,
    /// The frequency of a stronger wave below the range of human steps, Hz.
    pub slower_hz: Option<f32>,
}

/// A window of samples, weighted, and relative to their trend.
struct SampleWindow {
    len: usize,
    /// Index of the middle.
    middle: f32,
    /// Hann's window, 0 for samples that show nobody.
    weights: [f32; CYCLE_SAMPLES],
    /// Width and pixels as differences from their trends, over their means, weighted.
    weighted: [WaveSample; CYCLE_SAMPLES],
    /// Sum of all weights.
    sum: f32,
}

/// Real and imaginary parts of width and pixels at one frequency.
type WaveParts = [[f32; 2]; 2];

impl Wave {
    /// Fits a wave to these samples at `rate_hz`; `None` if most of them show nobody.
    pub(super) fn fit(
        samples: impl Iterator<Item = WaveSample>,
        rate_hz: f32,
    ) -> Option<FittedWave> {
        let window = SampleWindow::new(samples)?;
        let spectrum = window.spectrum(rate_hz);
        let width = window.best(&spectrum, rate_hz, 0.0);
        let (wave, pixels_weight) = if width.swing >= WIDE_SWING {
            (width, 0.0)
        } else {
            let both = window.best(&spectrum, rate_hz, PIXELS_WEIGHT);
            (both, PIXELS_WEIGHT)
        };
        let slower_hz = window.slower(&wave, rate_hz, pixels_weight);
        Some(FittedWave { wave, slower_hz })
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
        // Weighted sums of 1, t, t^2 and of both channels times 1 and t.
        let (mut ones, mut times, mut squares) = (0.0, 0.0, 0.0);
        let mut sums = [[0.0; 2]; 2];
        let mut whole = 0.0;
        let turn = Turn::new(1.0 / (count + 1.0), middle);
        for ((weight, sample), (t, [cos, _])) in
            weights.iter_mut().zip(&weighted).zip(turn).take(len)
        {
            let hann = 0.5 + 0.5 * cos;
            whole += hann;
            let [_, pixels] = sample;
            if *pixels <= 0.0 {
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
        let mut t = -middle;
        for (sample, weight) in weighted.iter_mut().zip(&weights).take(len) {
            for (value, [level, slope]) in sample.iter_mut().zip(trends) {
                *value = if level > 0.0 {
                    weight * (*value - level - slope * t) / level
                } else {
                    0.0
                };
            }
            t += 1.0;
        }
        Some(Self {
            len,
            middle,
            weights,
            weighted,
            sum: ones,
        })
    }

    /// Returns the parts at each frequency that is tried.
    fn spectrum(&self, rate_hz: f32) -> [WaveParts; CYCLE_FREQUENCIES] {
        let mut frequency_hz = CYCLE_LOWEST_HZ;
        core::array::from_fn(|_| {
            let parts = self.at(frequency_hz / rate_hz);
            frequency_hz += CYCLE_FREQUENCY_STEP_HZ;
            parts
        })
    }

    /// Returns the strongest wave of width and weighted pixels.
    fn best(
        &self,
        spectrum: &[WaveParts; CYCLE_FREQUENCIES],
        rate_hz: f32,
        pixels_weight: f32,
    ) -> Wave {
        let powers = spectrum.map(|parts| {
            let [re, im] = together(parts, pixels_weight);
            re * re + im * im
        });
        let peak = highest(&powers, CYCLE_LOWEST_HZ, CYCLE_FREQUENCY_STEP_HZ);
        let frequency = peak.map_or(CYCLE_LOWEST_HZ, |peak| peak.frequency_hz) / rate_hz;
        let [re, im] = together(self.at(frequency), pixels_weight);
        let scale = 2.0 / self.sum;
        let swing = scale * libm::sqrtf(re * re + im * im);
        let mut all = 0.0;
        for ([width, pixels], weight) in self.weighted.iter().zip(&self.weights) {
            if *weight > 0.0 {
                let value = width + pixels_weight * pixels;
                all += value * value / weight;
            }
        }
        let all = all / self.sum;
        let regular = if all > 0.0 {
            swing * swing / 2.0 / all
        } else {
            0.0
        };
        Wave {
            step: 1.0 / frequency,
            peak: -self.middle - libm::atan2f(im, re) / (TAU * frequency),
            middle: -self.middle,
            swing,
            regular: regular.min(1.0),
        }
    }

    /// Returns the frequency of the strongest wave below the range of human steps, Hz, if it swings
    /// much more than `wave`.
    fn slower(&self, wave: &Wave, rate_hz: f32, pixels_weight: f32) -> Option<f32> {
        let mut frequency_hz = CYCLE_LOWEST_HZ + 2.0 * CYCLE_FREQUENCY_STEP_HZ;
        let powers: [f32; CYCLE_LOWER_FREQUENCIES + 2] = core::array::from_fn(|_| {
            frequency_hz -= CYCLE_FREQUENCY_STEP_HZ;
            let [re, im] = together(self.at(frequency_hz / rate_hz), pixels_weight);
            re * re + im * im
        });
        let swing = LEAST_SWING.max(SLOWER_SWING * wave.swing);
        let least = swing * self.sum / 2.0;
        let from = CYCLE_LOWEST_HZ + CYCLE_FREQUENCY_STEP_HZ;
        let peak = highest(&powers, from, -CYCLE_FREQUENCY_STEP_HZ)?;
        (peak.power > least * least).then_some(peak.frequency_hz)
    }

    /// Sums width and pixels times a wave of `frequency` periods a sample, whose phase is 0 in the
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

/// Returns the real and imaginary part of width plus weighted pixels.
fn together([width, pixels]: WaveParts, pixels_weight: f32) -> [f32; 2] {
    let ([re, im], [pixels_re, pixels_im]) = (width, pixels);
    [
        re + pixels_weight * pixels_re,
        im + pixels_weight * pixels_im,
    ]
}

/// A local maximum of power.
struct Peak {
    frequency_hz: f32,
    power: f32,
}

/// Returns the highest local maximum of powers at frequencies from `first_hz` on, `step_hz` apart;
/// its frequency is the vertex of the parabola through it and its neighbours. A maximum at the edge
/// of the range belongs to a wave outside, such as that of a whole cycle. `None` if there is no
/// other.
fn highest(powers: &[f32], first_hz: f32, step_hz: f32) -> Option<Peak> {
    let mut best: Option<Peak> = None;
    let mut middle_hz = first_hz;
    for around in powers.windows(3) {
        middle_hz += step_hz;
        let [left, middle, right] = around else {
            continue;
        };
        let bend = left - 2.0 * middle + right;
        let most = best.as_ref().map_or(0.0, |peak| peak.power);
        if middle > left && middle >= right && *middle > most && bend < 0.0 {
            let aside = 0.5 * (left - right) / bend;
            best = Some(Peak {
                frequency_hz: middle_hz + step_hz * aside,
                power: *middle,
            });
        }
    }
    best
}

/// Converts a number of samples or frequencies, which a byte holds.
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

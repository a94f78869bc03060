//! The detector: it finds gait cycles in a stream of frames.

use super::wave::{LEAST_SWING, Wave, WaveSample};
use super::{FrameRateError, LowerBody, NoCycle};
use crate::budget::{
    CYCLE_FRAME_RATES_HZ, CYCLE_MOST_SAMPLES_HZ, CYCLE_SAMPLES, CYCLE_STEPS_PER_MINUTE,
};
use heapless::HistoryBuf;

/// Steps in the window to which a wave is fitted: Hann's window separates a wave from one of twice
/// its period if it spans two periods of the latter.
const STEPS: f32 = 4.0;
/// The minimum share of the change that one wave must explain. Our choice: among the people used
/// for tuning, nearly all walks reach it from each view, and some with the wrong period do not.
const LEAST_REGULAR: f32 = 0.25;
/// The minimum share in a window of few samples, times the number of samples: the strongest wave of
/// white noise stays below it in most windows. Our choice.
const OF_NOISE: f32 = 14.0;
/// The upper bound of that share: clean walks seen from the side reach it in ten samples.
const MOST_REGULAR: f32 = 0.5;
/// Steps after a peak from which the next one is sought. Our choice: a closer one is the same peak.
const NEXT_FROM: f32 = 0.6;
/// The share of a step by which the next peak may be early or late. Our choice: beyond it the
/// walker stopped, turned or was lost, and a new cycle begins.
const TOLERANCE: f32 = 0.3;
/// Fits of the wave in a step of the fastest walker.
const LOOKS_A_STEP: f32 = 3.0;

/// A gait cycle: two steps, from one widest stance to the next but one. Silhouettes do not show
/// whether it begins with the left or the right foot ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectedCycle {
    /// The beginning, in frames from the first, which is 0; a real number.
    pub start: f64,
    /// The end, where the next cycle begins.
    pub end: f64,
    /// The share of the legs' change that a steady wave explains, 0..1: the least at the three peaks
    /// of its two steps. Above 0.25; about 0.95 from the side.
    pub regular: f32,
}

impl DetectedCycle {
    /// Returns its duration in frames.
    #[must_use]
    pub fn period_frames(&self) -> f64 {
        self.end - self.start
    }
}

/// The current gait of a walking person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walking {
    /// The duration of a cycle in frames, from the last four steps.
    pub period_frames: f32,
    /// The amplitude by which the legs swing, as a share of the figure's height.
    pub swing: f32,
    /// The share of the legs' change that one steady wave explains, 0..1.
    pub regular: f32,
}

/// A detector of gait cycles in a stream of frames. At most 1 kB; see [the module](super).
#[derive(Clone, Debug)]
pub struct CycleDetector {
    /// Frames per sample.
    every: u8,
    /// Samples per second.
    rate_hz: f32,
    /// Samples until the next fit of the wave, and between two fits.
    looks: [u8; 2],
    /// Frames received so far.
    frames: u64,
    /// Sums over those frames of the next sample that show a person, and their number.
    sums: WaveSample,
    present: u8,
    /// The last samples.
    samples: HistoryBuf<WaveSample, CYCLE_SAMPLES>,
    /// The wave of the last samples, or the reason why there is none.
    seen: Result<Wave, NoCycle>,
    /// The moment at which the last step was widest, in samples from the first.
    peak: Option<f64>,
    /// The start of the incomplete cycle, and which of its steps is current.
    begun: Option<Begun>,
}

#[derive(Clone, Copy, Debug)]
struct Begun {
    start: f64,
    /// Whether its first step is complete.
    is_half: bool,
    regular: f32,
}

impl CycleDetector {
    /// Makes a detector for this many frames a second.
    ///
    /// # Errors
    /// Unless there are 10 to 120 frames a second.
    pub fn new(frame_rate_hz: f32) -> Result<Self, FrameRateError> {
        let (low, high) = CYCLE_FRAME_RATES_HZ;
        if !(low..=high).contains(&frame_rate_hz) {
            return Err(FrameRateError {
                found_hz: frame_rate_hz,
            });
        }
        // At most 4, because the rate is at most 120 Hz and 120 / 32 = 3.75.
        let every = whole(libm::ceilf(frame_rate_hz / CYCLE_MOST_SAMPLES_HZ));
        let rate_hz = frame_rate_hz / f32::from(every);
        let (shortest, _) = step_range(rate_hz);
        let look = whole(shortest / LOOKS_A_STEP).max(1);
        Ok(Self {
            every,
            rate_hz,
            looks: [look, look],
            frames: 0,
            sums: [0.0; 2],
            present: 0,
            samples: HistoryBuf::new(),
            seen: Err(NoCycle::TooShort { frames: 0 }),
            peak: None,
            begun: None,
        })
    }

    /// Adds the next frame, `None` if it shows nobody, and returns a cycle if one is complete.
    pub fn push(&mut self, lower_body: Option<LowerBody>) -> Option<DetectedCycle> {
        self.frames = self.frames.saturating_add(1);
        if let Some(body) = lower_body.filter(LowerBody::is_somebody) {
            let [spread, sway] = &mut self.sums;
            *spread += body.spread;
            *sway += body.sway;
            self.present += 1;
        }
        if self.frames.is_multiple_of(self.every.into()) {
            self.sample();
            let [left, look] = &mut self.looks;
            *left -= 1;
            if *left == 0 {
                *left = *look;
                self.look(StreamState::Open);
                return self.next_cycle(StreamState::Open);
            }
        }
        None
    }

    /// Returns the number of frames received so far.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns the gait in the last four steps.
    ///
    /// # Errors
    /// If nobody is visible, nobody walks, or there were too few frames.
    pub fn walking(&self) -> Result<Walking, NoCycle> {
        let wave = self.seen.map_err(|reason| match reason {
            NoCycle::TooShort { .. } => NoCycle::TooShort {
                frames: self.frames,
            },
            other => other,
        })?;
        Ok(Walking {
            period_frames: 2.0 * wave.step * f32::from(self.every),
            swing: wave.swing,
            regular: wave.regular,
        })
    }

    /// Ends the stream and returns the cycles that are still open, in order. The last wave is
    /// extended to the last frame. Above 32 frames a second, where several frames make one sample,
    /// up to 3 last frames are ignored.
    #[must_use]
    pub fn finish(mut self) -> OpenCycles {
        self.look(StreamState::Final);
        OpenCycles(self)
    }

    /// Adds the mean of the frames as a sample.
    fn sample(&mut self) {
        let mean = |sum| {
            if self.present > 0 {
                sum / f32::from(self.present)
            } else {
                0.0
            }
        };
        self.samples.write(self.sums.map(mean));
        (self.sums, self.present) = ([0.0; 2], 0);
    }

    /// Fits a wave to the last four steps.
    fn look(&mut self, ending: StreamState) {
        self.seen = match self.last_steps(ending) {
            Ok(Wave { swing, .. }) if swing < LEAST_SWING => Err(NoCycle::Standing { swing }),
            Ok(wave) if wave.regular < least_regular(&wave) => Err(NoCycle::Irregular {
                regular: wave.regular,
            }),
            Ok(wave) => match wave.slow_steps_per_minute(self.rate_hz) {
                Some(steps_per_minute) => Err(NoCycle::Slower { steps_per_minute }),
                None => Ok(wave),
            },
            Err(reason) => Err(reason),
        };
    }

    /// Returns the wave of the last four steps, or of fewer at the end of the stream.
    fn last_steps(&self, ending: StreamState) -> Result<Wave, NoCycle> {
        let held = count(self.samples.len());
        let (shortest, longest) = step_range(self.rate_hz);
        let fewest = match ending {
            StreamState::Open => STEPS * shortest,
            StreamState::Final => 2.0 * shortest,
        };
        let too_short = NoCycle::TooShort {
            frames: self.frames,
        };
        if held < fewest {
            return Err(too_short);
        }
        let most = libm::ceilf(STEPS * longest);
        let wave = self.wave(most).ok_or(NoCycle::Absent)?;
        let wanted = libm::roundf(STEPS * wave.step).min(most);
        if wanted < held {
            return self.wave(wanted).ok_or(NoCycle::Absent);
        }
        let is_enough = match ending {
            StreamState::Open => held >= wanted,
            StreamState::Final => held >= 2.0 * wave.step,
        };
        if is_enough { Ok(wave) } else { Err(too_short) }
    }

    /// Returns the wave of the last `samples` samples, or of all.
    fn wave(&self, samples: f32) -> Option<Wave> {
        let skipped = self.samples.len().saturating_sub(whole(samples).into());
        let samples = self.samples.oldest_ordered().skip(skipped).copied();
        Wave::fit(samples, self.rate_hz)
    }

    /// Returns where the next step is widest, in samples from the first, if it is certain.
    fn next_peak(&self, wave: &Wave, ending: StreamState) -> Option<f64> {
        let newest = exact(self.frames / u64::from(self.every)) - 1.0;
        let (step, middle) = (f64::from(wave.step), f64::from(wave.middle));
        let window = newest + 2.0 * middle;
        let oldest = if window < step {
            // The stream begins here, so the first steps are taken to be like those after them.
            // Half a sample early is still within the first sample.
            window - 0.5
        } else {
            // The person may have stood still until the window's middle, and the wave reaches back
            // further.
            newest + middle - 0.5 * step
        };
        let next = self.peak.map(|last| last + f64::from(NEXT_FROM) * step);
        let from = next.map_or(oldest, |next| next.max(oldest));
        let known = newest + f64::from(wave.peak);
        let peak = known + libm::ceil((from - known) / step) * step;
        let until = match ending {
            StreamState::Open => newest + middle,
            StreamState::Final => newest,
        };
        (peak <= until).then_some(peak)
    }

    /// Moves on to a peak, and returns the cycle that it completes.
    fn go_on(&mut self, wave: &Wave, peak: f64) -> Option<DetectedCycle> {
        let step = f64::from(wave.step);
        let last = self.peak.replace(peak);
        let is_next = last.is_some_and(|last| {
            let late = (peak - last) / step - 1.0;
            libm::fabs(late) <= f64::from(TOLERANCE)
        });
        let from_here = Begun {
            start: peak,
            is_half: false,
            regular: wave.regular,
        };
        let Some(begun) = self.begun.filter(|_| is_next) else {
            self.begun = Some(from_here);
            return None;
        };
        let regular = begun.regular.min(wave.regular);
        if !begun.is_half {
            self.begun = Some(Begun {
                is_half: true,
                regular,
                ..begun
            });
            return None;
        }
        self.begun = Some(from_here);
        // A sample lies at the middle of its frames.
        let every = f64::from(self.every);
        let in_frames = |samples: f64| (samples * every + (every - 1.0) / 2.0).max(0.0);
        Some(DetectedCycle {
            start: in_frames(begun.start),
            end: in_frames(peak),
            regular,
        })
    }

    /// Moves on until a cycle is complete or no further peak is certain.
    fn next_cycle(&mut self, ending: StreamState) -> Option<DetectedCycle> {
        let wave = self.seen.ok()?;
        // Each peak is more than half a step after the previous one, so this ends.
        while let Some(peak) = self.next_peak(&wave, ending) {
            let cycle = self.go_on(&wave, peak);
            if cycle.is_some() {
                return cycle;
            }
        }
        None
    }
}

/// The cycles that were still open at the end; see [`CycleDetector::finish`].
#[derive(Clone, Debug)]
pub struct OpenCycles(CycleDetector);

impl OpenCycles {
    /// Returns the detector at the end of the stream.
    #[must_use]
    pub const fn detector(&self) -> &CycleDetector {
        &self.0
    }
}

impl Iterator for OpenCycles {
    type Item = DetectedCycle;

    fn next(&mut self) -> Option<DetectedCycle> {
        self.0.next_cycle(StreamState::Final)
    }
}

/// Whether more frames may come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StreamState {
    Open,
    Final,
}

/// Returns the least share of the change in its window that a wave must explain.
const fn least_regular(wave: &Wave) -> f32 {
    let samples = 1.0 - 2.0 * wave.middle;
    LEAST_REGULAR.max(MOST_REGULAR.min(OF_NOISE / samples))
}

/// Returns the samples in the shortest and the longest step.
fn step_range(rate_hz: f32) -> (f32, f32) {
    let (slow, fast) = CYCLE_STEPS_PER_MINUTE;
    (60.0 / fast * rate_hz, 60.0 / slow * rate_hz)
}

/// Converts a number of samples, which a byte holds.
fn count(samples: usize) -> f32 {
    f32::from(u8::try_from(samples).unwrap_or(u8::MAX))
}

/// Returns the whole part of a number, at most 255.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped; only the fraction is dropped"
)]
const fn whole(value: f32) -> u8 {
    value.clamp(0.0, 255.0) as u8
}

/// Converts a number of samples to a real number.
#[expect(
    clippy::cast_precision_loss,
    reason = "exact for 2^53 samples, which take three million years"
)]
const fn exact(samples: u64) -> f64 {
    samples as f64
}

//! Cycles of a whole sequence, by one of several methods.

use super::series::{Signal, SmoothedSignal};
use super::{CycleDetector, DetectedCycle, FrameRateError, LowerBody, NoCycle};
use super::{autocorrelation, extrema};
use std::ops::Range;

/// The gait cycles of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundCycles {
    /// In order, none of which overlap; at least one. One does not always begin where the one before
    /// ends: somebody may have stopped or turned.
    pub cycles: Vec<DetectedCycle>,
    /// Frames of a cycle: the median, or what the method gives. A real number.
    pub period_frames: f64,
    /// How steady it is, 0..1: of the wave its median share of what changes, of peaks and minima 1 less
    /// the spread of their distances over the mean, otherwise the autocorrelation a period on.
    pub regular: f64,
}

/// How cycles are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CycleMethod {
    /// The wave that fits four steps best, as on a board: [`CycleDetector`].
    #[default]
    Wave,
    /// Every second peak of the signal: Charalambous & Bharath (BMVC 2016).
    Peaks(Signal),
    /// The mean of the median distances between every second minimum: Sarkar et al. (IEEE TPAMI
    /// 27(2), 2005). Cycles follow one another from the first minimum on.
    Minima(Signal),
    /// The lag at which the signal is most like itself. Cycles follow one another from where the steps,
    /// laid over one another, are widest.
    Autocorrelation(Signal),
}

/// Finds the gait cycles of recordings of one frame rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleFinder {
    frame_rate_hz: f32,
    /// How; the wave unless it is set.
    pub method: CycleMethod,
}

impl CycleFinder {
    /// Of recordings of so many frames a second.
    ///
    /// # Errors
    /// Unless there are 10 to 120.
    pub fn new(frame_rate_hz: f32) -> Result<Self, FrameRateError> {
        CycleDetector::new(frame_rate_hz)?;
        Ok(Self {
            frame_rate_hz,
            method: CycleMethod::Wave,
        })
    }

    /// The cycles of a sequence: what each frame shows of the legs, `None` where nobody is.
    ///
    /// # Errors
    /// What there is instead of cycles. No sequence is a mistake: somebody may stand.
    pub fn find(
        &self,
        frames: impl IntoIterator<Item = Option<LowerBody>>,
    ) -> Result<FoundCycles, NoCycle> {
        let series =
            |frames, signal| SmoothedSignal::new(frames, signal, self.frame_rate_hz.into());
        match self.method {
            CycleMethod::Wave => self.wave(frames),
            CycleMethod::Peaks(signal) => extrema::by_peaks(&series(frames, signal)?),
            CycleMethod::Minima(signal) => extrema::by_minima(&series(frames, signal)?),
            CycleMethod::Autocorrelation(signal) => {
                autocorrelation::cycles(&series(frames, signal)?)
            }
        }
    }

    fn wave(
        &self,
        frames: impl IntoIterator<Item = Option<LowerBody>>,
    ) -> Result<FoundCycles, NoCycle> {
        let Ok(mut detector) = CycleDetector::new(self.frame_rate_hz) else {
            return Err(NoCycle::TooShort { frames: 0 });
        };
        let mut cycles = Vec::new();
        for frame in frames {
            cycles.extend(detector.push(frame));
        }
        let mut rest = detector.finish();
        cycles.extend(&mut rest);
        let frames = rest.detector().frames();
        let reason = match rest.detector().walking() {
            Err(reason) => reason,
            // Long enough, and yet no three steps in a row.
            Ok(end) if frames as f64 >= 2.0 * f64::from(end.period_frames) => NoCycle::Irregular {
                regular: end.regular,
            },
            Ok(_) => NoCycle::TooShort { frames },
        };
        FoundCycles::of(cycles, reason)
    }
}

impl FoundCycles {
    /// Of these, with the median of their periods; `reason` if there are none.
    fn of(cycles: Vec<DetectedCycle>, reason: NoCycle) -> Result<Self, NoCycle> {
        let periods = cycles.iter().map(DetectedCycle::period_frames);
        let period_frames = median(periods.collect()).ok_or(reason)?;
        let regular = cycles.iter().map(|cycle| f64::from(cycle.regular));
        let regular = median(regular.collect()).ok_or(reason)?;
        Ok(Self {
            cycles,
            period_frames,
            regular,
        })
    }

    /// Cycles of one length from `start` on, as far as the series goes.
    pub(super) fn evenly(
        series: &SmoothedSignal,
        start: f64,
        period: f64,
        regular: f64,
    ) -> Result<Self, NoCycle> {
        let last = series.values.len() as f64 - 1.0;
        let count = ((last - start) / period).floor().max(0.0) as usize;
        let at = |number: usize| start + number as f64 * period;
        let cycles = (0..count).map(|number| cycle(at(number), at(number + 1), regular));
        let mut found = Self::of(cycles.collect(), series.too_short())?;
        found.period_frames = period;
        Ok(found)
    }

    /// Between every second of these places.
    pub(super) fn between(
        series: &SmoothedSignal,
        places: &[f64],
        regular: f64,
    ) -> Result<Self, NoCycle> {
        let cycles = places.windows(3).step_by(2);
        let cycles = cycles.map(|three| cycle(three[0], three[2], regular));
        Self::of(cycles.collect(), series.too_short())
    }
}

fn cycle(start: f64, end: f64, regular: f64) -> DetectedCycle {
    DetectedCycle {
        start,
        end,
        regular: regular as f32,
    }
}

/// The frames of a cycle as whole numbers: `ceil(start)..ceil(end)`, so that each belongs to one cycle.
#[must_use]
pub fn whole_frames(cycle: &DetectedCycle) -> Range<usize> {
    cycle.start.ceil() as usize..cycle.end.ceil() as usize
}

/// What each frame of `[frames][rows][columns]` shows of the legs; pixels of 128 and more are on. An
/// incomplete last frame is left out, and without rows or columns there are no frames.
pub fn lower_bodies(
    pixels: &[u8],
    [rows, columns]: [usize; 2],
) -> impl Iterator<Item = Option<LowerBody>> {
    let frame = rows.saturating_mul(columns);
    let frames = if frame == 0 { &[] } else { pixels };
    let frames = frames.chunks_exact(frame.max(1));
    frames.map(move |pixels| LowerBody::of_pixels(pixels, columns))
}

/// The middle of some numbers, or the mean of the two in the middle; `None` without any.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let (&low, &high) = (
        values.get(values.len().checked_sub(1)? / 2)?,
        values.get(values.len() / 2)?,
    );
    Some(f64::midpoint(low, high))
}

//! Running the pipeline on a repeated video, for a given time, in windows.

use super::histogram::Histogram;
use super::laps::{Laps, PathStage, Stages, ns};
use super::walk::{CycleAnswer, WatchedWalker};
use crate::bench::statistics::Times;
use crate::bench::windows::Watch;
use crate::error::{Error, Result};
use crate::segment::Video;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The approximate length of a window. Our choice: a small board without a heat sink is throttled
/// within minutes.
const WINDOW: Duration = Duration::from_secs(10);

/// The duration of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PathPlan {
    /// The number of windows; at least two.
    windows: u32,
    /// The minimum length of a window, which has at least one frame.
    window: Duration,
}

impl PathPlan {
    /// Plans at least two windows of equal length, about 10 s each, for this duration.
    pub(super) fn for_duration(duration: Duration) -> Self {
        let windows = (duration.as_secs_f64() / WINDOW.as_secs_f64()).round();
        let windows = windows.max(2.0) as u32;
        Self {
            windows,
            window: duration / windows,
        }
    }
}

/// A window of the measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathWindow {
    /// The length of the window, seconds.
    pub seconds: f64,
    /// The number of frames.
    pub frames: u64,
    /// The number of answers.
    pub answers: u64,
    /// The frames a second.
    pub frames_per_second: f64,
    /// The energy in joules, if metered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_j: Option<f64>,
}

/// The measurements of the pipeline.
#[derive(Clone, Debug)]
pub(super) struct MeasuredPath {
    pub windows: Vec<PathWindow>,
    pub stages: Stages,
    /// The times from the file of the frame that made a cycle known to the answer.
    pub answer: Times,
    /// The frames from the end of a cycle until it was known: the sum over all answers, and the
    /// maximum.
    pub waited: (u64, usize),
    pub answers: u64,
    pub non_finite: u64,
    /// The number of times that the video began again.
    pub again: u64,
}

/// Processes frames until the first answer, then resets the detector and the video.
///
/// # Errors
/// If the video ends without an answer, or as [`timed`].
pub(super) fn first_answer(walk: &mut WatchedWalker<'_>, video: &mut Video) -> Result<()> {
    let mut still = || Duration::ZERO;
    let mut laps = Laps::new(&mut still);
    let mut has_answered = false;
    while !has_answered {
        let Some(frame) = video.frame()? else {
            break;
        };
        has_answered = walk.frame(&frame, &mut laps)?.is_some();
    }
    if walk.finish(&mut laps)?.is_empty() && !has_answered {
        return Err(Error::Missing("a gait cycle in the video"));
    }
    video.again()
}

/// Processes frames for the planned time, and at least until there is an answer.
///
/// # Errors
/// If a frame cannot be read, the network fails, or the video has no answer in it.
pub(super) fn timed(
    walk: &mut WatchedWalker<'_>,
    video: &mut Video,
    plan: PathPlan,
    laps: &mut Laps<'_>,
    watch: &mut dyn Watch,
) -> Result<MeasuredPath> {
    let mut tally = AnswerTally::new();
    let mut windows = Vec::new();
    let mut again = 0;
    watch.begin()?;
    laps.resume();
    let mut window = PathWindow::default();
    // The measured time at which the window and the last frame began.
    let (mut window_begun, mut frame_begun) = (laps.total(), laps.total());
    loop {
        let begun = laps.total();
        let Some(frame) = video.frame()? else {
            laps.lap(PathStage::Decode);
            for answer in walk.finish(laps)? {
                window.answers += 1;
                tally.add(&answer, laps.total() - frame_begun);
            }
            video.again()?;
            again += 1;
            if tally.answers == 0 {
                return Err(Error::Missing("a gait cycle in the video"));
            }
            continue;
        };
        laps.lap(PathStage::Decode);
        frame_begun = begun;
        if let Some(answer) = walk.frame(&frame, laps)? {
            window.answers += 1;
            tally.add(&answer, laps.total() - frame_begun);
        }
        laps.close();
        window.frames += 1;
        let took = laps.total() - window_begun;
        if took < plan.window {
            continue;
        }
        window.seconds = took.as_secs_f64();
        window.frames_per_second = window.frames as f64 / window.seconds;
        window.energy_j = watch.end();
        windows.push(std::mem::take(&mut window));
        if windows.len() >= plan.windows as usize && tally.answers > 0 {
            break;
        }
        watch.begin()?;
        laps.resume();
        window_begun = laps.total();
    }
    Ok(MeasuredPath {
        windows,
        stages: laps.stages().ok_or(Error::Missing("an answer"))?,
        answer: tally.took.times().ok_or(Error::Missing("an answer"))?,
        waited: tally.waited,
        answers: tally.answers,
        non_finite: tally.non_finite,
        again,
    })
}

/// Counts of the answers.
struct AnswerTally {
    took: Histogram,
    waited: (u64, usize),
    answers: u64,
    non_finite: u64,
}

impl AnswerTally {
    fn new() -> Self {
        Self {
            took: Histogram::new(),
            waited: (0, 0),
            answers: 0,
            non_finite: 0,
        }
    }

    fn add(&mut self, answer: &CycleAnswer, took: Duration) {
        self.took.add(ns(took));
        let (sum, most) = &mut self.waited;
        *sum += answer.waited as u64;
        *most = (*most).max(answer.waited);
        self.answers += 1;
        self.non_finite += answer.outputs.non_finite as u64;
    }
}

#[cfg(test)]
mod tests;

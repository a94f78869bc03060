//! The path on a video that begins again and again, for a stated time, in windows.

use super::histogram::Histogram;
use super::laps::{Laps, PathStage, Stages, ns};
use super::walk::{CycleAnswer, WatchedWalker};
use crate::bench::statistics::Times;
use crate::bench::windows::Watch;
use crate::error::{Error, Result};
use crate::segment::Video;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// How long a window is, about. Ours: a small board without a heat sink is throttled within minutes.
const WINDOW: Duration = Duration::from_secs(10);

/// For how long is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PathPlan {
    /// Windows, at least two.
    windows: u32,
    /// Shortest window; one also has a frame.
    window: Duration,
}

impl PathPlan {
    /// So long in windows of about 10 s, at least two, all of one length.
    pub(super) fn of(duration: Duration) -> Self {
        let windows = (duration.as_secs_f64() / WINDOW.as_secs_f64()).round();
        let windows = windows.max(2.0) as u32;
        Self {
            windows,
            window: duration / windows,
        }
    }
}

/// A part of the time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathWindow {
    /// How long it was.
    pub seconds: f64,
    /// Frames that went in.
    pub frames: u64,
    /// Answers that came out.
    pub answers: u64,
    /// Frames a second.
    pub frames_per_second: f64,
    /// Energy in joules, where it was metered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_j: Option<f64>,
}

/// What was measured.
#[derive(Clone, Debug)]
pub(super) struct MeasuredPath {
    pub windows: Vec<PathWindow>,
    pub stages: Stages,
    /// From the file of the frame that made a cycle known, to the answer.
    pub answer: Times,
    /// Frames that came after a cycle until it was known: their sum over all answers, and the most.
    pub waited: (u64, usize),
    pub answers: u64,
    pub non_finite: u64,
    /// How often the video began anew.
    pub again: u64,
}

/// Walks until there is an answer; nobody is watched afterwards, and the video begins anew.
///
/// # Errors
/// If the video ends without one, or as [`timed`].
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

/// Walks for as long as is planned, at least until there is an answer.
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
    watch.begin();
    laps.resume();
    let mut window = PathWindow::default();
    // When the window and the last frame began, by the time that was measured.
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
        watch.begin();
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

/// What is counted of answers.
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

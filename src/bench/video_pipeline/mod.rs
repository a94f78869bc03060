//! The costs of the whole pipeline of a device: from the frames of a video to answers.
//!
//! Timed is everything that a frame takes: reading and decoding it, segmenting it, framing the
//! figure to the model's size, and detecting the gait cycle; and, when a cycle is complete, making
//! the model's input from its silhouettes and the inference. Not timed are loading the model and
//! the background, the frames until the first answer, and reading the machine's state between
//! windows.
//!
//! Cycles are found while frames come in, by the detector that a microcontroller also runs
//! ([`CycleDetector`](edgegait_core::cycle::CycleDetector)), so that a device answers while the
//! person walks and its memory is bounded. The detector knows a cycle's end only some steps later;
//! this delay in frames is measured as well. Each pass of the video is one recording: at its end
//! the open cycles are answered, the detector is reset, and the video begins again. Cycles and
//! answers are the same as from a tree of the segmented video (tests of [`walk`]).
//!
//! Everything runs on one thread, except the inference, which has the requested number of threads,
//! and a video that `ffmpeg` decodes in its own process.

mod check;
mod histogram;
mod laps;
mod made;
mod run;
mod table;
#[cfg(test)]
mod testing;
mod walk;

pub(crate) use check::{CheckedVideo, check, check_model};
pub(crate) use made::{MADE_FPS, MADE_SIZE, write_made};
mod results;

pub(crate) use results::PathResult;
pub(super) use table::ROWS;

use super::board::{Board, LoadWatch, MachineState, warnings};
use super::conditions::MachineConditions;
use super::memory;
use super::time_budget::Cap;
use super::timed_model::Watched;
use crate::error::{Error, Result};
use crate::inference::{Model, Runtime};
use crate::segment::{SegmentSettings, Segmenter, Video};
use laps::Laps;
use results::{PathAnswers, PathEnergy, PathRates};
use run::{MeasuredPath, PathPlan, first_answer, timed};
use std::path::Path;
use std::time::{Duration, Instant};
use walk::WatchedWalker;

/// The largest share by which the last window may be slower than the first without a warning. Our
/// choice.
const STEADY: f64 = 0.05;

/// The measurement of the pipeline with one model.
pub(crate) struct PathTask<'a> {
    /// A function that reads the model.
    pub open: &'a dyn Fn() -> Result<Model>,
    /// A function that starts the runtime.
    pub start: &'a dyn Fn() -> Result<Runtime>,
    /// The number of threads within one inference.
    pub threads: usize,
    /// The path of the video.
    pub video: &'a Path,
    /// The path of an image of the empty scene.
    pub background: &'a Path,
    /// The video's frames a second.
    pub fps: f32,
    /// The duration of the measurement.
    pub duration: Duration,
    /// The root folder of the machine's files.
    pub root: &'a Path,
}

/// Measures the pipeline with a model, in this process, which should do nothing else.
///
/// # Errors
/// If the model or the video cannot be used, or an inference fails.
pub(crate) fn measure_path(task: &PathTask<'_>) -> Result<PathResult> {
    let mut video = Video::open(task.video)?;
    let background = Some(task.background);
    let size = video.size();
    let (segmenter, _) = Segmenter::open(task.video, size, background, SegmentSettings::default())?;
    memory::forget_peak();
    let started = Instant::now();
    let runtime = (task.start)()?.with_threads(task.threads);
    let model = (task.open)()?;
    let recognizer = runtime.load(&model)?;
    let load_ms = started.elapsed().as_secs_f64() * 1e3;

    let others = LoadWatch::start(task.root);
    let (plan, fps) = (PathPlan::for_duration(task.duration), task.fps);
    let clock = Instant::now();
    let mut watched = Watched::new(
        task.root,
        MachineState::read(task.root),
        Cap::new(None, Vec::new(), &|_| {}),
    );
    let mut found = None;
    recognizer.beside(&mut || {
        let mut now = || clock.elapsed();
        let mut measure = || -> Result<(MeasuredPath, Option<u64>)> {
            let mut walk = WatchedWalker::new(&segmenter, recognizer.as_ref(), fps)?;
            first_answer(&mut walk, &mut video)?;
            let peak = memory::peak_rss_bytes();
            let mut laps = Laps::new(&mut now);
            let measured = timed(&mut walk, &mut video, plan, &mut laps, &mut watched)?;
            Ok((measured, peak))
        };
        found = Some(measure());
    });
    let (measured, peak_rss_start_bytes) = found.ok_or(Error::Missing("a measurement"))??;
    let peak_rss_end_bytes = memory::peak_rss_bytes();
    let energy = watched
        .meter
        .as_ref()
        .and_then(|meter| PathEnergy::from_windows(meter.source(), &measured.windows));
    let states = watched.states;
    let rates = PathRates::from_measured(&measured, f64::from(task.fps))?;
    let affinity = Board::read(task.root).affinity;
    let mut doubts = warnings(&states, affinity.as_ref());
    doubts.extend(rates.doubts());
    doubts.extend(video.doubts());
    if measured.non_finite > 0 {
        doubts.push("some outputs are not finite numbers".into());
    }
    if video.is_decoded_elsewhere() {
        doubts.push(
            "ffmpeg decodes the video in its own process, on other processors: the decoding time is the time spent waiting for it"
                .into(),
        );
    }
    let contract = recognizer.contract();
    Ok(PathResult {
        name: recognizer.name().to_owned(),
        runtime: recognizer.runtime().clone(),
        threads: task.threads,
        path_threads: 1,
        template: contract.template.name().to_owned(),
        video: CheckedVideo::default(),
        load_ms,
        rates,
        answers: PathAnswers::from_measured(&measured)?,
        stages: measured.stages,
        peak_rss_start_bytes,
        peak_rss_end_bytes,
        energy,
        windows: measured.windows,
        conditions: MachineConditions::from_states(&states),
        others_busy: others.and_then(|others| others.share(task.root)),
        warnings: doubts,
    })
}

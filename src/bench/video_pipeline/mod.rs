//! What the whole path costs that a device runs: from the frames of a video to answers.
//!
//! Inside of the timed part is all that a frame takes: reading and decoding it, segmenting it, framing
//! the figure to the model's size, and following the gait cycle; and where a cycle is complete, making
//! the model's input of its silhouettes and the inference. Outside are loading the model and the
//! background, the first frames until there is an answer, and reading the machine's state between
//! windows.
//!
//! Cycles are found while frames come in, by the detector that a microcontroller runs too
//! ([`CycleDetector`](edgegait_core::cycle::CycleDetector)), not in a whole recording afterwards: a device
//! answers while somebody walks, and its memory is bounded. The detector knows a cycle's end only some
//! steps later; how many frames later is measured as well. The video is one recording: at its end the
//! cycles that are still open are answered, the detector forgets, and the video begins anew. The same
//! cycles are found as in a tree of the segmented video, and the same answers given
//! (tests of [`walk`]).
//!
//! All of it is on one thread but the inference, which has as many as are asked for, and a video that
//! `ffmpeg` decodes in a process of its own.

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
use crate::score::{Model, Runtime};
use crate::segment::{SegmentSettings, Segmenter, Video};
use laps::Laps;
use results::{PathAnswers, PathEnergy, PathRates};
use run::{MeasuredPath, PathPlan, first_answer, timed};
use std::path::Path;
use std::time::{Duration, Instant};
use walk::WatchedWalker;

/// By how much the last window may be slower than the first before that is warned of. Ours, as
/// windows of inferences may differ.
const STEADY: f64 = 0.05;

/// What is to be measured.
pub(crate) struct PathTask<'a> {
    /// Reads the model.
    pub open: &'a dyn Fn() -> Result<Model>,
    /// Starts the runtime.
    pub start: &'a dyn Fn() -> Result<Runtime>,
    /// Threads inside of one inference.
    pub threads: usize,
    /// The video.
    pub video: &'a Path,
    /// A picture of its scene without anybody.
    pub background: &'a Path,
    /// Its frames a second.
    pub fps: f32,
    /// For how long.
    pub duration: Duration,
    /// Where the machine's files are.
    pub root: &'a Path,
}

/// Measures the path with a model, in this process, which should do nothing else.
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
    let (plan, fps) = (PathPlan::of(task.duration), task.fps);
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
        .and_then(|meter| PathEnergy::of(meter.source(), &measured.windows));
    let states = watched.states;
    let rates = PathRates::of(&measured, f64::from(task.fps))?;
    let affinity = Board::read(task.root).affinity;
    let mut doubts = warnings(&states, affinity.as_ref());
    doubts.extend(rates.doubts());
    if measured.non_finite > 0 {
        doubts.push("some of its outputs are not finite numbers".into());
    }
    if video.is_decoded_elsewhere() {
        doubts.push(
            "ffmpeg decodes the video in a process of its own, on other processors: decoding is how long it was waited for"
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
        answers: PathAnswers::of(&measured)?,
        stages: measured.stages,
        peak_rss_start_bytes,
        peak_rss_end_bytes,
        energy,
        windows: measured.windows,
        conditions: MachineConditions::of(&states),
        others_busy: others.and_then(|others| others.share(task.root)),
        warnings: doubts,
    })
}

//! The pipeline: takes frames and gives answers.

use super::laps::{Laps, PathStage};
use crate::dataset::framed;
use crate::dataset::gait_cycles::{CycleDetector, DetectedCycle, LowerBody, whole_frames};
use crate::dataset::sequences::{Form, in_form};
use crate::draw::sweep::Settings;
use crate::error::{Error, Result};
use crate::inference::{Outputs, Recognizer};
use crate::segment::Segmenter;
use edgegait_core::budget::CYCLE_STEPS_PER_MINUTE;
use edgegait_core::silhouette::Silhouette;
use image::RgbImage;
use std::collections::VecDeque;
use std::ops::Range;

/// The number of silhouettes that are kept, in steps of the slowest walker: a cycle's two steps,
/// each up to a third longer than the one before, are known at most two steps and one frame later;
/// and one more step.
const KEPT_STEPS: f32 = 6.0;

/// The answer to one gait cycle.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CycleAnswer {
    /// The frames of the gait cycle, counted from the start of the recording.
    pub frames: Range<usize>,
    /// The number of frames from the cycle's last frame until it was known.
    pub waited: usize,
    /// The outputs of the network.
    pub outputs: Outputs,
}

/// A walker in front of the camera, with the state of the pipeline.
pub(super) struct WatchedWalker<'a> {
    segmenter: &'a Segmenter,
    recognizer: &'a dyn Recognizer,
    form: Form,
    fps: f32,
    detector: CycleDetector,
    /// The last silhouettes, framed; `None` for frames without a figure. The next frame is `next`.
    recent: VecDeque<Option<Silhouette>>,
    next: usize,
    kept: usize,
    input: Vec<f32>,
}

impl<'a> WatchedWalker<'a> {
    /// Starts without frames.
    ///
    /// # Errors
    /// If the frame rate is out of range, or the contract has no size.
    pub(super) fn new(
        segmenter: &'a Segmenter,
        recognizer: &'a dyn Recognizer,
        fps: f32,
    ) -> Result<Self> {
        let contract = recognizer.contract();
        let (slowest, _) = CYCLE_STEPS_PER_MINUTE;
        Ok(Self {
            segmenter,
            recognizer,
            form: Form {
                settings: Settings {
                    template: contract.template,
                    size: contract.size().ok_or(Error::Missing("a size"))?,
                    framing: contract.framing,
                    ..Settings::default()
                },
                frames: contract.frames,
            },
            fps,
            detector: CycleDetector::new(fps)?,
            recent: VecDeque::new(),
            next: 0,
            kept: (KEPT_STEPS * 60.0 / slowest * fps).ceil() as usize,
            input: Vec::new(),
        })
    }

    /// Takes the next frame, and returns an answer if it completes a gait cycle.
    ///
    /// # Errors
    /// If the network fails.
    pub(super) fn frame(
        &mut self,
        frame: &RgbImage,
        laps: &mut Laps<'_>,
    ) -> Result<Option<CycleAnswer>> {
        let mask = self.segmenter.segment(frame).mask;
        laps.lap(PathStage::Segment);
        let (grey, columns) = (mask.grey(), mask.columns());
        let Settings { size, framing, .. } = self.form.settings;
        let silhouette = framed(&grey, columns, size, framing)?;
        if self.recent.len() == self.kept {
            self.recent.pop_front();
        }
        self.recent.push_back(silhouette);
        self.next += 1;
        laps.lap(PathStage::Framing);
        let cycle = self.detector.push(LowerBody::of_pixels(&grey, columns));
        laps.lap(PathStage::Cycle);
        cycle.map(|cycle| self.answer(&cycle, laps)).transpose()
    }

    /// Ends the recording and returns the answers to cycles that are still open. The next frame
    /// begins another recording.
    ///
    /// # Errors
    /// If the network fails.
    pub(super) fn finish(&mut self, laps: &mut Laps<'_>) -> Result<Vec<CycleAnswer>> {
        let detector = std::mem::replace(&mut self.detector, CycleDetector::new(self.fps)?);
        let cycles: Vec<DetectedCycle> = detector.finish().collect();
        laps.lap(PathStage::Cycle);
        let answers = cycles.iter().map(|cycle| self.answer(cycle, laps));
        let answers = answers.collect::<Result<_>>()?;
        self.recent.clear();
        self.next = 0;
        Ok(answers)
    }

    fn answer(&mut self, cycle: &DetectedCycle, laps: &mut Laps<'_>) -> Result<CycleAnswer> {
        let frames = whole_frames(cycle);
        let first = self.next - self.recent.len();
        let from = frames.start.checked_sub(first);
        let from = from.ok_or(Error::Missing("the first frames of a gait cycle"))?;
        let of_cycle = self.recent.range(from..frames.end - first).flatten();
        let mut pixels = Vec::with_capacity(frames.len() * self.form.settings.size.pixels());
        for silhouette in of_cycle {
            pixels.extend_from_slice(silhouette.to_coverage().pixels());
        }
        if pixels.is_empty() {
            return Err(Error::Missing("a figure in a gait cycle"));
        }
        let bytes = in_form(pixels, &self.form)?;
        self.input.clear();
        let contract = self.recognizer.contract();
        contract.feed(&bytes, &mut self.input);
        contract.feed_view(None, &mut self.input)?;
        laps.lap(PathStage::Template);
        let outputs = self.recognizer.run(&self.input, 1)?;
        laps.lap(PathStage::Network);
        Ok(CycleAnswer {
            waited: self.next - frames.end,
            frames,
            outputs,
        })
    }
}

#[cfg(test)]
mod tests;

//! Flags that choose how the recordings of a tree are cut into gait cycles.

use super::args::Common;
use super::progress::Progress;
use crate::dataset::gait_cycles::CycleFinder;
use crate::dataset::sequences::{CutRecordings, Recordings, summary};
use crate::draw::sweep::UNCUT_FPS;
use crate::error::Result;
use crate::files::ResultHeader;
use std::ops::RangeInclusive;

/// Steps a minute that most walkers take, by which an assumed frame rate is judged. Our choice: slow
/// patients take 80, walkers 90 to 130, and runners more.
const USUAL_STEPS_PER_MINUTE: RangeInclusive<f64> = 70.0..=150.0;

/// The flags that choose how recordings are cut.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct CuttingArgs {
    /// Frames a second of a tree's recordings, to find gait cycles [default: 25; the cycles of a
    /// tree that EdgeGait wrote are known]
    #[arg(long, value_name = "F", conflicts_with = "whole_recordings")]
    fps: Option<f32>,
    /// Make one template of each whole recording of a tree, not of each gait cycle
    #[arg(long)]
    whole_recordings: bool,
}

impl CuttingArgs {
    /// Creates the flags for a command that has a frame rate of its own.
    pub(super) const fn new(fps: Option<f32>, whole_recordings: bool) -> Self {
        Self {
            fps,
            whole_recordings,
        }
    }

    /// Returns the flags, and whether each was given.
    pub(super) fn given(&self) -> [(&'static str, bool); 2] {
        [
            ("--fps", self.fps.is_some()),
            ("--whole-recordings", self.whole_recordings),
        ]
    }

    /// Cuts the recordings into gait cycles, unless they are to stay whole, and states the result
    /// in the header.
    ///
    /// # Errors
    /// If the frame rate is out of range, or a recording cannot be read.
    pub(super) fn cut(
        &self,
        recordings: Recordings,
        header: &mut ResultHeader,
        common: &Common,
    ) -> Result<Recordings> {
        if self.whole_recordings {
            *header = header.clone().with("whole_recordings", true);
            return Ok(recordings);
        }
        if let (Some(frames), None) = (recordings.frames_per_cycle(), self.fps) {
            *header = header.clone().with("frames_per_cycle", frames);
            return recordings.in_even_cycles(frames);
        }
        let fps = self.fps.unwrap_or(UNCUT_FPS as f32);
        let finder = CycleFinder::new(fps)?;
        let all = recordings.len();
        let progress = Progress::new(common, ("finding cycles in", "recordings"), all);
        let CutRecordings {
            recordings: cut,
            without,
            period_frames,
        } = recordings.in_cycles(&finder, &|| progress.step())?;
        *header = header
            .clone()
            .with("fps", f64::from(fps))
            .with("recordings", all);
        let assumed = match self.fps {
            Some(_) => String::new(),
            None => format!(
                " at {UNCUT_FPS} frames a second, which are assumed (state theirs with --fps)"
            ),
        };
        let what = format!(
            "{} of {all} recordings have no gait cycle that can be found{assumed}, and are used whole",
            without.len()
        );
        header.warnings.extend(summary(what, &without));
        let cadence = period_frames.map(|frames| 120.0 / frames * f64::from(fps));
        let unusual = cadence.filter(|steps| !USUAL_STEPS_PER_MINUTE.contains(steps));
        if let (Some(steps), None) = (unusual, self.fps) {
            header.warnings.push(format!(
                "walkers take {steps:.0} steps a minute at {UNCUT_FPS} frames a second, which are assumed (if the recordings have another rate, state it with --fps)"
            ));
        }
        Ok(cut)
    }
}

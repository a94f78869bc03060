//! What was found of the path, as the JSON that holds it.

use super::check::CheckedVideo;
use super::laps::Stages;
use super::run::{MeasuredPath, PathWindow};
use crate::bench::conditions::MachineConditions;
use crate::bench::statistics::Times;
use crate::error::{Error, Result};
use crate::score::RuntimeName;
use serde::{Deserialize, Serialize};

/// What the path costs with one model. Times are in microseconds unless their name says otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathResult {
    /// The model's name.
    pub name: String,
    /// What ran it.
    pub runtime: RuntimeName,
    /// Threads inside of one inference.
    pub threads: usize,
    /// Threads of all else.
    pub path_threads: usize,
    /// What the model takes.
    pub template: String,
    /// The video.
    pub video: CheckedVideo,
    /// From the model's path to a recognizer that is ready, milliseconds, with the runtime's start.
    pub load_ms: f64,
    /// How fast.
    #[serde(flatten)]
    pub rates: PathRates,
    /// How late.
    pub answers: PathAnswers,
    /// Where the time goes.
    pub stages: Stages,
    /// The most memory that the process had until its first answer, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_start_bytes: Option<u64>,
    /// The same until the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_end_bytes: Option<u64>,
    /// Energy, where the machine meters it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<PathEnergy>,
    /// Parts of the time, in order.
    pub windows: Vec<PathWindow>,
    /// The machine while this was measured.
    pub conditions: MachineConditions,
    /// The share of its processors that others kept busy meanwhile, 0..1, if the machine tells; a process
    /// that decodes the video is one of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub others_busy: Option<f64>,
    /// What should be known before these numbers are trusted.
    pub warnings: Vec<String>,
}

/// Frames and answers a second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathRates {
    /// How long was measured.
    pub seconds: f64,
    /// Frames that went in.
    pub frames: u64,
    /// Frames a second.
    pub frames_per_second: f64,
    /// How many times as many as the video has: below 1 the path does not keep up with it.
    pub times_real_time: f64,
    /// Frames a second without the time for decoding them, as where a camera gives pixels.
    pub without_decoding_per_second: f64,
    /// Frames a second of the first window, of the last and of the slowest.
    pub first_per_second: f64,
    /// Of the last.
    pub last_per_second: f64,
    /// Of the slowest.
    pub slowest_per_second: f64,
    /// How often the video began anew.
    pub times_again: u64,
}

impl PathRates {
    /// Of a video of so many frames a second.
    ///
    /// # Errors
    /// Without windows.
    pub(super) fn of(measured: &MeasuredPath, fps: f64) -> Result<Self> {
        let windows = &measured.windows;
        let [Some(first), Some(last)] = [windows.first(), windows.last()] else {
            return Err(Error::Missing("a window"));
        };
        let seconds: f64 = windows.iter().map(|window| window.seconds).sum();
        let frames: u64 = windows.iter().map(|window| window.frames).sum();
        let rates = windows.iter().map(|window| window.frames_per_second);
        let decode = measured.stages.decode;
        let decoding_s = 1e-6 * decode.mean_us * decode.calls as f64;
        let frames_per_second = frames as f64 / seconds;
        Ok(Self {
            seconds,
            frames,
            frames_per_second,
            times_real_time: frames_per_second / fps,
            without_decoding_per_second: frames as f64 / (seconds - decoding_s),
            first_per_second: first.frames_per_second,
            last_per_second: last.frames_per_second,
            slowest_per_second: rates.fold(f64::INFINITY, f64::min),
            times_again: measured.again,
        })
    }

    /// What speaks against them.
    pub(super) fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        if self.times_real_time < 1.0 {
            doubts.push(format!(
                "the path does not keep up with the video: {:.1} frames a second are {:.2} of its rate",
                self.frames_per_second, self.times_real_time
            ));
        }
        if self.last_per_second < (1.0 - super::STEADY) * self.first_per_second {
            doubts.push(format!(
                "the last window has {:.0} % fewer frames a second than the first",
                100.0 - 100.0 * self.last_per_second / self.first_per_second
            ));
        }
        doubts
    }
}

/// Answers, one for each gait cycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathAnswers {
    /// How many there were.
    pub count: u64,
    /// A second.
    pub per_second: f64,
    /// Frames that came after a cycle's last one until its end was known: their mean. What that is in
    /// seconds follows from the video's rate; it is waited for whatever the machine.
    pub waited_frames_mean: f64,
    /// And their most.
    pub waited_frames_most: usize,
    /// From the file of the frame that made a cycle known, or that ended the recording, to the answer.
    #[serde(flatten)]
    pub times: Times,
}

impl PathAnswers {
    pub(super) fn of(measured: &MeasuredPath) -> Result<Self> {
        let seconds: f64 = measured.windows.iter().map(|window| window.seconds).sum();
        if measured.answers == 0 {
            return Err(Error::Missing("an answer"));
        }
        let (sum, most) = measured.waited;
        Ok(Self {
            count: measured.answers,
            per_second: measured.answers as f64 / seconds,
            waited_frames_mean: sum as f64 / measured.answers as f64,
            waited_frames_most: most,
            times: measured.answer,
        })
    }
}

/// Energy of all that the counter sees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathEnergy {
    /// What was read.
    pub source: String,
    /// Millijoules of a frame, with its share of the answers.
    pub frame_mj: f64,
}

impl PathEnergy {
    /// Of all windows; none if one was not metered.
    pub(super) fn of(source: &str, windows: &[PathWindow]) -> Option<Self> {
        let joules = windows.iter().map(|window| window.energy_j);
        let joules = joules.sum::<Option<f64>>()?;
        let frames: u64 = windows.iter().map(|window| window.frames).sum();
        (frames > 0).then(|| Self {
            source: source.to_owned(),
            frame_mj: 1e3 * joules / frames as f64,
        })
    }
}

#[cfg(test)]
mod tests;

//! The results of the pipeline, as JSON.

use super::check::CheckedVideo;
use super::laps::Stages;
use super::run::{MeasuredPath, PathWindow};
use crate::bench::conditions::MachineConditions;
use crate::bench::statistics::Times;
use crate::error::{Error, Result};
use crate::inference::RuntimeName;
use serde::{Deserialize, Serialize};

/// The costs of the pipeline with one model. Times are in microseconds unless their name states
/// another unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathResult {
    /// The model's name.
    pub name: String,
    /// The runtime that ran the model.
    pub runtime: RuntimeName,
    /// The number of threads within one inference.
    pub threads: usize,
    /// The number of threads for everything else.
    pub path_threads: usize,
    /// The template that the model takes.
    pub template: String,
    /// The properties of the video.
    pub video: CheckedVideo,
    /// The time to start the runtime and load the model, milliseconds.
    pub load_ms: f64,
    /// The rates of frames.
    #[serde(flatten)]
    pub rates: PathRates,
    /// The rate and delay of answers.
    pub answers: PathAnswers,
    /// The times of each stage.
    pub stages: Stages,
    /// The peak memory of the process until its first answer, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_start_bytes: Option<u64>,
    /// The peak memory of the process until the end, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_rss_end_bytes: Option<u64>,
    /// Energy, where the machine meters it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<PathEnergy>,
    /// The windows of the measurement, in order.
    pub windows: Vec<PathWindow>,
    /// The state of the machine during the measurement.
    pub conditions: MachineConditions,
    /// The share of the processors that other processes kept busy during the measurement, 0..1, if
    /// known. A process that decodes the video counts as another process.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub others_busy: Option<f64>,
    /// Reasons to doubt these numbers.
    pub warnings: Vec<String>,
}

/// The rates of frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathRates {
    /// The measured time, seconds.
    pub seconds: f64,
    /// The number of frames.
    pub frames: u64,
    /// The frames a second.
    pub frames_per_second: f64,
    /// The frames a second relative to the video's rate; below 1 the pipeline does not keep up.
    pub times_real_time: f64,
    /// The frames a second without decoding, as with a camera that provides pixels.
    pub without_decoding_per_second: f64,
    /// The frames a second of the first window.
    pub first_per_second: f64,
    /// The frames a second of the last window.
    pub last_per_second: f64,
    /// The frames a second of the slowest window.
    pub slowest_per_second: f64,
    /// The number of times that the video began again.
    pub times_again: u64,
}

impl PathRates {
    /// Computes the rates for a video of `fps` frames a second.
    ///
    /// # Errors
    /// If there are no windows.
    pub(super) fn from_measured(measured: &MeasuredPath, fps: f64) -> Result<Self> {
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

    /// Returns reasons to doubt the rates.
    pub(super) fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        if self.times_real_time < 1.0 {
            doubts.push(format!(
                "processing does not keep up with the video: {:.1} frames a second are {:.2} of its rate",
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

/// The answers, one for each gait cycle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathAnswers {
    /// The number of answers.
    pub count: u64,
    /// The answers a second.
    pub per_second: f64,
    /// The mean number of frames from a cycle's last frame until its end was known. The delay in
    /// seconds follows from the video's rate and is the same on every machine.
    pub waited_frames_mean: f64,
    /// The greatest such number of frames.
    pub waited_frames_most: usize,
    /// The times from the file of the frame that made a cycle known, or that ended the recording,
    /// to the answer.
    #[serde(flatten)]
    pub times: Times,
}

impl PathAnswers {
    pub(super) fn from_measured(measured: &MeasuredPath) -> Result<Self> {
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

/// The energy of all that the meter covers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PathEnergy {
    /// The name of the meter.
    pub source: String,
    /// The energy of a frame, with its share of the answers, millijoules.
    pub frame_mj: f64,
}

impl PathEnergy {
    /// Computes the energy over all windows; none if a window was not metered.
    pub(super) fn from_windows(source: &str, windows: &[PathWindow]) -> Option<Self> {
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

//! The requested outputs of each job, and the moments for which they are made.

use super::{Job, Moments, Raster, Settings, is_uncut, walk_name};
use crate::draw::template::{Builder, Template};
use crate::error::{Result, SettingError, SweepError};
use edgegait_core::pack::Pack;

/// The default frame rate of uncut motions, frames a second, after CASIA-B's video.
pub const UNCUT_FPS: f64 = 25.0;

/// The maximum number of frames in one job: an hour at 25 frames a second.
pub const MAX_FRAMES: u32 = 90_000;

/// The requested outputs of each job.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// The templates to make: at least one, each once.
    pub templates: Vec<Template>,
    /// Whether to output joints too: their positions in space and in the images.
    pub joints: bool,
    /// Whether frames without any visible part of the figure become blank silhouettes; otherwise
    /// they are left out.
    pub blanks: bool,
    /// Frames a second, instead of [`Settings::frames_per_cycle`]; the default for uncut motions is
    /// [`UNCUT_FPS`].
    pub fps: Option<f64>,
}

impl Wanted {
    /// Requests one template of a cycle.
    #[must_use]
    pub fn one(template: Template) -> Self {
        Self {
            templates: vec![template],
            joints: false,
            blanks: false,
            fps: None,
        }
    }

    /// Checks that the rasteriser can make these outputs.
    ///
    /// # Errors
    /// If an output requires single frames, which [`Raster::Columns`] does not draw.
    pub fn check(&self, settings: &Settings) -> Result<()> {
        let other = self
            .templates
            .iter()
            .find(|template| **template != Template::Gei);
        let what = match other {
            Some(other) => other.name(),
            None if self.joints => "joints",
            None => return Ok(()),
        };
        if settings.rasterizer == Raster::Columns {
            return Err(
                SettingError::ColumnsSumFrames(what).refuses("raster", settings.rasterizer.name())
            );
        }
        Ok(())
    }

    /// Returns the moments of a job, and the settings with the job's frames a cycle.
    ///
    /// # Errors
    /// If a template of an uncut motion is requested, or there are too many frames.
    pub(super) fn moments(
        &self,
        pack: &Pack<'_>,
        job: Job<'_>,
        settings: Settings,
    ) -> Result<(Moments, Settings)> {
        let frames = self.frames(pack, job, &settings)?;
        if is_uncut(pack, job.walk) {
            let fps = self.fps.unwrap_or(UNCUT_FPS);
            let start_s = 0.0;
            return Ok((
                Moments::Seconds {
                    start_s,
                    fps,
                    frames,
                },
                settings,
            ));
        }
        let settings = Settings {
            frames_per_cycle: frames,
            ..settings
        };
        Ok((Moments::Cycle, settings))
    }

    /// Returns the number of frames of a job: for a cycle, its duration at [`Self::fps`], rounded;
    /// for an uncut motion, all frames from its first moment to its last.
    ///
    /// # Errors
    /// If a template of an uncut motion is requested, or there are too many frames.
    pub fn frames(&self, pack: &Pack<'_>, job: Job<'_>, settings: &Settings) -> Result<u32> {
        let duration_s = || {
            let clip = pack.walk(job.walk).and_then(|walk| pack.clip(walk.clip));
            clip.map_or(0.0, |clip| clip.duration_s())
        };
        let is_uncut = is_uncut(pack, job.walk);
        let name = || walk_name(pack, job.walk);
        if is_uncut && self.templates != [Template::Silhouettes] {
            return Err(SweepError::UncutHasNoCycle(name()).into());
        }
        let (frames, most) = match (is_uncut, self.fps) {
            // The duration is stated in whole microseconds.
            (true, fps) => (
                ((duration_s() + 1e-6) * fps.unwrap_or(UNCUT_FPS)).floor() + 1.0,
                MAX_FRAMES,
            ),
            (false, Some(fps)) => ((duration_s() * fps).round().max(1.0), Builder::MAX_FRAMES),
            (false, None) => return Ok(settings.frames_per_cycle),
        };
        if frames > f64::from(most) {
            return Err(SweepError::TooManyFrames {
                walk: name(),
                frames,
                most,
            }
            .into());
        }
        Ok(frames as u32)
    }
}

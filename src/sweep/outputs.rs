//! What is made of each job, and of which of its moments.

use super::{Job, Moments, Raster, Settings, is_take, walk_name};
use crate::error::{ChoiceError, Result, SweepError};
use crate::template::{Builder, Template};
use edgegait_core::pack::Pack;

/// Frames a second of takes, unless a user says otherwise: those of CASIA-B's video.
pub const TAKE_FPS: f64 = 25.0;

/// Most frames of one job: an hour at 25 a second.
pub const MAX_FRAMES: u32 = 90_000;

/// What is made of each job.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// At least one, each once.
    pub templates: Vec<Template>,
    /// Whether joints are told besides, where they are and where they appear.
    pub joints: bool,
    /// Whether frames in which nothing is left of the figure are blank silhouettes, rather than
    /// left out.
    pub blanks: bool,
    /// Frames a second, in place of [`Settings::frames_per_cycle`]; of takes [`TAKE_FPS`] if it is
    /// not said.
    pub fps: Option<f64>,
}

impl Wanted {
    /// One template of a cycle.
    #[must_use]
    pub fn one(template: Template) -> Self {
        Self {
            templates: vec![template],
            joints: false,
            blanks: false,
            fps: None,
        }
    }

    /// Refuses what cannot be made.
    ///
    /// # Errors
    /// If frames are wanted that [`Raster::Columns`] does not draw one by one.
    pub fn check(&self, settings: &Settings) -> Result<()> {
        let other = self.templates.iter().find(|one| **one != Template::Gei);
        let what = match other {
            Some(other) => other.name(),
            None if self.joints => "joints",
            None => return Ok(()),
        };
        if settings.rasterizer == Raster::Columns {
            return Err(ChoiceError::ColumnsSumFrames(what).into());
        }
        Ok(())
    }

    /// The moments of a job, and the settings with as many frames a cycle as it has.
    ///
    /// # Errors
    /// If a template is wanted of a take, or there are too many frames.
    pub(super) fn moments(
        &self,
        pack: &Pack<'_>,
        job: Job<'_>,
        settings: Settings,
    ) -> Result<(Moments, Settings)> {
        let frames = self.frames(pack, job, &settings)?;
        if is_take(pack, job.walk) {
            let fps = self.fps.unwrap_or(TAKE_FPS);
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

    /// How many frames of a job there are: of a cycle the nearest number to its duration at
    /// [`Self::fps`], of a take all from its first moment to its last.
    ///
    /// # Errors
    /// If a template is wanted of a take, or there are too many frames.
    pub fn frames(&self, pack: &Pack<'_>, job: Job<'_>, settings: &Settings) -> Result<u32> {
        let duration_s = || {
            let clip = pack.walk(job.walk).and_then(|walk| pack.clip(walk.clip));
            clip.map_or(0.0, |clip| clip.duration_s())
        };
        let is_take = is_take(pack, job.walk);
        let name = || walk_name(pack, job.walk);
        if is_take && self.templates != [Template::Silhouettes] {
            return Err(SweepError::TakeHasNoCycle(name()).into());
        }
        let (frames, most) = match (is_take, self.fps) {
            // The duration is stated in whole microseconds.
            (true, fps) => (
                ((duration_s() + 1e-6) * fps.unwrap_or(TAKE_FPS)).floor() + 1.0,
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

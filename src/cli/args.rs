//! Flags that mean the same thing everywhere.

use crate::dataset::{Header, write_atomically};
use crate::error::{Error, Result};
use crate::sweep::{FRAMES_PER_CYCLE, Settings, Views};
use clap::ValueEnum;
use edgegait_core::raster::Rasterizer;
use serde::Serialize;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// What every subcommand takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Common {
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Threads [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Write the results as JSON; "-" is standard output, and then nothing else is printed there
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

impl Common {
    /// Whether standard output belongs to the JSON results.
    #[must_use]
    pub fn json_on_stdout(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }

    /// Prints what a person reads, unless standard output belongs to the JSON results.
    pub fn say(&self, text: impl std::fmt::Display) {
        if !self.json_on_stdout() {
            // A closed pipe (`| head`) is no error.
            let _ = writeln!(std::io::stdout(), "{text}");
        }
    }

    /// Writes the JSON results, if they were asked for.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_json(&self, results: &impl Serialize) -> Result<()> {
        let Some(path) = &self.json else {
            return Ok(());
        };
        let mut text = serde_json::to_string_pretty(results)
            .map_err(|error| Error::Failed(format!("cannot write the results as JSON: {error}")))?;
        text.push('\n');
        if self.json_on_stdout() {
            return std::io::stdout()
                .write_all(text.as_bytes())
                .map_err(|error| Error::io("standard output", error));
        }
        write_atomically(path, |file| {
            file.write_all(text.as_bytes())
                .map_err(|error| Error::io(path, error))
        })
    }
}

/// From where walks are seen.
#[derive(Clone, Debug, clap::Args)]
pub struct ViewArgs {
    /// Viewpoints: "paper" (703), "side", or a CSV file with azimuth_deg and elevation_deg
    #[arg(long, value_name = "NAME|FILE", conflicts_with_all = ["azimuth_deg", "elevation_deg"])]
    pub views: Option<String>,
    /// Azimuths in degrees; 0 is in front, 90 on the walker's left, 180 behind
    #[arg(
        long,
        value_name = "A[,A..]",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub azimuth_deg: Vec<f32>,
    /// Elevations in degrees; 0 is level, 90 straight above
    #[arg(
        long,
        value_name = "E[,E..]",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub elevation_deg: Vec<f32>,
}

impl ViewArgs {
    /// The viewpoints asked for, or those called `default`.
    ///
    /// # Errors
    /// For angles that are no viewpoint, and files that hold none.
    pub fn views(&self, default: &str) -> Result<Views> {
        if self.azimuth_deg.is_empty() && self.elevation_deg.is_empty() {
            return Views::named(self.views.as_deref().unwrap_or(default));
        }
        let or = |list: &[f32], default: f32| {
            if list.is_empty() {
                vec![default]
            } else {
                list.to_vec()
            }
        };
        let azimuths = or(&self.azimuth_deg, 90.0);
        let elevations = or(&self.elevation_deg, 0.0);
        let name = format!("azimuth {azimuths:?} by elevation {elevations:?}");
        Views::grid(name, azimuths, elevations)
    }
}

/// How silhouettes are drawn.
#[derive(Clone, Debug, clap::Args)]
pub struct DrawArgs {
    /// Rasteriser
    #[arg(long, value_name = "NAME", default_value = "skia")]
    pub raster: RasterArg,
    /// Silhouettes in each gait cycle
    #[arg(long, value_name = "N", default_value_t = FRAMES_PER_CYCLE, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub frames_per_cycle: u32,
}

impl DrawArgs {
    /// The settings of a sweep.
    #[must_use]
    pub fn settings(&self, seed: u64) -> Settings {
        Settings {
            rasterizer: self.raster.rasterizer(),
            frames_per_cycle: self.frames_per_cycle,
            seed,
        }
    }

    /// The same as named settings of a result.
    #[must_use]
    pub fn describe(&self, header: Header) -> Header {
        header
            .with("raster", self.raster.rasterizer().name())
            .with("framing", "height")
            .with("lens", "ortho")
            .with("frames_per_cycle", self.frames_per_cycle)
    }
}

/// Names of the rasterisers.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum RasterArg {
    /// tiny-skia, one sample a pixel
    Skia,
    /// tiny-skia, anti-aliased
    SkiaAa,
}

impl RasterArg {
    /// The rasteriser of this name.
    #[must_use]
    pub const fn rasterizer(self) -> Rasterizer {
        match self {
            Self::Skia => Rasterizer::Skia,
            Self::SkiaAa => Rasterizer::SkiaAa,
        }
    }
}

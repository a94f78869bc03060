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

    /// Refuses a JSON file that cannot be written, before any work is done.
    ///
    /// # Errors
    /// When its folder is missing, or it is a folder itself.
    pub fn check(&self) -> Result<()> {
        let Some(path) = self.json.as_deref().filter(|_| !self.json_on_stdout()) else {
            return Ok(());
        };
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        if path.is_dir() || folder.is_some_and(|folder| !folder.is_dir()) {
            return Err(Error::input(
                path,
                "expected a file to write in a folder that exists",
            ));
        }
        Ok(())
    }

    /// Prints what a person reads, unless standard output belongs to the JSON results.
    pub fn say(&self, text: impl std::fmt::Display) {
        if !self.json_on_stdout() {
            match writeln!(std::io::stdout(), "{text}") {
                Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                    eprintln!("error: standard output: {error}");
                    std::process::exit(1);
                }
                // A closed pipe (`| head`) is no error.
                _ => {}
            }
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
            return match std::io::stdout().write_all(text.as_bytes()) {
                Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                    Err(Error::io("standard output", error))
                }
                _ => Ok(()),
            };
        }
        write_atomically(path, |file| {
            file.write_all(text.as_bytes())
                .map_err(|error| Error::io(path, error))
        })
    }
}

/// Refuses flags that choose walks (`subjects`, `walks`) and say how they are drawn, where a
/// dataset's GEIs are used as they are.
///
/// # Errors
/// Naming the first such flag that was given.
pub fn refuse_for_datasets(
    [subjects, walks]: [&[String]; 2],
    cycles: Option<u32>,
    views: &ViewArgs,
    draw: &DrawArgs,
) -> Result<()> {
    let flags = [
        ("--subjects", !subjects.is_empty()),
        ("--walks", !walks.is_empty()),
        ("--cycles", cycles.is_some()),
        ("--views, --azimuth-deg, --elevation-deg", views.is_given()),
        ("--raster", draw.raster.is_some()),
        ("--frames-per-cycle", draw.frames_per_cycle.is_some()),
    ];
    match flags.iter().find(|(_, given)| *given) {
        Some((flag, _)) => Err(Error::Usage(format!(
            "{flag}: a dataset is used whole and as it was drawn (use a pack, or sweep another dataset)"
        ))),
        None => Ok(()),
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
    /// Whether any of these flags was given.
    #[must_use]
    pub fn is_given(&self) -> bool {
        self.views.is_some() || !self.azimuth_deg.is_empty() || !self.elevation_deg.is_empty()
    }

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
    /// Rasteriser [default: skia]
    #[arg(long, value_name = "NAME")]
    pub raster: Option<RasterArg>,
    /// Silhouettes in each gait cycle [default: 32]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub frames_per_cycle: Option<u32>,
}

impl DrawArgs {
    /// The rasteriser asked for, or the default.
    #[must_use]
    pub fn rasterizer(&self) -> Rasterizer {
        self.raster.map_or(Rasterizer::Skia, RasterArg::rasterizer)
    }

    /// The settings of a sweep.
    #[must_use]
    pub fn settings(&self, seed: u64) -> Settings {
        Settings {
            rasterizer: self.rasterizer(),
            frames_per_cycle: self.frames_per_cycle.unwrap_or(FRAMES_PER_CYCLE),
            seed,
        }
    }

    /// The same as named settings of a result.
    #[must_use]
    pub fn describe(&self, header: Header) -> Header {
        header
            .with("raster", self.rasterizer().name())
            .with("framing", "height")
            .with("lens", "ortho")
            .with("frames_per_cycle", self.settings(0).frames_per_cycle)
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

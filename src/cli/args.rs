//! Flags that mean the same thing everywhere.

use crate::dataset::{Header, write_atomically};
use crate::error::{Error, Result};
use crate::frontier::choose::Choice;
use crate::sweep::Views;
use serde::Serialize;
use std::fmt::Display;
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
    pub fn say(&self, text: impl Display) {
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

/// The value of `--max-gei-rmse`.
pub fn gei_rmse(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|x: &f64| *x > 0.0 && *x <= 255.0);
    found.ok_or_else(|| "expected a number above 0, at most 255".to_owned())
}

/// A result's header with what `--max-gei-rmse` chose, and why.
pub fn stated_choice<T: Display>(header: Header, most: Option<f64>, choice: &Choice<T>) -> Header {
    header
        .with("max_gei_rmse", most)
        .with("gei_rmse", choice.gei_rmse)
        .with("chosen", choice.to_string())
}

/// From where walks are seen.
#[derive(Clone, Debug, Default, clap::Args)]
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

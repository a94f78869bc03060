//! Flags that mean the same thing everywhere.

use super::outputs::{Output, OutputKind, check};
use super::stop::Stop;
use crate::draw::sweep::Views;
use crate::encode::within_error::choose::FrontierChoice;
use crate::error::{Error, Result, visible};
use crate::files::{ResultHeader, write_bytes};
use serde::Serialize;
use std::fmt::Display;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The flags that every subcommand takes.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct Common {
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Number of threads [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Vec<u16>,
    /// Write the results as JSON; "-" is standard output, and then nothing else is printed there
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Print only errors: no tables, warnings or progress
    #[arg(long)]
    pub quiet: bool,
    /// Replace any existing file; without it, only earlier results of this command are replaced
    #[arg(long)]
    pub overwrite: bool,
    /// Ends the work early.
    #[arg(skip)]
    pub stop: Stop,
}

/// The files that a command reads and writes.
#[derive(Clone, Debug, Default)]
pub(super) struct FileArgs {
    /// The files and folders that the command reads; some of them may not exist.
    pub inputs: Vec<PathBuf>,
    /// The outputs of the command besides the JSON results.
    pub outputs: Vec<Output>,
}

/// Returns the value as a path if it ends in this extension, and so is a file and no name.
pub(super) fn file_with(extension: &str, value: Option<&String>) -> Option<PathBuf> {
    let path = PathBuf::from(value?);
    let has_it = path.extension().is_some_and(|found| found == extension);
    has_it.then_some(path)
}

impl Common {
    /// Returns whether the JSON results go to standard output.
    #[must_use]
    pub(super) fn json_on_stdout(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }

    /// Checks, before any work is done, that the JSON results and the other outputs of `command`
    /// may and can be written.
    ///
    /// # Errors
    /// For the first output that must not or cannot be written.
    pub(super) fn check(&self, command: &'static str, files: &FileArgs) -> Result<()> {
        let mut outputs = files.outputs.clone();
        if let Some(path) = self.json.as_deref().filter(|_| !self.json_on_stdout()) {
            outputs.push(Output::new("--json", path, OutputKind::Json(command)));
        }
        check(&outputs, &files.inputs, self.overwrite)
    }

    /// Returns the number of threads, if one was given.
    ///
    /// # Errors
    /// If several numbers were given.
    pub(super) fn one_thread_count(&self) -> Result<Option<usize>> {
        match self.threads[..] {
            [] => Ok(None),
            [one] => Ok(Some(one.into())),
            _ => Err(Error::Usage(format!(
                "--threads: expected one number, found {} (edgegait bench takes several)",
                self.threads.len()
            ))),
        }
    }

    /// Prints text for people, unless `--quiet` is given or the JSON results go to standard output.
    pub(super) fn say(&self, text: impl Display) {
        if !self.quiet {
            self.put(visible(&text.to_string()));
        }
    }

    /// Prints each warning as [`Self::say`] does.
    pub(super) fn say_warnings(&self, warnings: &[String]) {
        for warning in warnings {
            self.say(format_args!("warning: {warning}"));
        }
    }

    /// Prints requested output, such as a file that goes to standard output, unless the JSON
    /// results go there.
    pub(super) fn put(&self, text: impl Display) {
        if !self.json_on_stdout() {
            match writeln!(std::io::stdout(), "{text}") {
                Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                    eprintln!("error: standard output: {error}");
                    std::process::exit(1);
                }
                // A closed pipe (`| head`) is not an error.
                _ => {}
            }
        }
    }

    /// Writes the JSON results, if `--json` is given.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn write_json(&self, results: &impl Serialize) -> Result<()> {
        let Some(path) = &self.json else {
            return Ok(());
        };
        let mut text = serde_json::to_string_pretty(results)?;
        text.push('\n');
        if self.json_on_stdout() {
            return match std::io::stdout().write_all(text.as_bytes()) {
                Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                    Err(Error::io("standard output", error))
                }
                _ => Ok(()),
            };
        }
        write_bytes(path, text.as_bytes())
    }
}

/// Parses the value of `--max-gei-rmse`.
pub(super) fn gei_rmse(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|x: &f64| *x > 0.0 && *x <= 255.0);
    found.ok_or_else(|| "expected a number above 0, at most 255".to_owned())
}

/// Adds to a result's header what `--max-gei-rmse` chose, and why.
pub(super) fn stated_choice<T: Display>(
    header: ResultHeader,
    most: Option<f64>,
    choice: &FrontierChoice<T>,
) -> ResultHeader {
    header
        .with("max_gei_rmse", most)
        .with("gei_rmse", choice.gei_rmse)
        .with("chosen", choice.to_string())
}

/// The flags that choose the viewpoints.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct ViewArgs {
    /// Viewpoints: "paper" (703), "side", or a CSV file with azimuth_deg and elevation_deg
    #[arg(long, value_name = "NAME|FILE", conflicts_with_all = ["azimuth_deg", "elevation_deg"])]
    pub views: Option<String>,
    /// Azimuths in degrees; 0 is in front, 90 on the walker's left, 180 behind
    #[arg(
        long,
        value_name = "A[,A..]",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    pub azimuth_deg: Vec<f32>,
    /// Elevations in degrees; 0 is level, 90 straight above
    #[arg(
        long,
        value_name = "E[,E..]",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    pub elevation_deg: Vec<f32>,
}

impl ViewArgs {
    /// Returns the file of viewpoints, if `--views` names one.
    pub(super) fn file(&self) -> Option<PathBuf> {
        file_with("csv", self.views.as_ref())
    }

    /// Returns whether any of these flags was given.
    #[must_use]
    pub(super) fn is_given(&self) -> bool {
        self.views.is_some() || !self.azimuth_deg.is_empty() || !self.elevation_deg.is_empty()
    }

    /// Returns the requested viewpoints, or none if no flag was given.
    ///
    /// # Errors
    /// As [`Self::views`].
    pub(super) fn given(&self) -> Result<Option<Views>> {
        self.is_given().then(|| self.views("side")).transpose()
    }

    /// Returns the requested viewpoints, or the set named `default`.
    ///
    /// # Errors
    /// For angles out of range, and for files without viewpoints.
    pub(super) fn views(&self, default: &str) -> Result<Views> {
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

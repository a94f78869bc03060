//! Whether criterion's results are recent and of the current code.
//!
//! Criterion's folder keeps the results of all earlier runs, also of benchmarks that were not run
//! again after a change.

use super::criterion::unix_s;
use super::figure::ResultFigure;
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Which of criterion's results are refused; the times are those at which files were changed.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Freshness {
    /// The maximum age of a result.
    max_age_hours: Option<f64>,
    /// The maximum time between the results of one limit.
    max_apart_hours: Option<f64>,
    /// Files and folders that are older than the results, relative to the file of limits. `{group}`
    /// is the first part of the benchmark's name.
    sources: Vec<String>,
}

impl Freshness {
    /// Checks the results with the values of one limit; `folder` is that of the limits.
    ///
    /// # Errors
    /// A message that names the benchmark to run again.
    pub(super) fn require(
        &self,
        folder: &Path,
        now: SystemTime,
        values: &[ResultFigure<'_>],
    ) -> Result<(), String> {
        let mut seen: Vec<(f64, &str)> = Vec::new();
        for value in values {
            let name = value
                .object()
                .and_then(|object| object.get("name")?.as_str());
            let (Some(name), Some(measured_s)) = (name, value.beside("measured_s")) else {
                return Err("[criterion]: expected criterion's results, found others".into());
            };
            let group = name.split('/').next().unwrap_or(name);
            let refuse = |expected: &str, found: &str| {
                Err(format!(
                    "{name}: expected a result of {expected}, found one {found} (run the benchmark {group} again)"
                ))
            };
            if let Some(hours) = self.max_age_hours
                && unix_s(now) - measured_s > 3600.0 * hours
            {
                return refuse(&format!("the last {hours} hours"), "that is older");
            }
            for source in &self.sources {
                let source = folder.join(source.replace("{group}", group));
                if let Some(newer) = newer(&source, measured_s)? {
                    return refuse(
                        "the current code",
                        &format!("older than {}", newer.display()),
                    );
                }
            }
            seen.push((measured_s, name));
        }
        seen.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        if let (Some(hours), [(first_s, first), .., (last_s, last)]) =
            (self.max_apart_hours, &seen[..])
            && last_s - first_s > 3600.0 * hours
        {
            return Err(format!(
                "{first} and {last}: expected results at most {hours} hours apart, found more (run cargo bench)"
            ));
        }
        Ok(())
    }
}

/// Returns a file at `path`, or in the folder there, that was changed after a moment.
fn newer(path: &Path, moment_s: f64) -> Result<Option<PathBuf>, String> {
    let said = |error| format!("{}: {error}", path.display());
    if !path.is_dir() {
        let metadata = fs::metadata(path).and_then(|metadata| metadata.modified());
        let changed = metadata.map_err(said)?;
        return Ok((unix_s(changed) > moment_s).then(|| path.to_path_buf()));
    }
    for entry in fs::read_dir(path).map_err(said)? {
        if let Some(found) = newer(&entry.map_err(said)?.path(), moment_s)? {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

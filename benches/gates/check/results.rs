//! Criterion's results, if they are recent and of the current code.

use edgegait::error::{Error, Result};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// The age at which a result is rejected: compiler, kernel and other load may have changed. Our
/// choice.
const MOST_AGE: Duration = Duration::from_hours(24);
/// The time between two results at which they are not compared; a full run takes two minutes. Our
/// choice.
const MOST_APART: Duration = Duration::from_hours(2);
/// The sources of all benchmarks, besides their own files.
const SOURCES: [&str; 6] = [
    "Cargo.toml",
    "Cargo.lock",
    "src",
    "no_std_core/Cargo.toml",
    "no_std_core/src",
    "benches/common",
];

/// The newest results of all benchmarks.
pub struct Results {
    package: PathBuf,
    criterion: PathBuf,
    now: SystemTime,
}

/// The result of one benchmark.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// The median time of an iteration.
    pub median_ns: f64,
    /// The elements of an iteration, if the benchmark counts them.
    pub elements: Option<NonZeroU32>,
    /// The time at which the result was written.
    measured: SystemTime,
}

/// The content of `benchmark.json`.
#[derive(Deserialize)]
struct Benchmark {
    throughput: Option<Throughput>,
}

#[derive(Deserialize)]
enum Throughput {
    Elements(NonZeroU32),
}

/// The content of `estimates.json`.
#[derive(Deserialize)]
struct Estimates {
    median: Estimate,
}

#[derive(Deserialize)]
struct Estimate {
    point_estimate: f64,
}

impl Results {
    /// Opens the results of the benchmarks of `package` in the folder `criterion`.
    pub fn new(
        package: impl Into<PathBuf>,
        criterion: impl Into<PathBuf>,
        now: SystemTime,
    ) -> Self {
        Self {
            package: package.into(),
            criterion: criterion.into(),
            now,
        }
    }

    /// Returns the result of `id`, such as `raster/skia-spread/19-hulls`, which `benches/raster.rs`
    /// measures.
    ///
    /// # Errors
    /// If there is no result, if it is a day old or older than the code, or if it is not
    /// criterion's JSON.
    pub fn timing(&self, id: &str) -> Result<Timing> {
        let bench = id.split('/').next().unwrap_or(id);
        let folder = self.criterion.join(id).join("new");
        let path = folder.join("estimates.json");
        if !path.exists() {
            let problem =
                format!("expected a result, found none (run cargo bench --bench {bench})");
            return Err(Error::input(path, problem));
        }
        let measured = modified(&path)?;
        let age = self.now.duration_since(measured);
        if age.is_ok_and(|age| age > MOST_AGE) {
            let hours = MOST_AGE.as_secs() / 3600;
            let problem = format!(
                "expected a result of the last {hours} hours, found an older one (run cargo bench --bench {bench} again)"
            );
            return Err(Error::input(path, problem));
        }
        let own = format!("benches/{bench}.rs");
        for source in SOURCES.into_iter().chain([own.as_str()]) {
            if let Some(newer) = newer(&self.package.join(source), measured)? {
                let problem = format!(
                    "expected a result of the current code, found one older than {} (run cargo bench --bench {bench} again)",
                    newer.display()
                );
                return Err(Error::input(path, problem));
            }
        }
        let estimates: Estimates = parsed(&path)?;
        let benchmark: Benchmark = parsed(&folder.join("benchmark.json"))?;
        let median_ns = estimates.median.point_estimate;
        if !(median_ns.is_finite() && median_ns > 0.0) {
            let problem = format!("expected a median above 0 ns, found {median_ns}");
            return Err(Error::input(path, problem));
        }
        let elements = benchmark
            .throughput
            .map(|Throughput::Elements(count)| count);
        Ok(Timing {
            median_ns,
            elements,
            measured,
        })
    }
}

/// Rejects results of different runs, in which the load of the machine or the code may differ.
///
/// # Errors
/// If the results are too far apart; the error names the first and the last.
pub fn assert_together(timings: &[(&str, Timing)]) -> Result<()> {
    let first = timings.iter().min_by_key(|(_, timing)| timing.measured);
    let last = timings.iter().max_by_key(|(_, timing)| timing.measured);
    let (Some((first_id, first)), Some((last_id, last))) = (first, last) else {
        return Ok(());
    };
    let apart = last.measured.duration_since(first.measured);
    if apart.is_ok_and(|apart| apart > MOST_APART) {
        return Err(Error::Failed(format!(
            "{first_id} and {last_id}: expected results at most {} hours apart, found more (run cargo bench)",
            MOST_APART.as_secs() / 3600
        )));
    }
    Ok(())
}

fn parsed<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let bytes = fs::read(path).map_err(|source| Error::io(path, source))?;
    serde_json::from_slice(&bytes)
        .map_err(|error| Error::input(path, format!("expected criterion's JSON: {error}")))
}

fn modified(path: &Path) -> Result<SystemTime> {
    let metadata = fs::metadata(path).and_then(|metadata| metadata.modified());
    metadata.map_err(|source| Error::io(path, source))
}

/// Returns a file at `path`, or in the folder there, that was changed after `moment`.
fn newer(path: &Path, moment: SystemTime) -> Result<Option<PathBuf>> {
    if !path.is_dir() {
        return Ok((modified(path)? > moment).then(|| path.to_path_buf()));
    }
    for entry in fs::read_dir(path).map_err(|source| Error::io(path, source))? {
        let entry = entry.map_err(|source| Error::io(path, source))?;
        if let Some(found) = newer(&entry.path(), moment)? {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

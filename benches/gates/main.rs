//! Checks the gates of `benches/gates.toml` against the results of the other benchmarks:
//!
//! `cargo bench`, then `cargo bench --bench gates -- --check`.
//!
//! It measures nothing itself. Without `--check` it only prints a note, since a plain `cargo bench`
//! runs this target before others have results. With `--busy`, gates that need an idle machine are
//! skipped. Other arguments are criterion's (`cargo bench -- --test`) and have no effect.

mod check;

use check::{Gates, Need, Results};
use edgegait::error::{Error, Result};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::SystemTime;
use std::{env, fs};

const PACKAGE: &str = env!("CARGO_MANIFEST_DIR");

fn main() -> ExitCode {
    let asked = |flag: &str| env::args().any(|argument| argument == flag);
    if !asked("--check") {
        println!("gates: not checked (run cargo bench --bench gates -- --check after the others)");
        return ExitCode::SUCCESS;
    }
    match passes(asked("--busy")) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Prints each gate and returns whether all of them hold. `busy` states that other work ran beside
/// the benchmarks.
fn passes(busy: bool) -> Result<bool> {
    let package = Path::new(PACKAGE);
    let path = package.join("benches/gates.toml");
    let text = fs::read_to_string(&path).map_err(|source| Error::io(&path, source))?;
    let gates = Gates::parse(&path, &text)?;
    let results = Results::new(package, criterion_folder()?, SystemTime::now());
    let report = gates.check(&results, |need| {
        need.is_met() && !(busy && need == Need::TwoThreads)
    });
    print!("{report}");
    Ok(report.passes())
}

/// Returns the folder of criterion's results, as criterion 0.8.2 finds it.
fn criterion_folder() -> Result<PathBuf> {
    if let Some(folder) = env::var_os("CRITERION_HOME") {
        return Ok(folder.into());
    }
    let target = match env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => folder.into(),
        None => target_folder()?,
    };
    Ok(target.join("criterion"))
}

/// Returns the target folder of cargo's configuration.
fn target_folder() -> Result<PathBuf> {
    #[derive(Deserialize)]
    struct Metadata {
        target_directory: PathBuf,
    }
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(&cargo)
        .args(["metadata", "--format-version", "1", "--no-deps"])
        .current_dir(PACKAGE)
        .output()
        .map_err(|source| Error::io(&cargo, source))?;
    let metadata: Metadata = serde_json::from_slice(&output.stdout).map_err(|error| {
        Error::Failed(format!(
            "cargo metadata: expected the target folder, found none: {error} (set CARGO_TARGET_DIR)"
        ))
    })?;
    Ok(metadata.target_directory)
}

//! `edgegait bench --compare`: results of several boards side by side.

use super::Args;
use crate::bench::{BenchResults, Compared, chart};
use crate::dataset::write_bytes;
use crate::error::Result;
use std::path::PathBuf;

/// Prints results of several boards side by side.
pub(super) fn run(args: &Args) -> Result<()> {
    let read = |path: &PathBuf| -> Result<(String, BenchResults)> {
        let stem = path.file_stem().unwrap_or(path.as_os_str());
        Ok((
            stem.to_string_lossy().into_owned(),
            BenchResults::read(path)?,
        ))
    };
    let boards = args.compare.iter().map(read).collect::<Result<Vec<_>>>()?;
    let compared = Compared {
        boards: told_apart(boards),
    };
    let compared = if args.no_accuracy {
        compared.without_accuracy()
    } else {
        compared
    };
    compared.check()?;
    if let Some(path) = &args.chart {
        write_bytes(path, chart(&compared)?.as_bytes())?;
    }
    args.common.say(compared.render(args.format).trim_end());
    for (name, results) in &compared.boards {
        for warning in &results.header.warnings {
            args.common.say(format_args!("warning: {name}: {warning}"));
        }
    }
    Ok(())
}

/// Results of one name get a number behind it.
fn told_apart(mut boards: Vec<(String, BenchResults)>) -> Vec<(String, BenchResults)> {
    let names: Vec<String> = boards.iter().map(|(name, _)| name.clone()).collect();
    for (at, (name, _)) in boards.iter_mut().enumerate() {
        let before = names[..at].iter().filter(|other| *other == name).count();
        if before > 0 {
            *name = format!("{name} ({})", before + 1);
        }
    }
    boards
}

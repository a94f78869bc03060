//! `edgegait bench --compare`: results of several boards side by side.

use super::BenchArgs;
use crate::bench::{BenchResults, Compared, chart};
use crate::error::Result;
use crate::files::write_bytes;
use std::path::PathBuf;

/// Prints results of several boards side by side.
pub(super) fn run(args: &BenchArgs) -> Result<()> {
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
    args.common.say(compared.render(args.format).trim_end());
    for (name, results) in &compared.boards {
        for warning in &results.header.warnings {
            args.common.say(format_args!("warning: {name}: {warning}"));
        }
    }
    match &args.chart {
        Some(path) => write_bytes(path, chart(&compared)?.as_bytes()),
        None => Ok(()),
    }
}

/// Makes names unique: appends the first free number to the name of results whose name is taken.
fn told_apart(mut boards: Vec<(String, BenchResults)>) -> Vec<(String, BenchResults)> {
    for at in 0..boards.len() {
        let is_there = |name: &String| boards[..at].iter().any(|(other, _)| other == name);
        let name = boards[at].0.clone();
        let numbered = (2..).map(|number| format!("{name} ({number})"));
        let free = std::iter::once(name.clone())
            .chain(numbered)
            .find(|name| !is_there(name));
        boards[at].0 = free.unwrap_or(name);
    }
    boards
}

//! The command's work in the process of another program, such as a Python interpreter.
//!
//! Words are those of the command line, without the name of the program. Nothing is printed: results
//! come as the JSON that `--json` writes.

use super::hints::WithFlags;
use super::{Cli, Command, command, progress, run, score, sweep, with_threads};
use crate::dataset::Items;
use crate::error::{Error, Result};
use crate::score::Recognizer;
use crate::source::PackSource;
use clap::FromArgMatches as _;
use std::ffi::OsString;
use std::sync::Arc;

/// What a program holds of which a command makes use, as if it were in files.
#[derive(Default)]
pub struct Held {
    /// Recognizers that `score` scores beside those that are named.
    pub recognizers: Vec<Arc<dyn Recognizer>>,
    /// The pack of `score` and of what is swept.
    pub pack: Option<PackSource>,
}

/// What a thread unwinds with when [`interrupt`] ended its work.
pub fn is_interruption(payload: &(dyn std::any::Any + Send)) -> bool {
    payload.is::<progress::Ended>()
}

/// Ends the work of all commands that this process runs, where they next make progress: by unwinding
/// ([`is_interruption`]), so that what is half-made is removed, or kept to be gone on with. Work that
/// begins afterwards runs.
pub fn interrupt() {
    progress::end(true);
}

/// An error as the command shows it, with the flags that help.
#[must_use]
pub fn text_of(error: &Error) -> String {
    WithFlags(error).to_string()
}

/// Runs a subcommand, and gives its results as JSON: empty where it has none.
///
/// # Errors
/// As the command; for words that it does not know, [`Error::Usage`].
pub fn results(words: &[OsString], held: Held) -> Result<String> {
    progress::end(false);
    let failed = |error| Error::io("a temporary folder", error);
    let folder = tempfile::tempdir().map_err(failed)?;
    let json = folder.path().join("results.json");
    let mut words = words.to_vec();
    // Behind the subcommand: what follows `--` is no flag.
    let flags = ["--quiet".into(), "--json".into(), json.clone().into()];
    words.splice(words.len().min(1)..words.len().min(1), flags);
    match parsed(&words)? {
        Command::Score(mut args) => {
            progress::silence(true);
            args.contest.held = held.pack;
            args.common.check("score", &args.files())?;
            with_threads(&args.common, || score::run_with(&args, &held.recognizers))?;
        }
        command => {
            run(&command)?;
        }
    }
    match std::fs::read_to_string(&json) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(String::new()),
        read => read.map_err(|error| Error::io(&json, error)),
    }
}

/// The items of what `sweep` with these words would store.
///
/// # Errors
/// As the command; for words that it does not know, [`Error::Usage`].
pub fn swept(words: &[OsString], pack: Option<PackSource>) -> Result<Items> {
    progress::end(false);
    let words: Vec<OsString> = ["sweep".into(), "--quiet".into()]
        .into_iter()
        .chain(words.iter().cloned())
        .collect();
    match parsed(&words)? {
        Command::Sweep(mut args) => {
            progress::silence(true);
            args.source.held = pack;
            with_threads(&args.common, || sweep::items(&args))
        }
        _ => Err(Error::Missing("the words of a sweep")),
    }
}

/// The subcommand of these words.
fn parsed(words: &[OsString]) -> Result<Command> {
    let words = std::iter::once("edgegait".into()).chain(words.iter().cloned());
    let matches = command().try_get_matches_from(words);
    let cli = matches.and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = cli.map_err(|error| {
        let text = error.to_string();
        let text = text.strip_prefix("error: ").unwrap_or(&text);
        let ends = ["\n\n  tip: to pass", "\n\nUsage:", "\n\nFor more"];
        let end = ends.iter().filter_map(|end| text.find(end)).min();
        Error::Usage(text[..end.unwrap_or(text.len())].trim_end().to_owned())
    })?;
    Ok(cli.command)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<OsString> {
        text.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn words_that_the_command_does_not_know_are_usage() {
        let said =
            results(&words("sweep --raster crayons"), Held::default()).expect_err("no such raster");
        assert_eq!(said.exit_code(), 2);
        let text = text_of(&said);
        assert!(
            text.starts_with("invalid value 'crayons' for '--raster <NAME>'")
                && text.contains("possible values: skia")
                && !text.contains("--help"),
            "{text}"
        );
        let said = results(&words("draw"), Held::default()).expect_err("no such subcommand");
        assert!(text_of(&said).contains("'draw'"), "{said}");
    }

    #[test]
    fn results_are_the_json_of_the_command() {
        let text = results(
            &words("inspect src/source/cohort-5kmh.egp"),
            Held::default(),
        )
        .expect("a pack");
        let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(found["command"], "inspect");
        assert_eq!(found["subjects"].as_array().map(Vec::len), Some(26));
    }
}

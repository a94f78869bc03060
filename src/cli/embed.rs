//! Runs the command in the process of another program, such as a Python interpreter.
//!
//! Words are the arguments of the command line, without the program's name. Nothing is printed:
//! results are returned as the JSON that `--json` writes.

use super::again::{is_known, set_program};
use super::hints::WithFlags;
pub use super::stop::Stop;
use super::{Cli, Command, command, run, score, sweep, with_files, with_threads};
use crate::dataset::Items;
use crate::dataset::sequences::PackSource;
use crate::error::{Error, Result};
use crate::inference::Recognizer;
use std::ffi::OsString;
use std::sync::Arc;

/// Objects in the memory of a program that a command uses as if they were files.
#[derive(Default)]
pub struct EmbeddedInputs {
    /// Recognizers that `score` scores besides the named ones.
    pub recognizers: Vec<Arc<dyn Recognizer>>,
    /// The pack for `score` and `sweep`.
    pub pack: Option<PackSource>,
    /// The program and first words that start the command in a process of its own, as `bench` does
    /// for each model.
    pub program: Vec<OsString>,
    /// The handle that ends the command.
    pub stop: Stop,
}

/// Formats an error as the command does, with the flags that help.
#[must_use]
pub fn text_of(error: &Error) -> String {
    WithFlags(error).to_string()
}

/// Runs a subcommand, and returns its results as JSON, or an empty string if it has none.
///
/// # Errors
/// The errors of the command, and [`Error::Cancelled`] if `held.stop` ended it; for unknown words,
/// [`Error::Usage`].
pub fn results(words: &[OsString], held: EmbeddedInputs) -> Result<String> {
    let failed = |error| Error::io("a temporary folder", error);
    let folder = tempfile::tempdir().map_err(failed)?;
    let json = folder.path().join("results.json");
    let mut words = words.to_vec();
    // After the subcommand, as words after `--` are not flags.
    let flags = ["--quiet".into(), "--json".into(), json.clone().into()];
    words.splice(words.len().min(1)..words.len().min(1), flags);
    set_program(held.program);
    match parsed(&words)? {
        Command::Bench(mut args) => {
            if !is_known() {
                return Err(Error::Usage("bench: measures each model in a process of its own, which this program does not know how to start: run it in a shell".into()));
            }
            args.words = words.split_off(1);
            run(Command::Bench(args), &held.stop)?;
        }
        Command::Score(mut args) => {
            args.common.stop = held.stop;
            args.contest.held = held.pack;
            let files = args.files();
            let work = || score::run_with(&args, &held.recognizers);
            with_files(&args.common, "score", &files, work)?;
        }
        command => {
            run(command, &held.stop)?;
        }
    }
    match std::fs::read_to_string(&json) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(String::new()),
        read => read.map_err(|error| Error::io(&json, error)),
    }
}

/// Returns the items that `sweep` with these words would store.
///
/// # Errors
/// The errors of the command; for unknown words, [`Error::Usage`].
pub fn swept(words: &[OsString], pack: Option<PackSource>) -> Result<Items> {
    let words: Vec<OsString> = ["sweep".into(), "--quiet".into()]
        .into_iter()
        .chain(words.iter().cloned())
        .collect();
    match parsed(&words)? {
        Command::Sweep(mut args) => {
            args.source.held = pack;
            let read = args.files().inputs;
            with_threads(&args.common, || sweep::items(&args)).map_err(|error| error.within(&read))
        }
        _ => Err(Error::Missing("the words of a sweep")),
    }
}

/// Checks words as the command line does, and runs nothing.
///
/// # Errors
/// For unknown words and values that flags do not take, [`Error::Usage`].
pub fn check(words: &[OsString]) -> Result<()> {
    parsed(words).map(drop)
}

/// Parses these words as a subcommand.
fn parsed(words: &[OsString]) -> Result<Command> {
    let words = std::iter::once("edgegait".into()).chain(words.iter().cloned());
    let matches = command().try_get_matches_from(words);
    let cli = matches.and_then(|matches| Cli::of_matches(&matches));
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
        let said = results(&words("sweep --raster crayons"), EmbeddedInputs::default())
            .expect_err("no such raster");
        assert_eq!(said.exit_code(), 2);
        let text = text_of(&said);
        assert!(
            text.starts_with("invalid value 'crayons' for '--raster <NAME>'")
                && text.contains("possible values: skia")
                && !text.contains("--help"),
            "{text}"
        );
        let said =
            results(&words("draw"), EmbeddedInputs::default()).expect_err("no such subcommand");
        assert!(text_of(&said).contains("'draw'"), "{said}");
    }

    #[test]
    fn a_command_is_ended_by_its_own_stop_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let pack = |name: &str| folder.path().join(name).display().to_string();
        let make = |name: &str, stop: &Stop| {
            let words = words(&format!(
                "cohort --people 2 --speeds-kmh 5 --quick --out {}",
                pack(name)
            ));
            let held = EmbeddedInputs {
                stop: stop.clone(),
                ..EmbeddedInputs::default()
            };
            results(&words, held)
        };
        let (ended, other) = (Stop::default(), Stop::default());
        ended.end();
        assert!(matches!(make("none.egp", &ended), Err(Error::Cancelled)));
        assert!(!folder.path().join("none.egp").exists());
        assert!(make("one.egp", &other).is_ok());
        assert!(swept(&words("--views side"), None).is_ok());
        assert!(folder.path().join("one.egp").exists());
    }

    #[test]
    fn what_needs_a_process_of_its_own_is_refused_where_none_is_known() {
        let said = results(&words("bench"), EmbeddedInputs::default()).expect_err("no program");
        assert!(said.to_string().contains("run it in a shell"), "{said}");
    }

    #[test]
    fn two_sources_of_walks_are_refused() {
        let pack = PackSource::made(&crate::dataset::sequences::built_in(&[]), &|| Ok(()))
            .expect("people");
        let held = EmbeddedInputs {
            pack: Some(pack),
            ..EmbeddedInputs::default()
        };
        let said = results(
            &words("score pixels src/dataset/sequences/cohort-5kmh.egp"),
            held,
        );
        let said = said.expect_err("two sources").to_string();
        assert!(
            said.starts_with(
                "expected one source of walks, found src/dataset/sequences/cohort-5kmh.egp and a pack of"
            ),
            "{said}"
        );
        let said = swept(&words("--whole-recordings"), None).expect_err("no tree");
        assert!(
            said.to_string().contains("expected a tree of silhouettes"),
            "{said}"
        );
    }

    #[test]
    fn results_are_the_json_of_the_command() {
        let text = results(
            &words("inspect src/dataset/sequences/cohort-5kmh.egp"),
            EmbeddedInputs::default(),
        )
        .expect("a pack");
        let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(found["command"], "inspect");
        assert_eq!(found["subjects"].as_array().map(Vec::len), Some(26));
    }
}

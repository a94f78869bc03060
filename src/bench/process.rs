//! Measuring each model in its own process.

use crate::error::{Error, Result};
use crate::files::remove_unfinished;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::panic::resume_unwind;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::Builder;

/// The exit code of a process whose parent has ended: a shell's code for SIGHUP.
const ORPHANED: i32 = 128 + 1;

/// The prefix of lines on standard error that report progress.
const PROGRESS: &str = "progress: ";

/// The progress of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeasuringProgress {
    /// The work that is being measured.
    pub what: String,
    /// The estimated time of all remaining work, seconds.
    pub left_s: f64,
}

impl MeasuringProgress {
    /// Reports the progress to the parent process.
    pub(crate) fn say(&self) {
        // If the parent no longer reads, this process is about to end too.
        let _ = writeln!(
            std::io::stderr(),
            "{PROGRESS}{:.1} {}",
            self.left_s,
            self.what
        );
    }

    /// Parses a line that reports progress.
    fn heard(line: &str) -> Option<Self> {
        let (left_s, what) = line.strip_prefix(PROGRESS)?.split_once(' ')?;
        Some(Self {
            what: what.to_owned(),
            left_s: left_s.parse().ok()?,
        })
    }
}

/// What a process that measures a model prints, as JSON.
#[derive(Serialize, Deserialize)]
pub(crate) enum ProcessOutcome<R> {
    /// The result.
    Measured(R),
    /// The process cannot measure it, because of an invalid choice: exit code 2.
    Usage(String),
    /// The process cannot measure it, as the text explains.
    Failed(String),
}

/// Runs a command that measures `model` and prints a [`ProcessOutcome`], and returns the result.
/// `told` is called with its progress. Its standard input stays open, and empty, for as long as
/// this process lives.
///
/// # Errors
/// If the command cannot be started, dies, or prints something else; the command's own errors, and
/// that of `told`, which ends the command.
pub(crate) fn measured_by<R: DeserializeOwned>(
    mut command: Command,
    model: &Path,
    told: &(dyn Fn(&MeasuringProgress) -> Result<()> + Sync),
) -> Result<R> {
    let spawned = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let failed = |error| Error::io(command.get_program(), error);
    let mut child = spawned.map_err(failed)?;
    let held = child.stdin.take();
    let (words, printed) = (child.stderr.take(), child.stdout.take());
    let heard = std::thread::scope(|scope| -> Result<_> {
        let words = || -> Result<String> {
            // Closing it ends the child. It stays open until the child has ended, or `told` fails.
            let _held = held;
            let mut rest = String::new();
            for line in words
                .into_iter()
                .flat_map(|it| BufReader::new(it).split(b'\n'))
            {
                let line = String::from_utf8_lossy(&line.map_err(failed)?).into_owned();
                match MeasuringProgress::heard(&line) {
                    Some(one) => told(&one)?,
                    None => rest += &format!("{line}\n"),
                }
            }
            Ok(rest)
        };
        // Without the thread, its closure is dropped, and with it what keeps the child alive.
        let words = Builder::new().spawn_scoped(scope, words);
        let words = words.map_err(Error::Threads)?;
        let mut stdout = Vec::new();
        let read = printed.map_or(Ok(0), |mut it| it.read_to_end(&mut stdout));
        let words = words.join().unwrap_or_else(|panic| resume_unwind(panic));
        Ok((words, read.map(|_| stdout)))
    });
    let status = child.wait().map_err(failed)?;
    let (stderr, stdout) = heard?;
    let output = Output {
        status,
        stdout: stdout.map_err(failed)?,
        stderr: stderr?.into_bytes(),
    };
    result_of(model, &output)
}

/// Starts a thread that ends this process when its parent has ended, for whatever reason: the
/// parent keeps this process's standard input open and never writes to it, so it then ends.
///
/// # Errors
/// If the system cannot start a thread.
pub(crate) fn end_with_parent() -> Result<()> {
    let wait = || {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        remove_unfinished();
        std::process::exit(ORPHANED);
    };
    Builder::new().spawn(wait).map(drop).map_err(Error::Threads)
}

/// Returns the result of the process that measured a model, or its error.
fn result_of<R: DeserializeOwned>(model: &Path, output: &Output) -> Result<R> {
    let words = String::from_utf8_lossy(&output.stderr);
    let words = words.trim();
    if !output.status.success() {
        return Err(Error::input(
            model,
            format!(
                "the process that measured it died ({}): {}",
                output.status,
                if words.is_empty() {
                    "it printed no error"
                } else {
                    words
                }
            ),
        ));
    }
    match serde_json::from_slice(&output.stdout) {
        Ok(ProcessOutcome::Measured(result)) => Ok(result),
        Ok(ProcessOutcome::Usage(error)) => Err(Error::Usage(error)),
        Ok(ProcessOutcome::Failed(error)) => Err(Error::Failed(error)),
        Err(error) => Err(Error::input(
            model,
            format!("the process that measured it gave no result: {error}; {words}"),
        )),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::ExitStatus;

    fn refusal(status: i32, outcome: &str, words: &str) -> Error {
        let output = Output {
            status: ExitStatus::from_raw(status),
            stdout: outcome.into(),
            stderr: words.into(),
        };
        result_of::<serde_json::Value>(Path::new("m.onnx"), &output).expect_err("it failed")
    }

    #[test]
    fn a_process_that_dies_names_its_model_and_one_that_fails_speaks_for_itself() {
        let died = refusal(11, "", "").to_string();
        assert!(
            died.starts_with("m.onnx: the process that measured it died (signal: 11"),
            "{died}"
        );
        let panicked = refusal(101 << 8, "", "thread 'main' panicked at x.rs").to_string();
        assert!(
            panicked.contains("died (exit status: 101): thread 'main'"),
            "{panicked}"
        );
        let failed = refusal(0, r#"{"Failed":"m.onnx: too large"}"#, "");
        assert_eq!(
            (failed.to_string().as_str(), failed.exit_code()),
            ("m.onnx: too large", 1)
        );
        let usage = refusal(0, r#"{"Usage":"cpus 99: no"}"#, "");
        assert_eq!(
            (usage.to_string().as_str(), usage.exit_code()),
            ("cpus 99: no", 2)
        );
        let silent = refusal(0, "", "").to_string();
        assert!(silent.contains("gave no result"), "{silent}");
    }

    #[test]
    fn a_process_ends_when_its_listener_is_cancelled() {
        let mut command = Command::new("sh");
        command.args(["-c", "echo 'progress: 1.0 m' >&2; cat"]);
        let told = |_: &MeasuringProgress| Err(Error::Cancelled);
        let ended = measured_by::<serde_json::Value>(command, Path::new("m.onnx"), &told);
        assert!(matches!(ended, Err(Error::Cancelled)));
    }

    #[test]
    fn progress_is_separated_from_the_errors_of_a_process() {
        let script = "echo 'progress: 12.5 m: one at a time' >&2; echo 'progress: soon' >&2; \
                      echo 'odd: words' >&2; echo '{\"Measured\":{\"a\":1}}'";
        let heard = std::sync::Mutex::new(Vec::new());
        let told = |one: &MeasuringProgress| {
            heard.lock().expect("no panic").push(one.clone());
            Ok(())
        };
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        let found: serde_json::Value =
            measured_by(command, Path::new("m.onnx"), &told).expect("a result");
        assert_eq!(found["a"], 1);
        let expected = MeasuringProgress {
            what: "m: one at a time".into(),
            left_s: 12.5,
        };
        assert_eq!(*heard.lock().expect("no panic"), [expected]);
        let mut command = Command::new("sh");
        command.args(["-c", &script.replace("echo '{", "exit 3; '{")]);
        let failed = measured_by::<serde_json::Value>(command, Path::new("m.onnx"), &told);
        let failed = failed.expect_err("it ended").to_string();
        assert!(
            failed.contains("died") && failed.contains("odd: words") && !failed.contains("12.5"),
            "{failed}"
        );
    }
}

//! A process of its own for each model that is measured.

use crate::dataset::remove_unfinished;
use crate::error::{Error, Result};
use serde::de::DeserializeOwned;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Exit code of a process whose parent has ended: as if SIGHUP had ended it, in a shell's words.
const ORPHANED: i32 = 128 + 1;

/// What a process has to say that measures `model` and prints its result as JSON. Its standard
/// input stays open for as long as this process lives, and has nothing to read.
///
/// # Errors
/// If it cannot be started, dies, or prints something else; and its own.
pub(crate) fn measured_by<T: DeserializeOwned>(mut command: Command, model: &Path) -> Result<T> {
    let spawned = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = spawned.map_err(|error| Error::io(command.get_program(), error))?;
    // Open until the child has ended, which ends when it is closed.
    let _held = child.stdin.take();
    let output = child
        .wait_with_output()
        .map_err(|error| Error::io(command.get_program(), error))?;
    result_of(model, &output)
}

/// Ends this process when the one that started it has ended, however it did: standard input, which
/// that one keeps open and never writes to, then ends.
///
/// # Errors
/// The system's, if it starts no thread.
pub(crate) fn end_with_parent() -> Result<()> {
    let wait = || {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        remove_unfinished();
        std::process::exit(ORPHANED);
    };
    std::thread::Builder::new()
        .spawn(wait)
        .map(drop)
        .map_err(|error| Error::io("a thread", error))
}

/// What the process that measured a model has to say.
fn result_of<T: DeserializeOwned>(model: &Path, output: &Output) -> Result<T> {
    let words = String::from_utf8_lossy(&output.stderr);
    let words = words.trim();
    if output.status.success() {
        return serde_json::from_slice(&output.stdout).map_err(|error| {
            Error::input(
                model,
                format!("the process that measured it gave no result: {error}; {words}"),
            )
        });
    }
    match (output.status.code(), words.strip_prefix("error: ")) {
        (Some(2), Some(error)) => Err(Error::Usage(error.into())),
        (Some(_), Some(error)) => Err(Error::Failed(error.into())),
        _ => Err(Error::input(
            model,
            format!(
                "the process that measured it died ({}): {}",
                output.status,
                if words.is_empty() {
                    "it left no words"
                } else {
                    words
                }
            ),
        )),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::bench::ModelResult;
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::ExitStatus;

    fn refusal(status: i32, words: &str) -> Error {
        let output = Output {
            status: ExitStatus::from_raw(status),
            stdout: Vec::new(),
            stderr: words.into(),
        };
        result_of::<ModelResult>(Path::new("m.onnx"), &output).expect_err("it failed")
    }

    #[test]
    fn a_process_that_dies_names_its_model_and_one_that_fails_speaks_for_itself() {
        let died = refusal(11, "").to_string();
        assert!(
            died.starts_with("m.onnx: the process that measured it died (signal: 11"),
            "{died}"
        );
        let panicked = refusal(101 << 8, "thread 'main' panicked at x.rs").to_string();
        assert!(
            panicked.contains("died (exit status: 101): thread 'main'"),
            "{panicked}"
        );
        let failed = refusal(1 << 8, "error: m.onnx: too large\n");
        assert_eq!(
            (failed.to_string().as_str(), failed.exit_code()),
            ("m.onnx: too large", 1)
        );
        assert_eq!(refusal(2 << 8, "error: cpus 99: no").exit_code(), 2);
        let silent = refusal(0, "").to_string();
        assert!(silent.contains("gave no result"), "{silent}");
    }
}

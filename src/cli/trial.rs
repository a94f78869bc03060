//! Tries a model in a process of its own, since a runtime can crash on it.

use super::again::{again, is_known};
use super::runtime::RuntimeArgs;
use crate::bench::end_with_parent;
use crate::error::{Error, Result};
use crate::inference::{Model, Runtime, model_memory};
use std::path::PathBuf;
use std::process::{ExitStatus, Stdio};

/// Run a model once on zeros: `edgegait` starts this for models that are not its own
#[derive(Debug, clap::Args)]
pub(super) struct TryModelArgs {
    model: PathBuf,
    #[command(flatten)]
    runtime: RuntimeArgs,
}

/// Runs a model once in a process of its own, unless it is a shipped one. Errors of the runtime are
/// left to the caller, who meets them again.
///
/// # Errors
/// If the process does not survive, or needs more memory than [`model_memory`].
pub(super) fn try_out(model: &Model, runtime: &Runtime) -> Result<()> {
    if !model.is_file() || !is_known() {
        return Ok(());
    }
    let mut command = again()?;
    command.arg("try-model").arg(model.path());
    if let Some(library) = runtime.library() {
        command.args(["--runtime", "ort", "--ort-lib"]).arg(library);
        command.args(["--provider", &runtime.name().provider]);
    }
    // The child ends with this process, at the end of its standard input.
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|source| Error::io("this program", source))?;
    let input = child.stdin.take();
    let output = child.wait_with_output();
    drop(input);
    let output = output.map_err(|source| Error::io(model.path(), source))?;
    if matches!(output.status.code(), Some(0..=2)) {
        return Ok(());
    }
    let words = String::from_utf8_lossy(&output.stderr);
    let said = words.lines().filter(|line| !line.trim().is_empty());
    // The place of a panic, and its message.
    let said: Vec<&str> = said.take(2).collect();
    let problem = format!(
        "{} ends the process that runs this model ({}{}); it may have at most {} MB, or EDGEGAIT_MODEL_MB",
        runtime.name(),
        how(output.status),
        if said.is_empty() {
            String::new()
        } else {
            format!(": {}", said.join(" "))
        },
        model_memory()? >> 20,
    );
    Err(Error::input(model.path(), problem))
}

#[cfg(unix)]
fn how(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt as _;
    let signal = status.signal().map(|signal| format!("signal {signal}"));
    signal.unwrap_or_else(|| status.to_string())
}

#[cfg(not(unix))]
fn how(status: ExitStatus) -> String {
    status.to_string()
}

/// Runs the subcommand.
pub(super) fn run(args: &TryModelArgs) -> Result<()> {
    end_with_parent()?;
    let model = Model::open(&args.model)?;
    let runtime = args.runtime.runtime()?;
    limit_memory(model_memory()?)?;
    let contract = model.contract();
    let shape = contract.input_shape(1, contract.frames.unwrap_or(1));
    let numbers = shape.iter().product::<usize>() + contract.view_numbers();
    runtime.load(&model)?.run(&vec![0.0; numbers], 1).map(drop)
}

/// Bounds the memory that this process may have, where the system can.
#[cfg(target_os = "linux")]
fn limit_memory(bytes: u64) -> Result<()> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let limit = Rlimit {
        current: Some(bytes),
        maximum: Some(bytes),
    };
    setrlimit(Resource::Data, limit).map_err(|error| Error::io("this process", error.into()))
}

#[cfg(not(target_os = "linux"))]
#[expect(clippy::unnecessary_wraps, reason = "the same on all systems")]
fn limit_memory(_: u64) -> Result<()> {
    Ok(())
}

//! Starts this program in a process of its own.

use crate::error::{Error, Result};
use std::ffi::OsString;
use std::process::Command;
use std::sync::OnceLock;

/// The program and first words that start it.
static PROGRAM: OnceLock<Vec<OsString>> = OnceLock::new();

/// States how this program is started. The first statement of a process counts.
pub(super) fn set_program(words: Vec<OsString>) {
    if !words.is_empty() {
        PROGRAM.get_or_init(|| words);
    }
}

/// Returns whether the way to start this program is known.
pub(super) fn is_known() -> bool {
    PROGRAM.get().is_some()
}

/// Returns a command that starts this program in a process of its own.
///
/// # Errors
/// If its path is unknown.
pub(super) fn again() -> Result<Command> {
    let Some([program, first @ ..]) = PROGRAM.get().map(Vec::as_slice) else {
        let none = std::io::Error::other("its path is unknown");
        return Err(Error::io("this program", none));
    };
    let mut command = Command::new(program);
    command.args(first);
    Ok(command)
}

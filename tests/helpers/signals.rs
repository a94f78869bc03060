//! Ending the built command with a signal.

#[cfg(target_os = "linux")]
use std::process::Command;

/// Returns the command as a terminal starts it, even if this test was started to ignore signals.
#[cfg(target_os = "linux")]
pub fn heeding_signals() -> Command {
    let mut command = Command::new("env");
    command.args([
        "--default-signal=INT,TERM,HUP",
        env!("CARGO_BIN_EXE_edgegait"),
    ]);
    command
}

//! Ending the built command by a signal.

#[cfg(target_os = "linux")]
use std::process::Command;

/// The command as a terminal starts it, though this test may have been started to ignore signals.
#[cfg(target_os = "linux")]
pub fn heeding_signals() -> Command {
    let mut command = Command::new("env");
    command.args([
        "--default-signal=INT,TERM,HUP",
        env!("CARGO_BIN_EXE_edgegait"),
    ]);
    command
}

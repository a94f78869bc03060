//! Handles the signals by which the user, or the system, ends the command early.

use crate::dataset::unfinished_work;
use crate::error::{Error, Result, visible_name};
use crate::files::remove_unfinished;

/// Makes SIGINT, SIGTERM and SIGHUP remove unfinished files, unless the work can be resumed, and
/// end the process with the exit code 128 plus the signal's number, like shells. Finished results
/// stay. Signals that the process was started to ignore (`nohup`, a script's background) stay
/// ignored.
///
/// # Errors
/// If the system accepts no handler.
#[cfg(unix)]
pub(super) fn listen() -> Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let failed =
        |error: std::io::Error| Error::Failed(format!("cannot listen for interruptions: {error}"));
    // Where the system does not report it, SIGHUP may be ignored.
    let ignored = ignored().unwrap_or(1 << (SIGHUP - 1));
    let heard = [SIGINT, SIGTERM, SIGHUP].into_iter();
    let heard = heard.filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let mut signals = signal_hook::iterator::Signals::new(heard).map_err(failed)?;
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            remove_unfinished();
            tell_unfinished();
            std::process::exit(128 + signal);
        }
    };
    let started = std::thread::Builder::new().spawn(wait);
    started.map(drop).map_err(Error::Threads)
}

/// Prints where unfinished work can be resumed, when a process ends early.
pub(super) fn tell_unfinished() {
    for folder in unfinished_work() {
        eprintln!(
            "{} keeps the finished part: continue with --resume",
            visible_name(&folder.to_string_lossy())
        );
    }
}

/// Does nothing: on other systems, an interrupted process leaves its hidden folders behind.
///
/// # Errors
/// Never.
#[cfg(not(unix))]
pub fn listen() -> Result<()> {
    Ok(())
}

/// Returns the signals that the process was started to ignore, the first in the lowest bit; none if
/// the system does not report them.
#[cfg(unix)]
fn ignored() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| {
        let digits = line.strip_prefix("SigIgn:")?.trim();
        u64::from_str_radix(digits, 16).ok()
    })
}

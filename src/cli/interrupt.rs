//! What happens when the user, or the system, ends the command before its work is done.

use crate::dataset::unfinished_work;
use crate::error::{Error, Result};
use crate::files::remove_unfinished;

/// From now on, SIGINT, SIGTERM and SIGHUP remove what is half-made, unless it can be gone on with, and end the process, with 128
/// and the signal's number as shells have it. Results that have their names already stay. Signals
/// that the process was started to ignore (`nohup`, a script's background) stay ignored.
///
/// # Errors
/// The system's, if it takes no handler.
#[cfg(unix)]
pub(super) fn listen() -> Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let failed =
        |error: std::io::Error| Error::Failed(format!("cannot listen for interruptions: {error}"));
    // Where the system does not tell, SIGHUP may be ignored.
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
    started.map(drop).map_err(failed)
}

/// Says where work waits to be gone on with, for a process that ends before its work is done.
pub(super) fn tell_unfinished() {
    for folder in unfinished_work() {
        eprintln!(
            "{} keeps what is done: go on with --resume",
            folder.display()
        );
    }
}

/// Elsewhere a process that is interrupted leaves its hidden folders behind.
///
/// # Errors
/// Never.
#[cfg(not(unix))]
pub fn listen() -> Result<()> {
    Ok(())
}

/// The signals that the process was started to ignore, the first in the lowest bit; none where the
/// system does not tell.
#[cfg(unix)]
fn ignored() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| {
        let digits = line.strip_prefix("SigIgn:")?.trim();
        u64::from_str_radix(digits, 16).ok()
    })
}

//! What happens when the user, or the system, ends the command before its work is done.

use crate::dataset::remove_unfinished;
use crate::error::{Error, Result};

/// Exit code of a process whose parent has ended: as if SIGHUP had ended it, in a shell's words.
const ORPHANED: i32 = 128 + 1;

/// From now on, SIGINT, SIGTERM and SIGHUP remove what is half-made and end the process, with 128
/// and the signal's number as shells have it. Results that have their names already stay. Signals
/// that the process was started to ignore (`nohup`, a script's background) stay ignored.
///
/// # Errors
/// The system's, if it takes no handler.
#[cfg(unix)]
pub fn listen() -> Result<()> {
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
            std::process::exit(128 + signal);
        }
    };
    let started = std::thread::Builder::new().spawn(wait);
    started.map(drop).map_err(failed)
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

/// Ends this process when the one that started it has ended, however it did: standard input, which
/// that one keeps open and never writes to, then ends.
///
/// # Errors
/// The system's, if it starts no thread.
pub fn end_with_parent() -> Result<()> {
    let wait = || {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        remove_unfinished();
        std::process::exit(ORPHANED);
    };
    std::thread::Builder::new()
        .spawn(wait)
        .map(drop)
        .map_err(|error| Error::Failed(format!("cannot start threads: {error}")))
}

//! What happens when the user, or the system, ends the command before its work is done.

use crate::dataset::remove_unfinished;
use crate::error::{Error, Result};

/// Exit code of a process that was interrupted: 128 and the number of SIGINT, as shells have it.
const INTERRUPTED: i32 = 130;

/// From now on, SIGINT, SIGTERM and SIGHUP remove what is half-made and end the process. Results
/// that have their names already stay.
///
/// # Errors
/// The system's, if it takes no handler.
pub fn listen() -> Result<()> {
    ctrlc::set_handler(|| {
        remove_unfinished();
        std::process::exit(INTERRUPTED);
    })
    .map_err(|error| Error::Failed(format!("cannot listen for interruptions: {error}")))
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
        std::process::exit(INTERRUPTED);
    };
    std::thread::Builder::new()
        .spawn(wait)
        .map(drop)
        .map_err(|error| Error::Failed(format!("cannot start threads: {error}")))
}

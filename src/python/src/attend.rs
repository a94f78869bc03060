//! Long work beside an interpreter that stays responsive: signals are seen while threads work.

use crate::errors::exception;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often signals are looked for: nobody notices, and it costs nothing.
pub(crate) const LOOK: Duration = Duration::from_millis(50);

/// Whether work is to end.
#[derive(Default)]
pub(crate) struct Stop(AtomicBool);

impl Stop {
    /// An error if so.
    pub(crate) fn check(&self) -> edgegait::Result<()> {
        if self.0.load(Ordering::Relaxed) {
            return Err(edgegait::Error::Failed("interrupted".into()));
        }
        Ok(())
    }
}

/// Does `work` on so many threads (all cores if 0), without the lock of the interpreter, while this
/// thread looks for signals; where one raises an exception, the work is stopped.
pub(crate) fn attended<R: Send>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(&Stop) -> R + Send,
) -> PyResult<R> {
    py.detach(|| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| exception(&error.into()))?;
        let (stop, (sender, receiver)) = (Stop::default(), channel());
        pool.in_place_scope(|scope| {
            scope.spawn(|_| {
                // Somebody waits for it.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(&stop))));
            });
            let mut interrupted = None;
            loop {
                match receiver.recv_timeout(LOOK) {
                    Ok(Ok(done)) => return interrupted.map_or(Ok(done), Err),
                    Ok(Err(panic)) => resume_unwind(panic),
                    Err(RecvTimeoutError::Timeout) if interrupted.is_none() => {
                        interrupted = Python::attach(|py| py.check_signals()).err();
                        stop.0.store(interrupted.is_some(), Ordering::Relaxed);
                    }
                    Err(_) => {}
                }
            }
        })
    })
}

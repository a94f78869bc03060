//! Long work beside an interpreter that stays responsive: signals are seen while threads work.

use crate::errors::exception;
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often signals are looked for: nobody notices, and it costs nothing.
pub(crate) const LOOK: Duration = Duration::from_millis(50);

/// The exception that a signal raises, if one came.
pub(crate) fn raised() -> Option<PyErr> {
    Python::attach(|py| py.check_signals().err())
}

/// Whether work is to end.
#[derive(Default)]
pub(crate) struct StopFlag(AtomicBool);

impl StopFlag {
    /// An error if so.
    pub(crate) fn check(&self) -> edgegait::Result<()> {
        if self.0.load(Ordering::Relaxed) {
            return Err(edgegait::Error::Failed("interrupted".into()));
        }
        Ok(())
    }
}

/// Threads that draw, kept from one call to the next: to start them anew costs as much as some GEIs.
struct DrawingThreads {
    /// The process that has them: those of another one stayed behind when this one forked off.
    process: u32,
    asked: usize,
    pool: Arc<ThreadPool>,
}

/// Locked only by who holds the lock of the interpreter, as who forks does, and for no work: in a
/// process that forked off nobody holds it.
static KEPT: Mutex<Option<DrawingThreads>> = Mutex::new(None);

/// So many threads (as many as cores if 0).
fn pool(_: Python<'_>, asked: usize) -> PyResult<Arc<ThreadPool>> {
    let process = std::process::id();
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    match &*kept {
        Some(kept) if (kept.process, kept.asked) == (process, asked) => {
            return Ok(Arc::clone(&kept.pool));
        }
        _ => {}
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(asked).build();
    let pool = Arc::new(pool.map_err(|error| exception(&error.into()))?);
    let former = kept.replace(DrawingThreads {
        process,
        asked,
        pool: Arc::clone(&pool),
    });
    // Nobody can tell threads to end that are not there.
    if let Some(former) = former.filter(|former| former.process != process) {
        std::mem::forget(former.pool);
    }
    Ok(pool)
}

/// Does `work` on so many threads (all cores if 0), without the lock of the interpreter, while this
/// thread looks for signals; where one raises an exception, the work is stopped.
pub(crate) fn attended<R: Send>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(&StopFlag) -> R + Send,
) -> PyResult<R> {
    let pool = pool(py, threads)?;
    py.detach(|| {
        let (stop, (sender, receiver)) = (StopFlag::default(), channel());
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
                        interrupted = raised();
                        stop.0.store(interrupted.is_some(), Ordering::Relaxed);
                    }
                    Err(_) => {}
                }
            }
        })
    })
}

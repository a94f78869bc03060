//! Long work that keeps the interpreter responsive: signals are handled while threads work.

use crate::errors::exception;
use edgegait::cli::embed::Stop;
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Interval between checks for signals: unnoticeable, at no measurable cost.
pub(crate) const LOOK: Duration = Duration::from_millis(50);

/// Returns the exception that a signal raises, if one arrived.
pub(crate) fn raised() -> Option<PyErr> {
    Python::attach(|py| py.check_signals().err())
}

/// Threads that draw, kept between calls: starting them costs as much as drawing a few GEIs.
struct DrawingThreads {
    /// The process that owns the threads: a forked process does not inherit them.
    process: u32,
    asked: usize,
    pool: Arc<ThreadPool>,
}

/// The kept threads. The lock is taken only under the interpreter's lock, which a forking thread
/// holds too, and never for long work, so that it is free in a forked process.
static KEPT: Mutex<Option<DrawingThreads>> = Mutex::new(None);

/// Returns the requested number of threads (one per core if 0).
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
    // Threads that do not exist in this process cannot be ended.
    if let Some(former) = former.filter(|former| former.process != process) {
        std::mem::forget(former.pool);
    }
    Ok(pool)
}

/// Returns the number of threads that work on what asks for this number (all cores if 0).
pub(crate) fn thread_count(py: Python<'_>, asked: usize) -> PyResult<usize> {
    Ok(pool(py, asked)?.current_num_threads())
}

/// Does `work` on this number of threads (all cores if 0), without the interpreter's lock, while
/// this thread checks for signals. If a signal raises an exception, the work is stopped.
pub(crate) fn attended<R: Send>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(&Stop) -> R + Send,
) -> PyResult<R> {
    let pool = pool(py, threads)?;
    py.detach(|| {
        let (stop, (sender, receiver)) = (Stop::default(), channel());
        pool.in_place_scope(|scope| {
            scope.spawn(|_| {
                // The receiver waits for it.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(&stop))));
            });
            let mut interrupted = None;
            loop {
                match receiver.recv_timeout(LOOK) {
                    Ok(Ok(done)) => return interrupted.map_or(Ok(done), Err),
                    Ok(Err(panic)) => resume_unwind(panic),
                    Err(RecvTimeoutError::Timeout) if interrupted.is_none() => {
                        interrupted = raised();
                        if interrupted.is_some() {
                            stop.end();
                        }
                    }
                    Err(_) => {}
                }
            }
        })
    })
}

//! Ending a command's work before it is done.

use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ends work at its next progress step, with [`Error::Cancelled`], so that unfinished files are
/// removed, or kept to be resumed.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Ends the work.
    pub fn end(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Checks whether the work may go on.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if it is to end.
    pub fn check(&self) -> Result<()> {
        if self.0.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        Ok(())
    }
}

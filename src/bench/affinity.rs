//! The processors that may be used.

use super::board::CpuList;
use crate::error::{Result, SettingError};

/// Restricts this thread, and all threads and processes that it starts, to these processors.
///
/// # Errors
/// If there is no such processor, or the system refuses.
#[cfg(target_os = "linux")]
pub(crate) fn pin(cpus: &CpuList) -> Result<()> {
    use rustix::thread::{CpuSet, sched_setaffinity};
    let mut set = CpuSet::new();
    for &cpu in cpus.numbers() {
        if cpu >= CpuSet::MAX_CPU {
            return Err(refused(
                cpus,
                format!("expected processors below {}", CpuSet::MAX_CPU),
            ));
        }
        set.set(cpu);
    }
    sched_setaffinity(None, &set)
        .map_err(|error| refused(cpus, format!("{error} (are these processors there?)")))
}

/// Returns an error, as only Linux is supported.
///
/// # Errors
/// Always.
#[cfg(not(target_os = "linux"))]
pub fn pin(cpus: &CpuList) -> Result<()> {
    let found = std::env::consts::OS;
    Err(refused(
        cpus,
        format!("expected Linux, found {found} (choose none)"),
    ))
}

fn refused(cpus: &CpuList, cause: String) -> crate::error::Error {
    SettingError::Processors(cause.into()).refuses("cpus", cpus)
}

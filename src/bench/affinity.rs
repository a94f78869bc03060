//! Which processors may be used.

use super::board::CpuList;
use crate::error::{Error, Result};

/// Lets this thread, and all threads and processes that it starts, use these processors only.
///
/// # Errors
/// If there is no such processor, or the system has no way to do it.
#[cfg(target_os = "linux")]
pub fn pin(cpus: &CpuList) -> Result<()> {
    use rustix::thread::{CpuSet, sched_setaffinity};
    let mut set = CpuSet::new();
    for &cpu in cpus.numbers() {
        if cpu >= CpuSet::MAX_CPU {
            return Err(Error::Usage(format!(
                "--cpus {cpus}: expected processors below {}",
                CpuSet::MAX_CPU
            )));
        }
        set.set(cpu);
    }
    sched_setaffinity(None, &set).map_err(|error| {
        Error::Usage(format!(
            "--cpus {cpus}: {error} (are these processors there?)"
        ))
    })
}

/// Refuses: only Linux is asked.
///
/// # Errors
/// Always.
#[cfg(not(target_os = "linux"))]
pub fn pin(cpus: &CpuList) -> Result<()> {
    Err(Error::Usage(format!(
        "--cpus {cpus}: expected Linux, found {} (leave the flag out)",
        std::env::consts::OS
    )))
}

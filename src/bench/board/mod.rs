//! A description of the machine.
//!
//! Everything is read from the files of Linux below a root folder, so that tests can provide their
//! own machines. What a machine does not expose is absent, never zero.

mod cpus;
mod load;
mod state;
mod tree;

pub(crate) use cpus::{CpuGroup, CpuList};
pub(crate) use load::{LOAD_WARNED_OF, LoadWatch, load_of_others};
pub(crate) use state::{Clock, MachineState, warnings};

use serde::{Deserialize, Serialize};
pub(super) use tree::SystemFiles;

/// The properties of a machine that do not change while it runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Board {
    /// The machine's name, from the device tree or else the firmware (DMI).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// The system on chip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub soc: Option<String>,
    /// The architecture that this program was built for, such as `aarch64`.
    pub architecture: String,
    /// The processors, in groups of equal ones.
    pub cpus: Vec<CpuGroup>,
    /// The processors that this process may use.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub affinity: Option<CpuList>,
    /// The instruction sets that matter to inference.
    pub features: Vec<String>,
    /// The memory of the machine, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ram_bytes: Option<u64>,
    /// The version of the kernel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<String>,
    /// The C library that this program was built for, such as `gnu`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub libc: Option<String>,
}

impl Board {
    /// Reads the machine whose files are below `root`, usually `/`.
    #[must_use]
    pub(crate) fn read(root: &std::path::Path) -> Self {
        let files = SystemFiles::new(root);
        let cpuinfo = files.text("proc/cpuinfo").unwrap_or_default();
        let libc = if cfg!(target_env = "gnu") {
            Some("gnu")
        } else if cfg!(target_env = "musl") {
            Some("musl")
        } else {
            None
        };
        Self {
            model: model(&files),
            soc: soc(&files),
            architecture: std::env::consts::ARCH.into(),
            cpus: cpus::groups(&files, &cpuinfo),
            affinity: files
                .field("proc/self/status", "Cpus_allowed_list:")
                .and_then(|list| CpuList::parse(&list)),
            features: cpus::features(&cpuinfo),
            ram_bytes: files.field("proc/meminfo", "MemTotal:").and_then(|text| {
                let kib: u64 = text.strip_suffix("kB")?.trim().parse().ok()?;
                kib.checked_mul(1024)
            }),
            kernel: files.text("proc/sys/kernel/osrelease"),
            libc: libc.map(Into::into),
        }
    }
}

fn model(files: &SystemFiles) -> Option<String> {
    files.text("proc/device-tree/model").or_else(|| {
        let name = files.text("sys/class/dmi/id/product_name")?;
        Some(match files.text("sys/class/dmi/id/sys_vendor") {
            Some(vendor) if !name.starts_with(&vendor) => format!("{vendor} {name}"),
            _ => name,
        })
    })
}

/// Returns the chip's name from `sysfs-devices-soc` (`Documentation/ABI/testing`), or else the last
/// name of the device tree's `compatible`, which lists the board first and the chip last.
fn soc(files: &SystemFiles) -> Option<String> {
    let parts = ["family", "soc_id"].map(|name| files.text(format!("sys/devices/soc0/{name}")));
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if !parts.is_empty() {
        return Some(parts.join(" "));
    }
    let compatible = files.raw_text("proc/device-tree/compatible")?;
    let mut names = compatible.rsplit('\0');
    names.find(|name| !name.is_empty()).map(Into::into)
}

#[cfg(test)]
pub(super) mod tests;

//! Which machine this is, as far as it tells.
//!
//! Everything is read from files of Linux below a root, so that tests have machines of their
//! own. What a machine does not expose is absent, never zero.

mod cpus;
mod load;
mod state;
mod tree;

pub(crate) use cpus::{CpuGroup, CpuList};
pub(crate) use load::{LOAD_WARNED_OF, LoadWatch, load_of_others};
pub(crate) use state::{Clock, MachineState, warnings};

use serde::{Deserialize, Serialize};
pub(super) use tree::SystemFiles;

/// What does not change while a machine runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Board {
    /// Its name, by the device tree or else by the firmware (DMI).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Its system on chip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub soc: Option<String>,
    /// Architecture that this program was built for, such as `aarch64`.
    pub architecture: String,
    /// Its processors, those that are alike together.
    pub cpus: Vec<CpuGroup>,
    /// Processors that this process may use.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub affinity: Option<CpuList>,
    /// Instruction sets that matter to inference.
    pub features: Vec<String>,
    /// Memory of the machine, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ram_bytes: Option<u64>,
    /// Version of the kernel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<String>,
    /// C library that this program was built for, such as `gnu`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub libc: Option<String>,
}

impl Board {
    /// Reads the machine whose files are below `root`, `/` as a rule.
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

/// What `Documentation/ABI/testing/sysfs-devices-soc` describes, or else the last name of the
/// device tree's `compatible`, from the board's to the chip's.
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

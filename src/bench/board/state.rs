//! The changing state of a machine: clocks, temperature, throttling.

use super::cpus::CpuList;
use super::tree::SystemFiles;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The state of a machine at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct MachineState {
    /// The clocks of the processors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clocks: Vec<Clock>,
    /// The temperature of the hottest zone, degrees Celsius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// The `get_throttled` bits of a Raspberry Pi's firmware: 0 to 3 for the present, 16 to 19 for
    /// the time since start (under-voltage, frequency capped, throttled, soft limit).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub throttled: Option<u32>,
    /// The number of times that cores of an x86 processor have been throttled since start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub throttle_count: Option<u64>,
}

/// A clock that processors share (a policy of `cpufreq`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Clock {
    /// The processors of this clock.
    pub cpus: CpuList,
    /// The governor that chooses the frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub governor: Option<String>,
    /// The lowest allowed frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_khz: Option<u64>,
    /// The current frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current_khz: Option<u64>,
    /// The highest allowed frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_khz: Option<u64>,
}

impl MachineState {
    /// Reads the machine whose files are below `root`.
    #[must_use]
    pub(crate) fn read(root: &Path) -> Self {
        let files = SystemFiles::new(root);
        let policies = files.entries("sys/devices/system/cpu/cpufreq", "policy");
        let clocks = policies.iter().filter_map(|policy| {
            Some(Clock {
                cpus: CpuList::parse(&files.text(policy.join("affected_cpus"))?)?,
                governor: files.text(policy.join("scaling_governor")),
                min_khz: files.number(policy.join("scaling_min_freq")),
                current_khz: files.number(policy.join("scaling_cur_freq")),
                max_khz: files.number(policy.join("scaling_max_freq")),
            })
        });
        let zones = files.entries("sys/class/thermal", "thermal_zone");
        let temperatures = zones.iter().filter_map(|zone| {
            let millidegrees: f64 = files.number(zone.join("temp"))?;
            // Zones that are switched off read as -274000 or as 0.
            Some(millidegrees * 1e-3).filter(|celsius| (1.0..200.0).contains(celsius))
        });
        let counts = files.entries("sys/devices/system/cpu", "cpu").into_iter();
        let counts = counts.filter_map(|cpu| {
            files.number::<u64>(cpu.join("thermal_throttle/core_throttle_count"))
        });
        Self {
            clocks: clocks.collect(),
            temperature_c: temperatures.max_by(f64::total_cmp),
            throttled: raspberry_pi(&files),
            throttle_count: counts.reduce(u64::saturating_add),
        }
    }
}

/// Reads `get_throttled`; the firmware's node is named after its bus, which differs between models.
fn raspberry_pi(files: &SystemFiles) -> Option<u32> {
    let mut nodes = files.entries("sys/devices/platform", "soc");
    for bus in nodes.clone() {
        nodes.extend(files.entries(bus, "soc"));
    }
    let text = nodes
        .iter()
        .find_map(|node| files.text(node.join("get_throttled")))?;
    u32::from_str_radix(text.trim_start_matches("0x"), 16).ok()
}

/// Returns warnings from the states before, between and after the measurements. Frequencies are
/// those of `cpus`, or of all processors if `cpus` is unknown.
#[must_use]
pub(crate) fn warnings(states: &[MachineState], cpus: Option<&CpuList>) -> Vec<String> {
    let (Some(first), Some(last)) = (states.first(), states.last()) else {
        return Vec::new();
    };
    let mut warnings = Vec::new();
    const NOW: [&str; 4] = [
        "under-voltage",
        "a capped frequency",
        "throttling",
        "its soft temperature limit",
    ];
    let was = first.throttled.unwrap_or(0);
    for (bit, what) in NOW.iter().enumerate() {
        let is_on = |state: &MachineState| state.throttled.is_some_and(|bits| bits >> bit & 1 == 1);
        let is_new = last
            .throttled
            .is_some_and(|bits| (bits & !was) >> (16 + bit) & 1 == 1);
        if states.iter().any(is_on) || is_new {
            warnings.push(format!(
                "the firmware reported {what} while this was measured"
            ));
        }
    }
    if let (Some(before), Some(after)) = (first.throttle_count, last.throttle_count)
        && after > before
    {
        warnings.push(format!(
            "cores were throttled {} times while this was measured",
            after - before
        ));
    }
    // Skip the state before any work, as a governor may have slowed an idle processor.
    let mut highest = 0;
    let mut lowest_share = (1, 1);
    for state in states.iter().skip(1) {
        let used = state
            .clocks
            .iter()
            .filter(|clock| cpus.is_none_or(|cpus| clock.cpus.meets(cpus)));
        let Some(khz) = used.filter_map(|clock| clock.current_khz).max() else {
            continue;
        };
        highest = highest.max(khz);
        if khz.saturating_mul(lowest_share.1) < highest.saturating_mul(lowest_share.0) {
            lowest_share = (khz, highest);
        }
    }
    let (low, high) = lowest_share;
    // By more than 5 %.
    if low.saturating_mul(20) < high.saturating_mul(19) {
        warnings.push(format!(
            "the processors' frequency dropped by {:.0} % while this was measured",
            100.0 - 100.0 * low as f64 / high as f64
        ));
    }
    warnings
}

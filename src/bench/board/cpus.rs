//! The processors: names, groups of equal ones, and instruction sets.

use super::tree::SystemFiles;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// A list of processor numbers, ascending and unique; as text in the format of Linux: `0-3,6`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct CpuList(Vec<usize>);

impl CpuList {
    /// Parses `0-3,6` or `0 1 2 3 6`; none if the text is neither, or is empty.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let mut numbers = Vec::new();
        let parts = text.split(|c: char| c == ',' || c.is_whitespace());
        for part in parts.filter(|part| !part.is_empty()) {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let (first, last): (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
            if last.checked_sub(first)? >= 1 << 16 {
                return None;
            }
            numbers.extend(first..=last);
        }
        numbers.sort_unstable();
        numbers.dedup();
        (!numbers.is_empty()).then_some(Self(numbers))
    }

    /// Returns the numbers.
    #[must_use]
    pub fn numbers(&self) -> &[usize] {
        &self.0
    }

    /// Returns whether the lists have a processor in common.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        self.0.iter().any(|cpu| other.0.contains(cpu))
    }
}

impl fmt::Display for CpuList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let runs = self.0.chunk_by(|a, b| a + 1 == *b).map(|run| match *run {
            [first, .., last] => format!("{first}-{last}"),
            _ => run[0].to_string(),
        });
        f.write_str(&runs.collect::<Vec<_>>().join(","))
    }
}

impl From<CpuList> for String {
    fn from(list: CpuList) -> Self {
        list.to_string()
    }
}

impl TryFrom<String> for CpuList {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Self::parse(&text).ok_or_else(|| format!("expected processors as in 0-3,6, found {text:?}"))
    }
}

/// A group of equal processors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CpuGroup {
    /// The processors of the group.
    pub cpus: CpuList,
    /// The name of the processors, such as `Cortex-A72`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The implementer and part of an ARM processor (`0x41/0xd08`); family and model of others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The relative speed of one processor, 1024 for the machine's fastest (`cpu_capacity`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capacity: Option<u64>,
    /// The highest frequency.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_khz: Option<u64>,
}

/// Part numbers of ARM's processors (implementer 0x41), from Linux 6.12,
/// `arch/arm64/include/asm/cputype.h` and `arch/arm/include/asm/cputype.h`.
const ARM_PARTS: [(u32, &str); 24] = [
    (0xC07, "Cortex-A7"),
    (0xC09, "Cortex-A9"),
    (0xC0F, "Cortex-A15"),
    (0xD03, "Cortex-A53"),
    (0xD04, "Cortex-A35"),
    (0xD05, "Cortex-A55"),
    (0xD07, "Cortex-A57"),
    (0xD08, "Cortex-A72"),
    (0xD09, "Cortex-A73"),
    (0xD0A, "Cortex-A75"),
    (0xD0B, "Cortex-A76"),
    (0xD0C, "Neoverse-N1"),
    (0xD0D, "Cortex-A77"),
    (0xD40, "Neoverse-V1"),
    (0xD41, "Cortex-A78"),
    (0xD42, "Cortex-A78AE"),
    (0xD44, "Cortex-X1"),
    (0xD46, "Cortex-A510"),
    (0xD47, "Cortex-A710"),
    (0xD48, "Cortex-X2"),
    (0xD49, "Neoverse-N2"),
    (0xD4D, "Cortex-A715"),
    (0xD4E, "Cortex-X3"),
    (0xD4F, "Neoverse-V2"),
];

/// Returns the processors of `/proc/cpuinfo`, or else those with a folder, in groups.
pub(super) fn groups(files: &SystemFiles, cpuinfo: &str) -> Vec<CpuGroup> {
    let mut described: BTreeMap<usize, (Option<String>, Option<String>)> = BTreeMap::new();
    for block in cpuinfo.split("\n\n") {
        if let Some(Ok(cpu)) = field(block, "processor").map(str::parse) {
            described.insert(cpu, (name(block), part(block)));
        }
    }
    if described.is_empty() {
        let folders = files.entries("sys/devices/system/cpu", "cpu");
        let numbers = folders.iter().filter_map(|path| {
            let name = path.file_name()?.to_str()?;
            name.strip_prefix("cpu")?.parse().ok()
        });
        described.extend(numbers.map(|cpu| (cpu, (None, None))));
    }
    let mut groups: Vec<CpuGroup> = Vec::new();
    for (cpu, (name, part)) in described {
        let folder = format!("sys/devices/system/cpu/cpu{cpu}");
        let one = CpuGroup {
            cpus: CpuList(vec![cpu]),
            name,
            part,
            capacity: files.number(format!("{folder}/cpu_capacity")),
            max_khz: files.number(format!("{folder}/cpufreq/cpuinfo_max_freq")),
        };
        let is_alike = |group: &&mut CpuGroup| {
            CpuGroup {
                cpus: one.cpus.clone(),
                ..(**group).clone()
            } == one
        };
        match groups.iter_mut().find(is_alike) {
            Some(group) => group.cpus.0.push(cpu),
            None => groups.push(one),
        }
    }
    groups
}

fn field<'a>(block: &'a str, name: &str) -> Option<&'a str> {
    block.lines().find_map(|line| {
        let (found, value) = line.split_once(':')?;
        (found.trim() == name).then(|| value.trim())
    })
}

fn name(block: &str) -> Option<String> {
    if let Some((implementer, part)) = arm_ids(block) {
        let known = ARM_PARTS.iter().find(|(known, _)| *known == part);
        return known
            .filter(|_| implementer == 0x41)
            .map(|(_, name)| (*name).to_owned());
    }
    field(block, "model name").map(Into::into)
}

fn part(block: &str) -> Option<String> {
    if let Some((implementer, part)) = arm_ids(block) {
        return Some(format!("{implementer:#04x}/{part:#05x}"));
    }
    Some(format!(
        "family {} model {}",
        field(block, "cpu family")?,
        field(block, "model")?
    ))
}

fn arm_ids(block: &str) -> Option<(u32, u32)> {
    let hexadecimal = |name| u32::from_str_radix(field(block, name)?.strip_prefix("0x")?, 16).ok();
    Some((hexadecimal("CPU implementer")?, hexadecimal("CPU part")?))
}

/// The instruction sets that determine the choice of inference kernels, by their names in
/// `/proc/cpuinfo`.
const MATTERING: [&str; 19] = [
    "neon",
    "asimd",
    "asimdhp",
    "asimddp",
    "i8mm",
    "bf16",
    "sve",
    "sve2",
    "svei8mm",
    "sme",
    "sse4_2",
    "avx",
    "avx2",
    "avx_vnni",
    "avx512f",
    "avx512_vnni",
    "avx512_bf16",
    "amx_int8",
    "amx_bf16",
];

/// Returns the instruction sets of the first processor that matter to inference.
pub(super) fn features(cpuinfo: &str) -> Vec<String> {
    let found = field(cpuinfo, "Features").or_else(|| field(cpuinfo, "flags"));
    let found: Vec<&str> = found.unwrap_or_default().split_whitespace().collect();
    let kept = MATTERING.iter().filter(|feature| found.contains(feature));
    kept.map(|feature| (*feature).to_owned()).collect()
}

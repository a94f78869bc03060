//! What a limit needs of the machine that runs the gate.

use edgegait_core::raster::Simd;
use serde::Deserialize;
use std::fmt;
use std::thread::available_parallelism;

/// A requirement; without it, the limit is skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum MachineNeed {
    /// A processor with AVX2.
    Avx2,
    /// A processor with AVX-512 that moves bytes (VBMI, VBMI2).
    Avx512f,
    /// An ARM processor with NEON.
    Neon,
    /// ONNX Runtime; `EDGEGAIT_ORT_LIB` names its library.
    Ort,
    /// Two threads at the same time, without other work.
    TwoThreads,
}

impl MachineNeed {
    /// Returns whether this machine meets the requirement. `is_busy` states that other work ran
    /// during the measurement.
    pub(super) fn is_met(self, is_busy: bool) -> bool {
        let has = |name| Simd::available().any(|simd| simd.name() == name);
        match self {
            Self::Avx2 => has("avx2"),
            Self::Avx512f => has("avx512"),
            Self::Neon => has("neon"),
            Self::Ort => std::env::var_os("EDGEGAIT_ORT_LIB").is_some(),
            Self::TwoThreads => {
                !is_busy && available_parallelism().is_ok_and(|threads| threads.get() >= 2)
            }
        }
    }
}

impl fmt::Display for MachineNeed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Avx2 => "AVX2",
            Self::Avx512f => "AVX-512 with VBMI",
            Self::Neon => "NEON",
            Self::Ort => "ONNX Runtime",
            Self::TwoThreads => "idle second thread",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_processor_with_avx_512_has_avx2() {
        assert!(MachineNeed::Avx2.is_met(false) || !MachineNeed::Avx512f.is_met(false));
    }

    #[test]
    fn a_busy_machine_has_no_idle_second_thread() {
        assert!(!MachineNeed::TwoThreads.is_met(true));
    }
}

//! Requirements of gates on the machine.

use edgegait_core::raster::Simd;
use serde::Deserialize;
use std::fmt;
use std::thread::available_parallelism;

/// A requirement; without it, a gate is skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Need {
    /// A processor with AVX2.
    Avx2,
    /// A processor with the parts of AVX-512 that bit rows use.
    Avx512f,
    /// An ARM processor with NEON.
    Neon,
    /// ONNX Runtime; `EDGEGAIT_ORT_LIB` names its library.
    Ort,
    /// Two threads at the same time, without other work.
    TwoThreads,
}

impl Need {
    /// Returns whether this machine meets the requirement.
    pub fn is_met(self) -> bool {
        let has = |name| Simd::available().any(|simd| simd.name() == name);
        match self {
            Self::Avx2 => has("avx2"),
            Self::Avx512f => has("avx512"),
            Self::Neon => has("neon"),
            Self::Ort => std::env::var_os("EDGEGAIT_ORT_LIB").is_some(),
            Self::TwoThreads => available_parallelism().is_ok_and(|threads| threads.get() >= 2),
        }
    }
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Avx2 => "AVX2",
            Self::Avx512f => "AVX-512",
            Self::Neon => "NEON",
            Self::Ort => "ONNX Runtime",
            Self::TwoThreads => "idle second thread",
        })
    }
}

//! Names of runtimes, and the execution providers of ONNX Runtime.

use crate::error::Result;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The name of a runtime, for results.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RuntimeName {
    /// `rten`, `onnxruntime` or `edgegait-core`; `none` for baselines.
    pub name: String,
    /// Its version.
    pub version: String,
    /// The execution provider, by [`Provider::name`]; empty where there is no choice.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub provider: String,
}

impl RuntimeName {
    /// Returns the version, and the provider if it is not the processor itself.
    #[must_use]
    pub fn detail(&self) -> String {
        if [Provider::Cpu.name(), ""].contains(&self.provider.as_str()) {
            self.version.clone()
        } else {
            format!("{} ({})", self.version, self.provider)
        }
    }
}

impl fmt::Display for RuntimeName {
    /// Writes name and detail: `onnxruntime 1.31.1 (xnnpack)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(format!("{} {}", self.name, self.detail()).trim_end())
    }
}

/// An execution provider of ONNX Runtime, if its library was built with it. Operations that a
/// provider does not support run on the processor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Provider {
    /// The processor, in every library.
    #[default]
    Cpu,
    /// XNNPACK: the processor, with Google's kernels.
    Xnnpack,
    /// Arm Compute Library.
    Acl,
    /// Arm NN.
    Armnn,
    /// Android's Neural Networks API.
    Nnapi,
    /// Apple's Core ML.
    Coreml,
    /// Qualcomm AI Engine Direct.
    Qnn,
    /// Rockchip's NPU.
    Rknpu,
    /// Nvidia GPUs.
    Cuda,
    /// Nvidia TensorRT.
    Tensorrt,
    /// Intel OpenVINO.
    Openvino,
}

impl Provider {
    /// All providers.
    pub const ALL: [Self; 11] = [
        Self::Cpu,
        Self::Xnnpack,
        Self::Acl,
        Self::Armnn,
        Self::Nnapi,
        Self::Coreml,
        Self::Qnn,
        Self::Rknpu,
        Self::Cuda,
        Self::Tensorrt,
        Self::Openvino,
    ];

    /// Returns the name used in flags and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Xnnpack => "xnnpack",
            Self::Acl => "acl",
            Self::Armnn => "armnn",
            Self::Nnapi => "nnapi",
            Self::Coreml => "coreml",
            Self::Qnn => "qnn",
            Self::Rknpu => "rknpu",
            Self::Cuda => "cuda",
            Self::Tensorrt => "tensorrt",
            Self::Openvino => "openvino",
        }
    }
}

/// The loop body that [`Runtime::bare`](super::Runtime::bare) returns.
pub type BareLoop = Box<dyn FnMut() -> Result<f32>>;

/// Where the outputs of a bare loop are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BareOutputs {
    /// In new tensors for each call, as in ONNX Runtime's examples.
    New,
    /// In the same tensors for all calls.
    Reused,
}

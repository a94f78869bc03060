//! Runtimes by name, and the processors that they compute on.

use crate::error::Result;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Which software runs a model, for results.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RuntimeName {
    /// `rten` or `onnxruntime`; `none` where nothing needs to run.
    pub name: String,
    /// Its version.
    pub version: String,
    /// The execution provider, by [`Provider::name`]; empty where there is no choice.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub provider: String,
}

impl RuntimeName {
    /// Version, and the provider if it is not the processor itself.
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
    /// `onnxruntime 1.31.1 (xnnpack)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(format!("{} {}", self.name, self.detail()).trim_end())
    }
}

/// What ONNX Runtime computes with, where its library was built for it. What a provider does not
/// support of a model is left to the processor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Provider {
    /// The processor, in every library.
    #[default]
    Cpu,
    /// XNNPACK: the processor by Google's kernels.
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
    /// All of them.
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

    /// The name under which flags and results state it.
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

/// What [`Runtime::bare`] makes.
pub type BareLoop = Box<dyn FnMut() -> Result<f32>>;

/// Where a bare loop's outputs lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BareOutputs {
    /// ONNX Runtime makes them anew in each call, as in the loops of its examples.
    New,
    /// In the same tensors each time.
    Reused,
}

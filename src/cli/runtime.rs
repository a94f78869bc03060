//! Flags that say what runs the models.

use crate::error::{Error, Result};
use crate::score::{Provider, Runtime, find_library};
use clap::ValueEnum;
use std::path::PathBuf;

/// What runs the models.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct RuntimeArgs {
    /// What runs the models: the embedded runtime, or the real ONNX Runtime
    #[arg(long, value_name = "NAME", default_value = "rten")]
    runtime: RuntimeArg,
    /// The ONNX Runtime library, for `--runtime ort` [env: EDGEGAIT_ORT_LIB, ORT_DYLIB_PATH;
    /// default: looked for beside Python's onnxruntime and in the system's library folders]
    #[arg(long, value_name = "PATH")]
    ort_lib: Option<PathBuf>,
    /// What ONNX Runtime computes with, if its library was built for it
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    provider: Provider,
}

/// Names of the runtimes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RuntimeArg {
    /// rten, embedded
    Rten,
    /// ONNX Runtime, from its shared library
    Ort,
}

impl RuntimeArgs {
    /// The runtime asked for, with one thread.
    ///
    /// # Errors
    /// If there is no ONNX Runtime library, or it cannot be used, or has no such provider; if
    /// flags are given that the embedded runtime has no use for.
    pub(super) fn runtime(&self) -> Result<Runtime> {
        match self.runtime {
            RuntimeArg::Rten if self.ort_lib.is_some() => Err(Error::Usage(
                "--ort-lib: the embedded runtime needs no library (use --runtime ort)".into(),
            )),
            RuntimeArg::Rten => Runtime::rten().with_provider(self.provider),
            RuntimeArg::Ort => {
                let library = find_library(self.ort_lib.as_deref())?;
                Runtime::ort(library)?.with_provider(self.provider)
            }
        }
    }
}

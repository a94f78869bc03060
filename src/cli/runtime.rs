//! Flags that choose the runtime of models.

use crate::error::{Error, Result};
use crate::inference::Provider;
use crate::inference::{Runtime, find_library};
use clap::ValueEnum;
use std::fmt;
use std::path::{Path, PathBuf};

/// The flags that choose the runtime.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct RuntimeArgs {
    /// Runtime of the models
    #[arg(long, value_name = "NAME", default_value = "rten")]
    runtime: RuntimeArg,
    /// The ONNX Runtime library, for `--runtime ort` [env: EDGEGAIT_ORT_LIB, ORT_DYLIB_PATH;
    /// default: searched for in Python's onnxruntime and in the system's library folders]
    #[arg(long, value_name = "PATH")]
    ort_lib: Option<PathBuf>,
    /// Execution provider of ONNX Runtime, if its library was built with it
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    provider: Provider,
}

/// The runtimes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RuntimeArg {
    /// The embedded runtime, rten
    Rten,
    /// ONNX Runtime, from its shared library
    Ort,
}

impl RuntimeArgs {
    /// Returns the requested runtime, with one thread.
    ///
    /// # Errors
    /// If there is no ONNX Runtime library, or it cannot be used, or has no such provider; if
    /// flags have no effect on the embedded runtime.
    pub(super) fn runtime(&self) -> Result<Runtime> {
        let engine = RuntimeChoice {
            runtime: self.runtime,
            provider: self.provider,
        };
        refuse_idle_library(self.ort_lib.as_deref(), &[engine])?;
        engine.load(self.ort_lib.as_deref())
    }
}

/// A runtime and its provider, in one word: `rten`, `ort`, `ort:xnnpack`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RuntimeChoice {
    runtime: RuntimeArg,
    provider: Provider,
}

impl RuntimeChoice {
    /// The embedded runtime.
    pub(super) const EMBEDDED: Self = Self {
        runtime: RuntimeArg::Rten,
        provider: Provider::Cpu,
    };
    /// ONNX Runtime on the processor.
    pub(super) const ONNX_RUNTIME: Self = Self {
        runtime: RuntimeArg::Ort,
        provider: Provider::Cpu,
    };

    /// Parses a word.
    ///
    /// # Errors
    /// For an unknown word, with a list of the known ones.
    pub(super) fn parse(word: &str) -> std::result::Result<Self, String> {
        match word.split_once(':') {
            None if word == "rten" => return Ok(Self::EMBEDDED),
            None if word == "ort" => return Ok(Self::ONNX_RUNTIME),
            Some(("ort", name)) => {
                let known = Provider::ALL
                    .into_iter()
                    .find(|provider| provider.name() == name);
                if let Some(provider) = known {
                    return Ok(Self {
                        provider,
                        ..Self::ONNX_RUNTIME
                    });
                }
            }
            _ => {}
        }
        let names = Provider::ALL.map(Provider::name).join(", ");
        Err(format!(
            "expected rten, ort, or ort:PROVIDER with one of {names}"
        ))
    }

    /// Loads the runtime, with one thread.
    ///
    /// # Errors
    /// If there is no ONNX Runtime library, or it cannot be used, or has no such provider.
    pub(super) fn load(self, ort_lib: Option<&Path>) -> Result<Runtime> {
        match self.runtime {
            RuntimeArg::Rten => Runtime::rten().with_provider(self.provider),
            RuntimeArg::Ort => Runtime::ort(find_library(ort_lib)?)?.with_provider(self.provider),
        }
    }
}

/// Formats a choice as the word that [`RuntimeChoice::parse`] reads.
impl fmt::Display for RuntimeChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.runtime, self.provider) {
            (RuntimeArg::Rten, _) => f.write_str("rten"),
            (RuntimeArg::Ort, Provider::Cpu) => f.write_str("ort"),
            (RuntimeArg::Ort, provider) => write!(f, "ort:{}", provider.name()),
        }
    }
}

/// Rejects a library that no runtime uses.
pub(super) fn refuse_idle_library(ort_lib: Option<&Path>, engines: &[RuntimeChoice]) -> Result<()> {
    let is_used = engines
        .iter()
        .any(|engine| engine.runtime == RuntimeArg::Ort);
    if ort_lib.is_none() || is_used {
        return Ok(());
    }
    Err(Error::Usage(
        "--ort-lib: the embedded runtime needs no library (use --runtime ort)".into(),
    ))
}

//! The runtimes that run models: the embedded one, or ONNX Runtime with one of its providers.

use super::provider::{BareLoop, BareOutputs, Provider, RuntimeName};
use super::{Model, OperatorTime, ProfiledOperations, Recognizer, onnx, rten};
use crate::error::{ChoiceError, Result, SettingError};
use std::path::Path;

/// A runtime that is ready to load models.
#[derive(Clone, Debug)]
pub struct Runtime {
    engine: Engine,
    threads: usize,
}

#[derive(Clone, Debug)]
enum Engine {
    Rten,
    Ort(onnx::Ort, Provider),
}

impl Runtime {
    /// Returns the embedded runtime, with one thread. It needs no library.
    #[must_use]
    pub const fn rten() -> Self {
        Self {
            engine: Engine::Rten,
            threads: 1,
        }
    }

    /// Loads ONNX Runtime from a shared library of version 1.18 or later: one thread, on the
    /// processor.
    ///
    /// The library is in the `onnxruntime` wheel from 1.19 on, as
    /// `onnxruntime/capi/libonnxruntime.so.*`; [`find_library`](super::find_library) looks for
    /// it. It stays loaded, so a second call in a process has to name the same file. Loading runs
    /// the library's code: name only a library that you trust. Telemetry is off.
    ///
    /// # Errors
    /// If the file is missing, cut short, for another system, not ONNX Runtime or too old, or
    /// another library is loaded already.
    pub fn ort(library: impl AsRef<Path>) -> Result<Self> {
        Ok(Self {
            engine: Engine::Ort(onnx::Ort::load(library.as_ref())?, Provider::Cpu),
            threads: 1,
        })
    }

    /// Sets the number of threads (at least 1) for the work inside one call.
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        self.threads = threads.max(1);
        self
    }

    /// Sets the provider that computes.
    ///
    /// # Errors
    /// If the library has no such provider (the error lists those it has), or the runtime is the
    /// embedded one, which has the processor only.
    pub fn with_provider(mut self, provider: Provider) -> Result<Self> {
        match &mut self.engine {
            Engine::Rten if provider != Provider::Cpu => {
                return Err(SettingError::EmbeddedProvider.refuses("provider", provider.name()));
            }
            Engine::Rten => {}
            Engine::Ort(ort, chosen) => {
                ort.require(provider)?;
                *chosen = provider;
            }
        }
        Ok(self)
    }

    /// Returns its name, version and provider.
    #[must_use]
    pub fn name(&self) -> RuntimeName {
        match &self.engine {
            Engine::Rten => rten::runtime_name(),
            Engine::Ort(ort, provider) => ort.runtime_name(*provider),
        }
    }

    /// Returns the library of ONNX Runtime; none for the embedded runtime.
    #[must_use]
    pub fn library(&self) -> Option<&Path> {
        match &self.engine {
            Engine::Rten => None,
            Engine::Ort(ort, _) => Some(ort.library()),
        }
    }

    /// Returns the tightest loop body around ONNX Runtime alone, as a reference for a recognizer.
    /// Each call runs `model` on the same input and returns the sum of the first numbers of its
    /// outputs, without copies or checks.
    ///
    /// # Errors
    /// For the embedded runtime, or if ONNX Runtime rejects the model or the input.
    pub fn bare(&self, model: &Model, input: &[f32], outputs: BareOutputs) -> Result<BareLoop> {
        match &self.engine {
            Engine::Rten => Err(ChoiceError::BareEmbedded.into()),
            Engine::Ort(ort, provider) => {
                let threads = self.threads;
                onnx::OrtRecognizer::load(ort, model, *provider, threads)?.into_bare(input, outputs)
            }
        }
    }

    /// Profiles `model` on one input: which provider ran each operation, and whether in float or in
    /// 8-bit integers. Returns `None` for the embedded runtime, which has the processor only and
    /// computes quantised models in float.
    ///
    /// # Errors
    /// If ONNX Runtime rejects the model or the input, or its profile cannot be read.
    pub fn profile(&self, model: &Model, input: &[f32]) -> Result<Option<Vec<ProfiledOperations>>> {
        match &self.engine {
            Engine::Rten => Ok(None),
            Engine::Ort(ort, provider) => {
                onnx::profile(ort, model, *provider, self.threads, input).map(Some)
            }
        }
    }

    /// Measures the times of the operators of `model` in `runs` inferences of one input; the first
    /// inference is left out if there are more. Returns `None` for the embedded runtime, which does
    /// not report them.
    ///
    /// # Errors
    /// As [`Self::profile`].
    pub fn operator_times(
        &self,
        model: &Model,
        input: &[f32],
        runs: usize,
    ) -> Result<Option<Vec<OperatorTime>>> {
        match &self.engine {
            Engine::Rten => Ok(None),
            Engine::Ort(ort, provider) => {
                let threads = self.threads;
                onnx::operator_times(ort, model, *provider, threads, input, runs.max(1)).map(Some)
            }
        }
    }

    /// Prepares `model` for running.
    ///
    /// # Errors
    /// If the runtime does not support one of the model's operators, or rejects the file.
    pub fn load(&self, model: &Model) -> Result<Box<dyn Recognizer>> {
        Ok(match &self.engine {
            Engine::Rten => Box::new(rten::RtenRecognizer::load(model, self.threads)?),
            Engine::Ort(ort, provider) => {
                let threads = self.threads;
                Box::new(onnx::OrtRecognizer::load(ort, model, *provider, threads)?)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::testing::{ort_library, small_model};

    #[test]
    fn a_name_states_the_provider_unless_it_is_the_processor() {
        let name = |provider: &str| {
            RuntimeName {
                name: "onnxruntime".into(),
                version: "1.31.1".into(),
                provider: provider.into(),
            }
            .to_string()
        };
        assert_eq!(name("cpu"), "onnxruntime 1.31.1");
        assert_eq!(name("xnnpack"), "onnxruntime 1.31.1 (xnnpack)");
    }

    #[test]
    fn the_embedded_runtime_has_the_processor_only() {
        assert!(Runtime::rten().with_provider(Provider::Cpu).is_ok());
        let error = Runtime::rten().with_provider(Provider::Xnnpack);
        assert!(error.is_err_and(|error| {
            error.to_string() == "provider xnnpack: the embedded runtime has cpu only"
        }));
    }

    mod with_ort {
        use super::*;

        #[test]
        #[ignore = "needs EDGEGAIT_ORT_LIB"]
        fn a_provider_runs_or_is_refused_with_those_there_are() {
            let ort = Runtime::ort(ort_library()).expect("the real library");
            for provider in Provider::ALL {
                match ort.clone().with_provider(provider) {
                    Ok(runtime) => {
                        assert_eq!(runtime.name().provider, provider.name());
                        let loaded = runtime.load(&small_model()).expect("our own model");
                        assert!(loaded.run(&[0.5; 1500], 1).is_ok(), "{provider:?}");
                    }
                    Err(error) => {
                        assert_ne!(provider, Provider::Cpu);
                        let text = error.to_string();
                        let start = format!("provider {}: expected ", provider.name());
                        assert!(text.starts_with(&start) && text.contains("cpu"), "{text}");
                    }
                }
            }
        }
    }
}

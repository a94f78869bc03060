//! Recognizers with 8-bit weights for firmware, run as firmware runs them.

use super::provider::RuntimeName;
use super::{Contract, InputLayout, OutputNames, Outputs, Recognizer, SCORES};
use crate::draw::sweep::FramingMode;
use crate::draw::template::Template;
use crate::error::{Error, FilePlace, Result};
use crate::files::{InputFile, sha256_of_bytes};
use edgegait_core::camera;
use edgegait_core::format::RECOGNIZER_MAGIC;
use edgegait_core::linear::LinearRecognizer as Linear;
use std::path::Path;

/// The maximum number of bytes in a file: 255 classes of the largest GEIs take a quarter of it.
const MAX_BYTES: u64 = 1 << 22;

/// A recognizer in the file format of `edgegait quantize`.
pub struct Firmware {
    /// Its bytes stay as long as the process, like flash.
    linear: Linear<'static>,
    contract: Contract,
    runtime: RuntimeName,
    input: InputFile,
}

impl Firmware {
    /// Reads a recognizer.
    ///
    /// # Errors
    /// If the file cannot be read, or is not a recognizer of this version.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let io = |error| Error::io(path, error);
        let length = std::fs::metadata(path).map_err(io)?.len();
        if length > MAX_BYTES {
            let problem =
                format!("expected a recognizer of at most {MAX_BYTES} bytes, found {length}");
            return Err(Error::input(path, problem));
        }
        let bytes = crate::files::read(path)?;
        let input = InputFile {
            path: path.display().to_string(),
            sha256: sha256_of_bytes(&bytes),
        };
        // Leaked: a process reads only a few of them.
        let bytes: &'static [u8] = Box::leak(bytes.into_boxed_slice());
        let linear = Linear::parse(bytes).map_err(|error| {
            let problem = format!("expected {}", error.expected);
            Error::at(path, FilePlace::Byte(error.byte), problem)
        })?;
        let names = (0..linear.classes()).map(|class| linear.name(class).unwrap_or_default());
        let stem = path.file_stem().unwrap_or(path.as_os_str());
        let contract = Contract {
            name: stem.to_string_lossy().into_owned(),
            input_range: super::InputRange::Byte,
            rows: linear.size().rows(),
            columns: linear.size().columns(),
            layout: InputLayout::for_template(Template::Gei),
            framing: match linear.framing() {
                camera::Framing::Box => FramingMode::Box,
                _ => FramingMode::Height,
            },
            classes: names.map(str::to_owned).collect(),
            outputs: OutputNames {
                scores: Some(SCORES.into()),
                embedding: None,
            },
            ..Contract::default()
        };
        Ok(Self {
            linear,
            contract,
            runtime: RuntimeName {
                name: "edgegait-core".into(),
                version: env!("CARGO_PKG_VERSION").into(),
                provider: String::new(),
            },
            input,
        })
    }

    /// Returns whether a file begins like a recognizer for firmware.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        use std::io::Read as _;
        let mut start = [0; RECOGNIZER_MAGIC.len()];
        let file = crate::files::open(path).ok();
        let read = file.and_then(|mut file| file.read_exact(&mut start).ok());
        read.is_some() && start == RECOGNIZER_MAGIC
    }

    /// Returns the file's path and hash, for results.
    #[must_use]
    pub fn input(&self) -> &InputFile {
        &self.input
    }

    /// Renames the recognizer in results and messages.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.contract.name = name.into();
        self
    }
}

impl Recognizer for Firmware {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    /// Computes class scores; the embedding is the same numbers.
    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
        self.contract.frames_in(input.len(), batch)?;
        let classes = self.linear.classes();
        let mut scores = Vec::with_capacity(batch * classes);
        for gei in input.chunks_exact(self.contract.numbers()) {
            let pixels: Vec<u8> = gei.iter().copied().map(super::ports::byte_of).collect();
            scores.extend((0..classes).filter_map(|class| self.linear.score(class, &pixels)));
        }
        Ok(Outputs {
            embedding: scores.clone(),
            embedding_dims: classes,
            embedding_parts: 1,
            scores: Some(scores),
            classes,
            non_finite: 0,
        })
    }
}

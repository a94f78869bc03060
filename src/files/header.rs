//! The header of every JSON result and every manifest.
//!
//! It holds what is needed to reproduce the numbers, and nothing that
//! differs between two runs: no date, no host name, no duration.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::Result;
use crate::files::sha256_of_file;

/// The version of the JSON results and manifests that this program writes.
pub const SCHEMA: u32 = 1;

/// The origin of a result: the first fields of every JSON file of this program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultHeader {
    /// The version of the format, [`SCHEMA`].
    pub schema: u32,
    /// The subcommand, such as `score`.
    pub command: String,
    /// The program's version.
    pub version: String,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The files that were read.
    #[serde(default)]
    pub inputs: Vec<InputFile>,
    /// Every setting by its flag's name, in the names' order.
    #[serde(default)]
    pub settings: BTreeMap<String, Value>,
    /// Warnings that the user should read before trusting the numbers.
    #[serde(default)]
    pub warnings: Vec<String>,
}

impl ResultHeader {
    /// Returns a header of this program's version, without inputs, settings or warnings.
    #[must_use]
    pub fn new(command: &str, seed: u64) -> Self {
        Self {
            schema: SCHEMA,
            command: command.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed,
            inputs: Vec::new(),
            settings: BTreeMap::new(),
            warnings: Vec::new(),
        }
    }

    /// Returns the header with one more setting.
    #[must_use]
    pub fn with(mut self, setting: &str, value: impl Into<Value>) -> Self {
        self.settings.insert(setting.to_owned(), value.into());
        self
    }
}

impl ResultHeader {
    /// Returns the input files except models and their contracts, ordered by SHA-256.
    #[must_use]
    pub(crate) fn data(&self) -> Vec<&InputFile> {
        let is_model = |file: &InputFile| {
            let end = Path::new(&file.path).extension();
            end.is_some_and(|end| {
                end.eq_ignore_ascii_case("onnx") || end.eq_ignore_ascii_case("egr")
            })
        };
        let is_contract = |file: &InputFile| {
            let mut models = self.inputs.iter().filter(|file| is_model(file));
            models
                .any(|model| Path::new(&model.path).with_extension("toml") == Path::new(&file.path))
        };
        let all = self.inputs.iter();
        let mut data: Vec<&InputFile> = all
            .filter(|file| !is_model(file) && !is_contract(file))
            .collect();
        data.sort_unstable_by(|a, b| a.sha256.cmp(&b.sha256));
        data
    }
}

/// A file that was read, with the hash of its bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// The path as the user gave it.
    pub path: String,
    /// SHA-256 of its bytes, 64 lower-case hexadecimal digits.
    pub sha256: String,
}

impl InputFile {
    /// Reads a file and returns its path and hash.
    ///
    /// # Errors
    ///
    /// If the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Ok(Self {
            path: path.display().to_string(),
            sha256: sha256_of_file(path)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_written_in_the_order_of_their_names() {
        let header = ResultHeader::new("sweep", 7)
            .with("views", "paper")
            .with("framing", "height");
        let json = serde_json::to_string(&header).expect("plain data");
        assert_eq!(
            json,
            format!(
                r#"{{"schema":1,"command":"sweep","version":"{}","seed":7,"inputs":[],"settings":{{"framing":"height","views":"paper"}},"warnings":[]}}"#,
                env!("CARGO_PKG_VERSION")
            )
        );
    }
}

//! Which recognizers a command runs: named models, the pixel baseline, or the shipped models.

use super::source::is_pack_or_dataset;
use crate::dataset::{Header, InputFile, sha256_of_bytes};
use crate::error::{Error, Result};
use crate::score::pixels::{self, Pixels};
use crate::score::{Model, Recognizer, Runtime, shipped};
use crate::sweep::Settings;
use std::path::{Path, PathBuf};

/// Models, and at most one pack or dataset, told apart by what they are.
pub fn sort_inputs(inputs: &[PathBuf]) -> Result<(Vec<PathBuf>, Option<PathBuf>)> {
    let (mut models, mut data) = (Vec::new(), None);
    for path in inputs {
        if is_baseline(path) || !is_pack_or_dataset(path)? {
            models.push(path.clone());
        } else if data.replace(path.clone()).is_some() {
            return Err(Error::Usage(format!(
                "{}: expected one pack or dataset, found another before it",
                path.display()
            )));
        }
    }
    Ok((models, data))
}

/// Whether a name stands for the pixel baseline.
fn is_baseline(path: &Path) -> bool {
    path == Path::new(pixels::NAME) && !path.exists()
}

/// Loads the named models, or the shipped ones.
pub fn load(
    paths: &[PathBuf],
    runtime: &Runtime,
    settings: &Settings,
    header: &mut Header,
) -> Result<Vec<Box<dyn Recognizer>>> {
    let mut recognizers: Vec<Box<dyn Recognizer>> = Vec::new();
    if paths.iter().any(|path| is_baseline(path)) {
        recognizers.push(Box::new(Pixels::new(settings.size, settings.framing)));
    }
    let models: Vec<Model> = if paths.is_empty() {
        shipped::models()?
    } else {
        let files = paths.iter().filter(|path| !is_baseline(path));
        files.map(Model::open).collect::<Result<_>>()?
    };
    for model in &models {
        let contract = model.contract();
        if contract.template != "gei" {
            return Err(Error::input(
                model.path(),
                format!(
                    "the contract asks for template {:?}: expected \"gei\", the one that is drawn so far",
                    contract.template
                ),
            ));
        }
        header.inputs.push(InputFile {
            path: model.path().display().to_string(),
            sha256: sha256_of_bytes(model.bytes()),
        });
        recognizers.push(runtime.load(model)?);
    }
    Ok(recognizers)
}

//! Which recognizers a command runs: named models, the pixel baseline, or the shipped models.

use super::drawing::DrawArgs;
use super::source::is_pack_or_folder;
use crate::dataset::{Header, InputFile, sha256_of_bytes};
use crate::error::{Error, Origin, Result};
use crate::evaluate::contest::Entrant;
use crate::score::pixels::{self, Pixels};
use crate::score::{Contract, Model, Runtime, shipped};
use crate::sweep::{Framing, Settings};
use crate::template::Template;
use edgegait_core::silhouette::Size;
use std::path::{Path, PathBuf};

/// Models, and at most one pack or folder, told apart by what they are.
pub fn sort_inputs(inputs: &[PathBuf]) -> Result<(Vec<PathBuf>, Option<PathBuf>)> {
    let (mut models, mut data) = (Vec::new(), None);
    for path in inputs {
        if is_baseline(path) || !is_pack_or_folder(path)? {
            models.push(path.clone());
        } else if data.replace(path.clone()).is_some() {
            return Err(Error::Usage(format!(
                "{}: expected one pack, dataset or tree of silhouettes, found another before it",
                path.display()
            )));
        }
    }
    Ok((models, data))
}

/// These files, and the contracts that are read with those that are models.
pub fn with_contracts(inputs: &[PathBuf]) -> Vec<PathBuf> {
    let beside = inputs.iter().map(|path| Contract::path_beside(path));
    inputs.iter().cloned().chain(beside).collect()
}

/// Whether a name stands for the pixel baseline.
pub fn is_baseline(path: &Path) -> bool {
    path == Path::new(pixels::NAME) && !path.exists()
}

/// How a folder's templates are.
#[derive(Clone, Copy, Debug)]
pub struct Given {
    /// Which they are.
    pub template: Template,
    /// Of which silhouettes.
    pub size: Size,
    /// How those were framed, if it says.
    pub framing: Option<Framing>,
}

/// Loads the named models, or the shipped ones, and says how each is shown people: as its
/// contract asks, where they are drawn, or as a folder's templates are `given`.
///
/// # Errors
/// If a model cannot be used, or its contract asks for what is not given or can not be drawn.
pub fn load(
    paths: &[PathBuf],
    runtime: &Runtime,
    (draw, seed, given): (&DrawArgs, u64, Option<Given>),
    header: &mut Header,
) -> Result<Vec<Entrant>> {
    let settings = draw.settings(seed)?;
    let mut entrants = Vec::new();
    if paths.iter().any(|path| is_baseline(path)) {
        let settings = given.map_or(settings, |given| Settings {
            template: given.template,
            size: given.size,
            framing: given.framing.unwrap_or_default(),
            ..settings
        });
        let (template, size) = (settings.template, settings.size);
        entrants.push(Entrant {
            recognizer: Box::new(Pixels::new(template, size, settings.framing)),
            settings,
        });
    }
    for model in models(paths)? {
        header.inputs.push(InputFile {
            path: model.path().display().to_string(),
            sha256: sha256_of_bytes(model.bytes()),
        });
        let contract = Contract::path_beside(model.path());
        if !paths.is_empty() && contract.is_file() {
            header.inputs.push(InputFile::of(contract)?);
        }
        header.warnings.extend(model.warning());
        let settings = match given {
            Some(given) => {
                let (contract, origin) = (model.contract(), Origin::Dataset);
                // A dataset has no silhouettes, as it says itself.
                if contract.template != Template::Silhouettes {
                    contract.require_template(given.template, origin)?;
                }
                contract.require(given.size, given.framing, origin)?;
                Settings {
                    template: contract.template,
                    size: given.size,
                    framing: contract.framing,
                    ..settings
                }
            }
            None => draw.settings_for(model.contract(), seed)?,
        };
        entrants.push(Entrant {
            recognizer: runtime.load(&model)?,
            settings,
        });
    }
    Ok(entrants)
}

/// The named models, or the shipped ones.
pub fn models(paths: &[PathBuf]) -> Result<Vec<Model>> {
    if paths.is_empty() {
        return shipped::models();
    }
    let files = paths.iter().filter(|path| !is_baseline(path));
    files.map(Model::open).collect()
}

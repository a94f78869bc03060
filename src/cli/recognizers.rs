//! Which recognizers a command runs: named models, the pixel baseline, or the shipped models.

use super::contest::Setup;
use crate::cache::Cache;
use crate::dataset::Header;
use crate::error::{Error, Result};
use crate::evaluate::contest::Entrant;
use crate::score::baseline;
use crate::score::{Contract, Kept, Model, Runtime, shipped};
use crate::source::is_pack_or_folder;
use std::path::{Path, PathBuf};

/// Models, and at most one pack or folder, told apart by what they are.
pub(super) fn sort_inputs(inputs: &[PathBuf]) -> Result<(Vec<PathBuf>, Option<PathBuf>)> {
    let (mut models, mut data) = (Vec::new(), None);
    for path in inputs {
        if !is_baseline(path) {
            shipped::require_name(path)?;
        }
        if is_baseline(path) || shipped::is_name(path) || !is_pack_or_folder(path)? {
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
pub(super) fn with_contracts(inputs: &[PathBuf]) -> Vec<PathBuf> {
    let beside = inputs.iter().map(|path| Contract::path_beside(path));
    inputs.iter().cloned().chain(beside).collect()
}

/// Whether a name stands for the pixel baseline.
pub(super) fn is_baseline(path: &Path) -> bool {
    path == Path::new(baseline::PIXELS) && !path.exists()
}

/// Loads the named models, or the shipped ones, and says how each is shown people: as its
/// contract asks, where they are drawn, or as a dataset's templates are `stored`. Networks that take
/// long remember in the cache what they answered.
///
/// # Errors
/// If a model cannot be used, or its contract asks for what is not stored or can not be drawn.
pub(super) fn load(
    paths: &[PathBuf],
    (runtime, cache): (&Runtime, &Cache),
    (draw, seed, stored): Setup<'_>,
    header: &mut Header,
) -> Result<Vec<Entrant>> {
    let settings = draw.settings(seed)?;
    let mut entrants = Vec::new();
    if paths.iter().any(|path| is_baseline(path)) {
        entrants.push(Entrant::pixels(stored, settings));
    }
    for model in models(paths)? {
        header.inputs.extend(model.inputs()?);
        header.warnings.extend(model.warnings());
        let entrant = entrant(&model, runtime, (draw, seed, stored))?;
        entrants.push(Entrant {
            recognizer: Kept::of(entrant.recognizer, &model, cache)?,
            ..entrant
        });
    }
    Ok(entrants)
}

/// A model on a runtime, and how it is shown people.
///
/// # Errors
/// As [`load`].
pub(super) fn entrant(
    model: &Model,
    runtime: &Runtime,
    (draw, seed, stored): Setup<'_>,
) -> Result<Entrant> {
    match stored {
        Some(stored) => Entrant::stored(model, runtime, (stored, draw.settings(seed)?)),
        None => {
            let settings = draw.settings_for(model.contract(), seed)?;
            Entrant::drawn(model, runtime, settings)
        }
    }
}

/// The named models, or the shipped ones.
pub(super) fn models(paths: &[PathBuf]) -> Result<Vec<Model>> {
    if paths.is_empty() {
        return shipped::linear();
    }
    let files = paths.iter().filter(|path| !is_baseline(path));
    files.map(|path| shipped::open(path)).collect()
}

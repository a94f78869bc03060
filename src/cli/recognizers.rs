//! Loads the recognizers of a command: named models, the pixel baseline, or the shipped models.

use super::baselines::is_baseline;
use super::contest::InputSource;
use super::trial::try_out;
use crate::dataset::sequences::is_pack_or_folder;
use crate::error::{Error, Result};
use crate::evaluate::contest::Entrant;
use crate::files::cache::Cache;
use crate::files::{InputFile, ResultHeader};
use crate::inference::RuntimeName;
use crate::inference::{
    CachedRecognizer, Contract, Firmware, Model, Outputs, Recognizer, Runtime, shipped,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Separates the models from the pack or folder, of which there is at most one.
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

/// Returns these files, and the contracts beside them.
pub(super) fn with_contracts(inputs: &[PathBuf]) -> Vec<PathBuf> {
    let beside = inputs.iter().map(|path| Contract::path_beside(path));
    inputs.iter().cloned().chain(beside).collect()
}

/// Loads the named models, or the shipped ones, with the form of their inputs: drawn according to
/// the contract, or as a dataset's templates are `stored`. The answers of slow networks are cached.
///
/// # Errors
/// If a model cannot be used, or if its contract needs inputs that are not stored or cannot be
/// drawn.
pub(super) fn load(
    paths: &[PathBuf],
    runtime: &Runtime,
    cache: &Cache,
    inputs: InputSource<'_>,
    header: &mut ResultHeader,
) -> Result<Vec<Entrant>> {
    let settings = inputs.draw.settings(inputs.seed)?;
    let mut entrants = Vec::new();
    if paths.iter().any(|path| is_baseline(path)) {
        entrants.push(Entrant::pixels(inputs.stored, settings));
    }
    let (firmware, files): (Vec<&PathBuf>, Vec<&PathBuf>) =
        paths.iter().partition(|path| Firmware::is_one(path));
    let files: Vec<PathBuf> = files.into_iter().cloned().collect();
    // Nothing is named, or not only firmware.
    let models = if firmware.is_empty() || !files.is_empty() {
        models(&files)?
    } else {
        Vec::new()
    };
    let firmware = firmware.into_iter().map(Firmware::read);
    let firmware = firmware.collect::<Result<Vec<_>>>()?;
    let named = |named: &str, input: InputFile| (named.to_owned(), PathBuf::from(input.path));
    let of_models = models
        .iter()
        .map(|model| named(&model.contract().name, model.input()));
    let of_firmware = firmware
        .iter()
        .map(|recognizer| named(recognizer.name(), recognizer.input().clone()));
    let names = told_apart(of_models.chain(of_firmware).collect())?;
    for (model, name) in models.into_iter().zip(&names) {
        let model = model.named(name);
        header.inputs.extend(model.inputs()?);
        header.warnings.extend(model.warnings());
        try_out(&model, runtime)?;
        let entrant = entrant(&model, runtime, inputs)?;
        entrants.push(Entrant {
            recognizer: CachedRecognizer::wrap(entrant.recognizer, &model, cache)?,
            ..entrant
        });
    }
    let of_models = names.len() - firmware.len();
    for (one, name) in firmware.into_iter().zip(&names[of_models..]) {
        header.inputs.push(one.input().clone());
        entrants.push(entrant_of(Box::new(one.named(name)), inputs)?);
    }
    Ok(entrants)
}

/// Returns a loaded recognizer with the form of its inputs.
///
/// # Errors
/// If its contract needs inputs that are not stored or cannot be drawn.
fn entrant_of(recognizer: Box<dyn Recognizer>, inputs: InputSource<'_>) -> Result<Entrant> {
    let InputSource { draw, seed, stored } = inputs;
    let contract = recognizer.contract();
    let settings = match stored {
        Some(stored) => Entrant::stored_settings_of(contract, stored, draw.settings(seed)?)?,
        None => Entrant::settings_of(contract, draw.settings_for(contract, seed)?)?,
    };
    Ok(Entrant {
        recognizer,
        settings,
        model_bytes: None,
    })
}

/// Adds the recognizers of the program that runs this command in its own process to the loaded
/// ones.
///
/// # Errors
/// The same as [`entrant_of`], and if two have the same name.
pub(super) fn with_held(
    mut entrants: Vec<Entrant>,
    held: &[Arc<dyn Recognizer>],
    inputs: InputSource<'_>,
) -> Result<Vec<Entrant>> {
    for one in held {
        let name = one.name();
        if entrants.iter().any(|other| other.recognizer.name() == name) {
            return Err(Error::Usage(format!("two recognizers are called {name:?}")));
        }
        entrants.push(entrant_of(Box::new(HeldRecognizer(one.clone())), inputs)?);
    }
    Ok(entrants)
}

/// A recognizer of the program that runs this command in its own process.
struct HeldRecognizer(Arc<dyn Recognizer>);

impl Recognizer for HeldRecognizer {
    fn runtime(&self) -> &RuntimeName {
        self.0.runtime()
    }

    fn contract(&self) -> &Contract {
        self.0.contract()
    }

    fn run(&self, input: &[f32], batch: usize) -> Result<Outputs> {
        self.0.run(input, batch)
    }

    fn at_once(&self) -> usize {
        self.0.at_once()
    }
}

/// Returns unique names of the recognizers from these files, in order. Equal names get the end of
/// the path that distinguishes them.
///
/// # Errors
/// If a file appears twice.
pub(super) fn told_apart(all: Vec<(String, PathBuf)>) -> Result<Vec<String>> {
    for (at, (_, path)) in all.iter().enumerate() {
        let same = |other: &Path| {
            let resolved = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
            resolved(other) == resolved(path)
        };
        if all[..at].iter().any(|(_, other)| same(other)) {
            return Err(Error::Usage(format!("{}: appears twice", path.display())));
        }
    }
    // The last parts of a path, without the extension unless it distinguishes two files.
    let is_ending_told = |path: &Path| {
        let stem = path.with_extension("");
        all.iter()
            .filter(|(_, other)| other.with_extension("") == stem)
            .count()
            > 1
    };
    let end = |path: &Path, parts: usize| -> PathBuf {
        let whole = if is_ending_told(path) {
            path.to_owned()
        } else {
            path.with_extension("")
        };
        let skipped = whole.components().count().saturating_sub(parts);
        whole.components().skip(skipped).collect()
    };
    let name = |(name, path): &(String, PathBuf)| {
        let alike: Vec<&PathBuf> = all
            .iter()
            .filter(|(other, _)| other == name)
            .map(|(_, other)| other)
            .collect();
        if alike.len() == 1 {
            return name.clone();
        }
        let tells = |parts: &usize| {
            let mine = end(path, *parts);
            alike
                .iter()
                .filter(|other| end(other, *parts) == mine)
                .count()
                == 1
        };
        let most = path.components().count();
        let parts = (1..most).find(tells).unwrap_or(most);
        let label = end(path, parts).display().to_string();
        if end(path, 1).with_extension("") == Path::new(name) {
            label
        } else {
            format!("{name} ({label})")
        }
    };
    Ok(all.iter().map(name).collect())
}

/// Loads a model on a runtime, with the form of its inputs.
///
/// # Errors
/// The same as [`load`].
pub(super) fn entrant(
    model: &Model,
    runtime: &Runtime,
    inputs: InputSource<'_>,
) -> Result<Entrant> {
    let InputSource { draw, seed, stored } = inputs;
    match stored {
        Some(stored) => Entrant::stored(model, runtime, stored, draw.settings(seed)?),
        None => {
            let settings = draw.settings_for(model.contract(), seed)?;
            Entrant::drawn(model, runtime, settings)
        }
    }
}

/// Opens the named models, or the shipped ones.
pub(super) fn models(paths: &[PathBuf]) -> Result<Vec<Model>> {
    if paths.is_empty() {
        return shipped::linear();
    }
    let files = paths.iter().filter(|path| !is_baseline(path));
    let models = files.map(|path| shipped::open(path));
    let models = models.collect::<Result<Vec<_>>>()?;
    let named = models
        .iter()
        .map(|model| (model.contract().name.clone(), model.path().to_owned()));
    let names = told_apart(named.collect())?;
    let named = models.into_iter().zip(names);
    Ok(named.map(|(model, name)| model.named(name)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(all: &[(&str, &str)]) -> Result<Vec<String>> {
        let all = all
            .iter()
            .map(|(name, path)| ((*name).to_owned(), PathBuf::from(path)));
        told_apart(all.collect())
    }

    #[test]
    fn recognizers_of_one_name_are_told_apart_by_their_paths() {
        let found = names(&[
            ("m", "runs/a/m.onnx"),
            ("m", "runs/b/m.onnx"),
            ("n", "runs/n.onnx"),
            ("x", "runs/u.onnx"),
            ("x", "runs/v.egr"),
        ]);
        assert_eq!(found.expect("names"), ["a/m", "b/m", "n", "x (u)", "x (v)"]);
        let beside = names(&[("m", "m.onnx"), ("m", "m.egr")]);
        assert_eq!(beside.expect("names"), ["m.onnx", "m.egr"]);
        let said = names(&[("m", "m.onnx"), ("m", "m.onnx")]).expect_err("twice");
        assert_eq!(said.to_string(), "m.onnx: appears twice");
    }
}

//! Merges shards into the same bytes as one run.

use super::contents::{Contents, DatasetFormat};
use super::existing::Existing;
use super::manifest::read_manifest;
use super::unfinished::difference;
use super::writer::{DatasetRun, DatasetWriter};
use super::{MANIFEST, Manifest};
use crate::error::{Error, Result};

use std::path::{Path, PathBuf};

/// Merges shards, given in any order, and returns the number of rows.
///
/// # Errors
/// If a folder is not a shard, shards belong to different runs, one is missing or given twice, or
/// its files do not have the hashes in its manifest; as [`DatasetWriter::begin`]; if a file cannot
/// be read or written.
pub fn merge(
    shards: &[PathBuf],
    target: &Path,
    format: Option<DatasetFormat>,
    existing: Existing,
    resume: bool,
) -> Result<usize> {
    let mut all = Vec::new();
    for path in shards {
        let is_above = |name: &str| path.join(name).join(MANIFEST).is_file();
        if !path.join(MANIFEST).exists() && (is_above("train") || is_above("test")) {
            return Err(Error::input(
                path,
                "expected a shard, found a folder of splits (merge the shards of each split separately, such as all train folders)",
            ));
        }
        let manifest = read_manifest(&path.join(MANIFEST))?;
        let Some(shard) = manifest.shard else {
            return Err(Error::input(
                path.join(MANIFEST),
                "expected one shard of several, found a whole dataset",
            ));
        };
        all.push((shard, path, manifest));
    }
    all.sort_by_key(|(shard, ..)| shard.number);
    let Some((first, first_path, model)) = all.first() else {
        return Err(Error::Usage("expected shards, found none".into()));
    };
    let stated = |manifest: &Manifest| -> Result<serde_json::Value> {
        let shared = Manifest {
            shard: None,
            geis: 0,
            files: Vec::new(),
            ..manifest.clone()
        };
        Ok(serde_json::to_value(shared)?)
    };
    for (shard, path, manifest) in &all {
        let differs = difference(&stated(model)?, &stated(manifest)?);
        let differs = differs.or_else(|| {
            (shard.of != first.of)
                .then(|| format!("shards are {} there, {} here", first.of, shard.of))
        });
        if let Some(differs) = differs {
            return Err(Error::input(
                path,
                format!(
                    "it belongs to another run than {}: {differs}",
                    first_path.display()
                ),
            ));
        }
    }
    for number in 1..=first.of {
        let mut found = all.iter().filter(|(shard, ..)| shard.number == number);
        match (found.next(), found.next()) {
            (Some(_), None) => {}
            (None, _) => {
                return Err(Error::Usage(format!(
                    "expected all {} shards, found no shard {number}/{0}",
                    first.of
                )));
            }
            (Some((_, one, _)), Some((_, other, _))) => {
                return Err(Error::Usage(format!(
                    "{} and {} are both shard {number}/{}",
                    one.display(),
                    other.display(),
                    first.of
                )));
            }
        }
    }
    let format = format.unwrap_or(model.format);
    if format != model.format && (format.is_tree() || model.format.is_tree()) {
        return Err(Error::Usage(format!(
            "format {}: the shards are of format {}",
            format.name(),
            model.format.name()
        )));
    }
    let run = DatasetRun {
        header: model.header.clone(),
        contents: contents_of(model, first_path)?,
        format,
        units: all.len(),
        shard: None,
        is_recorded: false,
    };
    let mut writer = DatasetWriter::begin(target, run, existing, resume)?;
    for (_, path, manifest) in all.iter().skip(writer.done()) {
        writer.append(path, manifest)?;
    }
    let rows = writer.rows();
    writer.finish()?;
    Ok(rows)
}

/// Returns the contents of each row that a manifest states.
fn contents_of(manifest: &Manifest, folder: &Path) -> Result<Contents> {
    let size = manifest.size().ok_or_else(|| {
        Error::input(
            folder.join(MANIFEST),
            "expected settings.size to be 50x30, 64x44 or 64x64, found another or none",
        )
    })?;
    let templates = std::iter::once(manifest.template).chain(manifest.besides.iter().copied());
    Ok(Contents {
        templates: templates.collect(),
        size,
        joints: manifest.joints,
    })
}

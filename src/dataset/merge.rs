//! Shards put together to the bytes of one run.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

use super::contents::{Contents, DatasetFormat, NPY_HEADER};
use super::existing::Existing;
use super::partition::Partition;
use super::reader::read_manifest;
use super::sequences::PARTITION;
use super::unfinished::difference;
use super::writer::{DatasetRun, DatasetWriter};
use super::{MANIFEST, Manifest};
use crate::error::{Error, Result};
use crate::files::hex;
use edgegait_core::silhouette::Size;
use sha2::{Digest as _, Sha256};

/// A file of a shard that is read once, and whose bytes are those of which the manifest tells.
pub(super) struct CheckedFile {
    path: PathBuf,
    file: BufReader<File>,
    digest: Sha256,
    expected: Option<String>,
}

impl CheckedFile {
    pub(super) fn open(shard: &Path, name: &str, manifest: &Manifest) -> Result<Self> {
        let path = shard.join(name);
        let file = File::open(&path).map_err(|source| Error::io(&path, source))?;
        let known = manifest.files.iter().find(|file| file.path == name);
        Ok(Self {
            path,
            file: BufReader::with_capacity(1 << 16, file),
            digest: Sha256::new(),
            expected: known.map(|file| file.sha256.clone()),
        })
    }

    /// Passes over the header of an array, which was written here.
    pub(super) fn skip_header(&mut self) -> Result<()> {
        let mut header = [0; NPY_HEADER];
        let read = self.file.read_exact(&mut header);
        read.map_err(|source| Error::io(&self.path, source))?;
        self.digest.update(header);
        Ok(())
    }

    /// Passes over the first line.
    pub(super) fn skip_line(&mut self) -> Result<()> {
        let mut line = Vec::new();
        let read = self.file.read_until(b'\n', &mut line);
        read.map_err(|source| Error::io(&self.path, source))?;
        self.digest.update(line);
        Ok(())
    }

    /// Gives the rest to `take`, piece by piece.
    ///
    /// # Errors
    /// If the bytes are not those of the manifest; then some were given already.
    pub(super) fn copy(mut self, mut take: impl FnMut(&[u8]) -> Result<()>) -> Result<()> {
        let mut piece = vec![0; 1 << 16];
        loop {
            let read = self.file.read(&mut piece);
            let read = read.map_err(|source| Error::io(&self.path, source))?;
            if read == 0 {
                break;
            }
            self.digest.update(&piece[..read]);
            take(&piece[..read])?;
        }
        let found = hex(&self.digest.finalize());
        match self.expected {
            Some(expected) if expected != found => Err(Error::input(
                self.path,
                format!(
                    "expected SHA-256 {expected}, as {MANIFEST} says, found {found} (make the shard again)"
                ),
            )),
            _ => Ok(()),
        }
    }

    /// All of it.
    pub(super) fn whole(self) -> Result<Vec<u8>> {
        let mut all = Vec::new();
        self.copy(|bytes| {
            all.extend_from_slice(bytes);
            Ok(())
        })?;
        Ok(all)
    }
}

/// Who trains and who is tested of the people of a tree; nobody where it does not say.
pub(super) fn partition_of(shard: &Path, manifest: &Manifest) -> Result<Partition> {
    if manifest.format != DatasetFormat::Opengait {
        return Ok(Partition::default());
    }
    let text = CheckedFile::open(shard, PARTITION, manifest)?.whole()?;
    Partition::parse(&shard.join(PARTITION), &text)
}

/// Puts shards together, whatever their order; how many rows they have.
///
/// # Errors
/// If a folder is no shard, shards are of different runs, one is missing or given twice, or its
/// bytes are not those of which its manifest tells; as [`DatasetWriter::begin`], and the system's.
pub fn merge(
    shards: &[PathBuf],
    target: &Path,
    format: Option<DatasetFormat>,
    (existing, resume): (Existing, bool),
) -> Result<usize> {
    let mut all = Vec::new();
    for path in shards {
        let is_above = |name: &str| path.join(name).join(MANIFEST).is_file();
        if !path.join(MANIFEST).exists() && (is_above("train") || is_above("test")) {
            return Err(Error::input(
                path,
                "expected a shard, found a folder of splits (merge those of each split: its train, its test)",
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
                    "it is of another run than {}: {differs}",
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
    };
    let mut writer = DatasetWriter::begin(target, run, existing, resume)?;
    for (_, path, manifest) in all.iter().skip(writer.done()) {
        writer.append(path, manifest)?;
    }
    let rows = writer.rows();
    writer.finish()?;
    Ok(rows)
}

/// What a dataset holds of each row, as its manifest says.
fn contents_of(manifest: &Manifest, folder: &Path) -> Result<Contents> {
    let stated = manifest.header.settings.get("size");
    let size = Size::ALL
        .into_iter()
        .find(|size| stated.is_some_and(|stated| stated == size.name()));
    let size = size.ok_or_else(|| {
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

//! Writes trees of silhouettes: nested folders for each person, take and viewpoint.

use super::arrays::GrowingTable;
use super::checked_file::CheckedFile;
use super::contents::DatasetFormat;
use super::index::IndexRow;
use super::partition::Partition;
use super::{INDEX, MANIFEST, Manifest, WALKERS, tree};
use crate::error::{ChoiceError, Error, Result};
use crate::files::{grey_png, hex};
use edgegait_core::silhouette::Size;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The table of the written sequences.
pub(super) const SEQUENCES: &str = "sequences.csv";
/// The training and test people, in OpenGait's format.
pub(crate) const PARTITION: &str = "partition.json";
const COLUMNS: [&str; 3] = ["path", "frames", "sha256"];

/// A row of [`SEQUENCES`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct SequenceRow {
    /// The pickle, or the folder of pictures.
    path: String,
    /// The number of silhouettes.
    frames: usize,
    /// The SHA-256 of the pickle, or of all pictures one after another.
    sha256: String,
}

/// The sequences that are being written.
#[derive(Debug)]
pub(super) struct GrowingSequences {
    root: PathBuf,
    format: DatasetFormat,
    size: Size,
    table: GrowingTable,
    /// The sequences of the present unit of work, in the order of their first row.
    pending: Vec<Pending>,
}

/// A sequence that may still receive rows.
#[derive(Debug)]
struct Pending {
    /// The names of the person, take and viewpoint.
    names: [String; 3],
    pixels: Vec<u8>,
}

/// Returns the name of a viewpoint's folder, which our reader parses: `090`, `022.5`, `045e15`.
fn name_of_view(row: &IndexRow) -> String {
    let (azimuth, elevation) = (row.azimuth_deg + 0.0, row.elevation_deg + 0.0);
    let sign = if azimuth < 0.0 { "-" } else { "" };
    let whole = azimuth.abs().trunc();
    let rest = format!("{}", azimuth.abs());
    let rest = rest
        .split_once('.')
        .map_or(String::new(), |(_, rest)| format!(".{rest}"));
    if elevation == 0.0 {
        format!("{sign}{whole:03}{rest}")
    } else {
        format!("{sign}{whole:03}{rest}e{elevation}")
    }
}

/// Checks that a name is valid for a folder on every system.
///
/// # Errors
/// If it is not.
pub fn check_folder_name(name: &str) -> Result<()> {
    let is_plain = |c: char| !c.is_control() && !r#"/\:*?"<>|"#.contains(c);
    if name.is_empty() || name.starts_with('.') || name.len() > 200 || !name.chars().all(is_plain) {
        return Err(ChoiceError::FolderName(name.to_owned()).into());
    }
    Ok(())
}

/// Finds a file or folder that does not belong to a tree: not a table, not in the folder of
/// a listed sequence, and not such a folder or one above it.
///
/// # Errors
/// If the list or a folder cannot be read.
pub(super) fn foreign(root: &Path) -> Result<Option<PathBuf>> {
    let path = root.join(SEQUENCES);
    let refuse = |error: csv::Error| Error::input(&path, error.to_string());
    let file = crate::files::open(&path)?;
    let (mut files, mut inner, mut outer) = (HashSet::new(), HashSet::new(), HashSet::new());
    for name in [MANIFEST, INDEX, WALKERS, SEQUENCES, PARTITION] {
        files.insert(PathBuf::from(name));
    }
    for row in csv::Reader::from_reader(file).deserialize() {
        let row: SequenceRow = row.map_err(refuse)?;
        let path = PathBuf::from(row.path);
        let folder = if path.extension().is_some_and(|extension| extension == "pkl") {
            let folder = path.parent().unwrap_or(&path).to_path_buf();
            files.insert(path);
            folder
        } else {
            inner.insert(path.clone());
            path
        };
        outer.extend(folder.ancestors().map(Path::to_path_buf));
    }
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        let at = root.join(&folder);
        let io = |error| Error::io(&at, error);
        for entry in fs::read_dir(&at).map_err(io)? {
            let entry = entry.map_err(io)?;
            let path = folder.join(entry.file_name());
            let is_png = || path.extension().is_some_and(|extension| extension == "png");
            if entry.file_type().map_err(io)?.is_dir() {
                if !outer.contains(&path) {
                    return Ok(Some(path));
                }
                folders.push(path);
            } else if !(files.contains(&path) || inner.contains(&folder) && is_png()) {
                return Ok(Some(path));
            }
        }
    }
    Ok(None)
}

impl GrowingSequences {
    pub(super) fn open(
        made: &Path,
        format: DatasetFormat,
        size: Size,
        known: Option<u64>,
    ) -> Result<Self> {
        Ok(Self {
            root: made.to_path_buf(),
            format,
            size,
            table: GrowingTable::open(made, SEQUENCES, &COLUMNS, known)?,
            pending: Vec::new(),
        })
    }

    pub(super) const fn table(&mut self) -> &mut GrowingTable {
        &mut self.table
    }

    /// Appends silhouettes to their sequence.
    pub(super) fn push(&mut self, row: &IndexRow, take: &str, pixels: &[u8]) -> Result<()> {
        check_folder_name(&row.subject)?;
        check_folder_name(take)?;
        let names = [row.subject.clone(), take.to_owned(), name_of_view(row)];
        let known = self.pending.iter().position(|take| take.names == names);
        match known {
            Some(at) => self.pending[at].pixels.extend_from_slice(pixels),
            None => self.pending.push(Pending {
                names,
                pixels: pixels.to_vec(),
            }),
        }
        Ok(())
    }

    /// Writes the pending sequences on all cores.
    pub(super) fn write(&mut self) -> Result<()> {
        let pending = std::mem::take(&mut self.pending);
        let (root, format, size) = (&self.root, self.format, self.size);
        let rows: Vec<Result<Option<SequenceRow>>> = pending
            .par_iter()
            .map(|take| take.write(root, format, size))
            .collect();
        for row in rows {
            if let Some(row) = row? {
                self.table.push(&row)?;
            }
        }
        Ok(())
    }

    /// Copies the sequences of another tree.
    pub(super) fn append(&mut self, from: &Path, manifest: &Manifest) -> Result<()> {
        let text = CheckedFile::open(from, SEQUENCES, manifest)?.whole()?;
        let path = from.join(SEQUENCES);
        let refuse = |error: csv::Error| Error::input(&path, error.to_string());
        for row in csv::Reader::from_reader(text.as_slice()).deserialize() {
            let row: SequenceRow = row.map_err(refuse)?;
            let names: Vec<&str> = row.path.split('/').collect();
            for name in &names {
                check_folder_name(name).map_err(|error| Error::input(&path, error.to_string()))?;
            }
            let found = copy(&from.join(&row.path), &self.root.join(&row.path))?;
            if found != row.sha256 {
                return Err(Error::input(
                    from.join(&row.path),
                    format!(
                        "expected SHA-256 {}, as {SEQUENCES} says, found {found} (make the shard again)",
                        row.sha256
                    ),
                ));
            }
            self.table.push(&row)?;
        }
        Ok(())
    }
}

/// Copies a file, or the files of a folder, and returns the SHA-256 of their bytes in the order of
/// names.
fn copy(from: &Path, to: &Path) -> Result<String> {
    let io = |source| Error::io(from, source);
    let make =
        |folder: &Path| fs::create_dir_all(folder).map_err(|source| Error::io(folder, source));
    let mut digest = Sha256::new();
    let files = if from.is_dir() {
        make(to)?;
        let entries = fs::read_dir(from).map_err(io)?;
        let mut names = entries
            .map(|entry| entry.map(|entry| entry.file_name()))
            .collect::<std::io::Result<Vec<_>>>()
            .map_err(io)?;
        names.sort();
        names
            .iter()
            .map(|name| (from.join(name), to.join(name)))
            .collect()
    } else {
        make(to.parent().unwrap_or(to))?;
        vec![(from.to_path_buf(), to.to_path_buf())]
    };
    for (from, to) in files {
        let bytes = crate::files::read(&from)?;
        digest.update(&bytes);
        fs::write(&to, bytes).map_err(|source| Error::io(&to, source))?;
    }
    Ok(hex(&digest.finalize()))
}

impl Pending {
    /// Writes the frames that have a figure; writes nothing if none has.
    fn write(&self, root: &Path, format: DatasetFormat, size: Size) -> Result<Option<SequenceRow>> {
        let [subject, take, view] = &self.names;
        let folder = [subject, take, view].map(String::as_str).join("/");
        let frames = self.pixels.chunks_exact(size.pixels()).zip(1..);
        let frames: Vec<(&[u8], usize)> = frames
            .filter(|(pixels, _)| pixels.iter().any(|&pixel| pixel > 0))
            .collect();
        if frames.is_empty() {
            return Ok(None);
        }
        let at = root.join(&folder);
        fs::create_dir_all(&at).map_err(|source| Error::io(&at, source))?;
        let mut digest = Sha256::new();
        let mut write = |name: String, bytes: &[u8]| {
            digest.update(bytes);
            let path = at.join(name);
            fs::write(&path, bytes).map_err(|source| Error::io(&path, source))
        };
        let path = if format == DatasetFormat::Opengait {
            let pixels: Vec<u8> = frames
                .iter()
                .flat_map(|(pixels, _)| *pixels)
                .copied()
                .collect();
            let shape = [frames.len(), size.rows(), size.columns()];
            write(format!("{view}.pkl"), &tree::pickled(shape, &pixels))?;
            format!("{folder}/{view}.pkl")
        } else {
            for (pixels, number) in &frames {
                let name = format!("{subject}-{take}-{view}-{number:03}.png");
                write(name, &grey_png(pixels, size.columns())?)?;
            }
            folder
        };
        Ok(Some(SequenceRow {
            path,
            frames: frames.len(),
            sha256: hex(&digest.finalize()),
        }))
    }
}

/// Reads the training and test people of a tree; both are empty if its format has no partition.
pub(super) fn partition_of(shard: &Path, manifest: &Manifest) -> Result<Partition> {
    if manifest.format != DatasetFormat::Opengait {
        return Ok(Partition::default());
    }
    let text = CheckedFile::open(shard, PARTITION, manifest)?.whole()?;
    Partition::parse(&shard.join(PARTITION), &text)
}

//! Writes a dataset row by row, and never leaves a partial one under its name.
//!
//! Everything is written to a folder beside the target, from which interrupted work can be resumed
//! and which is renamed at the end. Memory does not grow with the number of rows.

use super::arrays::{GrowingArray, GrowingTable};
use super::contents::{Contents, DatasetFormat, Shard};
use super::existing::{Existing, check_replaceable};
use super::index::{COLUMNS, RECORDED_COLUMNS, WALKER_COLUMNS};
use super::manifest::read_manifest;
use super::partition::Partition;
use super::tree_writer::{GrowingSequences, PARTITION, SEQUENCES};
use super::unfinished::{Unfinished, difference};
use super::{INDEX, IndexRow, MANIFEST, WALKERS, WalkerRow, npz};
use crate::dataset::Manifest;
use crate::error::{Error, Result};
use crate::files::{InputFile, ResultHeader, sha256_of_file};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// The names of the splits that a partition has.
const TRAIN: &str = "train";
const TEST: &str = "test";

/// The settings of a dataset to write: everything that its bytes depend on.
#[derive(Clone, Debug)]
pub struct DatasetRun {
    /// The header of the manifest.
    pub header: ResultHeader,
    /// The contents of each row.
    pub contents: Contents,
    /// The file format.
    pub format: DatasetFormat,
    /// The number of units of work; the dataset can be resumed after each.
    pub units: usize,
    /// The shard that the dataset is; none for a whole dataset.
    pub shard: Option<Shard>,
    /// Whether the rows are gait cycles of recordings, with their first and last frames.
    pub is_recorded: bool,
}

impl DatasetRun {
    /// Returns the settings that must be equal in a run that resumes this one.
    fn stated(&self) -> Result<Value> {
        let mut stated = serde_json::to_value(&self.header)?;
        let templates: Vec<&str> = self.contents.templates.iter().map(|t| t.name()).collect();
        stated["written"] = json!({
            "templates": templates,
            "size": self.contents.size.name(),
            "joints": self.contents.joints,
            "format": self.format,
            "units": self.units,
            "shard": self.shard,
        });
        Ok(stated)
    }

    /// Returns the manifest of a dataset with this number of rows and these files.
    fn manifest(&self, rows: usize, files: Vec<InputFile>) -> Manifest {
        let mut templates = self.contents.templates.iter().copied();
        Manifest {
            header: self.header.clone(),
            template: templates.next().unwrap_or_default(),
            besides: templates.collect(),
            joints: self.contents.joints,
            format: self.format,
            shard: self.shard,
            geis: rows,
            files,
        }
    }
}

/// A row of the index with its arrays.
#[derive(Clone, Copy, Debug)]
pub struct Item<'a> {
    /// The row of the index.
    pub row: &'a IndexRow,
    /// The name of the take, which is a folder in trees.
    pub take: &'a str,
    /// The templates' bytes, images row by row from the top, in the order of
    /// [`Contents::templates`].
    pub templates: &'a [Vec<u8>],
    /// The positions of joints, f32 `[frames][19][3]`, and their image points,
    /// `[frames][19][2]`; used if the dataset holds joints.
    pub joints: [&'a [u8]; 2],
}

/// A dataset that is being written. If dropped before [`Self::finish`], it can be resumed.
#[derive(Debug)]
pub struct DatasetWriter {
    target: PathBuf,
    existing: Existing,
    run: DatasetRun,
    work: Unfinished,
    index: GrowingTable,
    /// The table of walkers, if any was described.
    walkers: Option<GrowingTable>,
    store: Store,
}

/// The destination of silhouettes and templates.
#[derive(Debug)]
enum Store {
    Arrays(Vec<GrowingArray>),
    Tree(GrowingSequences),
}

impl DatasetWriter {
    /// Begins a dataset that will become `target`, or resumes it after [`Self::done`] units.
    /// Creates the parent folder if needed; `target` itself is not touched yet.
    ///
    /// # Errors
    ///
    /// If `target` exists and must not be replaced ([`Existing`]), if unfinished work is there and
    /// `resume` is false or it belongs to another run, or if a file cannot be read or written.
    pub fn begin(
        target: impl AsRef<Path>,
        run: DatasetRun,
        existing: Existing,
        resume: bool,
    ) -> Result<Self> {
        let target = target_of(target.as_ref())?;
        check_replaceable(&target, run.format, existing)?;
        let work = Unfinished::begin(&target, run.stated()?, resume)?;
        let made = work.made();
        let known = |name: &str| work.journal.files.get(name).copied();
        let store = if run.format.is_tree() {
            let known = known(SEQUENCES);
            Store::Tree(GrowingSequences::open(
                &made,
                run.format,
                run.contents.size,
                known,
            )?)
        } else {
            let open = |array: super::contents::Array| {
                let known = known(&array.file());
                GrowingArray::open(&made, array, known)
            };
            let arrays = run.contents.arrays().into_iter().map(open);
            Store::Arrays(arrays.collect::<Result<_>>()?)
        };
        let columns = match run.is_recorded {
            true => &RECORDED_COLUMNS[..],
            false => COLUMNS,
        };
        let index = GrowingTable::open(&made, INDEX, columns, known(INDEX))?;
        let walkers = known(WALKERS)
            .map(|bytes| GrowingTable::open(&made, WALKERS, &WALKER_COLUMNS, Some(bytes)))
            .transpose()?;
        Ok(Self {
            target,
            existing,
            run,
            work,
            index,
            walkers,
            store,
        })
    }

    /// Returns the number of finished units of work.
    #[must_use]
    pub const fn done(&self) -> usize {
        self.work.journal.done
    }

    /// Returns the number of rows.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.work.journal.rows
    }

    /// Returns the number of frames of all rows.
    #[must_use]
    pub const fn frames(&self) -> usize {
        self.work.journal.frames
    }

    /// Returns the sum over all silhouettes of the share that lay outside the image.
    #[must_use]
    pub const fn clipped(&self) -> f64 {
        self.work.journal.clipped
    }

    /// Adds to [`Self::clipped`].
    pub fn clip(&mut self, share: f64) {
        self.work.journal.clipped += share;
    }

    /// Records that a person belongs to a split, such as `train`.
    pub fn belongs(&mut self, subject: &str, part: &str) {
        let people = self.work.journal.parts.entry(part.to_owned()).or_default();
        if people.last().is_none_or(|last| last != subject) {
            people.push(subject.to_owned());
        }
    }

    /// Appends a row.
    ///
    /// # Errors
    ///
    /// If the row is invalid (for example a speed below 0), an array has another size, or a file
    /// cannot be written.
    pub fn push(&mut self, item: Item<'_>) -> Result<()> {
        let Item { row, templates, .. } = item;
        let place = |problem: String| {
            let place = format!("row {}: {problem}", self.work.journal.rows);
            Error::input(&self.target, place)
        };
        if let Some(problem) = row.problem() {
            return Err(place(problem));
        }
        let all = templates.iter().map(Vec::as_slice);
        let joints = item.joints.into_iter().filter(|_| self.run.contents.joints);
        let all: Vec<&[u8]> = all.chain(joints).collect();
        let arrays = self.run.contents.arrays();
        if arrays.len() != all.len() {
            return Err(place(format!(
                "expected {} arrays, found {}",
                arrays.len(),
                all.len()
            )));
        }
        for (array, bytes) in arrays.iter().zip(&all) {
            let count = if array.is_of_frames {
                row.frames as usize
            } else {
                1
            };
            let expected = count * array.bytes();
            if bytes.len() != expected {
                return Err(place(format!(
                    "expected the {expected} bytes of {}, found {}",
                    array.name,
                    bytes.len()
                )));
            }
        }
        match &mut self.store {
            Store::Arrays(arrays) => {
                for (array, bytes) in arrays.iter_mut().zip(all) {
                    array
                        .push(bytes)
                        .map_err(|source| Error::io(&self.target, source))?;
                }
            }
            Store::Tree(sequences) => sequences.push(row, item.take, all[0])?,
        }
        self.index.push(row)?;
        self.work.journal.rows += 1;
        self.work.journal.frames += row.frames as usize;
        Ok(())
    }

    /// Appends the description of the person in one walk.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn describe(&mut self, row: &WalkerRow) -> Result<()> {
        self.walkers()?.push(row)
    }

    fn walkers(&mut self) -> Result<&mut GrowingTable> {
        Ok(match &mut self.walkers {
            Some(walkers) => walkers,
            none => none.insert(GrowingTable::open(
                &self.work.made(),
                WALKERS,
                &WALKER_COLUMNS,
                None,
            )?),
        })
    }

    /// Ends a unit of work.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn end_unit(&mut self) -> Result<()> {
        if let Store::Tree(sequences) = &mut self.store {
            sequences.write()?;
        }
        self.work.journal.done += 1;
        if self.work.is_due() {
            self.note()?;
        }
        Ok(())
    }

    /// Flushes all files and writes the journal.
    fn note(&mut self) -> Result<()> {
        let io = |source| Error::io(&self.target, source);
        let mut files = Vec::new();
        match &mut self.store {
            Store::Arrays(arrays) => {
                for array in arrays {
                    files.push((array.array.file(), array.flush().map_err(io)?));
                }
            }
            Store::Tree(sequences) => {
                let table = sequences.table();
                files.push((table.name().to_owned(), table.flush().map_err(io)?));
            }
        }
        for table in [Some(&mut self.index), self.walkers.as_mut()]
            .into_iter()
            .flatten()
        {
            files.push((table.name().to_owned(), table.flush().map_err(io)?));
        }
        self.work.journal.files = files.into_iter().collect();
        self.work.note()
    }

    /// Writes the manifest and renames the dataset to its target.
    ///
    /// # Errors
    ///
    /// If the number of finished units of work is not [`DatasetRun::units`], if `target` has
    /// appeared meanwhile and must not be replaced, or if a file cannot be written. Then `target`
    /// is unchanged.
    pub fn finish(mut self) -> Result<()> {
        let units = self.run.units;
        if self.done() != units {
            return Err(Error::input(
                &self.target,
                format!("expected {units} units of work, found {}", self.done()),
            ));
        }
        self.note()?;
        let Self {
            target,
            existing,
            run,
            work,
            walkers,
            store,
            ..
        } = self;
        let io = |source| Error::io(&target, source);
        let made = work.made();
        let mut names = Vec::new();
        match store {
            Store::Arrays(arrays) => {
                for array in arrays {
                    names.push(array.array.file());
                    array.close().map_err(io)?;
                }
            }
            Store::Tree(_) => {
                names.push(SEQUENCES.to_owned());
                if run.format == DatasetFormat::Opengait {
                    let of = |part| work.journal.parts.get(part).cloned().unwrap_or_default();
                    let partition = Partition {
                        test: of(TEST),
                        train: of(TRAIN),
                        ..Partition::default()
                    };
                    let text = partition.to_text()?;
                    fs::write(made.join(PARTITION), text).map_err(io)?;
                    names.push(PARTITION.to_owned());
                }
            }
        }
        names.push(INDEX.to_owned());
        names.extend(walkers.map(|_| WALKERS.to_owned()));
        let file = |name: String| -> Result<InputFile> {
            let sha256 = sha256_of_file(made.join(&name))?;
            Ok(InputFile { path: name, sha256 })
        };
        let files = names.iter().cloned().map(file).collect::<Result<_>>()?;
        let manifest = run.manifest(work.journal.rows, files);
        let mut json = serde_json::to_string_pretty(&manifest)?;
        json.push('\n');
        fs::write(made.join(MANIFEST), json).map_err(io)?;
        check_replaceable(&target, run.format, existing)?;
        if run.format == DatasetFormat::Npz {
            npz::write(&made, &names)?;
            return work.finish(Some(npz::FILE));
        }
        work.finish(None)
    }

    /// Appends the folder of a shard as one unit of work.
    ///
    /// # Errors
    /// If its files do not have the hashes and rows in its manifest, or a file cannot be read or
    /// written.
    pub(super) fn append(&mut self, shard: &Path, manifest: &Manifest) -> Result<()> {
        let checked =
            |name: &str| crate::dataset::checked_file::CheckedFile::open(shard, name, manifest);
        let expect_rows = |found: usize, name: &str| {
            let expected = manifest.geis;
            if found == expected {
                return Ok(());
            }
            let problem = format!(
                "expected {expected} rows, as {MANIFEST} says, found {found} (make the shard again)"
            );
            Err(Error::input(shard.join(name), problem))
        };
        match &mut self.store {
            Store::Arrays(arrays) => {
                for array in arrays {
                    let name = array.array.file();
                    let mut from = checked(&name)?;
                    from.skip_header()?;
                    let io = |source| Error::io(&self.target, source);
                    let mut length = 0;
                    from.copy(|bytes| {
                        length += bytes.len();
                        array.push(bytes).map_err(io)
                    })?;
                    if !array.array.is_of_frames {
                        expect_rows(length.div_ceil(array.array.bytes()), &name)?;
                    }
                }
            }
            Store::Tree(sequences) => {
                sequences.append(shard, manifest)?;
                let Partition { train, test, .. } =
                    crate::dataset::tree_writer::partition_of(shard, manifest)?;
                let parts = &mut self.work.journal.parts;
                for (part, people) in [(TRAIN, train), (TEST, test)] {
                    parts.entry(part.to_owned()).or_default().extend(people);
                }
            }
        }
        let mut from = checked(INDEX)?;
        from.skip_line()?;
        let (mut rows, mut is_quoted) = (0, false);
        from.copy(|bytes| {
            for byte in bytes {
                is_quoted ^= *byte == b'"';
                rows += usize::from(*byte == b'\n' && !is_quoted);
            }
            self.index.append(bytes)
        })?;
        expect_rows(rows, INDEX)?;
        if manifest.files.iter().any(|file| file.path == WALKERS) {
            let mut from = checked(WALKERS)?;
            from.skip_line()?;
            let walkers = self.walkers()?;
            from.copy(|bytes| walkers.append(bytes))?;
        }
        // Each row was there, so that the sum cannot overflow.
        self.work.journal.rows += rows;
        self.work.journal.done += 1;
        self.note()
    }
}

/// Returns the absolute path of the folder, with links resolved if it exists.
fn target_of(dir: &Path) -> Result<PathBuf> {
    if dir.exists() {
        return fs::canonicalize(dir).map_err(|source| Error::io(dir, source));
    }
    std::path::absolute(dir).map_err(|source| Error::io(dir, source))
}

/// The state of a target when a run is to be resumed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnfinishedRun {
    /// No dataset is at the target yet.
    Absent,
    /// The complete dataset of this run.
    Whole,
    /// A dataset of another run, and how it differs.
    Other(String),
}

/// Compares the manifest at a target with that of this run. Reads no other files.
///
/// # Errors
/// If the manifest cannot be read.
pub fn standing(target: &Path, run: &DatasetRun) -> Result<UnfinishedRun> {
    let path = target.join(MANIFEST);
    let found = match run.format {
        DatasetFormat::Npz if target.is_file() => npz::manifest(target)?,
        _ if path.is_file() => read_manifest(&path)?,
        _ => return Ok(UnfinishedRun::Absent),
    };
    let expected = run.manifest(found.geis, found.files.clone());
    let (found, expected) = (
        serde_json::to_value(found)?,
        serde_json::to_value(expected)?,
    );
    Ok(difference(&found, &expected).map_or(UnfinishedRun::Whole, UnfinishedRun::Other))
}

#[cfg(test)]
mod tests;

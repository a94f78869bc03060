//! Writes a dataset as its rows come, and leaves nothing half-written under its name.
//!
//! Everything is made in a folder beside the target, which is gone on with if the work is ended
//! before it is done, and renamed at the end. Memory does not grow with the number of rows.

use super::arrays::{Growing, GrowingTable};
use super::contents::{Contents, DatasetFormat, Shard};
use super::existing::{Existing, check_replaceable};
use super::index::{COLUMNS, WALKER_COLUMNS};
use super::partition::Partition;
use super::reader::read_manifest;
use super::sequences::{GrowingSequences, PARTITION, SEQUENCES};
use super::unfinished::{Unfinished, difference};
use super::{INDEX, IndexRow, MANIFEST, WALKERS, WalkerRow, npz};
use crate::dataset::{InputFile, Manifest, ResultHeader};
use crate::error::{Error, Result};
use crate::files::sha256_of_file;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// The names of the parts of people that a partition knows.
const TRAIN: &str = "train";
const TEST: &str = "test";

/// What is written: everything of which its bytes depend.
#[derive(Clone, Debug)]
pub struct DatasetRun {
    /// What makes it.
    pub header: ResultHeader,
    /// What it holds of each row.
    pub contents: Contents,
    /// How it is written.
    pub format: DatasetFormat,
    /// Pieces of work after which it can be gone on with.
    pub units: usize,
    /// Which part of the whole it is; none if it is the whole.
    pub shard: Option<Shard>,
}

impl DatasetRun {
    /// What another run must agree with to go on with this one.
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

    /// What the manifest says of so many rows in these files.
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

/// A row of the index with what belongs to it.
#[derive(Clone, Copy, Debug)]
pub struct Item<'a> {
    /// What it shows.
    pub row: &'a IndexRow,
    /// The recording that it is of: the name of a folder in trees.
    pub take: &'a str,
    /// The templates' bytes, images row by row from the top, in the order of
    /// [`Contents::templates`].
    pub templates: &'a [Vec<u8>],
    /// Where joints are, f32 `[frames][19][3]`, and where they appear, `[frames][19][2]`, if the
    /// dataset holds that.
    pub joints: [&'a [u8]; 2],
}

/// A dataset in the making. Dropped before [`Self::finish`] it waits to be gone on with.
#[derive(Debug)]
pub struct DatasetWriter {
    target: PathBuf,
    existing: Existing,
    run: DatasetRun,
    work: Unfinished,
    index: GrowingTable,
    /// Who walks, if anything was said of them.
    walkers: Option<GrowingTable>,
    store: Store,
}

/// Where silhouettes and templates go.
#[derive(Debug)]
enum Store {
    Arrays(Vec<Growing>),
    Tree(GrowingSequences),
}

impl DatasetWriter {
    /// Begins a dataset that will be `target`, or goes on with it: [`Self::done`] says where. The
    /// folder that holds it is made if need be; `target` itself is not touched yet.
    ///
    /// # Errors
    ///
    /// If `target` is there and must not be replaced ([`Existing`]), if unfinished work is there and
    /// `resume` is false or it is of another run, or the system's.
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
                Growing::open(&made, array, known)
            };
            let arrays = run.contents.arrays().into_iter().map(open);
            Store::Arrays(arrays.collect::<Result<_>>()?)
        };
        let index = GrowingTable::open(&made, INDEX, &COLUMNS, known(INDEX))?;
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

    /// How many pieces of work are done.
    #[must_use]
    pub const fn done(&self) -> usize {
        self.work.journal.done
    }

    /// How many rows there are.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.work.journal.rows
    }

    /// How many frames all rows have.
    #[must_use]
    pub const fn frames(&self) -> usize {
        self.work.journal.frames
    }

    /// Sum over all silhouettes of the share that lay outside of the image.
    #[must_use]
    pub const fn clipped(&self) -> f64 {
        self.work.journal.clipped
    }

    /// Adds to [`Self::clipped`].
    pub fn clip(&mut self, share: f64) {
        self.work.journal.clipped += share;
    }

    /// Says that a person belongs to a part of the people, such as `train`.
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
    /// If the row cannot be (a speed below 0, say), if something is of another size, or the
    /// system's.
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

    /// Says who walks in one walk.
    ///
    /// # Errors
    /// The system's.
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

    /// A piece of work is done.
    ///
    /// # Errors
    /// The system's.
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

    /// Gives everything to the system, and notes it.
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

    /// Writes the manifest and gives the dataset its name.
    ///
    /// # Errors
    ///
    /// If fewer pieces of work are done than [`DatasetRun::units`], if `target` has appeared
    /// meanwhile and must not be replaced, or the system's; then `target` is as before.
    pub fn finish(mut self) -> Result<()> {
        let units = self.run.units;
        if self.done() != units {
            return Err(Error::input(
                &self.target,
                format!("expected {units} pieces of work, found {}", self.done()),
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

    /// Appends a shard that is a folder of its own, as one piece of work.
    ///
    /// # Errors
    /// If its bytes are not those of which its manifest tells, or the system's.
    pub(super) fn append(&mut self, shard: &Path, manifest: &Manifest) -> Result<()> {
        let checked =
            |name: &str| crate::dataset::checked_file::CheckedFile::open(shard, name, manifest);
        match &mut self.store {
            Store::Arrays(arrays) => {
                for array in arrays {
                    let mut from = checked(&array.array.file())?;
                    from.skip_header()?;
                    let io = |source| Error::io(&self.target, source);
                    from.copy(|bytes| array.push(bytes).map_err(io))?;
                }
            }
            Store::Tree(sequences) => {
                sequences.append(shard, manifest)?;
                let Partition { train, test, .. } =
                    crate::dataset::sequences::partition_of(shard, manifest)?;
                let parts = &mut self.work.journal.parts;
                for (part, people) in [(TRAIN, train), (TEST, test)] {
                    parts.entry(part.to_owned()).or_default().extend(people);
                }
            }
        }
        let mut from = checked(INDEX)?;
        from.skip_line()?;
        from.copy(|bytes| self.index.append(bytes))?;
        if manifest.files.iter().any(|file| file.path == WALKERS) {
            let mut from = checked(WALKERS)?;
            from.skip_line()?;
            let walkers = self.walkers()?;
            from.copy(|bytes| walkers.append(bytes))?;
        }
        self.work.journal.rows += manifest.geis;
        self.work.journal.done += 1;
        self.note()
    }
}

/// The absolute path of the folder, through links if it is there.
fn target_of(dir: &Path) -> Result<PathBuf> {
    if dir.exists() {
        return fs::canonicalize(dir).map_err(|source| Error::io(dir, source));
    }
    std::path::absolute(dir).map_err(|source| Error::io(dir, source))
}

/// What is there of a run that was to be gone on with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnfinishedRun {
    /// No dataset has the name yet.
    Absent,
    /// All of it.
    Whole,
    /// Another run's dataset; how that differs, in words.
    Other(String),
}

/// What is there already of what this run would make. Files are not read, but what they say of
/// themselves.
///
/// # Errors
/// As reading a manifest.
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

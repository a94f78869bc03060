//! Writes a dataset as its templates come, and leaves nothing half-written behind.
//!
//! Everything is made in a hidden folder beside the target and renamed at the
//! end. Memory does not grow with their number.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::reader::read_manifest;
use super::staging::{Staging, folder_of, together};
use super::{INDEX, IndexRow, MANIFEST, WALKERS, WalkerRow, file_of};
use crate::dataset::{Header, InputFile, Manifest, sha256_of_file};
use crate::error::{ChoiceError, Error, Result};
use crate::template::{Shape, Template};
use edgegait_core::silhouette::Size;
use ndarray_npy::write_zeroed_npy;

/// What makes datasets: the commands that their manifests name.
const COMMANDS: [&str; 2] = ["sweep", "generate"];

/// What to do with a folder that is already there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Replace it if it is an earlier dataset of this program and holds nothing else.
    ReplaceOwn,
    /// Replace it if it is a dataset, whoever made it, and holds nothing else.
    Replace,
}

impl Existing {
    /// What may be replaced where `--overwrite` was given, or was not.
    #[must_use]
    pub const fn of(overwrite: bool) -> Self {
        if overwrite {
            Self::Replace
        } else {
            Self::ReplaceOwn
        }
    }
}

/// A dataset in the making. Dropped before [`Self::finish`] it leaves nothing.
#[derive(Debug)]
pub struct DatasetWriter {
    target: PathBuf,
    existing: Existing,
    staging: Staging,
    images: BufWriter<File>,
    index: csv::Writer<File>,
    /// Who walks, if anything was said of them.
    walkers: Option<csv::Writer<File>>,
    template: Template,
    size: Size,
    count: usize,
    written: usize,
}

impl DatasetWriter {
    /// Begins a dataset of `count` templates of silhouettes of this size that will be the folder `dir`. The folder
    /// that holds it is made if need be; `dir` itself is not touched yet.
    ///
    /// # Errors
    ///
    /// If `dir` is there and must not be replaced ([`Existing`]), or the system's.
    pub fn create(
        dir: impl AsRef<Path>,
        (template, size): (Template, Size),
        count: usize,
        existing: Existing,
    ) -> Result<Self> {
        let target = target_of(dir.as_ref())?;
        check_replaceable(&target, existing)?;
        let parent = folder_of(&target);
        fs::create_dir_all(&parent).map_err(|source| Error::io(&parent, source))?;
        let staging = Staging::beside(&target)?;
        let made = staging.path().join("made");
        fs::create_dir(&made).map_err(|source| Error::io(&made, source))?;

        let path = made.join(file_of(template));
        let file = File::create(&path).map_err(|source| Error::io(&path, source))?;
        if count
            .checked_mul(template.shape(size).numbers())
            .is_none_or(|bytes| i64::try_from(bytes).is_err())
        {
            return Err(Error::Usage(format!(
                "{count} {} are more than a file can hold",
                template.plural()
            )));
        }
        // Leaves the cursor at the first one.
        match template.shape(size) {
            Shape::Image {
                planes,
                rows,
                columns,
            } => write_zeroed_npy::<u8, _>(&file, (count, planes * rows, columns)),
            Shape::Vector(numbers) => write_zeroed_npy::<u8, _>(&file, (count, numbers)),
        }
        .map_err(|error| Error::input(&path, error.to_string()))?;
        let index_path = made.join(INDEX);
        let index = csv::Writer::from_path(&index_path).map_err(|e| csv_error(&index_path, e))?;
        Ok(Self {
            target,
            existing,
            staging,
            images: BufWriter::with_capacity(1 << 16, file),
            index,
            walkers: None,
            template,
            size,
            count,
            written: 0,
        })
    }

    /// Appends a template, row by row from the top, and what it shows.
    ///
    /// # Errors
    ///
    /// If the row cannot be (a speed below 0, say), if the template is of another size, if there are already as many
    /// as [`Self::create`] was told, or the system's.
    pub fn push(&mut self, bytes: &[u8], row: &IndexRow) -> Result<()> {
        let place = |problem: String| {
            let place = format!("{} {}: {problem}", self.name(), self.written);
            Error::input(&self.target, place)
        };
        if self.written == self.count {
            return Err(place(format!(
                "expected no more than {} {}",
                self.count,
                self.template.plural()
            )));
        }
        let numbers = self.template.shape(self.size).numbers();
        if bytes.len() != numbers {
            return Err(place(format!(
                "expected the {numbers} pixels of {}, found {}",
                self.size,
                bytes.len()
            )));
        }
        if let Some(problem) = row.problem() {
            return Err(place(problem));
        }
        self.images
            .write_all(bytes)
            .map_err(|source| Error::io(&self.target, source))?;
        self.index
            .serialize(row)
            .map_err(|error| csv_error(&self.target, error))?;
        self.written += 1;
        Ok(())
    }

    /// Says who walks in one walk.
    ///
    /// # Errors
    /// The system's.
    pub fn describe(&mut self, row: &WalkerRow) -> Result<()> {
        let error = |error| csv_error(&self.target, error);
        let walkers = match &mut self.walkers {
            Some(walkers) => walkers,
            none => {
                let path = self.staging.path().join("made").join(WALKERS);
                none.insert(csv::Writer::from_path(path).map_err(error)?)
            }
        };
        walkers.serialize(row).map_err(error)
    }

    /// What one of them is called.
    fn name(&self) -> &'static str {
        match self.template {
            Template::Gei => "GEI",
            other => other.name(),
        }
    }

    /// Writes the manifest and gives the folder its name.
    ///
    /// # Errors
    ///
    /// If fewer templates came than [`Self::create`] was told, if `dir` has appeared
    /// meanwhile and must not be replaced, or the system's; then `dir` is as before.
    pub fn finish(self, header: Header) -> Result<()> {
        let Self {
            target,
            existing,
            staging,
            images,
            index,
            walkers,
            template,
            count,
            written,
            ..
        } = self;
        if written != count {
            return Err(Error::input(
                &target,
                format!("expected {count} {}, found {written}", template.plural()),
            ));
        }
        let io = |source| Error::io(&target, source);
        images
            .into_inner()
            .map_err(|error| io(error.into_error()))?;
        close_index(index, written).map_err(|error| csv_error(&target, error))?;

        let has_walkers = walkers.is_some();
        if let Some(mut walkers) = walkers {
            walkers.flush().map_err(io)?;
        }
        let made = staging.path().join("made");
        let file = |name: &str| -> Result<InputFile> {
            Ok(InputFile {
                path: name.to_owned(),
                sha256: sha256_of_file(made.join(name))?,
            })
        };
        let manifest = Manifest {
            header,
            template,
            geis: count,
            files: [file_of(template), INDEX.to_owned()]
                .into_iter()
                .chain(has_walkers.then(|| WALKERS.to_owned()))
                .map(|name| file(&name))
                .collect::<Result<_>>()?,
        };
        let mut json = serde_json::to_string_pretty(&manifest)?;
        json.push('\n');
        fs::write(made.join(MANIFEST), json).map_err(io)?;

        check_replaceable(&target, existing)?;
        if target.is_dir() {
            let former = staging.path().join("former");
            // Between the two the former dataset lies where unfinished work does.
            return together(|| {
                fs::rename(&target, &former).map_err(io)?;
                if let Err(source) = fs::rename(&made, &target) {
                    fs::rename(&former, &target).map_err(io)?;
                    return Err(io(source));
                }
                Ok(())
            });
        }
        together(|| fs::rename(&made, &target)).map_err(io)
    }
}

/// Flushes the index; an empty one still has its column names.
fn close_index(
    mut index: csv::Writer<File>,
    written: usize,
) -> std::result::Result<(), csv::Error> {
    if written == 0 {
        index.write_record(super::index::COLUMNS)?;
    }
    Ok(index.flush()?)
}

/// The absolute path of the folder, through links if it is there.
fn target_of(dir: &Path) -> Result<PathBuf> {
    if dir.exists() {
        return fs::canonicalize(dir).map_err(|source| Error::io(dir, source));
    }
    std::path::absolute(dir).map_err(|source| Error::io(dir, source))
}

/// Refuses a folder that must not be replaced by a dataset.
///
/// # Errors
/// If `dir` is there and must not be replaced ([`Existing`]), or the system's.
pub fn check_replaceable(target: &Path, existing: Existing) -> Result<()> {
    if !target.exists() {
        return Ok(());
    }
    let refuse = |problem: String| Err(Error::Usage(format!("{}: {problem}", target.display())));
    if !target.is_dir() {
        return refuse("expected a folder or nothing, found a file (name another folder)".into());
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(target).map_err(|source| Error::io(target, source))? {
        names.push(
            entry
                .map_err(|source| Error::io(target, source))?
                .file_name(),
        );
    }
    if names.is_empty() {
        return Ok(());
    }
    names.sort();
    let images = Template::ALL.map(file_of);
    let files = images
        .iter()
        .map(String::as_str)
        .chain([INDEX, MANIFEST, WALKERS]);
    if let Some(other) = names
        .iter()
        .find(|name| !files.clone().any(|file| *name == file))
    {
        return refuse(format!(
            "holds {}, which is no part of a dataset (name another folder)",
            other.to_string_lossy()
        ));
    }
    if !names.iter().any(|name| name == MANIFEST) {
        return refuse(format!(
            "holds files but no {MANIFEST}, so it is no dataset (name another folder)"
        ));
    }
    let manifest = read_manifest(&target.join(MANIFEST))?;
    if existing == Existing::ReplaceOwn && !COMMANDS.contains(&manifest.header.command.as_str()) {
        return Err(ChoiceError::ForeignDataset(target.to_path_buf()).into());
    }
    Ok(())
}

fn csv_error(path: &Path, error: csv::Error) -> Error {
    let text = error.to_string();
    match error.into_kind() {
        csv::ErrorKind::Io(source) => Error::io(path, source),
        _ => Error::input(path, text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::Dataset;
    use edgegait_core::budget::PIXELS;

    fn row() -> IndexRow {
        IndexRow {
            subject: "s".into(),
            walk: "w".into(),
            cycle: 0,
            variation: 0,
            speed_kmh: 4.0,
            azimuth_deg: 90.0,
            elevation_deg: 0.0,
            condition: "normal".into(),
            alternative: String::new(),
            frames: 8,
            seed: 1,
        }
    }

    fn write(dir: &Path, shade: u8, existing: Existing) -> Result<()> {
        let mut writer = DatasetWriter::create(dir, (Template::Gei, Size::S50x30), 1, existing)?;
        writer.push(&[shade; PIXELS], &row())?;
        writer.finish(Header::new("sweep", 1))
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn a_dataset_that_is_not_finished_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = DatasetWriter::create(
            folder.path().join("d"),
            (Template::Gei, Size::S50x30),
            2,
            Existing::ReplaceOwn,
        )
        .unwrap();
        writer.push(&[1; PIXELS], &row()).unwrap();
        assert_eq!(names(folder.path()).len(), 1, "the hidden folder");
        let short = writer
            .finish(Header::new("sweep", 1))
            .unwrap_err()
            .to_string();
        assert!(short.ends_with("/d: expected 2 GEIs, found 1"), "{short}");
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn a_folder_with_files_is_kept_unless_it_is_a_dataset_to_replace() {
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path().join("d");
        fs::create_dir(&dir).unwrap();
        write(&dir, 1, Existing::ReplaceOwn).expect("an empty folder is no loss");
        write(&dir, 2, Existing::ReplaceOwn).expect("an earlier dataset of ours");
        let manifest = fs::read_to_string(dir.join(MANIFEST)).unwrap();
        let foreign = manifest.replace("\"sweep\"", "\"camera\"");
        fs::write(dir.join(MANIFEST), foreign).unwrap();
        let refused = write(&dir, 3, Existing::ReplaceOwn).unwrap_err();
        assert!(
            refused
                .to_string()
                .ends_with("a dataset that edgegait sweep did not make"),
            "{refused}"
        );
        assert_eq!(refused.exit_code(), 2);
        write(&dir, 2, Existing::Replace).unwrap();
        assert_eq!(Dataset::open(&dir).unwrap().bytes(0)[0], 2);

        fs::write(dir.join("thesis.tex"), "years").unwrap();
        let refused = write(&dir, 3, Existing::Replace).unwrap_err().to_string();
        assert!(
            refused.contains("holds thesis.tex, which is no part"),
            "{refused}"
        );
        assert_eq!(Dataset::open(&dir).unwrap().bytes(0)[0], 2);
        assert_eq!(names(folder.path()), ["d"]);

        fs::remove_file(dir.join("thesis.tex")).unwrap();
        fs::remove_file(dir.join(MANIFEST)).unwrap();
        let refused = write(&dir, 3, Existing::Replace).unwrap_err().to_string();
        assert!(
            refused.contains("no manifest.json, so it is no dataset"),
            "{refused}"
        );
    }

    #[test]
    fn a_file_where_the_folder_should_be_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d");
        fs::write(&path, "mine").unwrap();
        assert!(write(&path, 1, Existing::Replace).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"mine");
    }

    #[test]
    fn a_row_that_cannot_be_and_geis_of_another_size_or_too_many_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = DatasetWriter::create(
            folder.path().join("d"),
            (Template::Gei, Size::S64x44),
            1,
            Existing::ReplaceOwn,
        )
        .unwrap();
        let refused = writer.push(&[0; PIXELS], &row()).unwrap_err().to_string();
        assert!(
            refused.ends_with("GEI 0: expected the 2816 pixels of 64x44, found 1500"),
            "{refused}"
        );
        let bad = IndexRow { frames: 0, ..row() };
        let refused = writer.push(&[0; 64 * 44], &bad).unwrap_err().to_string();
        assert!(
            refused.ends_with("GEI 0: expected frames >= 1, found 0"),
            "{refused}"
        );
        writer.push(&[0; 64 * 44], &row()).unwrap();
        let refused = writer.push(&[0; 64 * 44], &row()).unwrap_err().to_string();
        assert!(
            refused.ends_with("GEI 1: expected no more than 1 GEIs"),
            "{refused}"
        );
    }

    #[test]
    fn two_runs_write_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        write(&a, 5, Existing::ReplaceOwn).unwrap();
        write(&b, 5, Existing::ReplaceOwn).unwrap();
        for name in ["geis.npy", INDEX, MANIFEST] {
            assert_eq!(
                fs::read(a.join(name)).unwrap(),
                fs::read(b.join(name)).unwrap()
            );
        }
    }

    #[test]
    fn an_empty_dataset_opens() {
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path().join("new/d");
        let writer =
            DatasetWriter::create(&dir, (Template::Gei, Size::S64x64), 0, Existing::ReplaceOwn)
                .unwrap();
        writer.finish(Header::new("sweep", 1)).unwrap();
        let dataset = Dataset::open(&dir).unwrap();
        assert_eq!(
            (dataset.templates().len(), dataset.size()),
            (0, Size::S64x64)
        );
    }
}

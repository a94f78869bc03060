//! Writes silhouettes in CASIA-B's layout: `<person>/<take>/<view>/`, a PNG for each frame.

use super::mask::Mask;
use crate::dataset::{check_folder_name, check_view_name};
use crate::error::{ChoiceError, Error, Result};
use crate::files::{Staging, grey_png};
use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the unfinished sequence in the staging folder.
const MADE: &str = "made";
/// Digits of a frame's number while the number of frames is unknown, and fewest digits at the end.
const STAGED_DIGITS: usize = 9;
const LEAST_DIGITS: usize = 3;

/// The names of a sequence's person, take and view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SequenceNames {
    person: String,
    take: String,
    view: String,
}

impl SequenceNames {
    /// Checks that all names can be folders' and that the view's states its azimuth, such as `090`
    /// and `090e15`.
    ///
    /// # Errors
    /// Names the invalid one.
    pub fn new(person: &str, take: &str, view: &str) -> Result<Self> {
        for name in [person, take, view] {
            check_folder_name(name)?;
        }
        check_view_name(view)?;
        Ok(Self {
            person: person.to_owned(),
            take: take.to_owned(),
            view: view.to_owned(),
        })
    }

    /// Returns the folder of the sequence in a tree.
    #[must_use]
    pub fn folder(&self, tree: &Path) -> PathBuf {
        tree.join(&self.person).join(&self.take).join(&self.view)
    }

    /// Returns the beginning of the names of all files of the sequence.
    fn start(&self) -> String {
        format!("{}-{}-{}-", self.person, self.take, self.view)
    }
}

/// Rejects a sequence that already exists, or, with `overwrite`, a folder that holds other files.
///
/// # Errors
/// Names the existing folder or file.
pub fn check_replaceable(tree: &Path, names: &SequenceNames, overwrite: bool) -> Result<()> {
    let folder = names.folder(tree);
    if !folder.exists() {
        return Ok(());
    }
    let io = |error| Error::io(&folder, error);
    let start = names.start();
    for entry in fs::read_dir(&folder).map_err(io)? {
        let name = entry.map_err(io)?.file_name();
        let text = name.to_string_lossy();
        if !(text.starts_with(&start) && text.ends_with(".png")) {
            return Err(Error::Usage(format!(
                "{}: holds {text}, which is not a silhouette {start}NNN.png (name another tree, person, take or view)",
                folder.display()
            )));
        }
        if !overwrite {
            return Err(ChoiceError::IsThere(folder).into());
        }
    }
    Ok(())
}

/// A sequence that is being written. Without [`SequenceWriter::finish`] nothing of it remains.
#[derive(Debug)]
pub struct SequenceWriter {
    staging: Staging,
    folder: PathBuf,
    start: String,
    frames: usize,
}

impl SequenceWriter {
    /// Begins a sequence in a hidden folder, beside the sequence's folder or the topmost folder
    /// above it that does not exist yet.
    ///
    /// # Errors
    /// If a folder cannot be created.
    pub fn new(tree: &Path, names: &SequenceNames) -> Result<Self> {
        let folder = names.folder(tree);
        let mut beside = std::path::absolute(&folder).map_err(|error| Error::io(&folder, error))?;
        while let Some(parent) = beside.parent().filter(|parent| !parent.exists()) {
            beside = parent.to_path_buf();
        }
        let staging = Staging::beside(&beside)?;
        let made = staging.path().join(MADE);
        fs::create_dir(&made).map_err(|error| Error::io(made, error))?;
        Ok(Self {
            staging,
            folder,
            start: names.start(),
            frames: 0,
        })
    }

    /// Appends the silhouettes of the next frames, on all cores.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn push(&mut self, masks: &[&Mask]) -> Result<()> {
        let made = self.staging.path().join(MADE);
        let first = self.frames;
        masks.par_iter().enumerate().try_for_each(|(at, mask)| {
            let path = made.join(format!("{:0STAGED_DIGITS$}.png", first + at + 1));
            fs::write(&path, grey_png(&mask.grey(), mask.columns())?)
                .map_err(|error| Error::io(path, error))
        })?;
        self.frames += masks.len();
        Ok(())
    }

    /// Numbers the frames from 001 on, with more digits if necessary, moves the folder to its place
    /// and returns its path.
    ///
    /// # Errors
    /// If a file cannot be renamed; then nothing has changed.
    pub fn finish(self) -> Result<PathBuf> {
        let made = self.staging.path().join(MADE);
        let digits = self.frames.to_string().len().max(LEAST_DIGITS);
        for number in 1..=self.frames {
            let from = made.join(format!("{number:0STAGED_DIGITS$}.png"));
            let to = made.join(format!("{}{number:0digits$}.png", self.start));
            fs::rename(&from, to).map_err(|error| Error::io(&from, error))?;
        }
        self.staging.place(MADE, &self.folder)?;
        Ok(self.folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> SequenceNames {
        SequenceNames::new("001", "nm-01", "090").unwrap()
    }

    fn listed(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_sequence_is_there_whole_or_not_at_all() {
        let place = tempfile::tempdir().unwrap();
        let tree = place.path().join("new/tree");
        let mask = Mask::new(2, vec![true, false, false, true]);
        let mut writer = SequenceWriter::new(&tree, &names()).unwrap();
        writer.push(&[&mask, &mask]).unwrap();
        drop(writer);
        assert!(listed(place.path()).is_empty());

        let mut writer = SequenceWriter::new(&tree, &names()).unwrap();
        writer.push(&[&mask]).unwrap();
        writer.push(&vec![&mask; 999]).unwrap();
        let folder = writer.finish().unwrap();
        assert_eq!(folder, tree.join("001/nm-01/090"));
        let found = listed(&folder);
        let shown = [found[0].as_str(), found[999].as_str()];
        assert_eq!(shown, ["001-nm-01-090-0001.png", "001-nm-01-090-1000.png"]);
        let picture = image::open(folder.join(shown[0])).unwrap();
        assert_eq!(picture.into_luma8().into_raw(), [255, 0, 0, 255]);
        assert_eq!(listed(place.path()), ["new"]);
    }

    #[test]
    fn another_sequence_is_replaced_only_if_asked_and_nothing_else_ever() {
        let place = tempfile::tempdir().unwrap();
        let check = |overwrite| check_replaceable(place.path(), &names(), overwrite);
        check(false).unwrap();
        let folder = names().folder(place.path());
        fs::create_dir_all(&folder).unwrap();
        check(false).unwrap();
        fs::write(folder.join("001-nm-01-090-001.png"), "").unwrap();
        let error = check(false).unwrap_err().to_string();
        assert!(error.ends_with("001/nm-01/090: already exists"), "{error}");
        check(true).unwrap();
        fs::write(folder.join("notes.txt"), "").unwrap();
        let error = check(true).unwrap_err().to_string();
        assert!(error.contains("holds notes.txt"), "{error}");
    }

    #[test]
    fn names_are_those_of_folders_and_views_are_angles() {
        for (person, take, view, expected) in [
            ("", "nm-01", "090", "\"\""),
            ("..", "nm-01", "090", "\"..\""),
            ("001", "a/b", "090", "\"a/b\""),
            ("001", "nm-01", "left", "\"left\""),
        ] {
            let error = SequenceNames::new(person, take, view)
                .unwrap_err()
                .to_string();
            assert!(error.contains(expected), "{error}");
        }
        SequenceNames::new("Anna", "bg-02", "090e15").unwrap();
    }
}

//! Packs from files, the built-in cohort, and the selection of people and walks.

use super::cohort::stored;
use crate::encode::{MAX_ERROR_MM, encode_subjects};
use crate::error::{ChoiceError, Error, FilePlace, Result};
use crate::files::{InputFile, sha256_of_bytes};
use crate::people::cohort::{self, CohortOptions};
use edgegait_core::budget::MAX_PACK_BYTES;
use edgegait_core::format::MAGIC;
use edgegait_core::pack::Pack;
use std::path::Path;

/// The default walk of the built-in cohort, and its speed in km/h.
pub(crate) const BUILT_IN_WALK: &str = "walk-5kmh";
const BUILT_IN_KMH: f64 = 5.0;

/// A pack's bytes and their source.
#[derive(Clone, Debug)]
pub struct PackSource {
    /// The bytes of the pack.
    pub bytes: Vec<u8>,
    /// The pack's file, for results; empty for the built-in cohort.
    pub inputs: Vec<InputFile>,
    /// The pack's name in results.
    pub name: String,
}

/// A selection of people and walks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// The names of the people; an empty list selects all.
    pub subjects: Vec<String>,
    /// The names of the walks; an empty list selects all.
    pub walks: Vec<String>,
}

impl Selection {
    /// Returns the numbers of the selected walks, in pack order.
    ///
    /// # Errors
    /// If a name is unknown, or nothing is selected.
    pub fn selected_walks(&self, pack: &Pack<'_>) -> Result<Vec<usize>> {
        let subjects: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
        let walks: Vec<&str> = pack.walks().map(|walk| walk.name).collect();
        require("subject", &self.subjects, &subjects)?;
        require("walk", &self.walks, &walks)?;
        let numbers = pack.walks().enumerate();
        let chosen: Vec<usize> = numbers
            .filter(|(_, walk)| self.has(subjects[walk.subject], walk.name))
            .map(|(index, _)| index)
            .collect();
        if chosen.is_empty() {
            return Err(ChoiceError::NothingChosen.into());
        }
        Ok(chosen)
    }

    /// Returns whether this walk of this person is selected.
    #[must_use]
    pub fn has(&self, subject: &str, walk: &str) -> bool {
        let wanted = |list: &[String], name: &str| {
            list.is_empty() || list.iter().any(|listed| listed == name)
        };
        wanted(&self.subjects, subject) && wanted(&self.walks, walk)
    }
}

/// Checks that all names are known.
///
/// # Errors
/// If a name is unknown; the error lists some known names.
pub(crate) fn require(what: &'static str, asked: &[String], known: &[&str]) -> Result<()> {
    for name in asked {
        if !known.contains(&name.as_str()) {
            let mut some: Vec<String> = Vec::new();
            for &name in known {
                if some.len() < 12 && some.iter().all(|listed| listed != name) {
                    some.push(name.to_owned());
                }
            }
            let name = name.clone();
            return Err(ChoiceError::Unknown {
                what,
                name,
                known: some,
            }
            .into());
        }
    }
    Ok(())
}

impl PackSource {
    /// Reads and checks a pack file.
    ///
    /// # Errors
    /// If the file cannot be read, is larger than a pack may be, or is not a pack.
    pub fn read(path: &Path) -> Result<Self> {
        let length = std::fs::metadata(path)
            .map_err(|error| Error::io(path, error))?
            .len();
        start_of(path)?;
        if length > MAX_PACK_BYTES as u64 {
            return Err(Error::input(
                path,
                format!("{length} bytes, expected a pack of at most {MAX_PACK_BYTES}"),
            ));
        }
        let bytes = crate::files::read(path)?;
        Pack::parse(&bytes).map_err(|error| {
            let problem = format!("expected {}", error.expected);
            Error::at(path, FilePlace::Byte(error.byte), problem)
        })?;
        let name = path.display().to_string();
        // The hash of the bytes that were read, since the file may have changed.
        let input = InputFile {
            path: name.clone(),
            sha256: sha256_of_bytes(&bytes),
        };
        Ok(Self {
            bytes,
            inputs: vec![input],
            name,
        })
    }

    /// Returns the people of these options as a pack, which is encoded unless it is stored;
    /// `progress` is called as by [`encode_subjects`]. The pack is named built-in cohort only if
    /// number of people and seed are the defaults.
    ///
    /// # Errors
    /// The errors of [`cohort::subjects`] and [`encode_subjects`].
    pub fn made(
        options: &CohortOptions,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Self> {
        let bytes = match stored(options) {
            Some(bytes) => bytes.to_vec(),
            None => encode_subjects(&cohort::subjects(options)?, MAX_ERROR_MM, progress)?,
        };
        let usual = CohortOptions::default();
        let name = if *options == CohortOptions::unseen() {
            "synthetic people whom no shipped model has seen".to_owned()
        } else if (options.people, options.seed) == (usual.people, usual.seed) {
            "built-in cohort".to_owned()
        } else {
            format!("cohort of {}, seed {}", options.people, options.seed)
        };
        Ok(Self {
            bytes,
            inputs: Vec::new(),
            name,
        })
    }
}

/// Returns the options of the built-in cohort: with its usual walk alone, if that is the only one
/// that is wanted, or else with all walks and sessions. Both are stored.
#[must_use]
pub(crate) fn built_in(walks: &[String]) -> CohortOptions {
    if walks == [BUILT_IN_WALK] {
        CohortOptions {
            speeds_kmh: vec![BUILT_IN_KMH],
            ..CohortOptions::default()
        }
    } else {
        CohortOptions::built_in()
    }
}

/// Reads as many bytes from a file's start as a pack's magic has. An .npz file is an error.
fn start_of(path: &Path) -> Result<Vec<u8>> {
    use std::io::Read as _;
    let mut start = Vec::new();
    let mut file = crate::files::open(path)?.take(MAGIC.len() as u64);
    let read = file.read_to_end(&mut start);
    read.map_err(|error| Error::io(path, error))?;
    if start.starts_with(b"PK") {
        return Err(Error::input(
            path,
            "expected a model, a pack or a folder, found an .npz or .zip (datasets are read as folders)",
        ));
    }
    Ok(start)
}

/// Returns whether a path is a pack or a folder (a dataset, a tree of silhouettes), not a model.
///
/// # Errors
/// If the path cannot be read.
pub(crate) fn is_pack_or_folder(path: &Path) -> Result<bool> {
    let metadata = std::fs::metadata(path).map_err(|error| Error::io(path, error))?;
    if metadata.is_dir() {
        return Ok(true);
    }
    let start = start_of(path)?;
    // A damaged pack is none, but not a model either.
    let is_called_pack = path
        .extension()
        .is_some_and(|found| found.eq_ignore_ascii_case("egp"));
    if start.is_empty() && !is_called_pack {
        return Err(Error::input(
            path,
            "expected a model, a pack or a folder, found an empty file",
        ));
    }
    Ok(is_called_pack || start == MAGIC)
}

//! Where walks come from: a pack file, or the built-in cohort.

use super::progress::Progress;
use crate::dataset::{InputFile, sha256_of_bytes};
use crate::encode::{MAX_ERROR_MM, encode_subjects};
use crate::error::{Error, Result};
use crate::scene::cohort::{self, CohortOptions, SPEEDS_KMH};
use edgegait_core::budget::MAX_PACK_BYTES;
use edgegait_core::format::MAGIC;
use edgegait_core::pack::Pack;
use std::path::{Path, PathBuf};

/// Which walks to use.
#[derive(Clone, Debug, clap::Args)]
pub struct SourceArgs {
    /// A pack [default: the built-in cohort of 26 people]
    #[arg(value_name = "PACK")]
    pub pack: Option<PathBuf>,
    /// Only these people, by name
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    pub subjects: Vec<String>,
    /// Only these walks, by name [default: walk-5kmh of the built-in cohort, all of a pack; `render`
    /// without names: the first]
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    pub walks: Vec<String>,
}

/// A pack's bytes and where they are from.
#[derive(Clone, Debug)]
pub struct Source {
    /// The pack.
    pub bytes: Vec<u8>,
    /// Its file, for results; empty for the built-in cohort.
    pub inputs: Vec<InputFile>,
    /// What it is called in results.
    pub name: String,
}

/// The walk of the built-in cohort that is used when none is named.
const DEFAULT_WALK: &str = "walk-5kmh";

impl SourceArgs {
    /// Reads the pack, or makes the built-in cohort at the speeds that are needed.
    ///
    /// # Errors
    /// When the file cannot be read or is no pack.
    pub fn load(&self) -> Result<Source> {
        match &self.pack {
            Some(path) => read_pack(path),
            None => built_in(&self.walk_names()),
        }
    }

    fn walk_names(&self) -> Vec<String> {
        if self.walks.is_empty() && self.pack.is_none() {
            return vec![DEFAULT_WALK.into()];
        }
        self.walks.clone()
    }

    /// The numbers of the chosen walks, in pack order.
    ///
    /// # Errors
    /// When a name is unknown.
    pub fn choose(&self, pack: &Pack<'_>) -> Result<Vec<usize>> {
        let subjects: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
        let walks: Vec<&str> = pack.walks().map(|walk| walk.name).collect();
        require("subject", &self.subjects, &subjects)?;
        let names = self.walk_names();
        require("walk", &names, &walks)?;
        let wanted =
            |list: &[String], name: &str| list.is_empty() || list.iter().any(|n| n == name);
        let chosen: Vec<usize> = pack
            .walks()
            .enumerate()
            .filter(|(_, walk)| {
                wanted(&self.subjects, subjects[walk.subject]) && wanted(&names, walk.name)
            })
            .map(|(index, _)| index)
            .collect();
        if chosen.is_empty() {
            return Err(Error::Usage(
                "no walk of the chosen people has the chosen name".into(),
            ));
        }
        Ok(chosen)
    }
}

/// Refuses names that are not there.
pub fn require(what: &str, asked: &[String], known: &[&str]) -> Result<()> {
    for name in asked {
        if !known.contains(&name.as_str()) {
            let mut some: Vec<&str> = Vec::new();
            for name in known {
                if !some.contains(name) && some.len() < 12 {
                    some.push(name);
                }
            }
            return Err(Error::Usage(format!(
                "there is no {what} {name:?}: expected one of {}",
                some.join(", ")
            )));
        }
    }
    Ok(())
}

/// Reads and checks a pack file.
///
/// # Errors
/// When the file cannot be read, is larger than a pack may be, or is no pack.
pub fn read_pack(path: &Path) -> Result<Source> {
    let length = std::fs::metadata(path)
        .map_err(|error| Error::io(path, error))?
        .len();
    if length > MAX_PACK_BYTES as u64 {
        return Err(Error::input(
            path,
            format!("{length} bytes, expected a pack of at most {MAX_PACK_BYTES}"),
        ));
    }
    let bytes = std::fs::read(path).map_err(|error| Error::io(path, error))?;
    check(path, &bytes)?;
    let name = path.display().to_string();
    // Of the bytes that were read: the file may be another by now.
    let input = InputFile {
        path: name.clone(),
        sha256: sha256_of_bytes(&bytes),
    };
    Ok(Source {
        bytes,
        inputs: vec![input],
        name,
    })
}

/// Refuses bytes that are not a pack, naming the byte.
fn check(path: &Path, bytes: &[u8]) -> Result<()> {
    Pack::parse(bytes).map(|_| ()).map_err(|error| {
        Error::at(
            path,
            crate::error::Place::Byte(error.byte),
            format!("expected {}", error.expected),
        )
    })
}

/// The built-in cohort at the speeds that `walks` name; at all speeds for no names.
fn built_in(walks: &[String]) -> Result<Source> {
    let speeds_kmh: Vec<f64> = SPEEDS_KMH
        .into_iter()
        .filter(|speed| {
            let name = |verb: &str| format!("{verb}-{speed}kmh");
            walks.is_empty() || walks.contains(&name("walk")) || walks.contains(&name("run"))
        })
        .collect();
    let options = CohortOptions {
        // No speed matches a name: all of them, so that the error can list the names.
        speeds_kmh: if speeds_kmh.is_empty() {
            SPEEDS_KMH.to_vec()
        } else {
            speeds_kmh
        },
        ..CohortOptions::default()
    };
    let progress = Progress::new("cohort", options.people * options.speeds_kmh.len());
    let subjects = cohort::subjects(&options)?;
    let bytes = encode_subjects(&subjects, MAX_ERROR_MM, &|| progress.step())?;
    Ok(Source {
        bytes,
        inputs: Vec::new(),
        name: "built-in cohort".into(),
    })
}

/// Whether a path is a pack or a folder (a dataset, a tree of silhouettes), as opposed to a model.
///
/// # Errors
/// When it cannot be read.
pub fn is_pack_or_folder(path: &Path) -> Result<bool> {
    use std::io::Read as _;
    let metadata = std::fs::metadata(path).map_err(|error| Error::io(path, error))?;
    if metadata.is_dir() {
        return Ok(true);
    }
    let mut start = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(MAGIC.len() as u64).read_to_end(&mut start))
        .map_err(|error| Error::io(path, error))?;
    Ok(start == MAGIC)
}

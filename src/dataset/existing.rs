//! Decides whether a dataset may replace what is at its target.

use std::fs;
use std::path::Path;

use super::contents::{DatasetFormat, name_of};
use super::manifest::read_manifest;
use super::{INDEX, MANIFEST, Manifest, WALKERS, npz, tree_writer};
use crate::draw::template::Template;
use crate::error::{ChoiceError, Error, Result};

/// The commands that make datasets, as manifests name them.
const COMMANDS: [&str; 2] = ["sweep", "generate"];

/// The rule for replacing an existing folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Replace it if it is an earlier dataset of this program and holds nothing else.
    ReplaceOwn,
    /// Replace it if it is a dataset of any program and holds nothing else.
    Replace,
}

impl Existing {
    /// Returns the rule with or without `--overwrite`.
    #[must_use]
    pub const fn from_overwrite(overwrite: bool) -> Self {
        if overwrite {
            Self::Replace
        } else {
            Self::ReplaceOwn
        }
    }
}

/// Returns whether this program made a dataset.
fn is_own(manifest: &Manifest) -> bool {
    COMMANDS.contains(&manifest.header.command.as_str())
}

/// Checks that a dataset of this format may replace `target`.
///
/// # Errors
/// If `target` exists and must not be replaced ([`Existing`]), or cannot be read.
pub fn check_replaceable(target: &Path, format: DatasetFormat, existing: Existing) -> Result<()> {
    let refuse = |problem: String| Err(Error::Usage(format!("{}: {problem}", target.display())));
    if !target.exists() {
        if target.is_symlink() {
            return refuse(
                "expected a folder, a file or nothing, found a link to nothing (remove it)".into(),
            );
        }
        return Ok(());
    }
    if format == DatasetFormat::Npz {
        let is_own = || npz::manifest(target).is_ok_and(|found| is_own(&found));
        return match (target.is_file(), existing) {
            (true, Existing::Replace) => Ok(()),
            (true, Existing::ReplaceOwn) if is_own() => Ok(()),
            (true, Existing::ReplaceOwn) => Err(ChoiceError::IsThere(target.to_path_buf()).into()),
            (false, _) => refuse("expected a file to write, found a folder".into()),
        };
    }
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
    let has_manifest = names.iter().any(|name| name == MANIFEST);
    let manifest = if has_manifest {
        Some(read_manifest(&target.join(MANIFEST))?)
    } else {
        None
    };
    if let Some(tree) = manifest.as_ref().filter(|found| found.format.is_tree()) {
        if let Some(other) = tree_writer::foreign(target)? {
            return refuse(format!(
                "holds {}, which is not part of a dataset (name another folder)",
                other.display()
            ));
        }
        return match existing {
            Existing::ReplaceOwn if !is_own(tree) => {
                Err(ChoiceError::ForeignDataset(target.to_path_buf()).into())
            }
            _ => Ok(()),
        };
    }
    let arrays = Template::ALL.map(name_of);
    let arrays = arrays.iter().chain(&["joints", "keypoints"]);
    let arrays: Vec<String> = arrays.map(|name| format!("{name}.npy")).collect();
    let files = arrays
        .iter()
        .map(String::as_str)
        .chain([INDEX, MANIFEST, WALKERS]);
    if let Some(other) = names
        .iter()
        .find(|name| !files.clone().any(|file| *name == file))
    {
        return refuse(format!(
            "holds {}, which is not part of a dataset (name another folder)",
            other.to_string_lossy()
        ));
    }
    let Some(manifest) = manifest else {
        return refuse(format!(
            "holds files but no {MANIFEST}, so it is not a dataset (name another folder)"
        ));
    };
    if existing == Existing::ReplaceOwn && !is_own(&manifest) {
        return Err(ChoiceError::ForeignDataset(target.to_path_buf()).into());
    }
    Ok(())
}

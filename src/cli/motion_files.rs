//! The motion files that folders stand for.

use crate::error::{Error, Result};
use crate::import::EXTENSIONS;
use std::path::PathBuf;

/// Lists the files to import. A folder stands for all files of known formats in it and its
/// subfolders, in order of names. Links to folders are not followed.
pub(super) fn expand(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let before = files.len();
        let mut folders = vec![path.clone()];
        while let Some(folder) = folders.pop() {
            let entries = std::fs::read_dir(&folder).map_err(|error| Error::io(&folder, error))?;
            for entry in entries {
                let entry = entry.map_err(|error| Error::io(&folder, error))?;
                let kind = entry
                    .file_type()
                    .map_err(|error| Error::io(entry.path(), error))?;
                let extension = entry
                    .path()
                    .extension()
                    .unwrap_or_default()
                    .to_ascii_lowercase();
                if kind.is_dir() {
                    folders.push(entry.path());
                } else if EXTENSIONS.iter().any(|known| extension == *known) {
                    files.push(entry.path());
                }
            }
        }
        if files.len() == before {
            return Err(Error::input(
                path,
                format!(
                    "no .{} file in this folder or its subfolders",
                    EXTENSIONS.join(", .")
                ),
            ));
        }
        files[before..].sort();
    }
    Ok(files)
}

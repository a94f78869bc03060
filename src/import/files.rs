//! Opens files, and reads whole ones in bounded memory.

use std::fs::File;
use std::io::{Error, ErrorKind, Read as _, Result};
use std::path::Path;

/// Largest size of a file, bytes. Our choice: a character with its textures has 100 MB.
pub(super) const MAX_BYTES: u64 = 200 << 20;

/// Opens a regular file.
pub(super) fn open_file(path: &Path) -> Result<File> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() {
        return File::open(path);
    }
    let found = if kind.is_dir() { "a folder" } else { "none" };
    let problem = format!("expected a regular file, found {found}");
    Err(Error::new(ErrorKind::InvalidData, problem))
}

/// Reads a whole regular file that is not too large.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>> {
    let file = open_file(path)?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        let problem = format!("expected at most {} MB, found more", MAX_BYTES >> 20);
        return Err(Error::new(ErrorKind::InvalidData, problem));
    }
    Ok(bytes)
}

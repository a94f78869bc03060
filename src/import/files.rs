//! Reads whole files in bounded memory.

use crate::error::{Error, Result};
use std::io::Read as _;
use std::path::Path;

/// Largest size of a file, bytes. Our choice: a character with its textures has 100 MB.
pub(super) const MAX_BYTES: u64 = 200 << 20;

/// Reads a whole regular file that is not too large.
///
/// # Errors
/// If it is larger, or cannot be read.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = crate::files::open(path)?
        .take(MAX_BYTES + 1)
        .read_to_end(&mut bytes);
    read.map_err(|error| Error::io(path, error))?;
    if bytes.len() as u64 > MAX_BYTES {
        let problem = format!("expected at most {} MB, found more", MAX_BYTES >> 20);
        return Err(Error::input(path, problem));
    }
    Ok(bytes)
}

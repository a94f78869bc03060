//! Reads whole files in bounded memory.

use std::io::{Error, ErrorKind, Read as _, Result};
use std::path::Path;

/// Largest size of a file, bytes. Our choice: a character with its textures has 100 MB.
pub(super) const MAX_BYTES: u64 = 200 << 20;

/// Reads a whole regular file that is not too large.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>> {
    let invalid = |problem: String| Error::new(ErrorKind::InvalidData, problem);
    let file = std::fs::File::open(path)?;
    if !file.metadata()?.is_file() {
        return Err(invalid("expected a file".into()));
    }
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(invalid(format!(
            "expected at most {} MB, found more",
            MAX_BYTES >> 20
        )));
    }
    Ok(bytes)
}

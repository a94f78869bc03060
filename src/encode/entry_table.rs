//! Tables of entries of different lengths, preceded by their ends.

use crate::error::{EncodeError, Result};

/// Writes entries after a table of their ends.
pub(super) fn table(entries: &[Vec<u8>]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    bytes.extend(narrow::<u32>(entries.len())?.to_le_bytes());
    let mut end = 0;
    for entry in entries {
        end += entry.len();
        bytes.extend(narrow::<u32>(end)?.to_le_bytes());
    }
    bytes.extend(entries.iter().flatten());
    Ok(bytes)
}

/// Converts a number to the type of a field in the format.
pub(super) fn narrow<T: TryFrom<usize>>(value: usize) -> Result<T> {
    T::try_from(value).map_err(|_| EncodeError::PackTooLarge(value).into())
}

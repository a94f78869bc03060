//! Entries of different lengths behind a table of their ends.

use crate::error::{EncodeError, Result};

/// Entries behind a table of their ends.
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

/// A number that must fit the format's field.
pub(super) fn narrow<T: TryFrom<usize>>(value: usize) -> Result<T> {
    T::try_from(value).map_err(|_| EncodeError::PackTooLarge(value).into())
}

//! Tables of entries of different lengths, which begin with the entries' ends.

use crate::budget::MAX_ENTRIES;
use crate::format::{END_BYTES, FormatError, u32_at};

/// Entries of different lengths, after a table of their ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EntryTable<'a> {
    ends: &'a [u8],
    body: &'a [u8],
}

impl<'a> EntryTable<'a> {
    /// A table without entries.
    pub(crate) const EMPTY: Self = Self {
        ends: &[],
        body: &[],
    };

    /// Reads the number of entries `u32`, then an end for each, counted from the first entry's
    /// start; then the entries.
    pub(crate) fn parse(section: &'a [u8]) -> Result<Self, FormatError> {
        let count = u32_at(section, 0) as usize;
        if section.len() < END_BYTES || count > MAX_ENTRIES {
            return Err(FormatError::new(0, "the number of entries, at most 65535"));
        }
        let ends_end = END_BYTES * (1 + count);
        let (Some(ends), Some(body)) = (section.get(END_BYTES..ends_end), section.get(ends_end..))
        else {
            return Err(FormatError::new(
                section.len(),
                "the rest of a table of ends",
            ));
        };
        let mut before = 0;
        for (index, end) in ends.chunks_exact(END_BYTES).enumerate() {
            let end = u32_at(end, 0) as usize;
            if end < before || end > body.len() {
                return Err(FormatError::new(
                    END_BYTES * (1 + index),
                    "ends in rising order within the section",
                ));
            }
            before = end;
        }
        if before != body.len() {
            return Err(FormatError::new(
                ends_end + before,
                "the end of the section after its last entry",
            ));
        }
        Ok(Self { ends, body })
    }

    pub(crate) fn len(&self) -> usize {
        self.ends.len() / END_BYTES
    }

    /// Returns where an entry begins in the section, and the entry.
    pub(crate) fn entry(&self, index: usize) -> Option<(usize, &'a [u8])> {
        let end_at = |index: usize| -> Option<usize> {
            let at = index.checked_mul(END_BYTES)?;
            self.ends.get(at..at + END_BYTES)?;
            Some(u32_at(self.ends, at) as usize)
        };
        let end = end_at(index)?;
        let start = match index.checked_sub(1) {
            Some(before) => end_at(before)?,
            None => 0,
        };
        let at = END_BYTES + self.ends.len() + start;
        Some((at, self.body.get(start..end)?))
    }

    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, &'a [u8])> + use<'_, 'a> {
        (0..self.len()).filter_map(|index| self.entry(index))
    }
}

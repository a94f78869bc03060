//! Sizes in bytes that are the same in every run.

use super::heap::rows_heap_bytes;
use edgegait::encode::{MAX_ERROR_MM, encode_subjects};
use edgegait::error::{Error, Result};
use edgegait::people::cohort::{CohortOptions, subjects};
use edgegait_core::budget::SKIA_HEAP_BYTES;
use edgegait_core::compact::Budget;
use serde::Deserialize;

/// A size in bytes, computed from the library in each run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Figure {
    /// The bound on the heap for drawing with tiny-skia.
    SkiaHeap,
    /// The heap that drawing with bit rows uses.
    RowsHeap,
    /// The total size of the types that are needed to make a GEI with bit rows, one of each.
    GeiTypes,
    /// The pack of the built-in cohort, encoded within 5 mm: 26 people at 10 speeds, with their
    /// bodies.
    StudyPack,
}

impl Figure {
    /// Returns the size. Encoding the pack takes about 13 s on one core, everything else no time.
    pub fn bytes(self) -> Result<u32> {
        let bytes = match self {
            Self::SkiaHeap => SKIA_HEAP_BYTES,
            Self::RowsHeap => rows_heap_bytes()?,
            Self::GeiTypes => Budget::UNPACKED_BYTES,
            Self::StudyPack => {
                let people = subjects(&CohortOptions::default())?;
                encode_subjects(&people, MAX_ERROR_MM, &|| {})?.len()
            }
        };
        u32::try_from(bytes).map_err(|_| {
            Error::Failed(format!(
                "{self:?}: expected less than 4 GiB, found {bytes} bytes"
            ))
        })
    }
}

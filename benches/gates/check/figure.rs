//! Numbers of bytes that do not vary from run to run.

use super::heap::rows_heap_bytes;
use edgegait::encode::{MAX_ERROR_MM, encode_subjects};
use edgegait::error::{Error, Result};
use edgegait::people::cohort::{CohortOptions, subjects};
use edgegait_core::budget::SKIA_HEAP_BYTES;
use edgegait_core::lean::Budget;
use serde::Deserialize;

/// A number of bytes, made from the library each time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Figure {
    /// Heap bound of drawing with tiny-skia.
    SkiaHeap,
    /// What drawing with bit rows asks of the heap.
    RowsHeap,
    /// One of each type that making a GEI with bit rows holds, where they stand.
    GeiTypes,
    /// The built-in study, encoded within 5 mm: 26 people at 10 speeds, and their bodies.
    StudyPack,
}

impl Figure {
    /// The number. The pack takes about 13 s on one core, everything else nothing.
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

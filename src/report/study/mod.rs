//! What a study found: a page, figures, and tables for a terminal.

mod tables;

pub(crate) use tables::study_tables;

use crate::dataset::Header;
use crate::error::Result;
use crate::study::Findings;
use std::path::Path;

/// Writes the page.
pub(crate) fn write_study(_folder: &Path, _header: &Header, _findings: &Findings) -> Result<()> {
    Ok(())
}

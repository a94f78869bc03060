//! What a study found: a page, figures, and tables for a terminal.

mod figures;
mod page;
mod tables;

pub(crate) use tables::study_tables;

use crate::dataset::ResultHeader;
use crate::error::Result;
use crate::files::write_bytes;
use crate::report::standalone::standalone;
use crate::study::Findings;
use figures::Chart;
use maud::Markup;
use std::path::Path;

/// A figure: what a page says of it, and its file.
struct StudyFigure {
    /// The file's name.
    name: String,
    /// What stands below it.
    caption: String,
    /// Its bytes.
    bytes: Vec<u8>,
    /// The same for a page.
    shown: Markup,
}

impl StudyFigure {
    fn of_chart(name: String, chart: &Chart) -> Self {
        Self {
            bytes: standalone(chart.size, &chart.title, &chart.drawn).into_bytes(),
            shown: chart.svg(),
            caption: chart.title.clone(),
            name: name + ".svg",
        }
    }

    fn of_png(name: String, caption: String, bytes: Vec<u8>) -> Self {
        Self {
            shown: page::picture(&caption, &bytes),
            caption,
            bytes,
            name: name + ".png",
        }
    }
}

/// Writes the page, `index.html`, and its figures, a file each in `figures`.
///
/// # Errors
/// The system's.
pub(crate) fn write_study(folder: &Path, header: &ResultHeader, findings: &Findings) -> Result<()> {
    let figures = page::Figures::of(findings)?;
    for figure in figures.all() {
        write_bytes(folder.join("figures").join(&figure.name), &figure.bytes)?;
    }
    let page = page::page(header, findings, &figures);
    write_bytes(folder.join("index.html"), page.as_bytes())
}

//! Reports of a study: a page, figures, and terminal tables.

mod figures;
mod page;
mod tables;

pub(crate) use tables::study_tables;

use crate::error::Result;
use crate::evaluate::study::Findings;
use crate::files::{ResultHeader, write_bytes};
use crate::report::standalone::standalone;
use figures::Chart;
use maud::Markup;
use std::path::Path;

/// A figure of a study: its file, and its form on the page.
struct StudyFigure {
    /// The file's name.
    name: String,
    /// The caption below the figure.
    caption: String,
    /// The bytes of the file.
    bytes: Vec<u8>,
    /// The figure for the page.
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

/// Writes the page, `index.html`, and its figures as files in `figures`.
///
/// # Errors
/// If a picture cannot be encoded, or a file cannot be written.
pub(crate) fn write_study(folder: &Path, header: &ResultHeader, findings: &Findings) -> Result<()> {
    let figures = page::Figures::from_findings(findings)?;
    for figure in figures.all() {
        write_bytes(folder.join("figures").join(&figure.name), &figure.bytes)?;
    }
    let page = page::page(header, findings, &figures);
    write_bytes(folder.join("index.html"), page.as_bytes())
}

//! Text tables that commands print, for a terminal or as Markdown.

use crate::error::{visible, visible_name};
use std::fmt;

/// The alignment of a column, and its minimum width in characters.
#[derive(Clone, Copy)]
pub(crate) enum Column {
    Left(usize),
    Right(usize),
}

/// Rows of cells, the first one the headings, and lines of text between them.
pub(crate) struct Table<'a> {
    columns: &'a [Column],
    gap: usize,
    lines: Vec<TableLine>,
}

enum TableLine {
    Row(Vec<String>),
    Note(String),
}

impl<'a> Table<'a> {
    /// Creates an empty table with at least one column. Further columns are like the last one.
    pub(crate) const fn new(columns: &'a [Column]) -> Self {
        Self {
            columns,
            gap: 1,
            lines: Vec::new(),
        }
    }

    /// Sets the number of spaces between two columns.
    pub(crate) fn with_gap(self, gap: usize) -> Self {
        Self { gap, ..self }
    }

    pub(crate) fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        let cells = cells.into_iter();
        let cells = cells.map(|cell| visible_name(&cell.into()).into_owned());
        self.lines.push(TableLine::Row(cells.collect()));
    }

    /// Adds a line of text outside the columns.
    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.lines
            .push(TableLine::Note(visible(&text.into()).into_owned()));
    }

    fn column(&self, at: usize) -> Column {
        self.columns[at.min(self.columns.len() - 1)]
    }

    /// Returns the width of each column: of its widest cell, or its least width.
    fn widths(&self) -> Vec<usize> {
        let mut widths: Vec<usize> = Vec::new();
        for line in &self.lines {
            let TableLine::Row(cells) = line else {
                continue;
            };
            for (at, cell) in cells.iter().enumerate() {
                if at == widths.len() {
                    let (Column::Left(least) | Column::Right(least)) = self.column(at);
                    widths.push(least);
                }
                widths[at] = widths[at].max(cell.chars().count());
            }
        }
        widths
    }

    /// Formats the table as Markdown.
    pub(crate) fn markdown(&self) -> String {
        let mut text = String::new();
        for (at, line) in self.lines.iter().enumerate() {
            match line {
                TableLine::Note(note) => text += note,
                TableLine::Row(cells) => {
                    let cells: Vec<String> =
                        cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
                    text += &format!("| {} |", cells.join(" | "));
                    if at == 0 {
                        let marks = (0..cells.len()).map(|at| match self.column(at) {
                            Column::Left(_) => "---|",
                            Column::Right(_) => "--:|",
                        });
                        text += &format!("\n|{}", marks.collect::<String>());
                    }
                }
            }
            text += "\n";
        }
        text
    }
}

/// Formats the table as aligned text. Each line ends with a newline, without trailing spaces; empty
/// rows are left out.
impl fmt::Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths = self.widths();
        for line in &self.lines {
            let text = match line {
                TableLine::Note(note) => note.clone(),
                TableLine::Row(cells) if cells.iter().all(String::is_empty) => continue,
                TableLine::Row(cells) => {
                    let aligned = cells.iter().zip(&widths).enumerate();
                    let aligned = aligned.map(|(at, (cell, width))| match self.column(at) {
                        Column::Left(_) => format!("{cell:<width$}"),
                        Column::Right(_) => format!("{cell:>width$}"),
                    });
                    aligned.collect::<Vec<_>>().join(&" ".repeat(self.gap))
                }
            };
            writeln!(f, "{}", text.trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Column::{Left, Right};
    use super::*;

    fn table() -> Table<'static> {
        let mut table = Table::new(&[Left(6), Right(0)]);
        table.row(["", "a", "b|c"]);
        table.row(["time", "1.25", "10"]);
        table.note("  of one run");
        table.row(["heat", "-", ""]);
        table
    }

    #[test]
    fn cells_are_aligned_by_column_and_lines_end_without_spaces() {
        let expected = "          a b|c\ntime   1.25  10\n  of one run\nheat      -\n";
        assert_eq!(table().to_string(), expected);
        let mut apart = Table::new(&[Left(0)]).with_gap(2);
        apart.row(["", ""]);
        apart.row(["é", "é"]);
        assert_eq!(apart.to_string(), "é  é\n");
    }

    #[test]
    fn a_cell_stays_in_its_row_and_its_column() {
        let mut table = Table::new(&[Left(0)]);
        table.row(["a\nb\u{1b}[31m", "c"]);
        table.row(["é", "d"]);
        let expected = "a\\nb\\u{1b}[31m c\né              d\n";
        assert_eq!(table.to_string(), expected);
    }

    #[test]
    fn markdown_escapes_what_would_part_cells() {
        let mut table = Table::new(&[Left(6), Right(0)]);
        table.row(["", "a", "b|c"]);
        table.row(["time", "1.25", "10"]);
        let expected = "|  | a | b\\|c |\n|---|--:|--:|\n| time | 1.25 | 10 |\n";
        assert_eq!(table.markdown(), expected);
    }
}

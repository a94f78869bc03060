//! Recognizers of the literature by class of confounder, as a table.

use super::percent;
use crate::literature::{COLUMNS, Row};
use crate::table::Column::{Left, Right};
use crate::table::Table;

/// Rank-1 of each recognizer under each class, with its 95 % interval over people, percent.
pub(crate) fn literature_table(rows: &[Row], people: usize) -> Table<'static> {
    let mut table = Table::new(&[Left(0), Right(0)]).with_gap(2);
    let headings = COLUMNS.iter().map(|column| column.name);
    table.row(std::iter::once("rank-1 %").chain(headings));
    for row in rows {
        let cells = row.cells.iter().map(|cell| {
            let (low, high) = cell.intervals.shown();
            format!(
                "{} ({:.0}-{:.0})",
                percent(cell.rank1),
                100.0 * low,
                100.0 * high
            )
        });
        table.row(std::iter::once(row.name.clone()).chain(cells));
    }
    let chance = 1.0 / people.max(1) as f64;
    table.row(std::iter::once("chance".to_owned()).chain(COLUMNS.iter().map(|_| percent(chance))));
    table
}

//! Tables of published recognizers by class of confounder.

use super::percent;
use crate::evaluate::literature::{ClassRank1, Garments, LiteratureRow};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;

/// Returns a table of Rank-1 of each recognizer under each class, with its 95 % interval over
/// people, percent.
pub(crate) fn literature_table(
    rows: &[LiteratureRow],
    people: usize,
    cells: fn(&LiteratureRow) -> &Vec<ClassRank1>,
) -> Table<'static> {
    let mut table = Table::new(&[Left(0), Right(0)]).with_gap(2);
    let classes: Vec<&str> = { rows.iter().take(1).flat_map(cells) }
        .map(|cell| cell.class.as_str())
        .collect();
    table.row(std::iter::once("rank-1 %").chain(classes.iter().copied()));
    for row in rows {
        let cells = cells(row).iter().map(|cell| {
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
    table.row(std::iter::once("chance".to_owned()).chain(classes.iter().map(|_| percent(chance))));
    table
}

/// Returns a table of the correlations of row widths between garments, and their variance within
/// each.
pub(crate) fn garments_table(garments: &Garments) -> Table<'static> {
    let mut table = Table::new(&[Left(0), Right(0)]).with_gap(2);
    let names = garments.names.iter().map(String::as_str);
    table.row(
        std::iter::once("row widths, r")
            .chain(names)
            .chain(["variance within"]),
    );
    let rows = garments
        .names
        .iter()
        .zip(&garments.correlations)
        .zip(&garments.within);
    for ((name, correlations), within) in rows {
        let correlations = correlations.iter().map(|r| format!("{r:.3}"));
        let within = std::iter::once(format!("{within:.5}"));
        table.row(
            std::iter::once(name.clone())
                .chain(correlations)
                .chain(within),
        );
    }
    let rows: Vec<String> = garments.chosen.iter().map(usize::to_string).collect();
    table.note(format!(
        "variance between garments {:.5}; rows chosen, 0 at the top: {}",
        garments.between,
        rows.join(" ")
    ));
    table
}

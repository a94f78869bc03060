//! The results of a contest at each pair of viewpoints, as a table of one line for each recognizer.

use super::cells::shortened;
use super::{headline_scope, microseconds, percent};
use crate::evaluate::results::{RecognizerResult, ScoreResults};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use crate::inference::baseline::PIXELS;

/// The number of sets of probes under conditions that have room.
const OTHERS: usize = 2;

/// Returns the table, at most 80 columns wide, with the best recognizer first, and a line about it.
#[must_use]
pub(crate) fn contest_table(results: &ScoreResults) -> String {
    let Some(first) = results.recognizers.first() else {
        return String::new();
    };
    let others = |result| headline_scope::others(result).take(OTHERS);
    let names: Vec<&str> = others(first).map(|set| set.name.as_str()).collect();
    let mut columns = vec![Left(14), Right(18), Right(19)];
    columns.extend(names.iter().map(|_| Right(6)));
    columns.extend([Right(8), Right(7)]);
    let mut table = Table::new(&columns);
    let rates = ["rank-1 %", "same view", "across views"].into_iter();
    let heads = rates.chain(names).chain(["us", "MB"]);
    table.row(heads.map(|name| shortened(name, 14)));
    let ranked = headline_scope::ranked(&results.recognizers);
    let pixels = ranked.iter().position(|result| result.name == PIXELS);
    for (place, result) in ranked.iter().enumerate() {
        let is_worse = pixels.is_some_and(|pixels| place > pixels);
        let same = headline_scope::same_view(result);
        let rate = |rank1, (low, high): (f64, f64)| {
            format!(
                "{} ({:.0} - {:.0})",
                percent(rank1),
                100.0 * low,
                100.0 * high
            )
        };
        let across = rate(result.rank1, result.intervals.shown());
        let cells = [
            shortened(&result.name, 14),
            same.map_or("-".into(), |same| rate(same.rank1, same.intervals.shown())),
            format!("{across}{}", if is_worse { "*" } else { " " }),
        ];
        let sets = others(result).map(|set| percent(set.rank1));
        let time = result.latency.map(|time| microseconds(time.p50_us, ","));
        let size = result
            .model_bytes
            .map(|bytes| format!("{:.2}", bytes as f64 / 1e6));
        let costs = [time, size].map(|cell| cell.unwrap_or("-".into()));
        table.row(cells.into_iter().chain(sets).chain(costs));
    }
    format!("{table}{}\n", about(first))
}

/// Describes the contest, and the mark of recognizers that are worse than pixels.
fn about(result: &RecognizerResult) -> String {
    format!(
        "{} people, two days; chance {} %; pixels, random: untrained; * worse than pixels",
        result.classes,
        percent(1.0 / result.classes.max(1) as f64)
    )
}

//! The results of a contest at each pair of viewpoints, as a table of one line for each recognizer.

use super::cells::shortened;
use super::{microseconds, percent};
use crate::evaluate::results::{ProbeSetResult, RecognizerResult, ScoreResults};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use crate::inference::baseline::PIXELS;

/// Returns the table, at most 80 columns wide, with the best recognizer first, and a line about it.
#[must_use]
pub(crate) fn contest_table(results: &ScoreResults) -> String {
    let Some(first) = results.recognizers.first() else {
        return String::new();
    };
    let others: Vec<&str> = others(first).map(|set| set.name.as_str()).collect();
    let mut columns = vec![Left(14), Right(18), Right(19)];
    columns.extend(others.iter().map(|_| Right(6)));
    columns.extend([Right(8), Right(7)]);
    let mut table = Table::new(&columns);
    let names = ["rank-1 %", "same view", "across views"].into_iter();
    let names = names.chain(others.iter().copied()).chain(["us", "MB"]);
    table.row(names.map(|name| shortened(name, 14)));
    let mut ranked: Vec<&RecognizerResult> = results.recognizers.iter().collect();
    ranked.sort_by(|a, b| b.rank1.total_cmp(&a.rank1));
    let pixels = ranked.iter().position(|result| result.name == PIXELS);
    for (place, result) in ranked.iter().enumerate() {
        let is_worse = pixels.is_some_and(|pixels| place > pixels);
        let same = leading(result).and_then(|set| set.cross_view.as_ref()?.same_view);
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
        let sets = self::others(result).map(|set| percent(set.rank1));
        let time = result.latency.map(|time| microseconds(time.p50_us, ","));
        let size = result
            .model_bytes
            .map(|bytes| format!("{:.2}", bytes as f64 / 1e6));
        let costs = [time, size].map(|cell| cell.unwrap_or("-".into()));
        table.row(cells.into_iter().chain(sets).chain(costs));
    }
    format!("{table}{}\n", about(first))
}

/// Returns the clean set of probes, or the first.
fn leading(result: &RecognizerResult) -> Option<&ProbeSetResult> {
    let sets = &result.probe_sets;
    sets.iter().find(|set| set.clean).or_else(|| sets.first())
}

/// Returns the sets of probes under conditions, of which two have room.
fn others(result: &RecognizerResult) -> impl Iterator<Item = &ProbeSetResult> {
    let is_other = |set: &&ProbeSetResult| !result.of_probe_sets.contains(&set.name);
    result.probe_sets.iter().filter(is_other).take(2)
}

/// Describes the contest, and the mark of recognizers that are worse than pixels.
fn about(result: &RecognizerResult) -> String {
    format!(
        "{} people, two days; chance {} %; pixels, random: untrained; * worse than pixels",
        result.classes,
        percent(1.0 / result.classes.max(1) as f64)
    )
}

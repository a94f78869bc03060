//! The effects of confounders on recognizers: a terminal table and a chart.

use super::strengths::recognizers;
use super::{percent, strengths};
use crate::error::Result;
use crate::evaluate::strengths::{ConfounderResult, StrengthResult};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use crate::files::write_bytes;
use std::fmt::Write as _;
use std::path::Path;

/// The number of worst confounders that a table lists for each recognizer.
const WORST: usize = 5;

/// Writes a chart of rank-1 of each recognizer against each confounder's strength; `classes` is the
/// number of people to choose from.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write_strengths(
    path: &Path,
    results: &[ConfounderResult],
    classes: usize,
) -> Result<()> {
    write_bytes(path, strengths::svg(results, classes).as_bytes())
}

/// Returns a table of all confounders, and the worst ones for each recognizer; `probes` is the
/// number of probes at each strength.
#[must_use]
pub(crate) fn strength_table(results: &[ConfounderResult], classes: usize, probes: u64) -> String {
    let recognizers = recognizers(results);
    let mut out = String::new();
    let Some(first) = results.first() else {
        return out;
    };
    let _ = writeln!(
        out,
        "rank-1 % of {probes} probes at each strength, {classes} people; GEI: difference from the GEI without the confounder, of 255;\nextra: additional time per silhouette at strength 1, one walk seen from ten azimuths"
    );
    let plain = first.by_strength.iter().find(|point| point.strength == 0.0);
    for (at, name) in recognizers.iter().enumerate() {
        if let Some(plain) = plain {
            let _ = writeln!(out, "{name} without confounders: {}", rank1(plain, at));
        }
    }
    let mut table = Table::new(&[Left(22), Right(8)]);
    let mut class = "";
    let mut sorted: Vec<&ConfounderResult> = results.iter().collect();
    sorted.sort_by_key(|result| result.class);
    for result in sorted {
        if result.class != class {
            class = result.class;
            table.note("");
            let names = recognizers.iter().map(String::as_str);
            table.row(
                [class, "strength", "GEI", "extra us"]
                    .into_iter()
                    .chain(names),
            );
        }
        let points = result.by_strength.iter();
        for point in points.filter(|point| point.strength != 0.0) {
            let extra = if point.strength == 1.0 {
                format!("{:.1}", 1e-3 * result.extra_ns)
            } else {
                String::new()
            };
            let cells = [
                format!("  {}", result.name),
                point.strength.to_string(),
                format!("{:.1}", point.gei_rmse),
                extra,
            ];
            let rates = (0..recognizers.len()).map(|at| rank1(point, at));
            table.row(cells.into_iter().chain(rates));
        }
    }
    out.push_str(&table.to_string());
    for (at, name) in recognizers.iter().enumerate() {
        let mut worst: Vec<&ConfounderResult> = results.iter().collect();
        worst.sort_by(|a, b| a.mean_rank1(at).total_cmp(&b.mean_rank1(at)));
        let worst: Vec<String> = worst
            .iter()
            .take(WORST)
            .map(|result| format!("{} {}", result.name, percent(result.mean_rank1(at))))
            .collect();
        let _ = writeln!(
            out,
            "\n{name}: worst confounders by mean rank-1 % over the strengths: {}",
            worst.join(", ")
        );
    }
    out
}

/// Formats a rate and its interval.
fn rank1(point: &StrengthResult, recognizer: usize) -> String {
    let of = &point.recognizers[recognizer];
    match of.intervals.over_people() {
        Some((low, high)) => format!(
            "{} ({} - {})",
            percent(of.rank1),
            percent(low),
            percent(high)
        ),
        None => percent(of.rank1),
    }
}

//! Results as plain text for a terminal, at most 80 columns.

use super::cells::shortened;
use super::{grouped, headline_scope, microseconds, paired, percent, probe_sets};
use crate::evaluate::bands::{AZIMUTHS, Bands, ELEVATIONS};
use crate::evaluate::rank1::Tally;
use crate::evaluate::results::{Latency, RecognizerResult, ScoreResults};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use std::fmt::Write;

/// Returns the results as text: a line for each recognizer, then its rank-1 by viewpoint.
#[must_use]
pub(crate) fn table(results: &ScoreResults) -> String {
    let mut table = Table::new(&[Left(18), Left(18), Right(10), Right(8), Right(13), Right(8)]);
    table.row("recognizer|runtime|probes|rank-1 %|95 % interval|p50 us".split('|'));
    for recognizer in &results.recognizers {
        let p50 = |latency: Latency| microseconds(latency.p50_us, ",");
        table.row([
            shortened(&recognizer.name, 18),
            shortened(&recognizer.runtime.to_string(), 18),
            grouped(recognizer.probes, ","),
            percent(recognizer.rank1),
            interval(recognizer),
            recognizer.latency.map_or("-".into(), p50),
        ]);
    }
    let mut out = table.to_string();
    let has_baselines = results.learnt().count() < results.recognizers.len();
    if has_baselines {
        line(
            &mut out,
            "pixels, random: baselines, which have learnt nothing",
        );
    }
    if let Some(first) = results.recognizers.first() {
        line(
            &mut out,
            &format!("protocol: {}", shortened(&first.protocol, 60)),
        );
        if let Some(which) = headline_scope::probe_sets(first) {
            line(&mut out, &shortened(&format!("rank-1 is on {which}"), 80));
        }
        if let Some((worst, others)) = headline_scope::worst_other(first) {
            let name = shortened(&worst.name, 30);
            let lowest = percent(worst.rank1);
            line(
                &mut out,
                &format!(
                    "  the other {others} are below; the lowest of {}: {name}, {lowest} %",
                    shortened(&first.name, 18)
                ),
            );
        }
    }
    out.push_str(&paired::text(results));
    // The page has more about baselines.
    for recognizer in results.learnt() {
        places(&mut out, recognizer);
        out.push_str(&probe_sets::text(recognizer));
    }
    out
}

/// Formats the interval over people or, if there is none, Wilson's.
fn interval(recognizer: &RecognizerResult) -> String {
    let (low, high) = recognizer.intervals.shown();
    format!("{} - {}", percent(low), percent(high))
}

fn places(out: &mut String, recognizer: &RecognizerResult) {
    let bands = Bands::sum(&recognizer.by_viewpoint);
    let name = shortened(&recognizer.name, 34);
    let seen = (0..ELEVATIONS.len()).filter(|&band| bands.elevation(band).probes > 0);
    // A single row needs no table.
    let is_grid = seen.count() > 1;
    if is_grid {
        line(
            out,
            &format!("\n{name}: rank-1 % by elevation and azimuth, degrees"),
        );
        if let Some(which) = headline_scope::probe_sets(recognizer) {
            line(out, &shortened(&format!("  on {which}"), 80));
        }
        out.push_str(&grid(&bands).to_string());
    } else {
        line(out, &format!("\n{name}"));
    }

    let trained = recognizer.at_training();
    if let Some(rank1) = trained.rank1() {
        line(out, &format!("  {} % where it was trained", percent(rank1)));
    }
    if is_grid && bands.between > 0 {
        line(
            out,
            &format!(
                "  {} of {} viewpoints are not multiples of 5 and count as the nearest one",
                grouped(bands.between as u64, ","),
                grouped(recognizer.by_viewpoint.len() as u64, ",")
            ),
        );
    }
    if bands.outside > 0 {
        line(
            out,
            &format!(
                "  {} viewpoints are in no band",
                grouped(bands.outside as u64, ",")
            ),
        );
    }
    if recognizer.non_finite > 0 {
        let count = grouped(recognizer.non_finite, ",");
        line(
            out,
            &format!("  {count} outputs were not finite: counted as misses"),
        );
    }
}

fn grid(bands: &Bands) -> Table<'static> {
    let mut table = Table::new(&[Right(9), Right(8)]);
    table.row([&[""], &AZIMUTHS[..], &["all"]].concat());
    let mut row = |name: &str, cells: [Tally; 5], all| {
        let rates = cells.into_iter().chain([all]).map(rate);
        table.row([name.to_owned()].into_iter().chain(rates));
    };
    // As in a picture, high elevations are at the top.
    for (band, elevation) in ELEVATIONS.iter().enumerate().rev() {
        row(elevation, bands.cells[band], bands.elevation(band));
    }
    let of_all = [0, 1, 2, 3, 4].map(|band| bands.azimuth(band));
    row("all", of_all, bands.all());
    table
}

fn line(out: &mut String, text: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{}", text.trim_end());
}

fn rate(tally: Tally) -> String {
    tally.rank1().map_or("-".into(), percent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::{result_of, results_of};

    #[test]
    fn the_table_is_aligned() {
        let mut first = result_of(&[(90.0, 0.0, 19, 20), (0.0, 0.0, 1, 2), (90.0, 90.0, 0, 1)]);
        first.latency = Latency::from_samples(&[5.314]);
        first.trained_at = vec![(90.0, 0.0)];
        let mut second = result_of(&[(300.0, 0.0, 1, 1)]);
        second.name = "a-recognizer-of-a-very-long-name".into();
        second.runtime.name = "onnxruntime".into();
        let expected = "\
recognizer         runtime                probes rank-1 % 95 % interval   p50 us
pca-svm            rten 0.27.0                23     87.0   67.9 - 95.5     5.31
a-recognizer-of-a~ onnxruntime 0.27.0          1    100.0  20.7 - 100.0        -
protocol: closed-set

pca-svm: rank-1 % by elevation and azimuth, degrees
              0-40    45-85       90   95-135  140-180      all
    80-90        -        -      0.0        -        -      0.0
    55-75        -        -        -        -        -        -
    30-50        -        -        -        -        -        -
     5-25        -        -        -        -        -        -
        0     50.0        -     95.0        -        -     90.9
      all     50.0        -     90.5        -        -     87.0
  95.0 % where it was trained

a-recognizer-of-a-very-long-name
  1 viewpoints are in no band
";
        assert_eq!(table(&results_of(vec![first, second])), expected);
    }

    #[test]
    fn no_line_is_wider_than_80_columns() {
        let mut wide = result_of(&[(90.0, 0.0, 1, 99_999_998), (-9.0, 0.0, 0, 1)]);
        wide.name = "n".repeat(300);
        wide.runtime.version = "v".repeat(300);
        wide.non_finite = 5;
        wide.latency = Latency::from_samples(&[999_999.0]);
        for line in table(&results_of(vec![wide])).lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
    }

    #[test]
    fn a_name_cannot_command_the_terminal() {
        assert_eq!(shortened("a\u{1b}[31mb", 20), "a\\u{1b}[31mb");
        assert_eq!(shortened("éèê", 2), "é~");
        assert_eq!(shortened("éè", 2), "éè");
    }
}

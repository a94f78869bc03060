//! Differences between the best recognizer and the others, on the same probes.

use super::cells::shortened;
use crate::evaluate::paired_results::PairedResult;
use crate::evaluate::results::ScoreResults;
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use maud::{Markup, html};

/// Returns the verdict on a difference in words.
fn verdict(one: &PairedResult) -> &'static str {
    match one.differs() {
        _ if one.low == Some(0.0) && one.high == Some(0.0) => "no difference",
        Some(true) => "differs",
        Some(false) => "undecided",
        None => "one person only",
    }
}

/// Formats a difference of rates in percentage points, with its sign.
fn points(rate: f64) -> String {
    let text = format!("{:+.1}", 100.0 * rate);
    // A value that rounds to 0 has no sign.
    if text.trim_start_matches(['+', '-']) == "0.0" {
        "0.0".into()
    } else {
        text
    }
}

fn interval(one: &PairedResult) -> String {
    let both = one.low.zip(one.high);
    both.map_or("-".into(), |(low, high)| {
        format!("{} to {}", points(low), points(high))
    })
}

/// Returns the differences of each recognizer that is the best of those with the same probes.
fn of_the_best(results: &ScoreResults) -> Vec<Vec<&PairedResult>> {
    let all = &results.paired;
    let is_best = |name: &str| all.iter().all(|pair| pair.other != name);
    let pairs = all.chunk_by(|a, b| a.recognizer == b.recognizer);
    let of_best = pairs.filter(|pairs| is_best(&pairs[0].recognizer));
    of_best.map(|pairs| pairs.iter().collect()).collect()
}

/// Returns at how many viewpoints the best recognizer is better and worse; empty if that is
/// unknown.
fn of_viewpoints(one: &PairedResult) -> String {
    if one.by_viewpoint.is_empty() {
        return String::new();
    }
    let (beyond, behind) = one.viewpoints_beyond_and_behind();
    format!("{beyond}, {behind} of {}", one.by_viewpoint.len())
}

/// Returns the best recognizer's differences on the headline probe sets as text of at most 80
/// columns, for each group of recognizers with the same probes; empty if there are none.
#[must_use]
pub(super) fn text(results: &ScoreResults) -> String {
    let leading = |pairs: Vec<&PairedResult>| {
        let leading = pairs.into_iter().filter(|pair| pair.probe_set.is_none());
        text_of(&leading.collect::<Vec<_>>())
    };
    of_the_best(results).into_iter().map(leading).collect()
}

fn text_of(leading: &[&PairedResult]) -> String {
    let Some(first) = leading.first() else {
        return String::new();
    };
    let has_views = leading.iter().any(|pair| pair.by_viewpoint.len() > 1);
    let mut table = Table::new(&[Left(18), Right(8), Right(16), Left(15), Right(0)]);
    let best = shortened(&first.recognizer, 18);
    let heading = if has_views { "viewpoints +, -" } else { "" };
    table.row(["against", "points", "95 % interval", "", heading]);
    for one in leading {
        table.row([
            shortened(&one.other, 18),
            points(one.difference),
            interval(one),
            verdict(one).into(),
            if has_views {
                of_viewpoints(one)
            } else {
                String::new()
            },
        ]);
    }
    format!("\n{best}: lead in rank-1 on the same probes, paired by person\n{table}")
}

/// Returns the name of the headline probe set of these results if there is only one.
fn headline_of<'r>(one: &PairedResult, results: &'r ScoreResults) -> Option<&'r str> {
    let all = &results.recognizers;
    let first = all.iter().find(|result| result.name == one.recognizer);
    match &first?.of_probe_sets[..] {
        [name] => Some(name),
        _ => None,
    }
}

/// Returns all of the best recognizer's differences as an HTML table, for each group of recognizers
/// with the same probes; empty if there are none.
pub(super) fn section(results: &ScoreResults) -> Markup {
    let groups = of_the_best(results);
    if groups.is_empty() {
        return html! {};
    }
    let names: Vec<&str> = groups
        .iter()
        .map(|pairs| pairs[0].recognizer.as_str())
        .collect();
    let best = match names[..] {
        [_] => ", the best here, ",
        _ => ", each the best on its probes, ",
    };
    html! {
        h2 { "Differences between the recognizers" }
        p.quiet {
            "Rank-1 of " (names.join(", ")) (best) "minus that of each other recognizer on the same probes, "
            "in percentage points, with the 95 % interval of the difference over people (paired bootstrap). "
            "If the interval contains 0, these people do not show a difference (undecided). Viewpoints are compared one by one; "
            "about five in a hundred are better or worse by chance alone."
        }
        @for pairs in groups {
        @let headline = headline_of(pairs[0], results);
        div.scroll { table.summary {
            thead { tr {
                th scope="col" { (pairs[0].recognizer) " against" }
                th.text scope="col" { "probes" }
                th scope="col" { "points" }
                th scope="col" { "95 % interval" }
                th.text scope="col" { "verdict" }
                th scope="col" { "viewpoints better, worse" }
            } }
            tbody { @for one in pairs {
                // The headline sets are listed first, and not again if there is only one.
                @if one.probe_set.is_none() || one.probe_set.as_deref() != headline { tr {
                    th scope="row" { (one.other) }
                    td.text data-label="probes" { (one.probe_set.as_deref().or(headline).unwrap_or("headline sets")) }
                    td data-label="points" { b { (points(one.difference)) } }
                    td data-label="95 % interval" { (interval(one)) }
                    td.text data-label="verdict" { (verdict(one)) }
                    td data-label="viewpoints better, worse" { (of_viewpoints(one)) }
                } }
            } }
        } } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::results_of;

    fn results() -> ScoreResults {
        let one =
            |other: &str, probe_set: Option<&str>, difference: f64, ends: Option<(f64, f64)>| {
                PairedResult {
                    recognizer: "geinet".into(),
                    other: other.into(),
                    probe_set: probe_set.map(str::to_owned),
                    people: 26,
                    difference,
                    low: ends.map(|ends| ends.0),
                    high: ends.map(|ends| ends.1),
                    by_viewpoint: Vec::new(),
                }
            };
        ScoreResults {
            paired: vec![
                one("pixels", None, 0.25, Some((0.125, 0.375))),
                one("pixels", Some("BG"), -0.5, Some((-0.6, -0.4))),
                one(
                    "a-recognizer-of-a-very-long-name",
                    None,
                    0.0004,
                    Some((-0.01, 0.011)),
                ),
                one("random", None, 1.0, None),
                PairedResult {
                    recognizer: "pixels".into(),
                    ..one("random", None, 0.5, None)
                },
            ],
            ..results_of(Vec::new())
        }
    }

    #[test]
    fn the_text_says_who_differs() {
        let expected = "
geinet: lead in rank-1 on the same probes, paired by person
against              points    95 % interval                \n\
pixels                +25.0   +12.5 to +37.5 differs        \n\
a-recognizer-of-a~      0.0     -1.0 to +1.1 undecided      \n\
random               +100.0                - one person only\n";
        let trimmed = |text: &str| {
            let lines = text.lines().map(str::trim_end);
            lines.collect::<Vec<_>>().join("\n")
        };
        assert_eq!(trimmed(&text(&results())), trimmed(expected));
        assert_eq!(text(&results_of(Vec::new())), "");
    }

    #[test]
    fn viewpoints_beyond_and_behind_are_counted() {
        use crate::evaluate::paired_results::PairedViewpoint;
        let mut results = results();
        let at = |low: f64, high: f64| PairedViewpoint {
            azimuth_deg: Some(0.0),
            elevation_deg: Some(0.0),
            view: None,
            difference: 0.5 * (low + high),
            low: Some(low),
            high: Some(high),
        };
        results.paired[0].by_viewpoint =
            vec![at(0.1, 0.2), at(-0.1, 0.2), at(-0.3, -0.2), at(0.2, 0.2)];
        let text = text(&results);
        assert!(
            text.contains("viewpoints +, -") && text.contains("2, 1 of 4"),
            "{text}"
        );
        assert!(
            text.lines().all(|line| line.trim_end().len() <= 80),
            "{text}"
        );
        assert!(section(&results).into_string().contains("2, 1 of 4"));
    }

    #[test]
    fn the_page_has_every_set_of_probes() {
        let page = section(&results()).into_string();
        assert_eq!(page.matches("<tr>").count(), 5);
        assert!(
            page.contains(">BG<") && page.contains("-60.0 to -40.0"),
            "{page}"
        );
        assert_eq!(section(&results_of(Vec::new())).into_string(), "");
    }
}

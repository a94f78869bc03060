//! The results of a protocol's sets of probes: on a terminal, and on the page.

use super::cells::shortened;
use super::{THIN, grouped, headline_scope, percent};
use crate::evaluate::results::{CrossViewResult, ProbeSetResult, RecognizerResult};
use crate::evaluate::view_angle::AngleResult;
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use maud::{Markup, html};

/// The number of angle bins in a row on a terminal.
const ANGLES_IN_A_ROW: usize = 11;
/// The maximum number of sets of probes whose matrices a page shows.
const MAX_MATRICES: usize = 6;
/// The maximum number of viewpoints of a cross-view matrix that a page shows cell by cell.
const MAX_CELLS: usize = 16;

/// Returns the sets and the angles as text of at most 80 columns.
pub(super) fn text(result: &RecognizerResult) -> String {
    let mut sets = Table::new(&[
        Left(16),
        Right(8),
        Right(6),
        Right(13),
        Right(6),
        Right(6),
        Right(6),
        Right(6),
        Right(5),
    ]);
    if !result.probe_sets.is_empty() {
        sets.row("  probe set|probes|rank-1|over people|rank-5|mAP|mINP|EER|AUC".split('|'));
    }
    for set in &result.probe_sets {
        let verification = set.verification.as_ref();
        let auc = verification.and_then(|found| found.auc);
        sets.row([
            format!("  {}", shortened(&set.name, 14)),
            grouped(set.probes, ","),
            percent(set.rank1),
            range(set.intervals.over_people(), " - "),
            percent(set.rank5),
            share(set.map),
            share(set.minp),
            share(verification.and_then(|found| found.eer)),
            auc.map_or("-".into(), |auc| format!("{auc:.3}")),
        ]);
        sets.note(format!(
            "    {}{} people, {} to choose from; chance {} %",
            if set.clean { "clean; " } else { "" },
            grouped(set.people, ","),
            result.classes,
            percent(1.0 / result.classes.max(1) as f64)
        ));
        if let Some(accepted) = accepted(set) {
            sets.note(wrapped(&accepted));
        }
        let more = [set.cross_view.as_ref().map(mean), left_out(set)];
        for text in more.into_iter().flatten() {
            sets.note(format!("    {text}"));
        }
    }
    if let (Some(which), false) = (
        headline_scope::probe_sets(result),
        result.by_angle.is_empty(),
    ) {
        let title = format!("  by angle from the training viewpoints, {which}:");
        sets.note(shortened(&title, 80));
    }
    let angles = result.by_angle.chunks(ANGLES_IN_A_ROW).map(angles);
    angles.fold(sets.to_string(), |text, angles| format!("{text}{angles}"))
}

fn angles(bins: &[AngleResult]) -> Table<'static> {
    let mut table = Table::new(&[Left(14), Right(5)]);
    let mut row = |head: &str, of: fn(&AngleResult) -> String| {
        table.row([head.to_owned()].into_iter().chain(bins.iter().map(of)));
    };
    row("  up to (deg)", |bin| bin.to_deg.to_string());
    row("  rank-1 %", |bin| percent(bin.rank1));
    row("    from", |bin| percent(bin.intervals.shown().0));
    row("    to", |bin| percent(bin.intervals.shown().1));
    table
}

/// Formats the true accept rates at fixed false accept rates.
fn accepted(set: &ProbeSetResult) -> Option<String> {
    let verification = set.verification.as_ref()?;
    let rates = verification.tar_at_far.iter();
    let known: Vec<String> = rates
        .filter_map(|at| {
            let mark = if at.note.is_some() { " (rough)" } else { "" };
            Some(format!(
                "{}{mark} at {}",
                share(Some(at.tar?)),
                at.far * 100.0
            ))
        })
        .collect();
    (!known.is_empty()).then(|| {
        format!(
            "TAR % at FAR %: {} ({} impostor pairs)",
            known.join(", "),
            grouped(verification.impostors, ",")
        )
    })
}

fn mean(cross_view: &CrossViewResult) -> String {
    match (cross_view.mean_percent, &cross_view.note) {
        (Some(mean), _) => {
            format!("mean over pairs of different viewpoints, equally weighted: {mean:.2} %")
        }
        (None, Some(note)) => note.clone(),
        (None, None) => "no mean over viewpoints".into(),
    }
}

fn left_out(set: &ProbeSetResult) -> Option<String> {
    let counts = [
        (set.without_mate, "whose person is not in the gallery"),
        (set.non_finite, "with answers that are not finite"),
    ];
    let found = counts.iter().filter(|(count, _)| *count > 0);
    let texts: Vec<String> = found
        .map(|(count, what)| format!("{} {what}", grouped(*count, ",")))
        .collect();
    (!texts.is_empty()).then(|| format!("misses: {}", texts.join(", ")))
}

fn share(rate: Option<f64>) -> String {
    rate.map_or("-".into(), percent)
}

fn range(interval: Option<(f64, f64)>, dash: &str) -> String {
    interval.map_or("-".into(), |(low, high)| {
        format!("{}{dash}{}", percent(low), percent(high))
    })
}

/// Wraps a text under a set of probes to lines of at most 80 columns.
fn wrapped(text: &str) -> String {
    let mut out = String::from("   ");
    let mut width = out.len();
    for word in text.split(' ') {
        let letters = 1 + word.chars().count();
        if width + letters > 80 {
            out.push_str("\n     ");
            width = 5;
        }
        out.push(' ');
        out.push_str(word);
        width += letters;
    }
    out
}

/// Returns the sets as an HTML table, and the matrices of sets that have one.
pub(super) fn page(result: &RecognizerResult) -> Markup {
    html! {
        @if !result.probe_sets.is_empty() {
            div.scroll { table.summary {
                caption { "Protocol " (result.protocol) ", "
                    @match result.probe_sets.len() { 1 => "its probe set", many => { "all " (many) " probe sets" } }
                    ", " (result.classes) " people to choose from; chance is "
                    (percent(crate::report::cells::chance(result))) " %" }
                thead { tr {
                    th scope="col" { "probes" }
                    th scope="col" { "rank-1" small { "% · over people" } }
                    th scope="col" { "rank-5" small { "%" } }
                    th scope="col" { "mAP" small { "% · over people" } }
                    th scope="col" { "mINP" small { "%" } }
                    th scope="col" { "EER" small { "% · over people" } }
                    th scope="col" { "AUC" }
                    th scope="col" { "TAR" small { "% at FAR of " (fars(&result.probe_sets)) " %" } }
                } }
                tbody { @for set in &result.probe_sets { (row(set, &result.probe_sets)) } }
            } }
            @let (sets, which) = headline_scope::chosen(result, MAX_MATRICES);
            @if sets.len() < result.probe_sets.len() && sets.iter().any(|set| set.cross_view.is_some()) {
                p { "Matrices of " (which) "." }
            }
            @for set in sets {
                @if let Some(cross_view) = &set.cross_view { (matrix(&set.name, cross_view)) }
            }
        }
    }
}

/// Returns the false accept rates of the first set that has any, percent.
fn fars(sets: &[ProbeSetResult]) -> String {
    let rates = sets.iter().find_map(|set| set.verification.as_ref());
    let rates = rates.iter().flat_map(|found| &found.tar_at_far);
    let texts: Vec<String> = rates.map(|at| (at.far * 100.0).to_string()).collect();
    texts.join(" / ")
}

fn row(set: &ProbeSetResult, sets: &[ProbeSetResult]) -> Markup {
    let verification = set.verification.as_ref();
    html! { tr {
        th scope="row" { (set.name) @if set.clean { " (clean)" }
            small { (headline_scope::of_people(set.probes, set.people, THIN)) }
            @if let Some(left_out) = left_out(set) { small { (left_out) } } }
        td data-label="rank-1" { (percent(set.rank1)) small { (range(set.intervals.over_people(), " to ")) } }
        td data-label="rank-5" { (percent(set.rank5)) }
        td data-label="mAP" { (share(set.map)) small { (range(set.map_low.zip(set.map_high), " to ")) } }
        td data-label="mINP" { (share(set.minp)) }
        td data-label="EER" { (share(verification.and_then(|found| found.eer)))
            small { (range(verification.and_then(|found| found.eer_low.zip(found.eer_high)), " to ")) } }
        td data-label="AUC" { (verification.and_then(|found| found.auc).map_or("–".into(), |auc| format!("{auc:.3}"))) }
        td data-label="TAR" {
            @for (place, at) in verification.iter().flat_map(|found| &found.tar_at_far).enumerate() {
                @if place > 0 { " / " }
                span title=[at.note.as_deref()] {
                    (share(at.tar)) @if at.tar.is_some() && at.note.is_some() { "?" }
                }
            }
            small.narrow { "at FAR of " (fars(sets)) " %" }
        }
    } }
}

fn matrix(set: &str, cross_view: &CrossViewResult) -> Markup {
    html! {
        p { (set) ": " (mean(cross_view)) }
        @if cross_view.views.len() <= MAX_CELLS {
            div.scroll { table.bands {
                caption { "Rank-1 in percent, " (set) ": probe viewpoint (rows), gallery viewpoint (columns)" }
                thead { tr { th scope="col" { } @for view in &cross_view.views { th scope="col" { (view.to_string()) } } } }
                tbody { @for (view, cells) in cross_view.views.iter().zip(&cross_view.rank1) { tr {
                    th scope="row" { (view.to_string()) }
                    @for cell in cells { (crate::report::cells::rate_cell(*cell)) }
                } } }
            } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::sequences::ViewLabel;
    use crate::evaluate::intervals::Rank1Intervals;
    use crate::evaluate::results::VerificationResult;
    use crate::evaluate::results::tests::result_of;
    use crate::evaluate::verification::TarAtFar;

    pub(super) fn set() -> ProbeSetResult {
        let at = |far, tar, note: Option<&str>| TarAtFar {
            far,
            tar,
            threshold: None,
            note: note.map(str::to_owned),
        };
        ProbeSetResult {
            name: "NM".into(),
            clean: true,
            probes: 12_345,
            people: 7,
            tied: 0,
            without_mate: 2,
            non_finite: 0,
            rank1: 0.5,
            intervals: Rank1Intervals {
                rank1_low: Some(0.25),
                rank1_high: Some(0.75),
                rank1_wilson_low: 0.4,
                rank1_wilson_high: 0.6,
            },
            rank5: 0.875,
            cmc: vec![0.5, 0.6],
            map: Some(0.625),
            map_low: None,
            map_high: None,
            minp: None,
            by_person: Vec::new(),
            verification: Some(VerificationResult {
                genuine: 10,
                impostors: 200,
                non_finite_genuine: 0,
                non_finite_impostors: 0,
                eer: Some(0.125),
                eer_threshold: Some(1.5),
                eer_low: None,
                eer_high: None,
                auc: Some(0.9375),
                tar_at_far: vec![
                    at(0.1, Some(0.75), None),
                    at(1e-4, None, Some("needs more")),
                ],
                roc: Vec::new(),
            }),
            cross_view: Some(CrossViewResult {
                views: vec![ViewLabel::Angles(0.0, 0.0), ViewLabel::Angles(90.0, 15.0)],
                rank1: vec![vec![Some(1.0), Some(0.25)], vec![None, Some(1.0)]],
                by_probe_view_percent: Vec::new(),
                mean_percent: None,
                same_view: None,
                note: Some("a cell is empty".into()),
            }),
        }
    }

    #[test]
    fn the_table_says_all_and_what_is_refused_is_not_a_number() {
        let mut result = result_of(&[(90.0, 0.0, 19, 20)]);
        result.protocol = "casia-b".into();
        result.probe_sets = vec![set()];
        let expected =
            "  probe set        probes rank-1   over people rank-5    mAP   mINP    EER   AUC
  NM               12,345   50.0   25.0 - 75.0   87.5   62.5      -   12.5 0.938
    clean; 7 people, 26 to choose from; chance 3.8 %
    TAR % at FAR %: 75.0 at 10 (200 impostor pairs)
    a cell is empty
    misses: 2 whose person is not in the gallery
";
        assert_eq!(text(&result), expected);
        result.probe_sets[0].people = 1_000_000;
        let found = result.probe_sets[0].verification.as_mut();
        let found = found.expect("there is one");
        found.impostors = 9_876_543;
        for at in &mut found.tar_at_far {
            (at.tar, at.note) = (Some(0.123), Some("needs more".into()));
        }
        found.tar_at_far = [&found.tar_at_far[..], &found.tar_at_far[..]].concat();
        for line in text(&result).lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
        let page = page(&result).into_string();
        assert!(page.contains("title=\"needs more\">12.3?<"), "{page}");
        assert!(page.contains(">90/15<"), "{page}");
    }
}

//! The beginning of the page: the best recognizer, and a table of all recognizers.

use super::cells::chance;
use super::heatmap::label;
use super::viewpoints::rate;
use super::{THIN, chart, grouped, headline_scope, microseconds, percent};
use crate::evaluate::bands::{Bands, ELEVATIONS};
use crate::evaluate::rank1::Tally;
use crate::evaluate::results::{RecognizerResult, ScoreResults};
use maud::{Markup, html};

/// Describes the best recognizer in a few sentences.
pub(super) fn finding(results: &ScoreResults) -> Markup {
    let learnt = results.learnt().count();
    let scored = results.learnt().filter(|result| result.probes > 0);
    // Ties go to the first listed: `max_by` keeps the last.
    let Some(best) = scored.rev().max_by(|a, b| a.rank1.total_cmp(&b.rank1)) else {
        return html! { p.finding { "Nothing was scored." } };
    };
    let trained = best.at_training();
    // If all viewpoints are training viewpoints, it would be the same number again.
    let trained = trained.rank1().filter(|_| trained.probes < best.probes);
    html! {
        div.finding {
            p {
                @if learnt > 1 { "The best of " (learnt) ", " }
                strong { (best.name) }
                @if learnt > 1 { "," }
                " recognizes " strong { (percent(best.rank1)) " %" }
                @match &best.by_viewpoint[..] {
                    [] => {}
                    [one] => { " from its one viewpoint, azimuth " (label(one.azimuth_deg)) "°, elevation " (label(one.elevation_deg)) "°" }
                    many => { " over all " (grouped(many.len() as u64, THIN)) " viewpoints" }
                }
                @if let Some(rate) = trained { " and " strong { (percent(rate)) " %" } " where it was trained" }
                "; chance is " (percent(chance(best))) " %."
                @if let Some((band, tally)) = worst_elevation(best) {
                    " It does worst at elevations of " (band) "°: "
                    strong { (rate(tally)) " %" } "."
                }
            }
            @if let Some(which) = headline_scope::probe_sets(best) {
                p {
                    "This is on " strong { (which) } ": " (headline_scope::counts(best, THIN)) "."
                    @if let Some((worst, others)) = headline_scope::worst_other(best) {
                        @match others {
                            1 => " The other one",
                            many => { " Of the other " (many) " it does worst on " (worst.name) },
                        }
                        @if others == 1 { " is " (worst.name) }
                        ": " strong { (percent(worst.rank1)) " %" } "."
                    }
                }
            }
        }
    }
}

/// Returns the table of all recognizers, a row for each.
pub(super) fn summary(results: &ScoreResults) -> Markup {
    html! {
        h2 { "Summary" }
        div.scroll { table.summary {
            thead { tr {
                th scope="col" { "recognizer" }
                th.text scope="col" { "runtime" }
                th scope="col" { "rank-1" small { "95 % interval; tick: chance" } }
                th scope="col" { "where trained" small { "rank-1" } }
                th scope="col" { "worst elevations" small { "rank-1" } }
                th scope="col" { "one inference, µs" small { "p50 / p90 / p99" } }
            } }
            tbody { @for result in &results.recognizers {
                @let trained = result.at_training();
                tr {
                    th scope="row" { (result.name)
                        @if result.baseline { small { "baseline: nothing learnt" } }
                        small { (result.protocol)
                        @if let Some(which) = headline_scope::probe_sets(result) { ": " (which) } } }
                    td.text data-label="runtime" { (result.runtime.name) small { (result.runtime.detail()) } }
                    td data-label="rank-1" {
                        b { (percent(result.rank1)) " %" }
                        @let (low, high) = result.intervals.shown();
                        small { (percent(low)) " to " (percent(high))
                            @if result.intervals.over_people().is_some() { " over people" } }
                        small { "of " (grouped(result.probes, THIN)) " probes" }
                        (chart::interval(result))
                    }
                    td data-label="where trained" { (rate_and_interval(trained)) }
                    td data-label="worst elevations" {
                        @match worst_elevation(result) {
                            Some((band, tally)) => { (rate(tally)) " %" small { "at " (band) "°" } }
                            None => "–",
                        }
                    }
                    td data-label="one inference, µs" {
                        @match result.latency {
                            Some(latency) => {
                                (microseconds(latency.p50_us, THIN)) " / "
                                (latency.p90_us.map_or("–".into(), |us| microseconds(us, THIN))) " / "
                                (latency.p99_us.map_or("–".into(), |us| microseconds(us, THIN)))
                            }
                            None => "–",
                        }
                    }
                }
            } }
        } }
    }
}

fn rate_and_interval(tally: Tally) -> Markup {
    let interval = tally.interval();
    html! {
        @match tally.rank1() {
            Some(rank1) => {
                (percent(rank1)) " %"
                small { (percent(interval.low)) " to " (percent(interval.high)) }
            }
            None => "–",
        }
    }
}

/// Returns the elevation band with a recognizer's lowest rank-1, by name, if there are several
/// bands.
fn worst_elevation(result: &RecognizerResult) -> Option<(String, Tally)> {
    let bands = Bands::sum(&result.by_viewpoint);
    let seen = (0..ELEVATIONS.len()).filter(|&band| bands.elevation(band).probes > 0);
    let worst = bands.worst_elevation().filter(|_| seen.count() > 1);
    worst.map(|(band, tally)| (band.replace('-', "–"), tally))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::evaluate::results::tests::set;
    use crate::evaluate::results::tests::{result_of, results_of};
    use crate::report::headline_scope::tests::confounded;

    /// Returns a result for four viewpoints, of which the side view is the training viewpoint.
    pub(crate) fn grid() -> RecognizerResult {
        let mut result = result_of(&[
            (0.0, 0.0, 1, 4),
            (90.0, 0.0, 4, 4),
            (0.0, 90.0, 0, 4),
            (90.0, 90.0, 2, 4),
        ]);
        result.trained_at = vec![(90.0, 0.0)];
        result
    }

    #[test]
    fn the_best_recognizer_and_its_worst_band_are_named() {
        let mut second = grid();
        second.name = "second".into();
        let said = finding(&results_of(vec![grid(), second])).into_string();
        assert!(said.contains(
            "The best of 2, <strong>pca-svm</strong>, recognizes <strong>43.8 %</strong> over all \
             4 viewpoints and <strong>100.0 %</strong> where it was trained; chance is 3.8 %. It does \
             worst at elevations of 80–90°: <strong>25.0 %</strong>."
        ));
    }

    #[test]
    fn the_headline_is_of_the_clean_probes_and_says_so() {
        let sets = vec![
            set("normal", true, 26),
            set("fog", false, 1),
            set("bag", false, 20),
        ];
        let results = results_of(vec![confounded(sets)]);
        let said = finding(&results).into_string();
        assert!(said.contains(
            "<strong>pca-svm</strong> recognizes <strong>100.0 %</strong> from its one viewpoint, \
             azimuth 90°, elevation 0°; chance is 3.8 %."
        ), "{said}");
        assert!(said.contains(
            "This is on <strong>the clean probe set normal, 1 of 3</strong>: 26 probes of 26 people. \
             Of the other 2 it does worst on fog: <strong>3.8 %</strong>."
        ), "{said}");
        let row = summary(&results).into_string();
        assert!(row.contains("the clean probe set normal, 1 of 3"), "{row}");
        // With one elevation, there is no worst one.
        assert!(row.contains("data-label=\"worst elevations\">–<"), "{row}");
    }

    #[test]
    fn what_is_pooled_is_said() {
        let sets = vec![set("5", false, 26), set("6", false, 26)];
        let said = finding(&results_of(vec![confounded(sets)])).into_string();
        assert!(said.contains(
            "This is on <strong>all 2 probe sets, pooled (5; 6): none is known to be clean</strong>"
        ), "{said}");
    }
}

//! The beginning of the page: the best recognizer, and a table of all recognizers.

use super::cells::chance;
use super::headline_scope::{others, ranked, same_view};
use super::heatmap::label;
use super::{THIN, chart, grouped, headline_scope, microseconds, percent};
use crate::evaluate::bands::{AZIMUTHS, Bands, ELEVATIONS};
use crate::evaluate::rank1::Tally;
use crate::evaluate::results::{ProbeSetResult, RecognizerResult, ScoreResults, ViewpointResult};
use maud::{Markup, html};

/// The least difference of a hard viewpoint's rank-1 from that of all viewpoints that is stated.
const HARDER: f64 = 0.05;
/// The maximum number of azimuths, or of elevations, that are told apart without bands.
const FEW: usize = 8;
/// The maximum number of other probe sets that have a column.
const OTHERS: usize = 4;

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
    let others: Vec<&ProbeSetResult> = others(best).collect();
    html! {
        div.finding {
            p {
                @if learnt > 1 { "The best of " (learnt) ", " }
                strong { (best.name) }
                @if learnt > 1 { "," }
                " finds the right one of " (best.classes) " people in " strong { (percent(best.rank1)) " %" }
                @match &best.by_viewpoint[..] {
                    [] => {}
                    [one] => { " from its one viewpoint, azimuth " (label(one.azimuth_deg)) "°, elevation " (label(one.elevation_deg)) "°" }
                    many => { " over all " (grouped(many.len() as u64, THIN)) " viewpoints" }
                }
                @if has_each_view(best) { ", enrolled from another one" }
                @if let Some(rate) = trained { ", and in " strong { (percent(rate)) " %" } " where it was trained" }
                "; chance is " (percent(chance(best))) " %."
                @if let Some((place, rate)) = hardest(best) {
                    " It is hardest at " (place) ": " strong { (percent(rate)) " %" } "."
                }
                @match &others[..] {
                    [] => {}
                    few @ [_, ..] if few.len() <= OTHERS => {
                        " With other probes: "
                        @for (at, set) in few.iter().enumerate() {
                            @if at > 0 { ", " }
                            (set.name) " " strong { (percent(set.rank1)) " %" }
                        }
                        "."
                    }
                    many => {
                        @if let Some((worst, _)) = headline_scope::worst_other(best) {
                            " Of " (many.len()) " other sets of probes it does worst on " (worst.name) ": "
                            strong { (percent(worst.rank1)) " %" } "."
                        }
                    }
                }
            }
            @if let Some((name, times)) = as_good_and_faster(results, best) {
                p { "These people do not show that " strong { (name) } ", which is " (times) " times as fast, is worse." }
            }
            @if is_synthetic(results) {
                p { "These people are synthetic. Rates on real people are lower." }
            }
        }
    }
}

/// Returns whether a probe is compared with each viewpoint separately.
fn has_each_view(result: &RecognizerResult) -> bool {
    result.probe_sets.iter().any(|set| set.cross_view.is_some())
}

/// Returns whether the people are those that are built in.
fn is_synthetic(results: &ScoreResults) -> bool {
    let pack = results.header.settings.get("pack");
    pack.and_then(|name| name.as_str())
        .is_some_and(|name| name.starts_with("built-in") || name.starts_with("synthetic"))
}

/// Returns the fastest recognizer that is at least twice as fast as the best one and whose
/// difference from it is undecided, and how many times as fast it is.
fn as_good_and_faster<'r>(
    results: &'r ScoreResults,
    best: &RecognizerResult,
) -> Option<(&'r str, u64)> {
    let best_us = best.latency?.p50_us;
    let undecided = results.paired.iter().filter(|pair| {
        pair.recognizer == best.name && pair.probe_set.is_none() && pair.differs() == Some(false)
    });
    let faster = undecided.filter_map(|pair| {
        let other = results.learnt().find(|other| other.name == pair.other)?;
        let times = best_us / other.latency?.p50_us;
        (times >= 2.0).then_some((other.name.as_str(), times))
    });
    let (name, times) = faster.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((name, times.round() as u64))
}

/// Returns the azimuth or elevation, or the band of them, at which a recognizer is worst, and its
/// rank-1 there, if that is clearly lower than over all viewpoints.
fn hardest(result: &RecognizerResult) -> Option<(String, f64)> {
    let bands = Bands::sum(&result.by_viewpoint);
    let of = |one: &ViewpointResult, axis: usize| [one.azimuth_deg, one.elevation_deg][axis];
    let groups = |axis: usize, name: &str, bands: [(&str, Tally); 5]| {
        let all = &result.by_viewpoint;
        let mut angles: Vec<f64> = all.iter().map(|one| of(one, axis)).collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        let sum = |angle: f64| {
            all.iter()
                .filter(|one| of(one, axis) == angle)
                .map(ViewpointResult::tally)
                .sum()
        };
        let found: Vec<(String, Tally)> = if angles.len() <= FEW {
            let each = angles.iter();
            each.map(|&angle| (format!("{name} {}°", label(angle)), sum(angle)))
                .collect()
        } else {
            let each = bands.into_iter().filter(|(_, tally)| tally.probes > 0);
            each.map(|(band, tally)| (format!("{name}s of {}°", band.replace('-', "–")), tally))
                .collect()
        };
        if found.len() > 1 { found } else { Vec::new() }
    };
    let azimuths = std::array::from_fn(|band| (AZIMUTHS[band], bands.azimuth(band)));
    let elevations = std::array::from_fn(|band| (ELEVATIONS[band], bands.elevation(band)));
    let all = [
        groups(0, "azimuth", azimuths),
        groups(1, "elevation", elevations),
    ]
    .concat();
    let rates = all
        .into_iter()
        .filter_map(|(place, tally)| Some((place, tally.rank1()?)));
    let worst = rates.min_by(|a, b| a.1.total_cmp(&b.1));
    worst.filter(|(_, rate)| result.rank1 - rate >= HARDER)
}

/// Returns the table of all recognizers, a row for each, the best first.
pub(super) fn summary(results: &ScoreResults) -> Markup {
    let ranked = ranked(&results.recognizers);
    let scopes: Vec<_> = ranked.iter().map(|result| scope(result)).collect();
    // What is the same for all is said once.
    let scope = scopes
        .first()
        .filter(|first| scopes.iter().all(|scope| scope == *first));
    let has = |is: fn(&RecognizerResult) -> bool| ranked.iter().any(|result| is(result));
    let has_same_view = has(|result| same_view(result).is_some());
    let has_training = has(|result| result.at_training().probes > 0);
    let has_hardest = has(|result| hardest(result).is_some());
    let has_size = has(|result| result.model_bytes.is_some());
    let mut sets: Vec<&str> = Vec::new();
    for set in ranked.iter().flat_map(|result| others(result)) {
        if !sets.contains(&set.name.as_str()) {
            sets.push(&set.name);
        }
    }
    sets.truncate(OTHERS);
    html! {
        h2 { "Summary" }
        @if let Some(scope) = scope { p.quiet { "Rank-1 is how often the first answer is right. Protocol " (scope) "." } }
        div.scroll { table.summary {
            thead { tr {
                th scope="col" { "recognizer" }
                @if has_same_view { th scope="col" { "same view" small { "rank-1" } } }
                th scope="col" { @if has_same_view { "across views" } @else { "rank-1" }
                    small { "95 % interval; tick: chance" } }
                @for set in &sets { th scope="col" { (set) small { "rank-1" } } }
                @if has_training { th scope="col" { "where trained" small { "rank-1" } } }
                @if has_hardest { th scope="col" { "hardest" small { "rank-1" } } }
                th scope="col" { "one inference, µs" small { "p50 / p90 / p99" } }
                @if has_size { th scope="col" { "MB" } }
            } }
            tbody { @for result in ranked {
                tr {
                    th scope="row" { (result.name)
                        @if result.baseline { small { "baseline: nothing learnt" } }
                        @else { small { (result.runtime.name) " " (result.runtime.detail()) } }
                        @if scope.is_none() { small { (self::scope(result)) } } }
                    @if has_same_view { td data-label="same view" { @match same_view(result) {
                        Some(same) => { (percent(same.rank1)) " %"
                            @let (low, high) = same.intervals.shown();
                            small { (percent(low)) " to " (percent(high)) } }
                        None => "–",
                    } } }
                    td data-label=(if has_same_view { "across views" } else { "rank-1" }) {
                        b { (percent(result.rank1)) " %" }
                        @let (low, high) = result.intervals.shown();
                        small { (percent(low)) " to " (percent(high))
                            @if result.intervals.over_people().is_some() { " over people" } }
                        (chart::interval(result))
                    }
                    @for name in &sets { td data-label=(name) {
                        @match others(result).find(|set| set.name == *name) {
                            Some(set) => { (percent(set.rank1)) " %" }
                            None => "–",
                        }
                    } }
                    @if has_training {
                        td data-label="where trained" { (rate_and_interval(result.at_training())) }
                    }
                    @if has_hardest { td data-label="hardest" {
                        @match hardest(result) {
                            Some((place, rate)) => { (percent(rate)) " %" small { "at " (place) } }
                            None => "–",
                        }
                    } }
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
                    @if has_size { td data-label="MB" {
                        (result.model_bytes.map_or("–".into(), |bytes| format!("{:.2}", bytes as f64 / 1e6)))
                    } }
                }
            } }
        } }
    }
}

/// Describes the protocol and the probes of the headline rates.
fn scope(result: &RecognizerResult) -> String {
    let which = headline_scope::probe_sets(result);
    let which = which.map_or(String::new(), |which| format!(", {which}"));
    format!(
        "{}{which}: {}",
        result.protocol,
        headline_scope::counts(result, THIN)
    )
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

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::evaluate::paired_results::PairedResult;
    use crate::evaluate::results::Latency;
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
            "The best of 2, <strong>pca-svm</strong>, finds the right one of 26 people in \
             <strong>43.8 %</strong> over all 4 viewpoints, and in <strong>100.0 %</strong> where it was \
             trained; chance is 3.8 %. It is hardest at azimuth 0°: <strong>12.5 %</strong>."
        ), "{said}");
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
            "<strong>pca-svm</strong> finds the right one of 26 people in <strong>100.0 %</strong> from \
             its one viewpoint, azimuth 90°, elevation 0°; chance is 3.8 %. With other probes: fog \
             <strong>3.8 %</strong>, bag <strong>76.9 %</strong>."
        ), "{said}");
        let table = summary(&results).into_string();
        assert!(
            table.contains("the clean probe set normal, 1 of 3: 26 probes of 26 people"),
            "{table}"
        );
        assert!(
            table.contains("<td data-label=\"fog\">3.8 %</td>"),
            "{table}"
        );
        // With one viewpoint, none is the hardest.
        assert!(!table.contains("hardest"), "{table}");
    }

    #[test]
    fn a_recognizer_that_is_as_good_and_faster_is_named() {
        let timed = |name: &str, us: f64| RecognizerResult {
            name: name.into(),
            latency: Latency::from_samples(&[us]),
            ..grid()
        };
        let mut results = results_of(vec![timed("slow", 90.0), timed("fast", 3.0)]);
        let faster = |results: &ScoreResults| {
            let found = as_good_and_faster(results, &results.recognizers[0]);
            found.map(|(name, times)| (name.to_owned(), times))
        };
        assert_eq!(faster(&results), None);
        let undecided = PairedResult {
            recognizer: "slow".into(),
            other: "fast".into(),
            probe_set: None,
            people: 9,
            difference: 0.01,
            low: Some(-0.02),
            high: Some(0.03),
            by_viewpoint: Vec::new(),
        };
        results.paired = vec![undecided];
        assert_eq!(faster(&results), Some(("fast".into(), 30)));
        results.paired[0].low = Some(0.005);
        assert_eq!(faster(&results), None);
    }

    #[test]
    fn what_is_pooled_is_said() {
        let sets = vec![set("5", false, 26), set("6", false, 26)];
        let said = summary(&results_of(vec![confounded(sets)])).into_string();
        assert!(
            said.contains("all 2 probe sets, pooled (5; 6): none is known to be clean"),
            "{said}"
        );
    }
}

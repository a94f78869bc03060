//! Rank-1 by person, and with whom each person is confused.

use super::percent;
use crate::evaluate::paired_results::{Confusion, PersonResult};
use crate::evaluate::results::{RecognizerResult, ScoreResults};
use maud::{Markup, html};

/// The number of people with the lowest rank-1 that the page lists for a recognizer.
const SHOWN: usize = 12;

/// Returns for each recognizer except baselines the people with the lowest rank-1; empty if hits
/// are not known by person.
pub(super) fn section(results: &ScoreResults) -> Markup {
    let named = |one: &&RecognizerResult| !one.baseline && !one.by_person.is_empty();
    let recognizers: Vec<&RecognizerResult> = results.recognizers.iter().filter(named).collect();
    if recognizers.is_empty() {
        return html! {};
    }
    html! {
        h2 { "Confusions by person" }
        p.quiet {
            "Rank-1 by person, the worst first, and the people with whom each is confused most often, with the number "
            "of probes. The JSON results list everybody."
        }
        @for recognizer in recognizers {
            details {
                summary { (recognizer.name) ": " (spread(recognizer)) }
                div.scroll { table.summary {
                    thead { tr {
                        th.text scope="col" { "person" }
                        th scope="col" { "probes" }
                        th scope="col" { "rank-1 %" }
                        th.text scope="col" { "confused with" }
                    } }
                    tbody { @for person in worst(recognizer) {
                        tr {
                            th.text scope="row" { (person.person) }
                            td data-label="probes" { (person.probes) }
                            td data-label="rank-1 %" { (percent(rank1(person))) }
                            td.text data-label="confused with" { (taken_for(&person.taken_for)) }
                        }
                    } }
                } }
            }
        }
    }
}

fn rank1(person: &PersonResult) -> f64 {
    person.hits as f64 / person.probes.max(1) as f64
}

/// Returns the people with the lowest rank-1; ties go to those listed first.
fn worst(recognizer: &RecognizerResult) -> Vec<&PersonResult> {
    let mut people: Vec<&PersonResult> = recognizer.by_person.iter().collect();
    people.sort_by(|a, b| rank1(a).total_cmp(&rank1(b)));
    people.truncate(SHOWN);
    people
}

/// Describes the number of people and the range of their rank-1.
fn spread(recognizer: &RecognizerResult) -> String {
    let rates = || recognizer.by_person.iter().map(rank1);
    let (least, most) = (rates().fold(1.0, f64::min), rates().fold(0.0, f64::max));
    format!(
        "{} people, from {} % to {} %",
        recognizer.by_person.len(),
        percent(least),
        percent(most)
    )
}

fn taken_for(all: &[Confusion]) -> String {
    let each = all
        .iter()
        .map(|confusion| format!("{} ({})", confusion.person, confusion.probes));
    each.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::{result_of, results_of};

    #[test]
    fn the_worst_stand_first_with_whom_they_are_taken_for() {
        let person = |name: &str, hits, others: &[(&str, u64)]| PersonResult {
            person: name.into(),
            probes: 10,
            hits,
            taken_for: others
                .iter()
                .map(|&(person, probes)| Confusion {
                    person: person.into(),
                    probes,
                })
                .collect(),
        };
        let mut result = result_of(&[(90.0, 0.0, 11, 20)]);
        result.by_person = vec![
            person("ann", 9, &[("bob", 1)]),
            person("bob", 2, &[("<cid>", 5), ("ann", 3)]),
        ];
        let page = section(&results_of(vec![result.clone()])).into_string();
        let (bob, ann) = (
            page.find(">bob<").expect("bob"),
            page.find(">ann<").expect("ann"),
        );
        assert!(bob < ann, "{page}");
        assert!(page.contains("&lt;cid&gt; (5), ann (3)"), "{page}");
        assert!(page.contains("2 people, from 20.0 % to 90.0 %"), "{page}");
        result.baseline = true;
        assert_eq!(section(&results_of(vec![result])).into_string(), "");
    }
}

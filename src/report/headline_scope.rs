//! Descriptions of the probes behind the headline numbers of a report.

use super::{grouped, percent};
use crate::evaluate::results::{ProbeSetResult, RecognizerResult, SameViewResult};

/// The number of probe sets that are named; further ones are only counted.
const NAMED: usize = 4;

/// Describes the probe sets that a result's headline rates pool, such as
/// `the clean probe set NM, 1 of 3`. None if there is only one set without a name of its own.
pub(super) fn probe_sets(result: &RecognizerResult) -> Option<String> {
    let (of, all) = (&result.of_probe_sets, &result.probe_sets);
    let is_clean = all.iter().any(|set| set.clean && of.contains(&set.name));
    Some(match (&of[..], all.len()) {
        ([], _) => return None,
        ([name], 0 | 1) if name == "all" => return None,
        ([name], 0 | 1) if is_clean => format!("the clean probe set {name}"),
        ([name], 0 | 1) => format!("the probe set {name}, which is not known to be clean"),
        ([name], many) => format!("the clean probe set {name}, 1 of {many}"),
        (names, many) if names.len() < many => format!(
            "{} clean probe sets of {many}, pooled ({})",
            names.len(),
            listed(names)
        ),
        (names, many) if is_clean => format!("all {many} probe sets, pooled ({})", listed(names)),
        (names, many) => format!(
            "all {many} probe sets, pooled ({}): none is known to be clean",
            listed(names)
        ),
    })
}

/// Describes the numbers behind a result's headline rates, such as `182 probes of 26 people`.
pub(super) fn counts(result: &RecognizerResult, gap: &str) -> String {
    let each = result.probe_sets.iter().any(|set| set.cross_view.is_some());
    format!(
        "{}{}",
        of_people(result.probes, result.people, gap),
        if each {
            ", each other gallery viewpoint counted separately"
        } else {
            ""
        }
    )
}

/// Returns a text such as `182 probes of 26 people`, without people if their number is not known.
pub(super) fn of_people(probes: u64, people: u64, gap: &str) -> String {
    let plural = |count: u64, one: &str, many: &str| {
        let noun = if count == 1 { one } else { many };
        format!("{} {noun}", grouped(count, gap))
    };
    let probes = plural(probes, "probe", "probes");
    match people {
        0 => probes,
        people => format!("{probes} of {}", plural(people, "person", "people")),
    }
}

/// Returns the recognizers, the best first; of equal ones the first listed.
pub(super) fn ranked(results: &[RecognizerResult]) -> Vec<&RecognizerResult> {
    let mut ranked: Vec<&RecognizerResult> = results.iter().collect();
    ranked.sort_by(|a, b| b.rank1.total_cmp(&a.rank1));
    ranked
}

/// Returns the rate where probes are seen as enrolled, of the clean set of probes, or else of the
/// first.
pub(super) fn same_view(result: &RecognizerResult) -> Option<SameViewResult> {
    let sets = &result.probe_sets;
    let leading = sets.iter().find(|set| set.clean).or_else(|| sets.first());
    leading?.cross_view.as_ref()?.same_view
}

/// Returns the sets of probes that the headline rates leave out.
pub(super) fn others(result: &RecognizerResult) -> impl Iterator<Item = &ProbeSetResult> {
    let is_other =
        |set: &&ProbeSetResult| set.probes > 0 && !result.of_probe_sets.contains(&set.name);
    result.probe_sets.iter().filter(is_other)
}

/// Returns the set with the lowest rank-1 among those that the headline rates leave out, and the
/// number of these sets.
pub(super) fn worst_other(result: &RecognizerResult) -> Option<(&ProbeSetResult, usize)> {
    let others: Vec<_> = others(result).collect();
    let worst = others
        .iter()
        .min_by(|a, b| a.rank1.total_cmp(&b.rank1))
        .copied();
    worst.map(|set| (set, others.len()))
}

/// Returns at most `most` of the sets, and a description: the clean one (the best if none is
/// clean), then those with the lowest rank-1.
pub(super) fn chosen(result: &RecognizerResult, most: usize) -> (Vec<&ProbeSetResult>, String) {
    let all = &result.probe_sets;
    if all.len() <= most {
        return (
            all.iter().collect(),
            format!("all {} probe sets", all.len()),
        );
    }
    let best = || all.iter().rev().max_by(|a, b| a.rank1.total_cmp(&b.rank1));
    let clean = all.iter().find(|set| set.clean);
    let what = if clean.is_some() { "clean" } else { "best" };
    let Some(first) = clean.or_else(best) else {
        return (Vec::new(), String::new());
    };
    let mut others: Vec<&ProbeSetResult> = all
        .iter()
        .filter(|set| !std::ptr::eq(*set, first))
        .collect();
    others.sort_by(|a, b| a.rank1.total_cmp(&b.rank1));
    others.truncate(most - 1);
    let words = format!(
        "{} of {} probe sets: the {what} one ({}, {} %) and the {} with the lowest rank-1",
        1 + others.len(),
        all.len(),
        first.name,
        percent(first.rank1),
        others.len()
    );
    (std::iter::once(first).chain(others).collect(), words)
}

/// Lists the first names and counts the rest. Names may contain commas.
fn listed(names: &[String]) -> String {
    let first = &names[..names.len().min(NAMED)];
    let rest = names.len() - first.len();
    let text = first.join("; ");
    if rest == 0 {
        text
    } else {
        format!("{text}; and {rest} more")
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::evaluate::results::tests::{result_of, set};

    /// Returns a result like the command's: 26 of 26 right on clean probes, and other sets that are
    /// not pooled.
    pub(crate) fn confounded(sets: Vec<ProbeSetResult>) -> RecognizerResult {
        let mut result = result_of(&[(90.0, 0.0, 26, 26)]);
        result.people = 26;
        result.trained_at = vec![(90.0, 0.0)];
        let has_clean = sets.iter().any(|set| set.clean);
        let leading = sets.iter().filter(|set| set.clean || !has_clean);
        result.of_probe_sets = leading.map(|set| set.name.clone()).collect();
        result.probe_sets = sets;
        result
    }

    #[test]
    fn it_is_said_which_probes_a_rate_is_of() {
        let said = |sets| probe_sets(&confounded(sets));
        assert_eq!(said(vec![]), None);
        assert_eq!(said(vec![set("all", false, 1)]), None);
        for (sets, expected) in [
            (vec![set("NM", true, 26)], "the clean probe set NM"),
            (
                vec![set("fog=1", false, 2)],
                "the probe set fog=1, which is not known to be clean",
            ),
            (
                vec![set("NM", true, 26), set("BG", false, 2)],
                "the clean probe set NM, 1 of 2",
            ),
            (
                vec![set("5", false, 26), set("6", false, 2)],
                "all 2 probe sets, pooled (5; 6): none is known to be clean",
            ),
            (
                vec![
                    set("5, NM", true, 26),
                    set("6, NM", true, 2),
                    set("6, BG", false, 2),
                ],
                "2 clean probe sets of 3, pooled (5, NM; 6, NM)",
            ),
            (
                "abcdef"
                    .chars()
                    .map(|name| set(&name.to_string(), true, 1))
                    .collect(),
                "all 6 probe sets, pooled (a; b; c; d; and 2 more)",
            ),
        ] {
            assert_eq!(said(sets).as_deref(), Some(expected));
        }
    }

    #[test]
    fn of_many_sets_the_clean_one_and_the_worst_are_chosen() {
        let names = ["a", "b", "c", "d", "e", "normal", "g", "h"];
        let hits = [20, 3, 19, 1, 18, 26, 5, 17];
        let sets = names.iter().zip(hits);
        let sets = sets.map(|(name, hits)| set(name, *name == "normal", hits));
        let mut result = confounded(sets.collect());
        let names = |(sets, words): (Vec<&ProbeSetResult>, String)| {
            let names: Vec<String> = sets.iter().map(|set| set.name.clone()).collect();
            (names.join(" "), words)
        };
        assert_eq!(
            names(chosen(&result, 4)),
            (
                "normal d b g".into(),
                "4 of 8 probe sets: the clean one (normal, 100.0 %) and the 3 with the lowest rank-1".into()
            )
        );
        assert_eq!(
            names(chosen(&result, 8)),
            ("a b c d e normal g h".into(), "all 8 probe sets".into())
        );
        let (worst, others) = worst_other(&result).expect("there are others");
        assert_eq!((worst.name.as_str(), others), ("d", 7));
        result.probe_sets[5].clean = false;
        assert_eq!(
            names(chosen(&result, 2)),
            (
                "normal d".into(),
                "2 of 8 probe sets: the best one (normal, 100.0 %) and the 1 with the lowest rank-1".into()
            )
        );
    }

    #[test]
    fn counts_have_their_noun() {
        assert_eq!(of_people(1, 1, ","), "1 probe of 1 person");
        assert_eq!(of_people(18_278, 26, ","), "18,278 probes of 26 people");
        assert_eq!(of_people(2, 0, ","), "2 probes");
    }
}

//! The CMC and ROC charts of the page.

use maud::{Markup, html};

use super::chart::{ChartCurve, curves, legend};
use super::drawing::LINES;
use super::drawing::Tick;
use super::{THIN, headline_scope};
use crate::evaluate::results::{ProbeSetResult, RecognizerResult};

/// The maximum number of ranks in the chart of the CMC.
const RANKS: usize = 20;

/// The lines of one pair of charts, each with its name, and a description.
struct ChartPair<'a> {
    lines: Vec<(String, &'a ProbeSetResult)>,
    /// The recognizer, if all lines are of one.
    name: Option<&'a str>,
    words: String,
    /// Number of people to choose from.
    classes: usize,
}

/// Draws CMC and ROC of all recognizers: one pair of charts if there are few enough sets of probes,
/// else one pair for each recognizer, with the sets of [`headline_scope::chosen`]. None without
/// lines.
pub(super) fn charts(results: &[RecognizerResult]) -> Option<Markup> {
    let drawn: Vec<Markup> = pairs(results).iter().filter_map(pair).collect();
    (!drawn.is_empty()).then(|| html! { @for one in drawn { (one) } })
}

fn pairs(results: &[RecognizerResult]) -> Vec<ChartPair<'_>> {
    let sets: usize = results.iter().map(|result| result.probe_sets.len()).sum();
    let one_each = results.iter().all(|result| result.probe_sets.len() <= 1);
    if sets > LINES.len() && !one_each {
        return results.iter().map(of_one).collect();
    }
    let lines = results.iter().flat_map(|result| {
        let alone = result.probe_sets.len() == 1;
        let name = move |set: &ProbeSetResult| {
            if alone && set.name == "all" {
                result.name.clone()
            } else {
                format!("{}, {}", result.name, set.name)
            }
        };
        let sets = result.probe_sets.iter();
        sets.map(move |set| (name(set), set))
    });
    let lines: Vec<_> = lines.take(LINES.len()).collect();
    let words = if lines.len() < sets {
        format!(
            "The first {} of {sets} recognizers; all are in the summary",
            lines.len()
        )
    } else {
        "All recognizers and probe sets".to_owned()
    };
    vec![ChartPair {
        lines,
        name: None,
        words,
        classes: results
            .iter()
            .map(|result| result.classes)
            .max()
            .unwrap_or(0),
    }]
}

fn of_one(result: &RecognizerResult) -> ChartPair<'_> {
    let (sets, which) = headline_scope::chosen(result, LINES.len());
    ChartPair {
        lines: sets.iter().map(|set| (set.name.clone(), *set)).collect(),
        name: Some(&result.name),
        words: format!(
            "The charts show {which}; the table of {} has all",
            result.name
        ),
        classes: result.classes,
    }
}

fn pair(pair: &ChartPair<'_>) -> Option<Markup> {
    let sets = || pair.lines.iter().map(|(_, set)| *set);
    // The last rank is the number of people, at most `RANKS`.
    let last = pair.classes.clamp(1, RANKS);
    let place = |rank: usize| (rank - 1) as f64 / (last - 1).max(1) as f64;
    let cmc: Vec<ChartCurve> = pair
        .lines
        .iter()
        .map(|(name, set)| {
            let ranks = set.cmc.iter().take(last).zip(1..);
            let points = ranks.map(|(&rate, rank)| (place(rank), rate));
            ChartCurve {
                name: name.clone(),
                points: points.collect(),
            }
        })
        .collect();
    let mut ranks: Vec<usize> = [1, 5, 10].into_iter().filter(|&r| r < last).collect();
    ranks.push(last);
    let ranks: Vec<_> = ranks
        .into_iter()
        .map(|rank| Tick::new(place(rank), rank))
        .collect();
    let cmc = curves("Right person within rank k (CMC)", "rank k", &ranks, &cmc);
    let roc: Vec<ChartCurve> = pair
        .lines
        .iter()
        .map(|(name, set)| {
            let points = set.verification.iter().flat_map(|found| &found.roc);
            // From 1e-4 to 1, a quarter of the axis for each power of ten.
            let place = |far: f64| 1.0 + far.max(1e-4).log10() / 4.0;
            let points = points.map(|at| (place(at.far), at.tar));
            ChartCurve {
                name: name.clone(),
                points: points.collect(),
            }
        })
        .collect();
    let fars = ["0.01", "0.1", "1", "10", "100"].into_iter().zip(0..);
    let fars: Vec<_> = fars
        .map(|(text, quarter)| Tick::new(f64::from(quarter) / 4.0, text))
        .collect();
    let roc = curves(
        "True accept rate (ROC)",
        "false accept rate, %",
        &fars,
        &roc,
    );
    if cmc.is_none() && roc.is_none() {
        return None;
    }
    let names: Vec<&str> = pair.lines.iter().map(|(name, _)| name.as_str()).collect();
    Some(html! {
        @if let Some(name) = pair.name { h3 { (name) } }
        p {
            (pair.words) ". " (counts(sets())) ", " (pair.classes) " to choose from. CMC: the share of probes "
            "whose person is among the k nearest people"
            @if roc.is_some() { ". ROC: the share of genuine pairs accepted, against that of impostor pairs" } "."
        }
        @if sets().any(|set| set.verification.is_none()) {
            p.quiet { "There is no ROC for sets with more than ten million pairs." }
        }
        div.pair {
            @if let Some(cmc) = cmc { (cmc) }
            @if let Some(roc) = roc { (roc) }
        }
        (legend(&names))
    })
}

/// Describes the numbers of probes and people of the lines.
fn counts<'a>(sets: impl Iterator<Item = &'a ProbeSetResult> + Clone) -> String {
    let least = sets.clone().min_by_key(|set| set.probes);
    let most = sets.max_by_key(|set| set.probes);
    match (least, most) {
        (Some(least), Some(most)) if least.probes == most.probes => format!(
            "Each line has {}",
            headline_scope::of_people(most.probes, most.people, THIN)
        ),
        (Some(least), Some(most)) => format!(
            "The lines have {} to {}",
            super::grouped(least.probes, THIN),
            headline_scope::of_people(most.probes, most.people, THIN)
        ),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::VerificationResult;
    use crate::evaluate::results::tests::result_of;
    use crate::evaluate::results::tests::set;
    use crate::evaluate::verification::RocPoint;
    use crate::report::headline_scope::tests::confounded;
    use crate::report::text_extent::assert_texts_are_readable;

    fn with_roc(mut set: ProbeSetResult, points: &[(f64, f64)]) -> ProbeSetResult {
        set.verification = Some(VerificationResult {
            genuine: 10,
            impostors: 200,
            non_finite_genuine: 0,
            non_finite_impostors: 0,
            eer: None,
            eer_threshold: None,
            eer_low: None,
            eer_high: None,
            auc: None,
            tar_at_far: Vec::new(),
            roc: points
                .iter()
                .map(|&(far, tar)| RocPoint { far, tar })
                .collect(),
        });
        set
    }

    #[test]
    fn curves_are_drawn_to_scale() {
        let bare = result_of(&[(90.0, 0.0, 19, 20)]);
        assert!(charts(&[bare]).is_none());
        let mut one = with_roc(
            set("all", false, 13),
            &[(0.0, 0.25), (0.01, 0.5), (1.0, 1.0)],
        );
        one.cmc = vec![0.5, 0.6];
        let page = charts(&[confounded(vec![one])])
            .expect("two charts")
            .into_string();
        // 50 % at rank 1, 60 % at rank 2 of 20.
        assert!(page.contains("M54.0 112.0L69.8 92.0"), "{page}");
        // 0 is drawn at 1e-4; 1 % is halfway to 100 %.
        assert!(
            page.contains("M54.0 162.0L204.0 112.0L354.0 12.0"),
            "{page}"
        );
        assert!(page.contains("Each line has 26 probes of 26 people, 26 to choose from."));
        assert_texts_are_readable(&page);
    }

    #[test]
    fn charts_of_76_sets_say_which_six_they_show_and_why() {
        let mut sets = vec![set("normal", true, 26)];
        sets.extend((0..75).map(|at| set(&format!("c{at}"), false, 25 - at % 25)));
        // The worst is the last.
        sets.push(set("fog", false, 0));
        sets.remove(1);
        let mut other = confounded(sets.clone());
        other.name = "spread".into();
        let page = charts(&[confounded(sets), other])
            .expect("charts")
            .into_string();
        for name in ["pca-svm", "spread"] {
            let said = format!(
                "<h3>{name}</h3><p>The charts show 6 of 76 probe sets: the clean one (normal, 100.0 %) and the 5 with the lowest rank-1; the table of {name} has all."
            );
            assert!(page.contains(&said), "{page}");
        }
        // A chart for each recognizer, with the worst sets rather than the first six.
        assert_eq!(page.matches("<svg class=\"curves\"").count(), 2);
        assert_eq!(page.matches("> fog</span>").count(), 2);
        assert!(
            page.contains("> c24</span>") && !page.contains("> c1</span>"),
            "{page}"
        );
    }

    #[test]
    fn ranks_end_at_the_number_of_people() {
        for (classes, last) in [
            (1, ">1<"),
            (2, ">2<"),
            (6, ">6<"),
            (12, ">12<"),
            (500, ">20<"),
        ] {
            let mut result = confounded(vec![set("a", false, 13), set("b", false, 12)]);
            result.classes = classes;
            result.probe_sets[0].cmc = vec![0.5; 50];
            let Some(page) = charts(&[result]) else {
                assert_eq!(classes, 1, "nothing to choose, nothing to draw");
                continue;
            };
            let page = page.into_string();
            assert!(page.contains(last), "{page}");
            assert!(page.contains("pca-svm, a") && page.contains("All recognizers and probe sets"));
            assert_texts_are_readable(&page);
        }
    }
}

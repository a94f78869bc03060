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
    words: String,
    /// Number of people to choose from.
    classes: usize,
}

/// Draws CMC and ROC of all recognizers: of all sets of probes if there are few enough, else of the
/// first set of each; [`more`] has the others. None without lines.
pub(super) fn charts(results: &[RecognizerResult]) -> Option<Markup> {
    pair(&match results {
        _ if has_all(results) => of_all(results),
        [one] => of_one(one),
        _ => of_first(results),
    })
}

/// Draws CMC and ROC of one recognizer of several, if [`charts`] shows only one of its sets.
pub(super) fn more(result: &RecognizerResult, results: &[RecognizerResult]) -> Option<Markup> {
    let is_first_only = results.len() > 1 && !has_all(results);
    is_first_only.then(|| pair(&of_one(result))).flatten()
}

/// Returns whether there are few enough sets of probes for one pair of charts.
fn has_all(results: &[RecognizerResult]) -> bool {
    let sets: usize = results.iter().map(|result| result.probe_sets.len()).sum();
    sets <= LINES.len() || results.iter().all(|result| result.probe_sets.len() <= 1)
}

/// Returns the sets of [`headline_scope::chosen`].
fn of_one(result: &RecognizerResult) -> ChartPair<'_> {
    let (sets, which) = headline_scope::chosen(result, LINES.len());
    ChartPair {
        lines: sets.iter().map(|set| (set.name.clone(), *set)).collect(),
        words: format!("The charts show {which}; the table above has all"),
        classes: result.classes,
    }
}

/// Returns the first set of each of the best recognizers.
fn of_first(results: &[RecognizerResult]) -> ChartPair<'_> {
    fn first(result: &RecognizerResult) -> Option<(String, &ProbeSetResult)> {
        let (sets, _) = headline_scope::chosen(result, 1);
        Some((result.name.clone(), *sets.first()?))
    }
    let lines = headline_scope::ranked(results)
        .into_iter()
        .filter_map(first)
        .take(LINES.len());
    let lines: Vec<_> = lines.collect();
    ChartPair {
        words: format!(
            "The best {} of {} recognizers on their headline probes; those on others are below, by recognizer",
            lines.len(),
            results.len()
        ),
        lines,
        classes: results
            .iter()
            .map(|result| result.classes)
            .max()
            .unwrap_or(0),
    }
}

fn of_all(results: &[RecognizerResult]) -> ChartPair<'_> {
    let sets: usize = results.iter().map(|result| result.probe_sets.len()).sum();
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
    ChartPair {
        lines,
        words,
        classes: results
            .iter()
            .map(|result| result.classes)
            .max()
            .unwrap_or(0),
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
        let both = [confounded(sets), other];
        let page = charts(&both).expect("charts").into_string();
        assert!(
            page.contains("The best 2 of 2 recognizers on their headline probes"),
            "{page}"
        );
        assert!(page.contains("> pca-svm</span>") && page.contains("> spread</span>"));
        let page = more(&both[1], &both).expect("charts").into_string();
        let alone = charts(&both[..1]).expect("charts").into_string();
        assert!(more(&both[0], &both[..1]).is_none());
        assert_eq!(page, alone);
        let said = "<p>The charts show 6 of 76 probe sets: the clean one (normal, 100.0 %) and the 5 with the lowest rank-1; the table above has all.";
        assert!(page.contains(said), "{page}");
        // The worst sets rather than the first six.
        assert_eq!(page.matches("<svg class=\"curves\"").count(), 1);
        assert_eq!(page.matches("> fog</span>").count(), 1);
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

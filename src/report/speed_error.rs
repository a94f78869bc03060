//! The first picture of the report: Rank-1 against the time of an inference (inline SVG).

use super::axis_ticks::LogAxis;
use super::drawing::{Axes, LINES, percents, to_tenth};
use super::standalone::standalone;
use super::{THIN, microseconds, percent};
use crate::evaluate::results::{RecognizerResult, ScoreResults};
use maud::{Markup, html};

/// Space between the names beside the picture, so that they do not overlap.
const LINE: f64 = 16.0;
const AXES: Axes = Axes {
    left: 54.0,
    top: 12.0,
    width: 400.0,
    height: 240.0,
};

const SIZE: (f64, f64) = (620.0, 300.0);
const TITLE: &str = "Rank-1 against the time of an inference; the table has the numbers";

/// A recognizer's place, with both coordinates 0..1.
struct TimedRate<'a> {
    result: &'a RecognizerResult,
    us: f64,
    at: (f64, f64),
    /// Whether no faster recognizer is right as often.
    is_best: bool,
}

/// Draws Rank-1 with its interval against the median time of an inference, and a line through the
/// recognizers that no other one beats in both. None with fewer than two known times.
fn plot(results: &ScoreResults) -> Option<Markup> {
    let timed = results.recognizers.iter().filter_map(|result| {
        let us = result.latency?.p50_us;
        (us > 0.0 && result.probes > 0).then_some((result, us))
    });
    let mut timed: Vec<(&RecognizerResult, f64)> = timed.collect();
    if timed.len() < 2 {
        return None;
    }
    // The faster first, and of equally fast ones the better.
    timed.sort_by(|a, b| a.1.total_cmp(&b.1).then(b.0.rank1.total_cmp(&a.0.rank1)));
    let across = LogAxis::around(timed.iter().map(|(_, us)| *us));
    let mut best = f64::NEG_INFINITY;
    let marks: Vec<TimedRate<'_>> = { timed.into_iter() }
        .map(|(result, us)| {
            let is_best = result.rank1 > best;
            best = best.max(result.rank1);
            TimedRate {
                result,
                us,
                at: (across.place(us), result.rank1),
                is_best,
            }
        })
        .collect();
    let times = across.ticks();
    let line = { marks.iter() }
        .filter(|mark| mark.is_best)
        .map(|mark| mark.at);
    Some(html! {
        (AXES.across(&percents([0, 25, 50, 75, 100])))
        (AXES.upwards(&times))
        (AXES.below(&times))
        text.axis x=(to_tenth(AXES.left + AXES.width / 2.0)) y="292" text-anchor="middle" {
            "one inference on this machine, µs (median)"
        }
        (AXES.curve("no other recognizer is both faster and better", line, LINES[0]))
        @for (mark, name_y) in marks.iter().zip(names_y(&marks)) { (drawn(mark, name_y)) }
    })
}

/// Returns [`plot`] as a figure of the page.
pub(super) fn figure(results: &ScoreResults) -> Option<Markup> {
    let plot = plot(results)?;
    Some(html! {
        figure {
            div.wide { svg.angles viewBox=(format!("0 0 {} {}", SIZE.0, SIZE.1)) role="img" aria-label=(TITLE) { (plot) } }
            figcaption {
                "Rank-1 (" (scope(results)) ") against the time of one inference. Bars are 95 % intervals. The line "
                "joins the recognizers that no other one beats in both. Baselines, which have learnt nothing, are hollow."
            }
        }
    })
}

/// Returns [`plot`] as a file (SVG).
pub(crate) fn speed_error_svg(results: &ScoreResults) -> Option<String> {
    Some(standalone(SIZE, TITLE, &plot(results)?))
}

/// Describes what the rates are of.
fn scope(results: &ScoreResults) -> &'static str {
    let mut sets = results
        .recognizers
        .iter()
        .flat_map(|result| &result.probe_sets);
    if sets.any(|set| set.cross_view.is_some()) {
        "across viewpoints"
    } else {
        "as in the table below"
    }
}

/// Returns the height of each name beside the picture: that of its mark, or as near as there is room.
fn names_y(marks: &[TimedRate<'_>]) -> Vec<f64> {
    let wanted = |at: usize| AXES.place(marks[at].at).1;
    let mut order: Vec<usize> = (0..marks.len()).collect();
    order.sort_by(|&a, &b| wanted(a).total_cmp(&wanted(b)));
    let mut places = vec![0.0; marks.len()];
    let mut lowest = f64::INFINITY;
    // From below, so that the last fits above the axis, and then downwards.
    let bottom = AXES.top + AXES.height;
    for (above, &at) in order.iter().rev().enumerate() {
        let most = bottom - LINE * above as f64;
        lowest = wanted(at).min(most).min(lowest - LINE);
        places[at] = lowest;
    }
    let mut highest = f64::NEG_INFINITY;
    for &at in &order {
        places[at] = places[at].max(highest + LINE).max(AXES.top);
        highest = places[at];
    }
    places
}

/// Draws a recognizer's mark, its interval and its name.
fn drawn(mark: &TimedRate<'_>, name_y: f64) -> Markup {
    let TimedRate { result, us, at, .. } = mark;
    let (low, high) = result.intervals.shown();
    let [(x, y), (_, low_y), (_, high_y)] = [at.1, low, high].map(|rate| AXES.place((at.0, rate)));
    let beside = AXES.left + AXES.width;
    let colour = LINES[usize::from(result.baseline)].colour;
    html! {
        line.rail x1=(to_tenth(x)) x2=(to_tenth(beside + 8.0)) y1=(to_tenth(y)) y2=(to_tenth(name_y)) {}
        text.axis x=(to_tenth(beside + 12.0)) y=(to_tenth(name_y + 4.0)) { (result.name) }
        line.error stroke=(colour) x1=(to_tenth(x)) x2=(to_tenth(x)) y1=(to_tenth(low_y)) y2=(to_tenth(high_y)) {}
        circle cx=(to_tenth(x)) cy=(to_tenth(y)) r="4.5"
            stroke=(colour) fill=(if result.baseline { "none" } else { colour }) {
            title {
                (result.name) ": " (percent(result.rank1)) " % (" (percent(low)) " to " (percent(high)) "), "
                (microseconds(*us, THIN)) " µs"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::Latency;
    use crate::evaluate::results::tests::{result_of, results_of};
    use crate::report::text_extent::assert_texts_are_readable;

    fn timed(name: &str, hits: u64, us: f64) -> RecognizerResult {
        let mut result = result_of(&[(90.0, 0.0, hits, 100)]);
        result.name = name.into();
        result.latency = Latency::from_samples(&[us]);
        result
    }

    #[test]
    fn the_line_joins_those_that_none_beats_in_both() {
        let all = vec![
            timed("slow", 80, 1000.0),
            timed("fast", 40, 10.0),
            timed("beaten", 30, 100.0),
            timed("middle", 60, 100.0),
        ];
        let svg = plot(&results_of(all)).expect("times").into_string();
        // 10 to 1000 us in the middle of the axis: 40, 60 and 80 % of 240 pixels above 252.
        let x = |us: f64| 54.0 + 400.0 * (us * 1.3 / 10.0).ln() / 169f64.ln();
        let [a, b, c] = [10.0, 100.0, 1000.0].map(x);
        assert!(
            svg.contains(&format!("d=\"M{a:.1} 156.0L{b:.1} 108.0L{c:.1} 60.0\"")),
            "{svg}"
        );
        assert_texts_are_readable(&svg);
    }

    #[test]
    fn names_are_apart_though_marks_are_not() {
        for count in [2, 8, 15] {
            let all = (0..count).map(|at| timed(&format!("n{at}"), 1, 10.0 + f64::from(at)));
            let all: Vec<_> = all.collect();
            let svg = plot(&results_of(all)).expect("times").into_string();
            assert_texts_are_readable(&svg);
        }
        assert!(plot(&results_of(vec![timed("alone", 1, 1.0)])).is_none());
    }
}

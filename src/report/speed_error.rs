//! The first picture of the report: Rank-1 against the time of an inference (inline SVG).

use super::axis_ticks::LogAxis;
use super::drawing::{Axes, LINES, percents, to_tenth};
use super::standalone::standalone;
use super::{THIN, microseconds, percent};
use crate::evaluate::results::{RecognizerResult, ScoreResults};
use maud::{Markup, html};

/// Space between the names beside the picture, so that they do not overlap.
const LINE: f64 = 16.0;
/// The height of the area of the marks, unless their names need more.
const HEIGHT: f64 = 240.0;
/// The maximum width of a letter of a name.
const LETTER: f64 = 10.0;
const TITLE: &str = "Rank-1 against the time of an inference";

/// What a mark of the picture shows: how fast and how right a recognizer is.
pub(crate) struct SpeedError {
    pub(crate) name: String,
    /// The board: marks of one have one colour and one line.
    pub(crate) board: usize,
    /// The median time of an inference in microseconds, and its range, if known.
    pub(crate) us: f64,
    pub(crate) us_range: Option<(f64, f64)>,
    /// The rank-1, 0..=1, and its interval.
    pub(crate) rank1: f64,
    pub(crate) rank1_range: (f64, f64),
    /// Whether it has learnt nothing.
    pub(crate) is_baseline: bool,
}

impl SpeedError {
    fn colour(&self) -> &'static str {
        LINES[self.board % LINES.len()].colour
    }
}

/// A picture of rank-1 against time.
pub(crate) struct SpeedErrorPlot {
    /// Width and height, pixels.
    size: (f64, f64),
    content: Markup,
}

impl SpeedErrorPlot {
    /// Draws the picture: for each mark its interval, and for each board a line through the marks
    /// that no other of the same board beats in both. None with fewer than two marks.
    pub(crate) fn of(mut all: Vec<SpeedError>, axis: &str) -> Option<Self> {
        if all.len() < 2 {
            return None;
        }
        // The faster first, and of equally fast ones the better.
        all.sort_by(|a, b| a.us.total_cmp(&b.us).then(b.rank1.total_cmp(&a.rank1)));
        let axes = Axes {
            left: 54.0,
            top: 12.0,
            width: 400.0,
            height: HEIGHT.max(LINE * all.len() as f64),
        };
        let ends = |one: &SpeedError| one.us_range.unwrap_or((one.us, one.us));
        let across = LogAxis::around(all.iter().flat_map(|one| [ends(one).0, ends(one).1]));
        let at = |us: f64, rank1: f64| axes.place((across.place(us), rank1));
        let places: Vec<(f64, f64)> = all.iter().map(|one| at(one.us, one.rank1)).collect();
        let mut boards: Vec<usize> = all.iter().map(|one| one.board).collect();
        boards.sort_unstable();
        boards.dedup();
        let line = |board: usize| {
            let best = best_of(&all, board);
            let points = best.map(|one| (across.place(one.us), one.rank1));
            let style = LINES[board % LINES.len()];
            axes.curve(
                "no other recognizer is both faster and better",
                points,
                style,
            )
        };
        let times = across.ticks();
        let content = html! {
            (axes.across(&percents([0, 25, 50, 75, 100])))
            (axes.upwards(&times))
            (axes.below(&times))
            text.axis x=(to_tenth(axes.left + axes.width / 2.0)) y=(to_tenth(axes.top + axes.height + 40.0))
                text-anchor="middle" { (axis) }
            @for board in boards { (line(board)) }
            @for ((one, &(x, y)), name_y) in all.iter().zip(&places).zip(names_y(&axes, &places)) {
                @let (left, right) = (at(ends(one).0, one.rank1).0, at(ends(one).1, one.rank1).0);
                @let (low, high) = (at(one.us, one.rank1_range.0).1, at(one.us, one.rank1_range.1).1);
                (drawn(one, (x, y), &axes, name_y))
                path.error fill="none" stroke=(one.colour())
                    d=(format!("M{left:.1} {y:.1}L{right:.1} {y:.1}M{x:.1} {low:.1}L{x:.1} {high:.1}")) {}
            }
        };
        let longest = all.iter().map(|one| one.name.chars().count()).max();
        let names = 20.0 + LETTER * longest.unwrap_or(0) as f64;
        Some(Self {
            size: (
                axes.left + axes.width + names,
                axes.top + axes.height + 48.0,
            ),
            content,
        })
    }

    /// Returns the picture as a file (SVG).
    pub(crate) fn file(&self) -> String {
        standalone(self.size, TITLE, &self.content)
    }
}

/// Returns the marks of a board that no other of it beats in both, of all marks by time.
fn best_of(all: &[SpeedError], board: usize) -> impl Iterator<Item = &SpeedError> {
    let mut best = f64::NEG_INFINITY;
    all.iter().filter(move |one| {
        let is_best = one.board == board && one.rank1 > best;
        if is_best {
            best = one.rank1;
        }
        is_best
    })
}

/// Returns the picture of the results; none with fewer than two known times.
fn plot(results: &ScoreResults) -> Option<SpeedErrorPlot> {
    let of = |result: &RecognizerResult| {
        let us = result.latency?.p50_us;
        (us > 0.0 && result.probes > 0).then(|| SpeedError {
            name: result.name.clone(),
            board: 0,
            us,
            us_range: None,
            rank1: result.rank1,
            rank1_range: result.intervals.shown(),
            is_baseline: result.baseline,
        })
    };
    let all = results.recognizers.iter().filter_map(of).collect();
    SpeedErrorPlot::of(all, "one inference on this machine, µs (median)")
}

/// Returns [`plot`] as a figure of the page.
pub(super) fn figure(results: &ScoreResults) -> Option<Markup> {
    let SpeedErrorPlot { size, content } = plot(results)?;
    Some(html! {
        figure {
            div.wide { svg.angles viewBox=(format!("0 0 {} {}", size.0, size.1)) role="img"
                aria-label={ (TITLE) "; the table has the numbers" } { (content) } }
            figcaption {
                "Rank-1 (" (scope(results)) ") against the time of one inference. Bars are 95 % intervals. The line "
                "joins the recognizers that no other one beats in both. Baselines, which have learnt nothing, are hollow."
            }
        }
    })
}

/// Returns [`plot`] as a file (SVG).
pub(crate) fn speed_error_svg(results: &ScoreResults) -> Option<String> {
    Some(plot(results)?.file())
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
fn names_y(axes: &Axes, marks: &[(f64, f64)]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..marks.len()).collect();
    order.sort_by(|&a, &b| marks[a].1.total_cmp(&marks[b].1));
    let mut places = vec![0.0; marks.len()];
    let mut lowest = f64::INFINITY;
    // From below, so that the last fits above the axis, and then downwards.
    let bottom = axes.top + axes.height;
    for (above, &at) in order.iter().rev().enumerate() {
        let most = bottom - LINE * above as f64;
        lowest = marks[at].1.min(most).min(lowest - LINE);
        places[at] = lowest;
    }
    let mut highest = f64::NEG_INFINITY;
    for &at in &order {
        places[at] = places[at].max(highest + LINE).max(axes.top);
        highest = places[at];
    }
    places
}

/// Draws a recognizer's mark, and its name beside the picture.
fn drawn(one: &SpeedError, (x, y): (f64, f64), axes: &Axes, name_y: f64) -> Markup {
    let beside = axes.left + axes.width;
    let (colour, (low, high)) = (one.colour(), one.rank1_range);
    html! {
        line.rail x1=(to_tenth(x)) x2=(to_tenth(beside + 8.0)) y1=(to_tenth(y)) y2=(to_tenth(name_y)) {}
        text.axis x=(to_tenth(beside + 12.0)) y=(to_tenth(name_y + 4.0)) { (one.name) }
        circle cx=(to_tenth(x)) cy=(to_tenth(y)) r="4.5"
            stroke=(colour) fill=(if one.is_baseline { "none" } else { colour }) {
            title {
                (one.name) ": " (percent(one.rank1)) " % (" (percent(low)) " to " (percent(high)) "), "
                (microseconds(one.us, THIN)) " µs"
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
        let svg = plot(&results_of(all)).expect("times").file();
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
            let svg = plot(&results_of(all)).expect("times").file();
            assert_texts_are_readable(&svg);
        }
        assert!(plot(&results_of(vec![timed("alone", 1, 1.0)])).is_none());
    }
}

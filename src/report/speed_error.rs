//! The first picture of the report: Rank-1 against the time of an inference (inline SVG).

use super::axis_ticks::{LogAxis, labels};
use super::drawing::{Axes, LINES, percents, to_tenth};
use super::standalone::standalone;
use super::{THIN, microseconds, percent};
use crate::evaluate::results::{RecognizerResult, ScoreResults};
use maud::{Markup, html};

/// The height of a line of text, and the maximum width of a letter of a name.
const LINE: i32 = 16;
const LETTER: i32 = 10;
/// The height of the area of the marks, unless their names need more.
const HEIGHT: f64 = 240.0;
/// The distance of a name from its mark from which a line joins them.
const NEAR: i32 = 40;
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
            top: 32.0,
            width: 400.0,
            height: HEIGHT.max(f64::from(LINE) * all.len() as f64),
        };
        let ends = |one: &SpeedError| one.us_range.unwrap_or((one.us, one.us));
        let across = LogAxis::around(all.iter().flat_map(|one| [ends(one).0, ends(one).1]));
        let at = |us: f64, rank1: f64| axes.place((across.place(us), rank1));
        let places: Vec<(f64, f64)> = all.iter().map(|one| at(one.us, one.rank1)).collect();
        let points: Vec<(i32, i32)> = places.iter().map(|at| (at.0 as i32, at.1 as i32)).collect();
        let width = |one: &SpeedError| LETTER * one.name.chars().count() as i32;
        let sizes: Vec<(i32, i32)> = all.iter().map(|one| (width(one), LINE)).collect();
        let longest = all.iter().map(width).max().unwrap_or(0);
        let picture = (
            (axes.left + axes.width) as i32 + 16 + longest,
            (axes.top + axes.height) as i32 + 48,
        );
        let names = labels(&points, &sizes, (picture.0, picture.1 - 48));
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
            text.axis x="8" y="16" { "right person found (rank-1)" }
            text.axis x=(to_tenth(axes.left + axes.width / 2.0)) y=(to_tenth(axes.top + axes.height + 40.0))
                text-anchor="middle" { (axis) }
            @for board in boards { (line(board)) }
            @for (one, &(x, y)) in all.iter().zip(&places) {
                @let (left, right) = (at(ends(one).0, one.rank1).0, at(ends(one).1, one.rank1).0);
                @let (low, high) = (at(one.us, one.rank1_range.0).1, at(one.us, one.rank1_range.1).1);
                (mark(one, (x, y)))
                path.error fill="none" stroke=(one.colour())
                    d=(format!("M{left:.1} {y:.1}L{right:.1} {y:.1}M{x:.1} {low:.1}L{x:.1} {high:.1}")) {}
            }
            @for ((one, &from), &(x, y)) in all.iter().zip(&points).zip(&names) {
                @if (x - from.0).abs().max((y - from.1).abs()) > NEAR {
                    line.rail x1=(from.0) y1=(from.1) x2=(x) y2=(y + LINE - 5) {}
                }
                text.axis x=(x) y=(y + LINE - 5) { (one.name) }
            }
        };
        Some(Self {
            size: (f64::from(picture.0), f64::from(picture.1)),
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

/// Draws a recognizer's mark.
fn mark(one: &SpeedError, (x, y): (f64, f64)) -> Markup {
    let (colour, (low, high)) = (one.colour(), one.rank1_range);
    html! {
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
        // 10 to 1000 us in the middle of the axis: 40, 60 and 80 % of 240 pixels above 272.
        let x = |us: f64| 54.0 + 400.0 * (us * 1.3 / 10.0).ln() / 169f64.ln();
        let [a, b, c] = [10.0, 100.0, 1000.0].map(x);
        assert!(
            svg.contains(&format!("d=\"M{a:.1} 176.0L{b:.1} 128.0L{c:.1} 80.0\"")),
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

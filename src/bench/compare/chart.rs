//! The chart of latency against rank-1 (SVG): one point for each model and board.

use super::{Compared, Met, p50_range};
use crate::error::{Error, Result};
use crate::report::axis_ticks::{LogAxis, NUMBER, labels};
use crate::report::drawing::{Axes, LINES, percents, to_tenth};
use crate::report::standalone::{LETTER, standalone};
use crate::report::{microseconds, percent};
use maud::{Markup, html};

/// The area of the plot.
const CHART: Axes = Axes {
    left: 64.0,
    top: 32.0,
    width: 640.0,
    height: 480.0,
};
const HEIGHT: f64 = 570.0;
/// The x of the list of points.
const LIST: f64 = 730.0;
/// The distance between two lines of the list.
const LINE: f64 = 18.0;

/// A point of the chart: a model on a board.
struct BoardPoint<'a> {
    met: Met<'a>,
    colour: &'static str,
    /// The median time in microseconds, and its range over windows.
    us: f64,
    us_range: (f64, f64),
    /// The rank-1 and its interval.
    rank1: f64,
    rank1_range: (f64, f64),
}

/// Draws the chart of all models whose rank-1 was measured.
///
/// # Errors
/// If no model has a rank-1.
pub(crate) fn chart(compared: &Compared) -> Result<String> {
    let points = points(compared);
    if points.is_empty() {
        return Err(Error::Failed(
            "expected results with rank-1 to draw latency against it, found none (measure \
             rank-1 as well)"
                .into(),
        ));
    }
    let lines = points.len() as f64 + 2.0;
    let longest = points
        .iter()
        .map(|point| entry(point).chars().count())
        .max();
    let width = LIST + 42.0 + LETTER.0 * longest.unwrap_or(0) as f64;
    let height = HEIGHT.max(30.0 + LINE * lines);
    let content = html! { (plot(&points)) (list(&points)) };
    Ok(standalone(
        (width, height),
        "Latency against rank-1, by model and board",
        &content,
    ))
}

fn points<'a>(compared: &'a Compared) -> Vec<BoardPoint<'a>> {
    let boards: Vec<&str> = compared
        .boards
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    let of = |met: Met<'a>| {
        let accuracy = met.model.accuracy.as_ref()?;
        let single = &met.model.single;
        let us = single.times.p50_us;
        let board = boards.iter().position(|name| *name == met.board)?;
        Some(BoardPoint {
            colour: LINES[board % LINES.len()].colour,
            us,
            us_range: p50_range(single)?,
            rank1: accuracy.rank1,
            rank1_range: accuracy.intervals.shown(),
            met,
        })
    };
    compared.met().filter_map(of).collect()
}

fn plot(points: &[BoardPoint<'_>]) -> Markup {
    let across = LogAxis::around(
        points
            .iter()
            .flat_map(|point| [point.us_range.0, point.us_range.1]),
    );
    let (times, rates) = (across.ticks(), percents([0, 20, 40, 60, 80, 100]));
    let at = |us: f64, rank1: f64| CHART.place((across.place(us), rank1));
    let places: Vec<(f64, f64)> = points
        .iter()
        .map(|point| at(point.us, point.rank1))
        .collect();
    let pixels: Vec<(i32, i32)> = places
        .iter()
        .map(|(x, y)| (x.round() as i32, y.round() as i32))
        .collect();
    html! {
        (CHART.across(&rates)) (CHART.upwards(&times)) (CHART.below(&times))
        text.axis x="8" y="18" { "rank-1 and its 95 % interval" }
        text.axis x=(CHART.left + CHART.width / 2.0) y=(CHART.top + CHART.height + 42.0) text-anchor="middle" {
            "median time of one inference, us; line: range over windows"
        }
        @for (point, (x, y)) in points.iter().zip(&places) {
            @let (left, right) = (at(point.us_range.0, point.rank1).0, at(point.us_range.1, point.rank1).0);
            @let (low, high) = (at(point.us, point.rank1_range.0).1, at(point.us, point.rank1_range.1).1);
            path.curve d=(format!("M{left:.1} {y:.1}L{right:.1} {y:.1}M{x:.1} {low:.1}L{x:.1} {high:.1}"))
                stroke=(point.colour) {}
            circle cx=(to_tenth(*x)) cy=(to_tenth(*y)) r="5" fill=(point.colour) { title { (entry(point)) } }
        }
        @for (index, (x, y)) in labels(&pixels).into_iter().enumerate() {
            text x=(x) y=(y + NUMBER.1 - 2) style=(format!("fill: {}", points[index].colour)) { (index + 1) }
        }
    }
}

/// Draws the list of points with their numbers.
fn list(points: &[BoardPoint<'_>]) -> Markup {
    html! { @for (index, point) in points.iter().enumerate() {
        @let (y, colour) = (18.0 + LINE * index as f64, format!("fill: {}", point.colour));
        text x=(LIST + 26.0) y=(y) text-anchor="end" style=(colour) { (index + 1) }
        text x=(LIST + 34.0) y=(y) style=(colour) { (entry(point)) }
    } }
}

/// Returns the description of a point.
fn entry(point: &BoardPoint<'_>) -> String {
    let Met { board, name, .. } = &point.met;
    format!(
        "{name} {board}: {} us, {} %",
        microseconds(point.us, ","),
        percent(point.rank1)
    )
}

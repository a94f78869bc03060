//! A plot (SVG) of the time of a GEI against its error.

use super::FrontierPoint;
use super::pareto::{ConfigurationCost, pareto};
use crate::report::axis_ticks::{LogAxis, RING, labels};
use crate::report::drawing::{Axes, LINES, LineStyle, to_tenth};
use crate::report::standalone::{LETTER, standalone};
use maud::{Markup, html};

/// The axes of the chart and, below, the list of names beside it, pixels.
const CHART: Axes = Axes {
    left: 56.0,
    top: 32.0,
    width: 752.0,
    height: 730.0,
};
const HEIGHT: f64 = 820.0;
const LIST: f64 = 820.0;
const LIST_WIDTH: f64 = 380.0;
/// The distance between lines of the list, pixels.
const LINE: f64 = 18.0;
const DOT: i32 = 5;
/// Width and height of a digit of a number.
const NUMBER: (i32, i32) = (LETTER.0 as i32, LETTER.1 as i32);
/// The meaning of the marks.
const LEGEND: [&str; 4] = [
    "filled: no other is better in time,",
    "bytes or error and not worse in the rest",
    "line: the best in time and error alone",
    "ring: the default",
];

/// Returns the plot as SVG.
#[must_use]
pub(crate) fn svg(points: &[FrontierPoint]) -> String {
    let title = "Time of a GEI against its error, by configuration";
    let content = html! { (chart(points)) (list(points)) };
    standalone((LIST + LIST_WIDTH, HEIGHT), title, &content)
}

/// Returns a point's coordinates: the time of a GEI, us, and its error.
fn place(point: &FrontierPoint) -> (f64, f64) {
    (1e-3 * point.ns_per_gei, point.gei_rmse)
}

/// Returns the colour of a rasteriser, by the order in which rasterisers appear.
fn colour(points: &[FrontierPoint], raster: &str) -> &'static str {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        if !names.contains(&point.raster) {
            names.push(point.raster);
        }
    }
    let index = names.iter().position(|name| *name == raster);
    LINES[index.unwrap_or(0) % LINES.len()].colour
}

fn chart(points: &[FrontierPoint]) -> Markup {
    let across = LogAxis::around(points.iter().map(|point| place(point).0));
    let up = LogAxis::around(points.iter().map(|point| place(point).1));
    let share = |(us, error): (f64, f64)| (across.place(us), up.place(error));
    let (times, errors) = (across.ticks(), up.ticks());
    let places: Vec<(f64, f64)> = points
        .iter()
        .map(|point| CHART.place(share(place(point))))
        .collect();
    let pixels: Vec<(i32, i32)> = places
        .iter()
        .map(|(x, y)| (x.round() as i32, y.round() as i32))
        .collect();
    let digits = |index: usize| (NUMBER.0 * if index < 9 { 1 } else { 2 }, NUMBER.1);
    let sizes: Vec<_> = (0..points.len()).map(digits).collect();
    let picture = (LIST as i32, HEIGHT as i32);
    let best = "the best in time and error alone";
    html! {
        (CHART.across(&errors)) (CHART.upwards(&times)) (CHART.below(&times))
        text.axis x="8" y="18" { "error of a GEI against exact coverage, RMS of 255" }
        text.axis x=(CHART.left + CHART.width / 2.0) y=(HEIGHT - 12.0) text-anchor="middle" {
            "time of a GEI on one thread, us"
        }
        (CHART.curve(best, front(points).into_iter().map(share), LineStyle::new("#8b9097", "none")))
        @for (point, (x, y)) in points.iter().zip(&places) {
            @let colour = colour(points, point.raster);
            circle cx=(to_tenth(*x)) cy=(to_tenth(*y)) r=(DOT) stroke=(colour)
                fill=(if point.pareto { colour } else { "none" }) {
                title { (point.name) ": " (to_tenth(place(point).0)) " us, error " (format!("{:.2}", point.gei_rmse)) }
            }
            @if point.is_default { circle.ring cx=(to_tenth(*x)) cy=(to_tenth(*y)) r=(RING) {} }
        }
        @for (index, (x, y)) in labels(&pixels, &sizes, picture).into_iter().enumerate() {
            text x=(x) y=(y + NUMBER.1 - 2) style=(format!("fill: {}", colour(points, points[index].raster))) {
                (index + 1)
            }
        }
    }
}

/// Returns the points that no other beats in time and error, from the fastest on.
fn front(points: &[FrontierPoint]) -> Vec<(f64, f64)> {
    let merits = points.iter().map(|point| ConfigurationCost {
        pack_bytes: 0,
        ..point.merits()
    });
    let set = pareto(&merits.collect::<Vec<_>>());
    let best = points.iter().zip(set).filter(|(_, is_best)| *is_best);
    let mut places: Vec<(f64, f64)> = best.map(|(point, _)| place(point)).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places
}

/// Draws the list of the points' numbers and names, and the legend.
fn list(points: &[FrontierPoint]) -> Markup {
    let y_of = |line: usize| 18.0 + LINE * line as f64;
    html! {
        @for (index, point) in points.iter().enumerate() {
            @let (y, colour) = (y_of(index), colour(points, point.raster));
            @if point.pareto { circle cx=(LIST + 8.0) cy=(y - 4.5) r="4" fill=(colour) {} }
            text x=(LIST + 34.0) y=(y) text-anchor="end" style=(format!("fill: {colour}")) { (index + 1) }
            text x=(LIST + 42.0) y=(y) style=(format!("fill: {colour}")) { (point.name) }
        }
        @for (line, text) in (points.len() + 1..).zip(LEGEND) {
            text.axis x=(LIST + 18.0) y=(y_of(line)) { (text) }
        }
    }
}

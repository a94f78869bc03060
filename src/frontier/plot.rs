//! Time of a GEI against its error, as a picture (SVG).

use super::Point;
use super::pareto::{Merits, pareto};
use crate::report::drawing::{Axes, LINES, Tick, to_tenth};
use crate::report::standalone::{LETTER, standalone};
use maud::{Markup, html};

/// The chart, and the list of names beside it, pixels.
const CHART: Axes = Axes {
    left: 56.0,
    top: 32.0,
    width: 752.0,
    height: 730.0,
};
const HEIGHT: f64 = 820.0;
const LIST: f64 = 820.0;
const LIST_WIDTH: f64 = 380.0;
/// From one line of the list to the next.
const LINE: f64 = 18.0;
/// Width and height of a character of the labels.
const CHARACTER: (i32, i32) = (LETTER.0 as i32, LETTER.1 as i32);
const DOT: i32 = 5;
/// Radius of the ring about the default, which no label covers either.
const RING: i32 = 9;
/// What the marks mean.
const LEGEND: [&str; 4] = [
    "filled: no other is better in time,",
    "bytes or error and not worse in the rest",
    "line: the best in time and error alone",
    "ring: the default",
];

/// The plot as SVG.
#[must_use]
pub(crate) fn svg(points: &[Point]) -> String {
    let title = "Time of a GEI against its error, by configuration";
    let content = html! { (chart(points)) (list(points)) };
    standalone((LIST + LIST_WIDTH, HEIGHT), title, &content)
}

/// A point's place: microseconds of a GEI, and its error.
fn place(point: &Point) -> (f64, f64) {
    (1e-3 * point.ns_per_gei, point.gei_rmse)
}

/// A logarithmic axis from its least to its greatest value.
struct Axis(f64, f64);

impl Axis {
    /// With room around the values.
    fn around(values: impl Iterator<Item = f64>) -> Self {
        let (least, most) = values.fold((f64::INFINITY, 0.0), |(least, most), value| {
            (value.min(least), value.max(most))
        });
        Self(least / 1.3, most * 1.3)
    }

    /// From 0 to 1.
    fn place(&self, value: f64) -> f64 {
        (value / self.0).ln() / (self.1 / self.0).ln()
    }

    /// Where it is labelled: with one digit and zeros, of a long axis only powers of ten.
    fn ticks(&self) -> Vec<Tick> {
        let digits: &[f64] = if self.1 / self.0 > 2e3 {
            &[1.0]
        } else {
            &[1.0, 2.0, 3.0, 5.0, 7.0]
        };
        let all = (-3..8).flat_map(|power| digits.iter().map(move |d| d * 10f64.powi(power)));
        all.filter(|value| (self.0..self.1).contains(value))
            .map(|value| {
                let decimals = if value < 1.0 { 3 } else { 0 };
                (self.place(value), format!("{value:.decimals$}"))
            })
            .collect()
    }
}

/// The colour of a rasteriser: by the order in which rasterisers appear.
fn colour(points: &[Point], raster: &str) -> &'static str {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        if !names.contains(&point.raster) {
            names.push(point.raster);
        }
    }
    let index = names.iter().position(|name| *name == raster);
    LINES[index.unwrap_or(0) % LINES.len()].0
}

fn chart(points: &[Point]) -> Markup {
    let across = Axis::around(points.iter().map(|point| place(point).0));
    let up = Axis::around(points.iter().map(|point| place(point).1));
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
    let best = "the best in time and error alone";
    html! {
        (CHART.across(&errors)) (CHART.upwards(&times)) (CHART.below(&times))
        text.axis x="8" y="18" { "error of a GEI against exact coverage, RMS of 255" }
        text.axis x=(CHART.left + CHART.width / 2.0) y=(HEIGHT - 12.0) text-anchor="middle" {
            "time of a GEI on one thread, us"
        }
        (CHART.curve(best, front(points).into_iter().map(share), ("#8b9097", "none")))
        @for (point, (x, y)) in points.iter().zip(&places) {
            @let colour = colour(points, point.raster);
            circle cx=(to_tenth(*x)) cy=(to_tenth(*y)) r=(DOT) stroke=(colour)
                fill=(if point.pareto { colour } else { "none" }) {
                title { (point.name) ": " (to_tenth(place(point).0)) " us, error " (format!("{:.2}", point.gei_rmse)) }
            }
            @if point.is_default { circle.ring cx=(to_tenth(*x)) cy=(to_tenth(*y)) r=(RING) {} }
        }
        @for (index, (x, y)) in labels(&pixels).into_iter().enumerate() {
            text x=(x) y=(y + CHARACTER.1 - 2) style=(format!("fill: {}", colour(points, points[index].raster))) {
                (index + 1)
            }
        }
    }
}

/// Points that no other beats in the two plotted respects, from the fastest on.
fn front(points: &[Point]) -> Vec<(f64, f64)> {
    let merits = points.iter().map(|point| Merits {
        pack_bytes: 0,
        ..point.merits()
    });
    let set = pareto(&merits.collect::<Vec<_>>());
    let best = points.iter().zip(set).filter(|(_, is_best)| *is_best);
    let mut places: Vec<(f64, f64)> = best.map(|(point, _)| place(point)).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places
}

/// Upper left corners of the points' numbers, each as near to its point as it can be without
/// covering another number or point.
fn labels(points: &[(i32, i32)]) -> Vec<(i32, i32)> {
    let boxed = |index: usize| (CHARACTER.0 * if index < 9 { 1 } else { 2 }, CHARACTER.1);
    let meets = |a: (i32, i32), a_size: (i32, i32), b: (i32, i32), b_size: (i32, i32)| {
        a.0 < b.0 + b_size.0 && b.0 < a.0 + a_size.0 && a.1 < b.1 + b_size.1 && b.1 < a.1 + a_size.1
    };
    let mut placed: Vec<(i32, i32)> = Vec::new();
    for (index, &(x, y)) in points.iter().enumerate() {
        let size = boxed(index);
        let mut best = (usize::MAX, (x, y));
        for distance in [12, 18, 26, 36, 48] {
            for (right, down) in [
                (1, 0),
                (0, -1),
                (-1, 0),
                (0, 1),
                (1, -1),
                (-1, -1),
                (1, 1),
                (-1, 1),
            ] {
                let centre = (
                    x + right * (distance + size.0 / 2),
                    y + down * (distance + size.1 / 2),
                );
                let at = (centre.0 - size.0 / 2, centre.1 - size.1 / 2);
                let on_labels = placed.iter().enumerate();
                let on_labels = on_labels.filter(|&(i, &other)| meets(at, size, other, boxed(i)));
                let side = (2 * RING, 2 * RING);
                let on_dots = points.iter();
                let on_dots =
                    on_dots.filter(|dot| meets(at, size, (dot.0 - RING, dot.1 - RING), side));
                let met = on_labels.count() + on_dots.count();
                if met < best.0 {
                    best = (met, at);
                }
            }
        }
        placed.push(best.1);
    }
    placed
}

/// The points' names by their numbers, and what the marks mean.
fn list(points: &[Point]) -> Markup {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_covers_a_point_or_another_number() {
        // Three points so close that all would be labelled on their right, and one far away.
        let points = [(100, 100), (104, 100), (100, 103), (300, 100)];
        let found = labels(&points);
        assert_eq!(found[3], (312, 94));
        for (index, a) in found.iter().enumerate() {
            let apart = |b: (i32, i32), size: (i32, i32)| {
                a.0 + CHARACTER.0 <= b.0
                    || b.0 + size.0 <= a.0
                    || a.1 + CHARACTER.1 <= b.1
                    || b.1 + size.1 <= a.1
            };
            assert!(found[..index].iter().all(|&b| apart(b, CHARACTER)));
            let dot = |(x, y): (i32, i32)| apart((x - RING, y - RING), (2 * RING, 2 * RING));
            assert!(points.iter().all(|&point| dot(point)));
        }
    }

    #[test]
    fn axes_are_labelled_within_their_range() {
        let axis = Axis::around([3.25, 46.0].into_iter());
        let texts: Vec<String> = axis.ticks().into_iter().map(|(_, text)| text).collect();
        assert_eq!(texts, ["3", "5", "7", "10", "20", "30", "50"]);
        assert_eq!(Axis(1.0, 100.0).place(10.0), 0.5);
        let small = Axis(0.45, 0.6).ticks();
        assert_eq!(small[0].1, "0.500");
        let long = Axis(0.9, 2000.0).ticks();
        let texts: Vec<&str> = long.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(texts, ["1", "10", "100", "1000"]);
    }
}

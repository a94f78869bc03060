//! Common parts of SVG charts: distinguishable colours, and axes.

use maud::{Markup, html};
use std::fmt::Write;

/// How a line of a chart is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineStyle {
    /// The colour, as in CSS.
    pub colour: &'static str,
    /// The lengths of dashes and gaps, as in SVG's `stroke-dasharray`.
    pub dashes: &'static str,
}

impl LineStyle {
    pub(crate) const fn new(colour: &'static str, dashes: &'static str) -> Self {
        Self { colour, dashes }
    }
}

/// The styles of lines: Okabe and Ito's colours (2008), safe for the colour-blind, on a light or
/// dark background. The dashes distinguish lines in grey.
pub(crate) const LINES: [LineStyle; 6] = [
    LineStyle::new("#0072b2", "none"),
    LineStyle::new("#d55e00", "7 3"),
    LineStyle::new("#009e73", "2 3"),
    LineStyle::new("#cc79a7", "9 3 2 3"),
    LineStyle::new("#e69f00", "4 4"),
    LineStyle::new("#56b4e9", "1 2"),
];

/// The beginning of every chart in its own file, by which the program recognizes its files.
pub(crate) const SVG_START: &str =
    "<svg xmlns=\"http://www.w3.org/2000/svg\" data-made-by=\"EdgeGait\"";

/// Formats a coordinate to a tenth.
pub(crate) fn to_tenth(coordinate: f64) -> String {
    format!("{coordinate:.1}")
}

/// A place on an axis, and its text.
#[derive(Clone)]
pub(crate) struct Tick {
    /// The place: 0 at the start of the axis and 1 at its end.
    pub(crate) at: f64,
    pub(crate) text: String,
}

impl Tick {
    pub(crate) fn new(at: f64, text: impl ToString) -> Self {
        let text = text.to_string();
        Self { at, text }
    }
}

/// Returns ticks at rates in percent.
pub(crate) fn percents<const N: usize>(rates: [u32; N]) -> [Tick; N] {
    rates.map(|rate| Tick::new(f64::from(rate) / 100.0, format!("{rate}%")))
}

/// The area of a chart's curves in its picture.
#[derive(Clone, Copy)]
pub(crate) struct Axes {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Axes {
    /// Returns the place of a point with both coordinates 0..=1, the second one upwards.
    pub(crate) fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (
            self.left + x.clamp(0.0, 1.0) * self.width,
            self.top + (1.0 - y.clamp(0.0, 1.0)) * self.height,
        )
    }

    /// Draws horizontal lines, each with its text on the left.
    pub(crate) fn across(&self, ticks: &[Tick]) -> Markup {
        html! { @for Tick { at, text } in ticks {
            @let (x, y) = self.place((0.0, *at));
            line.rail x1=(to_tenth(x)) x2=(to_tenth(x + self.width)) y1=(to_tenth(y)) y2=(to_tenth(y)) {}
            @if !text.is_empty() {
                text.tick x=(to_tenth(x - 6.0)) y=(to_tenth(y + 4.0)) text-anchor="end" { (text) }
            }
        } }
    }

    /// Draws vertical lines, without texts.
    pub(crate) fn upwards(&self, ticks: &[Tick]) -> Markup {
        html! { @for Tick { at, .. } in ticks {
            @let (x, y) = self.place((*at, 0.0));
            line.rail x1=(to_tenth(x)) x2=(to_tenth(x)) y1=(to_tenth(self.top)) y2=(to_tenth(y)) {}
        } }
    }

    /// Draws texts below the chart.
    pub(crate) fn below(&self, ticks: &[Tick]) -> Markup {
        html! { @for Tick { at, text } in ticks {
            @let (x, y) = self.place((*at, 0.0));
            text.tick x=(to_tenth(x)) y=(to_tenth(y + 18.0)) text-anchor="middle" { (text) }
        } }
    }

    /// Draws a line through points.
    pub(crate) fn curve(
        &self,
        name: &str,
        points: impl IntoIterator<Item = (f64, f64)>,
        style: LineStyle,
    ) -> Markup {
        let mut path = String::new();
        for point in points {
            let (x, y) = self.place(point);
            let command = if path.is_empty() { 'M' } else { 'L' };
            // Writing to a string cannot fail.
            let _ = write!(path, "{command}{x:.1} {y:.1}");
        }
        html! { path.curve d=(path) stroke=(style.colour) stroke-dasharray=(style.dashes) { title { (name) } } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_between_the_axes() {
        let axes = Axes {
            left: 10.0,
            top: 20.0,
            width: 100.0,
            height: 200.0,
        };
        assert_eq!(axes.place((0.25, 1.0)), (35.0, 20.0));
        assert_eq!(axes.place((2.0, -1.0)), (110.0, 220.0));
        let curve = axes.curve(
            "a",
            [(0.0, 0.0), (1.0, 0.5)],
            LineStyle::new("#000", "none"),
        );
        assert!(
            curve
                .into_string()
                .contains("d=\"M10.0 220.0L110.0 120.0\"")
        );
    }
}

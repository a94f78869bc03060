//! Small charts of the report (inline SVG): intervals, and Rank-1 by angle from training.

use maud::{Markup, html};

use super::drawing::{Axes, LINES, Tick, percents, to_tenth};
use super::{THIN, headline_scope, percent};
use crate::evaluate::results::RecognizerResult;
use crate::evaluate::view_angle::{AngleResult, BIN_DEG};

/// Rates at which charts have a horizontal line, percent.
const RATES: [u32; 5] = [0, 25, 50, 75, 100];

/// Draws a rate with its interval and the chance level on a line from 0 to 100 %.
pub(super) fn interval(result: &RecognizerResult) -> Markup {
    let x_of = |rate: f64| format!("{:.1}", 4.0 + rate.clamp(0.0, 1.0) * 92.0);
    let chance = 1.0 / result.classes.max(1) as f64;
    html! {
        svg.interval viewBox="0 0 100 14" aria-hidden="true" {
            line.rail x1="4" x2="96" y1="7" y2="7" {}
            line.chance-mark x1=(x_of(chance)) x2=(x_of(chance)) y1="2" y2="12" {}
            line.whisker x1=(x_of(result.intervals.shown().0)) x2=(x_of(result.intervals.shown().1)) y1="7" y2="7" {}
            circle cx=(x_of(result.rank1)) cy="7" r="3" {}
        }
    }
}

/// Draws Rank-1 by the angle from the nearest training viewpoint, with a line for each of the first
/// six recognizers with known training viewpoints. None if there is no such recognizer.
pub(super) fn angles(results: &[RecognizerResult]) -> Option<Markup> {
    let known = results.iter().filter(|result| result.by_angle.len() > 1);
    let curves: Vec<_> = known.take(LINES.len()).collect();
    let farthest = curves
        .iter()
        .flat_map(|result| &result.by_angle)
        .map(|bin| bin.to_deg)
        .fold(BIN_DEG, f64::max);
    if curves.is_empty() {
        return None;
    }
    let axes = Axes {
        left: 54.0,
        top: 12.0,
        width: 486.0,
        height: 200.0,
    };
    // Ends of bins, or every other end. The last is a whole number of degrees, at most 180.
    let step = if farthest > 90.0 { 20 } else { 10 };
    let ticks = (0..=farthest as u32).step_by(step);
    let ticks: Vec<Tick> = ticks
        .map(|tick| Tick::new(f64::from(tick) / farthest, tick))
        .collect();
    let bars = if curves.iter().all(|curve| {
        curve
            .by_angle
            .iter()
            .all(|bin| bin.intervals.over_people().is_some())
    }) {
        "95 % intervals over people"
    } else {
        "95 % intervals"
    };
    Some(html! {
        figure {
        p {
            "Rank-1 against the angle between a viewpoint and the recognizer's nearest training "
            "viewpoint. 0 stands for the training viewpoints themselves. Steps of "
            (BIN_DEG) " degrees follow, each with its upper end, drawn at its middle. Bars are " (bars) "."
        }
        ul.quiet { @for result in &curves {
            li { (result.name) ": " (headline_scope::counts(result, THIN))
                @if let Some(which) = headline_scope::probe_sets(result) { ", " (which) } }
        } }
        @if curves.len() < results.len() {
            p.quiet { (curves.len()) " of " (results.len()) " recognizers: at most the first "
                (LINES.len()) " with known training viewpoints" }
        }
        div.wide { svg.angles viewBox="0 0 560 258" role="img"
            aria-label="Rank-1 by the angle from the nearest training viewpoint" {
            (axes.across(&percents(RATES)))
            (axes.below(&ticks))
            text.axis x="297" y="250" text-anchor="middle" {
                "angle from the nearest training viewpoint, degrees"
            }
            @for (result, style) in curves.iter().zip(LINES) {
                @let points = result.by_angle.iter().map(|bin| (bin.middle_deg() / farthest, bin.rank1));
                (axes.curve(&result.name, points, style))
                @for bin in &result.by_angle {
                    @let (low, high) = bin.intervals.shown();
                    @let y_of = |rate| axes.place((bin.middle_deg() / farthest, rate));
                    @let [(x, y), (_, low_y), (_, high_y)] = [bin.rank1, low, high].map(y_of);
                    line.error stroke=(style.colour) x1=(to_tenth(x)) x2=(to_tenth(x))
                        y1=(to_tenth(low_y)) y2=(to_tenth(high_y)) {}
                    circle cx=(to_tenth(x)) cy=(to_tenth(y)) r="3.2" fill=(style.colour) {
                        title {
                            (result.name) ", " (where_is(bin)) ": " (percent(bin.rank1)) " % of "
                            (bin.probes) ", " (percent(low)) " to " (percent(high))
                        }
                    }
                }
            }
        }
        }
        (legend(&curves.iter().map(|result| result.name.as_str()).collect::<Vec<_>>()))
        }
    })
}

/// A line of a [`curves`] chart.
pub(super) struct ChartCurve {
    pub(super) name: String,
    /// The points, with both coordinates 0..1.
    pub(super) points: Vec<(f64, f64)>,
}

/// Draws a chart of at most as many lines of rates (0..1, upwards) as [`LINES`] has, with ticks of
/// the horizontal axis (place 0..1, text). None without lines.
pub(super) fn curves(
    what: &str,
    axis: &str,
    ticks: &[Tick],
    curves: &[ChartCurve],
) -> Option<Markup> {
    if curves.iter().all(|curve| curve.points.len() < 2) {
        return None;
    }
    let axes = Axes {
        left: 54.0,
        top: 12.0,
        width: 300.0,
        height: 200.0,
    };
    Some(html! {
        figure {
            svg.curves viewBox="0 0 370 258" role="img" aria-label=(what) {
                (axes.across(&percents(RATES)))
                (axes.below(ticks))
                text.axis x="204" y="250" text-anchor="middle" { (axis) }
                @for (curve, style) in curves.iter().zip(LINES) {
                    (axes.curve(&curve.name, curve.points.iter().copied(), style))
                }
            }
            figcaption { (what) }
        }
    })
}

/// Draws the key of the lines, for charts with the same lines.
pub(super) fn legend(names: &[&str]) -> Markup {
    html! {
        div.legend {
            @for (name, style) in names.iter().zip(LINES) {
                span {
                    svg.key viewBox="0 0 34 10" aria-hidden="true" {
                        path.curve d="M1 5L33 5" stroke=(style.colour) stroke-dasharray=(style.dashes) {}
                    }
                    " " (name)
                }
            }
        }
    }
}

fn where_is(bin: &AngleResult) -> String {
    if bin.to_deg == 0.0 {
        "at training viewpoints".into()
    } else {
        format!("{} to {}°", bin.from_deg, bin.to_deg)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::intervals::Rank1Intervals;
    use crate::evaluate::results::tests::result_of;

    #[test]
    fn a_recognizer_of_unknown_training_has_no_line() {
        let mut result = result_of(&[(90.0, 0.0, 4, 4), (0.0, 0.0, 1, 4)]);
        assert!(angles(std::slice::from_ref(&result)).is_none());
        let bin = |from_deg, to_deg, rank1| AngleResult {
            from_deg,
            to_deg,
            probes: 4,
            rank1,
            intervals: Rank1Intervals {
                rank1_low: Some(0.125),
                rank1_high: Some(0.5),
                rank1_wilson_low: 0.0,
                rank1_wilson_high: 1.0,
            },
        };
        result.by_angle = vec![bin(0.0, 0.0, 1.0), bin(90.0, 100.0, 0.25)];
        let chart = angles(&[result]).unwrap().into_string();
        crate::report::text_extent::assert_texts_are_readable(&chart);
        // 100 % at 0 degrees, 25 % in the bin of 90 to 100, where the axis ends.
        assert!(chart.contains("d=\"M54.0 12.0L515.7 162.0\""), "{chart}");
        assert!(
            chart.contains("<title>pca-svm, 90 to 100°: 25.0 % of 4, 12.5 to 50.0</title>"),
            "{chart}"
        );
    }
}

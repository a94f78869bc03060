//! Small charts of the report (inline SVG): intervals, and Rank-1 by angle.

use std::fmt::Write;

use maud::{Markup, html};

use super::percent;
use crate::evaluate::angle::by_angle;
use crate::evaluate::results::RecognizerResult;

/// A line's look: Okabe and Ito's colours (2008), safe for the colour-blind, on
/// either ground; the dashes tell lines apart in grey.
const LINES: [(&str, &str); 6] = [
    ("#0072b2", "none"),
    ("#d55e00", "7 3"),
    ("#009e73", "2 3"),
    ("#cc79a7", "9 3 2 3"),
    ("#e69f00", "4 4"),
    ("#56b4e9", "1 2"),
];

/// A rate with its interval and the chance level on a line from 0 to 100 %.
pub(super) fn interval(result: &RecognizerResult) -> Markup {
    let x_of = |rate: f64| format!("{:.1}", 4.0 + rate.clamp(0.0, 1.0) * 92.0);
    let chance = 1.0 / result.classes.max(1) as f64;
    html! {
        svg.interval viewBox="0 0 100 14" aria-hidden="true" {
            line.rail x1="4" x2="96" y1="7" y2="7" {}
            line.chance-mark x1=(x_of(chance)) x2=(x_of(chance)) y1="2" y2="12" {}
            line.whisker x1=(x_of(result.rank1_low)) x2=(x_of(result.rank1_high)) y1="7" y2="7" {}
            circle cx=(x_of(result.rank1)) cy="7" r="3" {}
        }
    }
}

/// Rank-1 by the angle from the nearest viewpoint of training, a line for each of
/// the first six recognizers that say where they were trained. None if none does.
pub(super) fn angles(results: &[RecognizerResult]) -> Option<Markup> {
    let known = results.iter().map(|result| (result, by_angle(result)));
    let curves: Vec<_> = known
        .filter(|(_, bins)| bins.len() > 1)
        .take(LINES.len())
        .collect();
    let farthest = curves
        .iter()
        .flat_map(|(_, bins)| bins)
        .map(|bin| bin.0)
        .fold(0.0, f64::max);
    if curves.is_empty() {
        return None;
    }
    let end = (farthest / 15.0).ceil() * 15.0;
    let x_of = |angle: f64| 54.0 + angle / end * 492.0;
    let y_of = |rate: f64| 12.0 + (1.0 - rate) * 200.0;
    let step = if end > 90.0 { 30 } else { 15 };
    // The end is a whole number of degrees, at most 180.
    let ticks = (0..=end as u32).step_by(step);
    Some(html! {
        svg.angles viewBox="0 0 560 258" role="img"
            aria-label="Rank-1 by the angle from the nearest viewpoint of training" {
            @for rate in [0, 25, 50, 75, 100] {
                @let y = y_of(f64::from(rate) / 100.0);
                line.rail x1="54" x2="546" y1=(y) y2=(y) {}
                text.tick x="48" y=(y + 4.0) text-anchor="end" { (rate) "%" }
            }
            @for tick in ticks {
                text.tick x=(x_of(f64::from(tick))) y="230" text-anchor="middle" { (tick) }
            }
            text.axis x="300" y="250" text-anchor="middle" {
                "angle from the nearest viewpoint of training, degrees"
            }
            @for ((result, bins), (colour, dashes)) in curves.iter().zip(LINES) {
                @let mut path = String::new();
                @for (place, (angle, tally)) in bins.iter().enumerate() {
                    @let command = if place == 0 { 'M' } else { 'L' };
                    @let rate = tally.rank1().unwrap_or_default();
                    @let _ = write!(path, "{command}{:.1} {:.1}", x_of(*angle), y_of(rate));
                }
                path.curve d=(path) stroke=(colour) stroke-dasharray=(dashes) {}
                @for (angle, tally) in bins {
                    @let rate = tally.rank1().unwrap_or_default();
                    circle cx=(format!("{:.1}", x_of(*angle))) cy=(format!("{:.1}", y_of(rate))) r="3.2"
                        fill=(colour) {
                        title {
                            (result.name) ", " (where_is(*angle)) ": " (percent(rate)) " % of "
                            (tally.probes)
                        }
                    }
                }
            }
        }
        div.legend {
            @for ((result, _), (colour, dashes)) in curves.iter().zip(LINES) {
                span {
                    svg.key viewBox="0 0 34 10" aria-hidden="true" {
                        path.curve d="M1 5L33 5" stroke=(colour) stroke-dasharray=(dashes) {}
                    }
                    " " (result.name)
                }
            }
        }
    })
}

fn where_is(angle: f64) -> String {
    if angle == 0.0 {
        "at training".into()
    } else {
        format!("{} to {}°", angle - 5.0, angle + 5.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::result_of;

    #[test]
    fn a_recognizer_of_unknown_training_has_no_line() {
        let mut result = result_of(&[(90.0, 0.0, 4, 4), (0.0, 0.0, 1, 4)]);
        assert!(angles(std::slice::from_ref(&result)).is_none());
        result.trained_at = vec![(90.0, 0.0)];
        let chart = angles(&[result]).unwrap().into_string();
        // 100 % at 0 degrees, 25 % at the bin of 90 to 100 of an axis that ends at 105.
        assert!(chart.contains("d=\"M54.0 12.0L499.1 162.0\""), "{chart}");
        assert!(
            chart.contains("<title>pca-svm, 90 to 100°: 25.0 % of 4</title>"),
            "{chart}"
        );
    }
}

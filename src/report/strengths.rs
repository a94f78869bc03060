//! Charts of Rank-1 against the strength of each confounder, as one picture (SVG).

use super::drawing::{Axes, LINES, LineStyle, Tick, percents, to_tenth};
use super::percent;
use super::standalone::{LETTER, standalone};
use crate::evaluate::strengths::ConfounderResult;
use maud::{Markup, html};

/// Width of the picture, and the number of charts side by side.
const WIDTH: f64 = 1000.0;
const COLUMNS: usize = 6;
/// Space for the percentages on the left, around the picture, and between two charts, pixels.
const LEFT: f64 = 50.0;
const MARGIN: f64 = 8.0;
const GAP: f64 = 16.0;
/// Distance from one chart to the next, pixels.
const PITCH: f64 = (WIDTH - LEFT - MARGIN + GAP) / COLUMNS as f64;
/// Heights of a chart, of its name above and of its strengths below, pixels.
const CHART: f64 = 84.0;
const NAME: f64 = 22.0;
const TICKS: f64 = 26.0;
/// Height of a line of text, pixels.
const LINE: f64 = 24.0;
/// Width of the key of a line, and the style of the line at chance.
const KEY: f64 = 28.0;
const CHANCE: LineStyle = LineStyle::new("#9aa4b0", "4 4");

/// Draws the charts of all confounders by class, with a line for each recognizer and a dashed line
/// at chance; `classes` is the number of people to choose from.
pub(super) fn svg(results: &[ConfounderResult], classes: usize) -> String {
    let chance = 1.0 / classes.max(1) as f64;
    let mut parts = vec![legend(&recognizers(results))];
    let mut y = MARGIN + LINE;
    let mut sorted: Vec<&ConfounderResult> = results.iter().collect();
    sorted.sort_by_key(|result| result.class);
    for members in sorted.chunk_by(|a, b| a.class == b.class) {
        y += LINE;
        parts.push(html! {
            text.axis x=(MARGIN) y=(y - 6.0) font-weight="600" { (members[0].class) }
        });
        for row in members.chunks(COLUMNS) {
            for (column, result) in row.iter().enumerate() {
                parts.push(chart(result, column, y, chance));
            }
            y += NAME + CHART + TICKS;
        }
    }
    let title = "Rank-1 against the strength of each confounder";
    let all = html! { @for part in parts { (part) } };
    standalone((WIDTH, y + MARGIN), title, &all)
}

/// Draws the key of the lines.
fn legend(recognizers: &[String]) -> Markup {
    let title = "rank-1 against strength:";
    let styles = LINES.into_iter().cycle();
    let names = recognizers.iter().map(String::as_str).zip(styles);
    let mut x = MARGIN + LETTER.0 * title.len() as f64;
    let keys = names.chain([("chance", CHANCE)]).map(|(name, style)| {
        let key = Axes {
            left: x,
            top: MARGIN + 8.0,
            width: KEY,
            height: 0.0,
        };
        let text = x + KEY + 6.0;
        x = text + LETTER.0 * name.chars().count() as f64 + GAP;
        html! {
            (key.curve(name, [(0.0, 0.0), (1.0, 0.0)], style))
            text.axis x=(text) y=(MARGIN + 12.0) { (name) }
        }
    });
    html! {
        text.axis x=(MARGIN) y=(MARGIN + 12.0) { (title) }
        @for key in keys { (key) }
    }
}

/// Draws one chart with its upper edge at `y`.
fn chart(result: &ConfounderResult, column: usize, y: f64, chance: f64) -> Markup {
    let axes = Axes {
        left: LEFT + column as f64 * PITCH,
        top: y + NAME,
        width: PITCH - GAP,
        height: CHART,
    };
    let is_signed = result.by_strength.iter().any(|point| point.strength < 0.0);
    let least = if is_signed { -1.0 } else { 0.0 };
    let place = |strength: f64| (strength - least) / (1.0 - least);
    let middle = f64::midpoint(least, 1.0);
    let strengths: [Tick; 3] = [least, middle, 1.0].map(|at| Tick::new(place(at), at));
    let mut rates = percents([0, 50, 100]);
    if column > 0 {
        rates = rates.map(|rate| Tick::new(rate.at, ""));
    }
    let curves = recognizers(std::slice::from_ref(result));
    let curves = curves.iter().enumerate().zip(LINES.into_iter().cycle());
    html! {
        text.axis x=(to_tenth(axes.left)) y=(to_tenth(y + NAME - 7.0)) { (result.name) }
        (axes.across(&rates)) (axes.upwards(&strengths)) (axes.below(&strengths))
        (axes.curve("chance", [(0.0, chance), (1.0, chance)], CHANCE))
        @for ((at, name), style) in curves {
            @let points = result.by_strength.iter().map(|of| (of.strength, of.recognizers[at].rank1));
            (axes.curve(name, points.clone().map(|(strength, rate)| (place(strength), rate)), style))
            @for (strength, rate) in points {
                @let (x, y) = axes.place((place(strength), rate));
                circle cx=(to_tenth(x)) cy=(to_tenth(y)) r="2.4" fill=(style.colour) {
                    title { (name) ", " (strength) ": " (percent(rate)) " %" }
                }
            }
        }
    }
}

/// Returns the recognizers' names.
pub(super) fn recognizers(results: &[ConfounderResult]) -> Vec<String> {
    let first = results
        .first()
        .and_then(|result| result.by_strength.first());
    let all = first.map_or(Vec::new(), |point| point.recognizers.clone());
    all.into_iter().map(|of| of.name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::intervals::Rank1Intervals;
    use crate::evaluate::strengths::{Rank1Rate, StrengthResult};
    use crate::report::text_extent::assert_texts_of_size_are_readable;

    fn result(name: &'static str, class: &'static str, rates: &[(f64, f64)]) -> ConfounderResult {
        let intervals = Rank1Intervals {
            rank1_low: None,
            rank1_high: None,
            rank1_wilson_low: 0.0,
            rank1_wilson_high: 1.0,
        };
        let at = |&(strength, rank1): &(f64, f64)| StrengthResult {
            strength,
            gei_rmse: 0.0,
            recognizers: vec![Rank1Rate {
                name: "side".into(),
                rank1,
                intervals,
            }],
        };
        ConfounderResult {
            name,
            class,
            at_full: "",
            by_strength: rates.iter().map(at).collect(),
            extra_ns: 0.0,
        }
    }

    #[test]
    fn a_line_goes_where_its_rates_are() {
        let halved = result("fog", "environment", &[(0.0, 1.0), (1.0, 0.5)]);
        let svg = svg(&[halved], 25);
        // The chart begins at (50, 78), is 84 high and 143.7 wide.
        assert!(svg.contains("d=\"M50.0 78.0L193.7 120.0\""), "{svg}");
        assert!(svg.contains("<title>side, 1: 50.0 %</title>"), "{svg}");
        // Chance is 4 % of 84 pixels, above 162.
        assert!(svg.contains("d=\"M50.0 158.6L193.7 158.6\""), "{svg}");
    }

    #[test]
    fn texts_of_many_charts_are_apart() {
        let classes = ["imaging", "appearance"];
        let signed = [(-1.0, 0.5), (0.0, 1.0), (1.0, 0.0)];
        let results: Vec<_> = (0..20)
            .map(|at| result("merged-background", classes[at % 2], &signed[at % 2..]))
            .collect();
        let svg = svg(&results, 25);
        assert_texts_of_size_are_readable(&svg, LETTER.1);
        assert_eq!(svg.matches(">merged-background</text>").count(), 20);
        // By class, ten of them in two rows each.
        assert!(svg.find(">appearance<") < svg.find(">imaging<"), "{svg}");
    }
}

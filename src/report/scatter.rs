//! A scatter plot of Rank-1 at viewpoints that are not a grid (inline SVG): a dot for each
//! viewpoint.

use maud::{Markup, html};

use super::drawing::to_tenth;
use super::heatmap::{axes, class_of, colour, exact, label, style_of};
use crate::evaluate::results::RecognizerResult;

/// Space to the left of the plot, for the longest label, such as `-22.25`.
const LEFT: usize = 80;
const TOP: usize = 36;
const WIDTH: usize = 480;
const HEIGHT: usize = 280;
const RIGHT: usize = 36;
const BOTTOM: usize = 54;

/// The values of an axis, with the least at 0 and the greatest at `length`.
struct ChartAxis {
    values: Vec<f64>,
    length: f64,
}

impl ChartAxis {
    fn new(values: impl Iterator<Item = f64>, length: usize) -> Self {
        let mut values: Vec<f64> = values.map(|value| value + 0.0).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        Self {
            values,
            length: length as f64,
        }
    }

    fn place(&self, value: f64) -> f64 {
        match (self.values.first(), self.values.last()) {
            (Some(least), Some(greatest)) if greatest > least => {
                (value - least) / (greatest - least) * self.length
            }
            _ => self.length / 2.0,
        }
    }

    /// Returns the values to label, at least `room` apart, including the greatest.
    fn ticks(&self, room: f64) -> Vec<f64> {
        let Some(&greatest) = self.values.last() else {
            return Vec::new();
        };
        let mut ticks: Vec<f64> = Vec::new();
        for &value in &self.values {
            let apart = |other: f64| (self.place(value) - self.place(other)).abs() >= room;
            let is_last = value == greatest;
            if is_last || (ticks.last().is_none_or(|&last| apart(last)) && apart(greatest)) {
                ticks.push(value);
            }
        }
        ticks
    }
}

/// Draws the scatter plot: azimuth to the right, elevation upwards, both to scale.
pub(super) fn svg(result: &RecognizerResult) -> Markup {
    let all = &result.by_viewpoint;
    let across = ChartAxis::new(all.iter().map(|v| v.azimuth_deg), WIDTH);
    let up = ChartAxis::new(all.iter().map(|v| v.elevation_deg), HEIGHT);
    let (width, height) = (LEFT + WIDTH + RIGHT, TOP + HEIGHT + BOTTOM);
    let x_of = |azimuth: f64| LEFT as f64 + across.place(azimuth);
    let y_of = |elevation: f64| (TOP + HEIGHT) as f64 - up.place(elevation);
    // Dots of many viewpoints cover at most two fifths of the plot.
    let area = (WIDTH * HEIGHT) as f64 / all.len().max(1) as f64;
    let radius = (area * 0.4 / std::f64::consts::PI).sqrt().clamp(2.5, 10.0);
    let text = format!(
        "Rank-1 of {} at its viewpoints by azimuth and elevation; the table has the numbers",
        result.name
    );
    html! {
        svg.(class_of(width)) viewBox=(format!("0 0 {width} {height}"))
            style=(style_of(width)) role="img" aria-label=(text) {
            @for elevation in up.ticks(20.0) {
                @let y = y_of(elevation);
                line.rail x1=(LEFT - 12) x2=(LEFT + WIDTH + 12) y1=(to_tenth(y)) y2=(to_tenth(y)) {}
                text.tick x=(LEFT - 16) y=(to_tenth(y + 4.0)) text-anchor="end" { (label(elevation)) }
            }
            @for azimuth in across.ticks(66.0) {
                @let x = x_of(azimuth);
                line.rail x1=(to_tenth(x)) x2=(to_tenth(x)) y1=(TOP - 12) y2=(TOP + HEIGHT + 12) {}
                text.tick x=(to_tenth(x)) y=(TOP + HEIGHT + 28) text-anchor="middle" { (label(azimuth)) }
            }
            @for viewpoint in all {
                @let is_trained = result.is_trained_at(viewpoint);
                circle.(if is_trained { "dot trained-dot" } else { "dot" })
                    cx=(to_tenth(x_of(viewpoint.azimuth_deg)))
                    cy=(to_tenth(y_of(viewpoint.elevation_deg)))
                    r=(to_tenth(radius)) fill=(colour(viewpoint.rank1)) { title { (exact(viewpoint)) } }
            }
            (axes(LEFT, WIDTH, (width, height)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::result_of;
    use crate::report::text_extent::assert_texts_are_readable;

    #[test]
    fn dots_are_drawn_to_scale_with_labels_at_values_that_exist() {
        let mut result = result_of(&[(10.0, -20.0, 1, 4), (20.0, 0.0, 4, 4), (70.0, 50.0, 0, 4)]);
        result.trained_at = vec![(20.0, 0.0)];
        let svg = svg(&result).into_string();
        // A sixth of 480 to the right of 80, and two sevenths of 280 above 316.
        assert!(svg.contains("cx=\"160.0\" cy=\"236.0\""), "{svg}");
        for tick in ["10", "20", "70", "-20", "0", "50"] {
            assert!(svg.contains(&format!(">{tick}</text>")), "{tick}: {svg}");
        }
        assert_eq!(svg.matches("trained-dot").count(), 1);
        assert_texts_are_readable(&svg);
    }

    #[test]
    fn labels_of_many_scattered_viewpoints_are_whole_and_apart() {
        for count in [2, 3, 20, 21, 150, 1000] {
            let list: Vec<_> = (0..count)
                .map(|at| {
                    let at = f64::from(at);
                    (at * 77.31 % 360.0 - 180.0, at * 13.37 % 170.0 - 80.0, 1, 2)
                })
                .collect();
            assert_texts_are_readable(&svg(&result_of(&list)).into_string());
        }
        // The same viewpoint twice.
        let twice = result_of(&[(90.0, 0.0, 1, 2), (90.0, 0.0, 2, 2)]);
        assert_texts_are_readable(&svg(&twice).into_string());
    }
}

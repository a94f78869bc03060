//! A heatmap of Rank-1 over azimuth and elevation (inline SVG).

use maud::{Markup, html};

use super::percent;
use crate::evaluate::results::{RecognizerResult, ViewpointResult};

/// Viridis in 16 equal steps (van der Walt and Smith, 2015; matplotlib 3). Its lightness is even,
/// so that it is readable in grey, and it is safe for the colour-blind.
const VIRIDIS: [[u8; 3]; 17] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x18, 0x6a],
    [0x47, 0x2d, 0x7b],
    [0x42, 0x40, 0x86],
    [0x3b, 0x52, 0x8b],
    [0x33, 0x63, 0x8d],
    [0x2c, 0x72, 0x8e],
    [0x26, 0x82, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x1f, 0xa0, 0x88],
    [0x28, 0xae, 0x80],
    [0x3f, 0xbc, 0x73],
    [0x5e, 0xc9, 0x62],
    [0x84, 0xd4, 0x4b],
    [0xad, 0xdc, 0x30],
    [0xd8, 0xe2, 0x19],
    [0xfd, 0xe7, 0x25],
];

/// The approximate longer side of a picture, unless its cells have the maximum size.
const SIDE: usize = 520;
/// The maximum width and height of cells, for few viewpoints.
const LARGEST: usize = 48;
/// The width and height from which cells contain their number.
const NUMBERED: usize = 44;
/// The maximum width of a letter of a label: 16 units high on a phone.
const LETTER: usize = 10;
/// Space above the cells, for the name of the vertical axis.
const TOP: usize = 28;
/// Space below the cells, for labels and the name of the horizontal axis.
const BOTTOM: usize = 46;
/// The minimum width, for the names of the axes.
const LEAST_WIDTH: usize = 130;

/// The maximum number of rows or columns in a heatmap.
const MAX_SIDE: usize = 120;

/// Returns the colour of a rate 0..1, as `#rrggbb`.
pub(super) fn colour(rate: f64) -> String {
    let place = rate.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    // Truncation is the floor: the place is 0..16.
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let mix = place - below as f64;
    let mut text = String::from("#");
    for (&from, &to) in VIRIDIS[below].iter().zip(&VIRIDIS[below + 1]) {
        let value = f64::from(from) + (f64::from(to) - f64::from(from)) * mix;
        text.push_str(&format!("{:02x}", value.round() as u8));
    }
    text
}

/// Returns a text colour that is readable on [`colour`].
pub(super) fn ink(rate: f64) -> &'static str {
    if rate < 0.55 { "#fff" } else { "#111" }
}

/// The viewpoints of a result that fill a grid.
pub(super) struct HeatmapGrid<'a> {
    azimuths: Vec<f64>,
    elevations: Vec<f64>,
    /// Results `[elevation][azimuth]`.
    cells: Vec<Vec<Option<&'a ViewpointResult>>>,
}

impl<'a> HeatmapGrid<'a> {
    /// Returns the grid; none if the viewpoints are not a grid: no viewpoint, more than a third of
    /// the cells empty, or two results in a cell.
    pub(super) fn from_viewpoints(viewpoints: &'a [ViewpointResult]) -> Option<Self> {
        let azimuths = distinct(viewpoints.iter().map(|v| v.azimuth_deg));
        let elevations = distinct(viewpoints.iter().map(|v| v.elevation_deg));
        let sides = 1..=MAX_SIDE;
        if !sides.contains(&azimuths.len())
            || !sides.contains(&elevations.len())
            || viewpoints.len() * 3 < azimuths.len() * elevations.len() * 2
        {
            return None;
        }
        let mut cells = vec![vec![None; azimuths.len()]; elevations.len()];
        for viewpoint in viewpoints {
            let row = place(&elevations, viewpoint.elevation_deg)?;
            let column = place(&azimuths, viewpoint.azimuth_deg)?;
            if cells[row][column].replace(viewpoint).is_some() {
                return None;
            }
        }
        Some(Self {
            azimuths,
            elevations,
            cells,
        })
    }

    /// Draws the heatmap: azimuth to the right, elevation upwards.
    pub(super) fn svg(&self, result: &RecognizerResult) -> Markup {
        let (columns, rows) = (self.azimuths.len(), self.elevations.len());
        let (across, up) = cell(columns, rows);
        let left = 12 + LETTER * longest(&self.elevations);
        let (plot_width, plot_height) = (columns * across, rows * up);
        // Half of the last label may extend beyond the last cell.
        let right = 6 + (LETTER * longest(&self.azimuths)).saturating_sub(across) / 2;
        let width = (left + plot_width + right).max(LEAST_WIDTH);
        let height = TOP + plot_height + BOTTOM;
        let y_of = |row: usize| TOP + (rows - 1 - row) * up;
        let x_of = |column: usize| left + column * across;
        let text = format!(
            "Heatmap of the rank-1 of {} by azimuth and elevation; the table has the numbers",
            result.name
        );
        html! {
            svg.(class_of(width)) viewBox=(format!("0 0 {width} {height}"))
                style=(style_of(width)) role="img" aria-label=(text) {
                rect.void x=(left) y=(TOP) width=(plot_width) height=(plot_height) {}
                @for (row, cells) in self.cells.iter().enumerate() {
                    @for (column, viewpoint) in cells.iter().enumerate() {
                        @if let Some(viewpoint) = viewpoint {
                            rect x=(x_of(column)) y=(y_of(row)) width=(across) height=(up)
                                fill=(colour(viewpoint.rank1)) { title { (exact(viewpoint)) } }
                            @if across.min(up) >= NUMBERED {
                                text.number x=(x_of(column) + across / 2) y=(y_of(row) + up / 2 + 5)
                                    text-anchor="middle" style=(format!("fill: {}", ink(viewpoint.rank1))) {
                                    (short(viewpoint.rank1))
                                }
                            }
                        }
                    }
                }
                @for (row, cells) in self.cells.iter().enumerate() {
                    @for (column, viewpoint) in cells.iter().enumerate() {
                        @if viewpoint.is_some_and(|v| result.is_trained_at(v)) {
                            rect.halo x=(x_of(column)) y=(y_of(row)) width=(across) height=(up) {}
                            rect.trained x=(x_of(column)) y=(y_of(row)) width=(across) height=(up) {}
                        }
                    }
                }
                @for column in ticks(&self.azimuths, across, LETTER * longest(&self.azimuths) + 4) {
                    text.tick x=(x_of(column) + across / 2) y=(TOP + plot_height + 17)
                        text-anchor="middle" { (label(self.azimuths[column])) }
                }
                @for row in ticks(&self.elevations, up, 18) {
                    text.tick x=(left - 6) y=(y_of(row) + up / 2 + 4)
                        text-anchor="end" { (label(self.elevations[row])) }
                }
                (axes(left, plot_width, (width, height)))
            }
        }
    }
}

/// The width above which pictures are shrunk on a phone, with enlarged letters.
const LARGE: usize = 400;

/// Returns the CSS classes of a picture of viewpoints of this width.
pub(super) fn class_of(width: usize) -> &'static str {
    if width > LARGE {
        "heatmap large"
    } else {
        "heatmap"
    }
}

/// Returns the CSS width of a picture on the page; a small one is only as wide as legible letters
/// need.
pub(super) fn style_of(width: usize) -> String {
    if width > LARGE {
        format!("max-width: {}px", width * 7 / 5)
    } else {
        format!("width: {}px; max-width: 100%", width * 6 / 5)
    }
}

/// Draws the names of both axes of a picture of viewpoints; its plot begins at `left`.
pub(super) fn axes(left: usize, plot_width: usize, (width, height): (usize, usize)) -> Markup {
    // "azimuth, °" is 10 letters.
    let middle = (left + plot_width / 2).clamp(5 * LETTER, width - 5 * LETTER);
    html! {
        text.axis x="2" y="16" { "elevation, °" }
        text.axis x=(middle) y=(height - 8) text-anchor="middle" { "azimuth, °" }
    }
}

/// Returns the width and height of a cell: square, except where there are so many in a row or
/// column that squares would be too small.
fn cell(columns: usize, rows: usize) -> (usize, usize) {
    let of = |count: usize| (SIDE / count).min(LARGEST);
    let square = of(columns.max(rows));
    if square < 8 {
        (of(columns), of(rows))
    } else {
        (square, square)
    }
}

/// Formats an angle, rounded to a hundredth: 77.31 in single precision is 77.30999755859375.
pub(super) fn label(angle: f64) -> String {
    format!("{}", (angle * 100.0).round() / 100.0 + 0.0)
}

/// Returns the number of characters of the longest label.
fn longest(angles: &[f64]) -> usize {
    let letters = angles.iter().map(|&angle| label(angle).chars().count());
    letters.max().unwrap_or(0)
}

/// Formats a rate in percent so that it fits into a cell.
fn short(rate: f64) -> String {
    let text = percent(rate);
    match text.strip_suffix(".0") {
        Some(whole) if whole == "0" || whole == "100" => whole.to_owned(),
        _ => text,
    }
}

/// Draws the colour scale with the chance level of `classes` people.
pub(super) fn legend(classes: usize, has_training: bool) -> Markup {
    let chance = if classes > 0 {
        1.0 / classes as f64
    } else {
        0.0
    };
    let x_of = |rate: f64| 16.0 + rate * 240.0;
    html! {
        div.legend {
            svg viewBox="0 0 280 40" role="img" aria-label="Colour scale of rank-1 from 0 to 100 percent" {
                @for step in 0..48u32 {
                    rect x=(16 + step * 5) y="12" width="5.2" height="11"
                        fill=(colour((f64::from(step) + 0.5) / 48.0)) {}
                }
                path.chance d=(format!("M{0:.1} 11l-4 -7h8z", x_of(chance))) {}
                @for tick in [0, 25, 50, 75, 100] {
                    text.tick x=(x_of(f64::from(tick) / 100.0)) y="36" text-anchor="middle" { (tick) "%" }
                }
            }
            span { "▼ chance: 1 in " (classes) ", " (percent(chance)) " %" }
            @if has_training {
                span { span.swatch {} " trained here" }
            }
        }
    }
}

/// Describes a viewpoint's result in words.
pub(super) fn exact(viewpoint: &ViewpointResult) -> String {
    let tally = viewpoint.tally();
    let interval = tally.interval();
    format!(
        "azimuth {}°, elevation {}°: {} % ({} of {}, 95 % interval {} to {})",
        label(viewpoint.azimuth_deg),
        label(viewpoint.elevation_deg),
        percent(viewpoint.rank1),
        tally.hits,
        tally.probes,
        percent(interval.low),
        percent(interval.high)
    )
}

/// Returns the distinct angles in order, with -0 as 0.
fn distinct(angles: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut angles: Vec<f64> = angles.map(|angle| angle + 0.0).collect();
    angles.sort_unstable_by(f64::total_cmp);
    angles.dedup();
    angles
}

fn place(angles: &[f64], angle: f64) -> Option<usize> {
    angles
        .binary_search_by(|other| other.total_cmp(&(angle + 0.0)))
        .ok()
}

/// Returns the places to label, at least `room` apart: all if they fit, else multiples of 15, 30,
/// 45 or 90 degrees if there are enough of them, else every n-th.
fn ticks(angles: &[f64], cell: usize, room: usize) -> Vec<usize> {
    if cell >= room {
        return (0..angles.len()).collect();
    }
    for step in [15.0, 30.0, 45.0, 90.0] {
        let places: Vec<_> = (0..angles.len())
            .filter(|&i| angles[i] % step == 0.0)
            .collect();
        let apart = places
            .windows(2)
            .all(|pair| (pair[1] - pair[0]) * cell >= room);
        if places.len() >= 3 && apart {
            return places;
        }
    }
    (0..angles.len()).step_by(room.div_ceil(cell)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::result_of;
    use crate::report::text_extent::assert_texts_are_readable;

    #[test]
    fn the_scale_has_viridis_at_its_ends_and_in_between() {
        assert_eq!(colour(0.0), "#440154");
        assert_eq!(colour(0.5), "#21918c");
        assert_eq!(colour(1.0), "#fde725");
        // Halfway between #21918c and #1fa088.
        assert_eq!(colour(8.5 / 16.0), "#20998a");
    }

    #[test]
    fn a_grid_is_recognised_and_drawn_with_every_number() {
        let mut result = result_of(&[
            (0.0, 0.0, 1, 4),
            (90.0, 0.0, 4, 4),
            (-0.0, 90.0, 0, 4),
            (90.0, 90.0, 2, 4),
        ]);
        result.trained_at = vec![(90.0, 0.0)];
        let svg = HeatmapGrid::from_viewpoints(&result.by_viewpoint)
            .unwrap()
            .svg(&result)
            .into_string();
        assert_eq!(svg.matches("<title>").count(), 4);
        assert!(svg.contains(
            "fill=\"#fde725\"><title>azimuth 90°, elevation 0°: 100.0 % (4 of 4, 95 % interval 51.0 to 100.0)"
        ), "{svg}");
        assert_eq!(svg.matches("class=\"trained\"").count(), 1);
    }

    #[test]
    fn viewpoints_that_are_no_grid_are_not_drawn_as_one() {
        let grid = |viewpoints: &[(f64, f64, u64, u64)]| {
            HeatmapGrid::from_viewpoints(&result_of(viewpoints).by_viewpoint).is_some()
        };
        assert!(!grid(&[]));
        assert!(grid(&[(90.0, 0.0, 1, 1)]), "one cell");
        assert!(grid(&[(0.0, 0.0, 1, 1), (45.0, 0.0, 1, 1)]), "one row");
        assert!(
            !grid(&[(1.0, 2.0, 1, 1), (3.0, 4.0, 1, 1), (5.0, 6.0, 1, 1)]),
            "scattered"
        );
        assert!(
            !grid(&[(0.0, 0.0, 1, 1), (0.0, 0.0, 1, 1), (5.0, 5.0, 1, 1)]),
            "one twice"
        );
        assert!(
            grid(&[(0.0, 0.0, 1, 1), (5.0, 0.0, 1, 1), (5.0, 5.0, 1, 1)]),
            "a gap"
        );
    }

    /// Draws a heatmap of all these azimuths with all these elevations.
    fn drawn(azimuths: &[f64], elevations: &[f64]) -> String {
        let all = azimuths.iter().flat_map(|&a| {
            let each = elevations.iter();
            each.map(move |&e| (a, e, 1, 3))
        });
        let result = result_of(&all.collect::<Vec<_>>());
        let grid = HeatmapGrid::from_viewpoints(&result.by_viewpoint).expect("a grid");
        grid.svg(&result).into_string()
    }

    #[test]
    fn labels_of_grids_of_any_size_are_whole_and_apart() {
        let steps = |count: u32, step: f64| -> Vec<f64> {
            (0..count).map(|at| f64::from(at) * step).collect()
        };
        for columns in [1, 2, 3, 5, 7, 10, 11, 13, 20, 37, 72, 120] {
            for rows in [1, 2, 3, 10, 19, 120] {
                for step in [5.0, 18.0, 2.5, -1.25, 33.333_333] {
                    let svg = drawn(&steps(columns, step), &steps(rows, step / 2.0));
                    assert_texts_are_readable(&svg);
                }
            }
        }
    }

    #[test]
    fn few_viewpoints_have_a_label_and_a_number_each() {
        let azimuths: Vec<f64> = (0..11).map(|at| f64::from(at) * 18.0).collect();
        let svg = drawn(&azimuths, &[0.0]);
        for azimuth in azimuths {
            assert!(svg.contains(&format!(">{azimuth}</text>")), "{svg}");
        }
        assert_eq!(svg.matches(">33.3</text>").count(), 11);
        // 11 cells of 47, not of 14.
        assert_eq!(svg.matches("width=\"47\" height=\"47\"").count(), 11);
        let one = drawn(&[90.0], &[30.0]);
        assert!(
            one.contains(">90</text>") && one.contains(">30</text>"),
            "{one}"
        );
    }

    #[test]
    fn the_papers_grid_keeps_its_cells() {
        let svg = drawn(
            &(0..37).map(|at| f64::from(at) * 5.0).collect::<Vec<_>>(),
            &(0..19).map(|at| f64::from(at) * 5.0).collect::<Vec<_>>(),
        );
        assert_eq!(svg.matches("width=\"14\" height=\"14\"").count(), 703);
        for tick in ["0", "45", "90", "135", "180"] {
            assert!(svg.contains(&format!(">{tick}</text>")), "{tick}");
        }
    }
}

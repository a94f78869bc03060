//! Rank-1 against the strength of each confounder: many small charts in one picture.

use super::drawing::{COLOURS, FONT, failed, register_font};
use crate::error::{Error, ReportError, Result};
use image::RgbImage;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Width of the picture, and how many charts stand side by side.
const WIDTH: u32 = 1000;
const COLUMNS: usize = 6;
/// Room for the percentages on the left, and around everything, pixels.
const LEFT: i32 = 34;
const MARGIN: i32 = 8;
/// A chart's own height, that of its name above and its strengths below, pixels.
const CHART: i32 = 84;
const NAME: i32 = 17;
const TICKS: i32 = 20;
/// Between two charts.
const GAP: i32 = 14;
/// A line of text, its letters, and the width of one, pixels.
const LINE: i32 = 22;
const TEXT: i32 = 12;
const HEADING: i32 = 14;
const LETTER: f64 = 7.2;
const INK: RGBColor = RGBColor(32, 36, 40);
const FAINT: RGBColor = RGBColor(222, 225, 228);
const GREY: RGBColor = RGBColor(120, 124, 128);

/// One confounder's chart.
#[derive(Clone, Debug)]
pub struct StrengthPanel {
    /// The confounder's name.
    pub confounder: String,
    /// Its class.
    pub class: String,
    /// For each recognizer strengths, rising within -1..=1, and the rank-1 rate at each, 0..=1.
    pub curves: Vec<Vec<(f64, f64)>>,
}

type Area<'b> = DrawingArea<BitMapBackend<'b>, Shift>;

/// The charts of all confounders, grouped by class, with lines of each recognizer and a dashed
/// one at chance: 1,000 pixels wide.
///
/// # Errors
/// If there is no chart, or if one has not as many lines as there are recognizers.
pub fn strength_chart(
    recognizers: &[String],
    panels: &[StrengthPanel],
    chance: f64,
) -> Result<RgbImage> {
    let expected = recognizers.len();
    let odd = panels.iter().find(|panel| panel.curves.len() != expected);
    if let Some(panel) = odd {
        return Err(ReportError::Lines {
            chart: panel.confounder.clone(),
            recognizers: expected,
            lines: panel.curves.len(),
        }
        .into());
    }
    if panels.is_empty() {
        return Err(Error::Missing("confounders to chart"));
    }
    let mut groups: Vec<(&str, Vec<&StrengthPanel>)> = Vec::new();
    for panel in panels {
        match groups.iter_mut().find(|(class, _)| *class == panel.class) {
            Some((_, members)) => members.push(panel),
            None => groups.push((&panel.class, vec![panel])),
        }
    }
    let rows: usize = groups.iter().map(|(_, g)| g.len().div_ceil(COLUMNS)).sum();
    let row = NAME + CHART + TICKS;
    let height = 2 * MARGIN + LINE + LINE * groups.len() as i32 + row * rows as i32;
    let mut picture = RgbImage::new(WIDTH, height as u32);
    {
        register_font();
        let size = picture.dimensions();
        let area = BitMapBackend::with_buffer(&mut picture, size).into_drawing_area();
        area.fill(&WHITE).map_err(failed)?;
        draw_legend(&area, recognizers)?;
        let mut y = MARGIN + LINE;
        for (class, members) in groups {
            text(&area, class, (MARGIN, y), (HEADING, INK))?;
            y += LINE;
            for line in members.chunks(COLUMNS) {
                for (column, panel) in line.iter().enumerate() {
                    draw_panel(&area, panel, (column, y), chance)?;
                }
                y += row;
            }
        }
        area.present().map_err(failed)?;
    }
    Ok(picture)
}

/// Which line is whose.
fn draw_legend(area: &Area<'_>, recognizers: &[String]) -> Result<()> {
    let title = "rank-1, %, against strength:";
    text(area, title, (MARGIN, MARGIN), (TEXT, INK))?;
    let mut x = MARGIN + length(title) + GAP;
    let names = recognizers.iter().map(String::as_str);
    let lines = names.zip(COLOURS.into_iter().cycle());
    for (name, colour) in lines.chain([("chance", GREY)]) {
        let y = MARGIN + TEXT / 2 + 1;
        let key = [(x, y), (x + 22, y)];
        area.draw(&PathElement::new(key, colour.stroke_width(2)))
            .map_err(failed)?;
        text(area, name, (x + 27, MARGIN), (TEXT, INK))?;
        x += 27 + length(name) + GAP;
    }
    Ok(())
}

/// One chart whose name's upper edge is at `y`.
fn draw_panel(
    area: &Area<'_>,
    panel: &StrengthPanel,
    (column, y): (usize, i32),
    chance: f64,
) -> Result<()> {
    let pitch = (WIDTH as i32 - LEFT - MARGIN + GAP) / COLUMNS as i32;
    let (left, top) = (LEFT + column as i32 * pitch, y + NAME);
    let width = pitch - GAP;
    let strengths = panel.curves.iter().flatten().map(|(strength, _)| *strength);
    let least = if strengths.fold(0.0, f64::min) < 0.0 {
        -1.0
    } else {
        0.0
    };
    let x_of = |strength: f64| {
        let share = (strength - least) / (1.0 - least);
        left + (share * f64::from(width)).round() as i32
    };
    let y_of = |rate: f64| top + ((1.0 - rate.clamp(0.0, 1.0)) * f64::from(CHART)).round() as i32;
    text(area, &panel.confounder, (left, y), (TEXT, INK))?;
    for (rate, label) in [(0.0, "0"), (0.5, "50"), (1.0, "100")] {
        let line = [(left, y_of(rate)), (left + width, y_of(rate))];
        area.draw(&PathElement::new(line, FAINT)).map_err(failed)?;
        if column == 0 {
            let at = (left - 4 - length(label), y_of(rate) - TEXT / 2);
            text(area, label, at, (TEXT, GREY))?;
        }
    }
    let ticks: &[(f64, &str)] = if least < 0.0 {
        &[(-1.0, "-1"), (0.0, "0"), (1.0, "1")]
    } else {
        &[(0.0, "0"), (0.5, "0.5"), (1.0, "1")]
    };
    for (strength, label) in ticks {
        let x = x_of(*strength);
        let line = [(x, top), (x, top + CHART)];
        area.draw(&PathElement::new(line, FAINT)).map_err(failed)?;
        let at = (x - length(label) / 2, top + CHART + 3);
        text(area, label, at, (TEXT, GREY))?;
    }
    for dash in 0..width / 8 {
        let (from, y) = (left + 8 * dash, y_of(chance));
        area.draw(&PathElement::new([(from, y), (from + 4, y)], GREY))
            .map_err(failed)?;
    }
    for (curve, colour) in panel.curves.iter().zip(COLOURS.into_iter().cycle()) {
        let known = curve.iter().filter(|(_, rate)| rate.is_finite());
        let points: Vec<(i32, i32)> = known.map(|&(s, rate)| (x_of(s), y_of(rate))).collect();
        for &point in &points {
            area.draw(&Circle::new(point, 2, colour.filled()))
                .map_err(failed)?;
        }
        area.draw(&PathElement::new(points, colour.stroke_width(2)))
            .map_err(failed)?;
    }
    Ok(())
}

/// A text's length, pixels.
fn length(text: &str) -> i32 {
    (LETTER * text.chars().count() as f64).round() as i32
}

fn text(
    area: &Area<'_>,
    text: &str,
    at: (i32, i32),
    (size, colour): (i32, RGBColor),
) -> Result<()> {
    let style = (FONT, size).into_text_style(area).color(&colour);
    // The font's letters begin above the place that they are drawn at.
    area.draw_text(text, &style, (at.0, at.1 + 3))
        .map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(curves: Vec<Vec<(f64, f64)>>) -> StrengthPanel {
        StrengthPanel {
            confounder: "fog".into(),
            class: "environment".into(),
            curves,
        }
    }

    #[test]
    fn a_line_goes_where_its_rates_are() {
        let halved = panel(vec![vec![(0.0, 1.0), (1.0, 0.5)]]);
        let picture = strength_chart(&["side".into()], &[halved], 0.04).unwrap();
        assert_eq!(picture.dimensions(), (1000, 16 + 44 + 121));
        // The chart begins at (34, 69), is 84 high and 148 wide.
        let at = |x, y| picture.get_pixel(x, y).0;
        assert_eq!([at(34, 69), at(182, 111)], [[0, 114, 178]; 2]);
        assert_eq!([at(34, 140), at(108, 69)], [[222, 225, 228]; 2]);
    }

    #[test]
    fn charts_without_a_line_for_each_recognizer_are_refused() {
        let names = ["side".to_string()];
        let refused = strength_chart(&names, &[panel(vec![])], 0.04).unwrap_err();
        let expected = "chart of fog: expected a line for each of 1 recognizers, found 0";
        assert!(refused.to_string().contains(expected), "{refused}");
        assert!(strength_chart(&names, &[], 0.04).is_err());
    }
}
